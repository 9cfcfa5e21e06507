//! Leaping over what is clear: a bit for each block of gaps over a triangle says whether anything can be seen there.
//!
//! What a ray passes over is a convex mean of values at vertices. Where these all lie in one clear part of the transfer
//! function, by more than rounding reaches, a frustum adds nothing, nor does it shift a cut or come near a step: rays pass it without
//! reading, and see the same bits as without leaping. Nor does one add anything that has one value all over which is clear,
//! though it lie on a knot, such as the zeros of a cloud's water.

use super::real::Real;
use super::transfer::Spans;
use crate::array::MapInline;
use crate::grid::Grid;
use std::ops::Range;

/// Gaps are joined into no more blocks than that.
pub(crate) const MOST_BLOCKS: usize = 32;

/// The blocks of gaps over each triangle in which something can be seen. Without any triangle: all that there are.
#[derive(Debug, Default)]
pub(crate) struct Visible {
    /// A bit per block for each triangle of the table.
    pub blocks: Vec<u32>,
    /// A block has `1 << shift` gaps.
    pub shift: u32,
    /// The layer above which nothing can be seen over any triangle.
    pub top: usize,
    /// What of each cell's column is not clear, while triangles are found by it.
    pub columns: Vec<u32>,
}

impl Visible {
    /// How gaps between so many layers are joined.
    #[inline]
    pub fn shift(layers: usize) -> u32 {
        (0..).find(|shift| layers.saturating_sub(2) >> shift < MOST_BLOCKS).unwrap_or(0)
    }

    /// All that there is between so many layers, in this memory.
    #[inline]
    pub fn all_in(mut self, layers: usize) -> Self {
        self.blocks.clear();
        Visible { shift: Self::shift(layers), top: layers - 1, ..self }
    }

    /// Whether that is all there is.
    #[inline]
    pub fn is_all(&self) -> bool {
        self.blocks.is_empty()
    }

    /// The blocks over a triangle.
    #[inline(always)]
    pub fn over(&self, triangle: u32) -> u32 {
        self.blocks.get(triangle as usize).copied().unwrap_or(u32::MAX)
    }

    /// Whether `gap`, from 1 on, can be seen by these blocks.
    #[inline(always)]
    pub fn shows(&self, blocks: u32, gap: usize) -> bool {
        blocks >> ((gap - 1) >> self.shift) & 1 != 0
    }

    /// The layers over a cell that bound what can be seen, out of so many.
    #[inline]
    pub fn layers_over(&self, grid: &Grid, cell: u32, layers: usize) -> Range<usize> {
        if self.is_all() {
            return 0..layers;
        }
        let triangles = grid.corners_of(cell).filter(|corner| grid.is_triangle(*corner));
        let blocks = triangles.fold(0, |all, triangle| all | self.over(triangle));
        if blocks == 0 {
            return 0..0;
        }
        let [first, behind] = [blocks.trailing_zeros(), u32::BITS - blocks.leading_zeros()];
        (first as usize) << self.shift..(((behind as usize) << self.shift) + 1).min(layers)
    }

    /// Bytes that it takes.
    #[inline]
    pub fn bytes(&self) -> usize {
        4 * (self.blocks.capacity() + self.columns.capacity())
    }
}

/// The widest parts of a transfer function that are clear, at most so many, in normalised values: those that hold some of the
/// field's, which are `within`. Each is narrowed by more than rounding may do to means of the field's values.
#[inline]
pub(crate) fn clear_ranges<T: Real>(spans: &Spans<T>, within: [f64; 2], most: usize) -> Vec<[f64; 2]> {
    let largest = within[0].abs().max(within[1].abs()).min(T::LARGEST);
    let margin = 64.0 * T::ROUNDING * (1.0 + largest);
    let mut ranges: Vec<[f64; 2]> = Vec::new();
    for span in spans.all().iter().filter(|span| span.is_clear) {
        let (low, high) = (span.low.wide(), span.high.wide());
        match ranges.last_mut() {
            Some(last) if last[1] == low => last[1] = high,
            _ => ranges.push([low, high]),
        }
    }
    let narrow = |[low, high]: [f64; 2]| [low + margin, high - margin];
    let held = |[low, high]: &[f64; 2]| low.max(within[0]) < high.min(within[1]);
    let mut ranges: Vec<_> = ranges.into_iter().map(narrow).filter(held).collect();
    let width = |[low, high]: &[f64; 2]| high.min(within[1]) - low.max(within[0]);
    ranges.sort_by(|a, b| width(b).total_cmp(&width(a)));
    ranges.truncate(most);
    ranges
}

/// Values that are clear although values beside them are not: knots without extinction, among those `within` the field's range.
/// Two of one value make a step, on which a constant counts as above.
#[inline]
pub(crate) fn clear_knots<T: Real>(spans: &Spans<T>, within: [f64; 2], most: usize) -> Vec<T> {
    let (all, [low, high]) = (spans.all(), within.map_inline(T::of));
    let mut knots: Vec<T> = Vec::new();
    for pair in all.windows(2) {
        let value = pair[1].low;
        let is_inside = value >= low && value <= high;
        let is_amid = pair[0].is_clear && pair[1].is_clear;
        let is_clear = spans.span(spans.find(value)).extinction(value) == T::zero();
        if is_inside && !is_amid && is_clear && knots.last() != Some(&value) {
            knots.push(value);
        }
    }
    knots.truncate(most);
    knots
}
