//! What of a field can be seen at all, found by reading it once before the first ray.

use crate::grid::Grid;
use crate::kernel::Real;
use crate::kernel::leap::{Visible, clear_ranges};
use crate::kernel::sample::{Sample, Samples};
use crate::kernel::transfer::Spans;
use rayon::prelude::*;

/// Each clear part of the transfer function costs a pass over the field.
const MOST_RANGES: usize = 3;
/// Where less than this part of all blocks is clear, rays would ask more than they leap.
const LEAST: f64 = 0.02;
/// Columns or triangles that a thread takes at a time.
const CHUNK: usize = 4096;

impl Visible {
    /// For a field of values in `range`; all of them, where nothing that it has is clear.
    pub fn new<T: Real, S: Sample>(
        grid: &Grid,
        samples: &Samples<S>,
        spans: &Spans<T>,
        layers: usize,
        range: Option<[f64; 2]>,
    ) -> Self {
        let all = Self::all(layers);
        let shift = all.shift;
        let [low, high] = spans.range();
        let normal = |value: f64| (value - low) / (high - low);
        let Some(within) = range.map(|range| range.map(normal)) else { return all };
        let ranges = clear_ranges(spans, within, MOST_RANGES);
        if ranges.is_empty() {
            return all;
        }
        // Layer l bounds the gaps l and l + 1.
        let block = |gap: usize| 1u32 << ((gap - 1) >> shift);
        let bits: Vec<u32> = (0..layers)
            .map(|l| {
                [l, l + 1].into_iter().fold(0, |all, gap| all | block(gap.clamp(1, (layers - 1).max(1))))
            })
            .collect();
        let mut columns = vec![0u32; grid.cells()];
        let mut blocks = vec![u32::MAX; grid.triangles()];
        for range in ranges {
            let chunks = columns.par_chunks_mut(CHUNK).enumerate();
            chunks.for_each(|(i, cells)| samples.outside(range, &bits, i * CHUNK, cells));
            blocks.par_chunks_mut(CHUNK).enumerate().for_each(|(i, chunk)| {
                for (triangle, blocks) in (i * CHUNK..).zip(chunk) {
                    let triangle = triangle as u32;
                    *blocks &= if grid.is_triangle(triangle) {
                        grid.triangle(triangle).iter().fold(0, |all, cell| all | columns[*cell as usize])
                    } else {
                        0
                    };
                }
            });
        }
        let seen: u64 = blocks.par_iter().map(|blocks| u64::from(blocks.count_ones())).sum();
        let most = bits.iter().fold(0, |all, bit| all | bit).count_ones() as usize * blocks.len();
        if seen as f64 > (1.0 - LEAST) * most as f64 {
            return all;
        }
        Visible { blocks, shift, stretch: stretch(grid) }
    }
}

/// How many times as high as a point the facet that it lies on is at most: with sides of no more than L the square of a unit
/// facet's height is at least 1 - L²/3 everywhere.
fn stretch(grid: &Grid) -> f64 {
    let longest = |triangle: usize| {
        let [a, b, c] = grid.triangle(triangle as u32).map(|cell| grid.direction(cell));
        a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a))
    };
    let triangles = (0..grid.triangles()).into_par_iter().with_min_len(CHUNK);
    let there = triangles.filter(|triangle| grid.is_triangle(*triangle as u32));
    let square = there.map(longest).reduce(|| 0.0, f64::max);
    if square < 3.0 { 1.0 / (1.0 - square / 3.0).sqrt() } else { f64::INFINITY }
}
