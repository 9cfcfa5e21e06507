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
use serde::{Deserialize, Serialize};

/// Maximum number of clear ranges of the transfer function that are tested, and of clear single values.
const MAX_RANGES: usize = 2;
const MAX_KNOTS: usize = 2;
/// Maximum number of those that are frequent.
pub(crate) const MAX_CLEAR: usize = 3;
/// Minimum fraction of clear blocks: with fewer, the test costs rays more time than skipping saves.
const MIN_CLEAR: f64 = 0.02;
/// Columns or triangles per parallel task.
const CHUNK: usize = 4096;
/// Stride and length of the runs of columns that are sampled first: if almost nothing is clear in these, the others are
/// not read.
const PROBE: [usize; 2] = [2048, 64];

/// The blocks of a grid's columns.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Blocks<'a> {
    pub grid: &'a Grid<'a>,
    pub layers: usize,
    /// Whether rays leap over macrocells.
    pub leaps: bool,
}

/// The values of a field that are clear: a frustum whose vertices all have values of one clear range is invisible.
pub(crate) trait OccupancyTest: Send + Sync {
    /// The clear ranges' bits.
    fn clear_bits(&self) -> Vec<[u64; 2]>;

    /// Keeps the clear ranges that are frequent in a sample of columns, the most frequent first, and returns their number,
    /// at most [`MAX_CLEAR`].
    fn keep_frequent(&mut self) -> usize;

    /// Finds the blocks with values outside each of the clear ranges, in the columns over the cells from `first` on: a
    /// word for each range, cell by cell.
    fn find_columns(&self, first: usize, found: &mut [u32]);
}

/// The test of one field.
pub(crate) struct FieldTest<'a, S> {
    pub blocks: Blocks<'a>,
    pub samples: Samples<'a, S>,
    pub clear: Vec<Stored<S>>,
}

/// What [`OccupancyTest::find_columns`] has found of all columns of a field.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FieldColumns<'c> {
    /// Words of a cell.
    pub ranges: usize,
    pub words: &'c [u32],
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

impl<S: PreparedSample> OccupancyTest for FieldTest<'_, S> {
    fn clear_bits(&self) -> Vec<[u64; 2]> {
        self.clear.iter().map(|range| range.map(|value| value.wide().to_bits())).collect()
    }

    fn keep_frequent(&mut self) -> usize {
        let (level, bits, cells) = (Level::new(), self.blocks.bits(), self.blocks.grid.cells());
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
        self.clear = found.into_iter().map(|(_, clear)| clear).take(MAX_CLEAR).collect();
        self.clear.len()
    }

    fn find_columns(&self, first: usize, found: &mut [u32]) {
        let (level, bits) = (Level::new(), self.blocks.bits());
        let chunks = found.par_chunks_mut(self.clear.len() * CHUNK).enumerate();
        chunks.for_each(|(i, found)| {
            let outside = Outside { level, ranges: &self.clear, bits: &bits, first: first + i * CHUNK, found };
            S::find_outside(&self.samples, outside);
        });
    }
}

impl FieldColumns<'_> {
    /// Adds the blocks over the triangles from `first` on.
    fn add(&self, grid: &Grid, first: usize, blocks: &mut [u32]) {
        match self.ranges {
            1 => self.add_outside::<1>(grid, first, blocks),
            2 => self.add_outside::<2>(grid, first, blocks),
            _ => self.add_outside::<MAX_CLEAR>(grid, first, blocks),
        }
    }

    fn add_outside<const R: usize>(&self, grid: &Grid, first: usize, blocks: &mut [u32]) {
        let (columns, _) = self.words.as_chunks::<R>();
        for (triangle, blocks) in (first..).zip(blocks) {
            *blocks |= blocks_over(grid, triangle as u32, columns);
        }
    }
}

impl Blocks<'_> {
    /// The bits of the blocks that each layer bounds.
    fn bits(&self) -> Vec<u32> {
        let shift = OccupancyMask::shift(self.layers);
        let block = |gap: usize| 1u32 << ((gap.clamp(1, (self.layers - 1).max(1)) - 1) >> shift);
        // Layer l bounds the gaps l and l + 1.
        (0..self.layers).map(|l| block(l) | block(l + 1)).collect()
    }

    /// The blocks that any of the fields of `tests` shows; reuses `memory`.
    pub fn visible(
        &self,
        tests: Vec<Box<dyn OccupancyTest + '_>>,
        memory: OccupancyMask<'static>,
    ) -> OccupancyMask<'static> {
        let mut visible = memory.full(self.layers);
        let (cells, columns) = (self.grid.cells(), &mut visible.columns);
        let (mut words, mut ranges) = (0, Vec::with_capacity(tests.len()));
        for mut test in tests {
            let count = test.keep_frequent();
            if count == 0 {
                return visible;
            }
            resize(columns, columns.len().max(words + count * cells));
            test.find_columns(0, &mut columns[words..words + count * cells]);
            words += count * cells;
            ranges.push(count);
        }
        resize(columns, words);
        let mut unread = &**columns;
        let fields = ranges.into_iter().filter_map(|ranges| {
            let words = unread.split_off(..ranges * cells)?;
            Some(FieldColumns { ranges, words })
        });
        let fields: Vec<_> = fields.collect();
        let blocks = visible.blocks.to_mut();
        resize(blocks, self.grid.triangles());
        let seen = self.find(&fields, 0, blocks);
        self.mask(visible, seen)
    }

    /// Finds the blocks over the triangles from `first` on that any of the fields shows.
    pub fn find(&self, fields: &[FieldColumns], first: usize, blocks: &mut [u32]) -> SeenBlocks {
        let seen = blocks.par_chunks_mut(CHUNK).enumerate().map(|(i, blocks)| {
            blocks.fill(0);
            fields.iter().for_each(|field| field.add(self.grid, first + i * CHUNK, blocks));
            let count = blocks.iter().map(|blocks| u64::from(blocks.count_ones())).sum();
            SeenBlocks { count, bits: joined(blocks) }
        });
        seen.reduce(SeenBlocks::default, SeenBlocks::and)
    }

    /// `visible`, which has the blocks over all triangles, completed; the full mask if too few blocks are clear to skip
    /// them.
    pub fn mask<'m>(&self, visible: OccupancyMask<'m>, seen: SeenBlocks) -> OccupancyMask<'m> {
        let blocks = u64::from(joined(&self.bits()).count_ones());
        if seen.count as f64 > (1.0 - MIN_CLEAR) * (blocks * self.grid.triangles() as u64) as f64 {
            return visible.full(self.layers);
        }
        let behind = (u32::BITS - seen.bits.leading_zeros()).max(1) as usize;
        let top = (behind << visible.shift).min(self.layers - 1);
        let visible = OccupancyMask { top, ..visible };
        if self.leaps { visible.with_macrocells(self.grid, self.layers) } else { visible }
    }
}

/// The number of visible blocks over some triangles, and the bits of all of them.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
pub(crate) struct SeenBlocks {
    count: u64,
    bits: u32,
}

impl SeenBlocks {
    /// Those over the triangles of both.
    pub fn and(self, other: Self) -> Self {
        SeenBlocks { count: self.count + other.count, bits: self.bits | other.bits }
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
