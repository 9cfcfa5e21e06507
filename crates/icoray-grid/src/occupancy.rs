//! The visible parts of a field's columns: a bit for each block of gaps over a triangle.

use crate::array::MapInline;
use crate::grid::Grid;
use crate::macrocells::JoinedBits;
use std::borrow::Cow;
use std::ops::Range;

/// Maximum number of blocks over a triangle.
pub(crate) const MAX_BLOCKS: usize = 32;

/// The visible blocks of gaps over each triangle. Gap `k` lies between layers `k - 1` and `k`, counted from the
/// innermost layer, so the first is 1. Without triangles, everything is visible.
#[derive(Debug, Default)]
pub struct OccupancyMask<'m> {
    /// A bit per block for each triangle of the table.
    pub blocks: Cow<'m, [u32]>,
    /// A block has `1 << shift` gaps.
    pub shift: u32,
    /// The layer above which nothing is visible over any triangle.
    pub top: usize,
    /// The same bits for each cell, from which those of triangles are made.
    pub columns: Vec<u32>,
    /// The joined bits of the triangles of each macrocell ([`Grid::macrocells`]); empty if not used.
    pub macrocells: JoinedBits,
}

impl<'m> OccupancyMask<'m> {
    /// [`Self::shift`](field@OccupancyMask::shift) for this number of layers.
    #[inline]
    pub fn shift(layers: usize) -> u32 {
        (0..).find(|shift| layers.saturating_sub(2) >> shift < MAX_BLOCKS).unwrap_or(0)
    }

    /// The mask that shows everything between this number of layers, in this memory.
    #[inline]
    pub fn full(mut self, layers: usize) -> Self {
        match &mut self.blocks {
            Cow::Owned(blocks) => blocks.clear(),
            borrowed => *borrowed = Cow::Borrowed(&[]),
        }
        self.macrocells.clear();
        OccupancyMask { shift: Self::shift(layers), top: layers - 1, ..self }
    }

    /// The mask over this number of triangles that shows nothing between this number of layers.
    #[inline]
    pub fn none(triangles: usize, layers: usize) -> Self {
        OccupancyMask { blocks: vec![0; triangles].into(), shift: Self::shift(layers), ..OccupancyMask::default() }
    }

    /// This mask between this number of layers with the joined bits of macrocells, if enough of these are clear for rays
    /// to leap over them.
    pub fn with_macrocells(mut self, grid: &Grid, layers: usize) -> Self {
        /// Minimum fraction of clear blocks: with fewer, looking ahead costs rays more time than leaps save.
        const MIN_EMPTY: f64 = 0.7;
        if !self.is_full() {
            let seen = grid.macrocells().join(grid, &self.blocks, &mut self.macrocells);
            let blocks = (layers.saturating_sub(2) >> self.shift) + 1;
            if seen as f64 > (1.0 - MIN_EMPTY) * (blocks * self.macrocells.len()) as f64 {
                self.macrocells.clear();
            }
        }
        self
    }

    /// Whether everything is visible.
    #[inline]
    pub fn is_full(&self) -> bool {
        self.blocks.is_empty()
    }

    /// The blocks over a triangle.
    #[inline(always)]
    pub fn blocks_over(&self, triangle: u32) -> u32 {
        self.blocks.get(triangle as usize).copied().unwrap_or(u32::MAX)
    }

    /// Whether `gap`, from 1 on, is visible according to these blocks.
    #[inline(always)]
    pub fn is_occupied(&self, blocks: u32, gap: usize) -> bool {
        blocks >> ((gap - 1) >> self.shift) & 1 != 0
    }

    /// The bits of the blocks that contain the gaps from `low` to `high`, among `layers` layers; 0 below and above all
    /// of them.
    #[inline(always)]
    pub fn between(&self, [low, high]: [usize; 2], layers: usize) -> u32 {
        let (low, high) = (low.max(1), high.min(layers - 1));
        if low > high {
            return 0;
        }
        let [first, last] = [low, high].map_inline(|gap| ((gap - 1) >> self.shift) as u32);
        (u32::MAX << first) & (u32::MAX >> (u32::BITS - 1 - last))
    }

    /// The range of layers over a cell that bounds the visible gaps, among `layers` layers.
    #[inline]
    pub fn layers_over(&self, grid: &Grid, cell: u32, layers: usize) -> Range<usize> {
        if self.is_full() {
            return 0..layers;
        }
        let blocks = grid.triangles_around(cell).fold(0, |all, triangle| all | self.blocks_over(triangle));
        if blocks == 0 {
            return 0..0;
        }
        let [first, behind] = [blocks.trailing_zeros(), u32::BITS - blocks.leading_zeros()];
        (first as usize) << self.shift..(((behind as usize) << self.shift) + 1).min(layers)
    }

    /// This one, if its blocks are in memory of its own.
    pub fn into_own(self) -> Option<OccupancyMask<'static>> {
        let OccupancyMask { blocks, shift, top, columns, macrocells } = self;
        let Cow::Owned(blocks) = blocks else { return None };
        Some(OccupancyMask { blocks: blocks.into(), shift, top, columns, macrocells })
    }

    /// Bytes of memory of its own.
    #[inline]
    pub fn own_bytes(&self) -> usize {
        let blocks = match &self.blocks {
            Cow::Owned(blocks) => blocks.capacity(),
            Cow::Borrowed(_) => 0,
        };
        4 * (blocks + self.columns.capacity()) + self.macrocells.bytes()
    }
}
