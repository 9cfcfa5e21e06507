//! Empty space skipping: marks the visible blocks of a field in one pass before the first ray.

use fearless_simd::Level;
use icoray_grid::Grid;
use icoray_grid::array::MapInline;
use icoray_grid::gradient::PreparedSample;
use icoray_grid::occupancy::OccupancyMask;
use icoray_grid::real::Real;
use icoray_grid::samples::{Outside, Samples, Stored};
use icoray_kernel::empty_space_skipping::{clear_knots, clear_ranges};
use icoray_kernel::transfer::Spans;
use rayon::prelude::*;

/// Maximum number of clear ranges of the transfer function that are tested, and of clear single values.
const MAX_RANGES: usize = 2;
const MAX_KNOTS: usize = 2;
/// Minimum fraction of clear blocks: with fewer, the test costs rays more time than skipping saves.
const MIN_CLEAR: f64 = 0.02;
/// Columns or triangles per parallel task.
const CHUNK: usize = 4096;
/// Stride and length of the runs of columns that are sampled first: if almost nothing is clear in these, the others are
/// not read.
const PROBE: [usize; 2] = [2048, 64];

/// The visibility test of one field.
pub(crate) struct OccupancyTest<'a, S> {
    pub grid: &'a Grid<'a>,
    pub samples: Samples<'a, S>,
    pub layers: usize,
    /// Clear values: a frustum whose vertices all have values of one clear range is invisible.
    pub clear: Vec<Stored<S>>,
    /// Whether rays leap over macrocells.
    pub leaps: bool,
}

/// The values of a field in `range` that are clear.
pub(crate) fn clear_values<T: Real, S: PreparedSample>(
    spans: &Spans<T>,
    samples: &Samples<S>,
    range: Option<[f64; 2]>,
) -> Vec<Stored<S>> {
    let [low, high] = spans.range();
    let Some(within) = range.map(|range| range.map_inline(|value| (value - low) / (high - low))) else {
        return Vec::new();
    };
    let ranges = clear_ranges(spans, within, MAX_RANGES).into_iter().filter_map(|range| samples.stored(range));
    let knots = clear_knots(spans, within, MAX_KNOTS).into_iter().filter_map(|knot| samples.stored_at(knot));
    ranges.chain(knots).collect()
}

impl<S: PreparedSample> OccupancyTest<'_, S> {
    /// The visible blocks; reuses `memory`.
    pub fn visible(&self, memory: OccupancyMask) -> OccupancyMask {
        let clear = self.frequent();
        match clear.len() {
            0 => memory.full(self.layers),
            1 => self.blocks_outside::<1>(&clear, memory),
            2 => self.blocks_outside::<2>(&clear, memory),
            _ => self.blocks_outside::<3>(&clear[..3], memory),
        }
    }

    /// The bits of the blocks that each layer bounds.
    fn bits(&self) -> Vec<u32> {
        let shift = OccupancyMask::shift(self.layers);
        let block = |gap: usize| 1u32 << ((gap.clamp(1, (self.layers - 1).max(1)) - 1) >> shift);
        // Layer l bounds the gaps l and l + 1.
        (0..self.layers).map(|l| block(l) | block(l + 1)).collect()
    }

    /// The clear ranges that are frequent in a sample of columns, the most frequent first.
    fn frequent(&self) -> Vec<Stored<S>> {
        let (level, bits, cells) = (Level::new(), self.bits(), self.grid.cells());
        let (stride, count) = if cells > 8 * PROBE[0] { (PROBE[0], PROBE[1]) } else { (CHUNK, CHUNK) };
        let blocks = joined(&bits).count_ones() as usize;
        let part = |clear: &Stored<S>| {
            let probes = (0..cells).into_par_iter().step_by(stride).map(|first| {
                let mut found = vec![0; count.min(cells - first)];
                let ranges = std::slice::from_ref(clear);
                S::find_outside(&self.samples, Outside { level, ranges, bits: &bits, first, found: &mut found });
                let seen: u32 = found.iter().map(|blocks| blocks.count_ones()).sum();
                [blocks * found.len() - seen as usize, blocks * found.len()]
            });
            let [clear, all] = probes.reduce(|| [0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
            clear as f64 / all.max(1) as f64
        };
        let mut found: Vec<_> = self.clear.iter().map(|clear| (part(clear), *clear)).collect();
        found.retain(|(part, _)| *part > 0.5 * MIN_CLEAR);
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        found.into_iter().map(|(_, clear)| clear).collect()
    }

    /// The blocks with values outside of R ranges that are clear.
    fn blocks_outside<const R: usize>(&self, ranges: &[Stored<S>], memory: OccupancyMask) -> OccupancyMask {
        let (grid, bits) = (self.grid, self.bits());
        let mut visible = memory.full(self.layers);
        resize(&mut visible.columns, R * grid.cells());
        resize(&mut visible.blocks, grid.triangles());
        let chunks = visible.columns.par_chunks_mut(R * CHUNK).enumerate();
        let (level, bits) = (Level::new(), &bits[..]);
        chunks.for_each(|(i, found)| {
            S::find_outside(&self.samples, Outside { level, ranges, bits, first: i * CHUNK, found });
        });
        let (columns, _) = visible.columns.as_chunks::<R>();
        let seen = visible.blocks.par_chunks_mut(CHUNK).enumerate().map(|(i, chunk)| {
            let (mut count, mut all) = (0, 0);
            for (triangle, blocks) in (i * CHUNK..).zip(chunk) {
                *blocks = blocks_over(grid, triangle as u32, columns);
                count += u64::from(blocks.count_ones());
                all |= *blocks;
            }
            (count, all)
        });
        let (seen, all) = seen.reduce(|| (0, 0), |a, b| (a.0 + b.0, a.1 | b.1));
        let blocks = u64::from(joined(bits).count_ones());
        if seen as f64 > (1.0 - MIN_CLEAR) * (blocks * grid.triangles() as u64) as f64 {
            return visible.full(self.layers);
        }
        let behind = (u32::BITS - all.leading_zeros()).max(1) as usize;
        let top = (behind << visible.shift).min(self.layers - 1);
        let visible = OccupancyMask { top, ..visible };
        if self.leaps { visible.with_macrocells(grid, self.layers) } else { visible }
    }
}

/// The visible blocks over a triangle: those with a value outside each clear range over one of its cells.
#[inline]
fn blocks_over<const R: usize>(grid: &Grid, triangle: u32, columns: &[[u32; R]]) -> u32 {
    if !grid.is_triangle(triangle) {
        return 0;
    }
    let [a, b, c] = grid.triangle(triangle).map_inline(|cell| columns[cell as usize]);
    let mut all = u32::MAX;
    for r in 0..R {
        all &= a[r] | b[r] | c[r];
    }
    all
}

fn joined(bits: &[u32]) -> u32 {
    bits.iter().fold(0, |all, bit| all | bit)
}

/// Resizes `memory` without clearing it.
fn resize(memory: &mut Vec<u32>, count: usize) {
    memory.reserve_exact(count.saturating_sub(memory.len()));
    memory.resize(count, 0);
}
