//! The position of a value in the model's array, for every layout of models, so that no array has to be copied.
//!
//! | layout | who has it | column_stride | layer_stride | block, block_stride |
//! |---|---|---|---|---|
//! | level-fastest | MPAS `(nVertLevels, nCells)` in Fortran's order | layers | 1 | - |
//! | cell-fastest | finite volumes with whole layers | 1 | cells | - |
//! | blocked | ICON `(nproma, nlev, nblks)`, NICAM `(gall, kall, lall)` | 1 | nproma | nproma, nproma·nlev |
//! | blocked, layers fastest | `(nlev, nproma, nblks)` | nlev | 1 | nproma, nproma·nlev |
//! | padded rows | rows aligned to cache lines; MPAS's extra column behind the last | more than layers | 1 | - |
//! | turned round | top first, or columns from the last to the first | any sign | any sign | any sign |
//!
//! `element = offset + (column % block)·column_stride + (column / block)·block_stride + layer·layer_stride`. Elements
//! that this does not reach, such as those behind ICON's npromz in the last block, are never read.

use crate::array::MapInline;

/// The layout of a field in a borrowed array. Value (column, layer) is element
/// `offset + (column % block)·column_stride + (column / block)·block_stride + layer·layer_stride` where columns are
/// blocked, or else `offset + column·column_stride + layer·layer_stride`.
///
/// Strides count elements and may be negative.
///
/// ```
/// use icoray_grid::{Field, Location, Shape};
///
/// // ICON's (nproma, nlev, nblks) with 2 columns per block: 3 columns of 2 layers, the last block partly filled.
/// let values = [0.0, 10.0, 1.0, 11.0, 20.0, f64::NAN, 21.0, f64::NAN];
/// let field = Field::new(values.as_slice().into(), Shape::blocked(3, 2, 2), Location::Center, None)?;
/// assert_eq!((field.value(1, 0), field.value(2, 1)), (10.0, 21.0));
///
/// // The same values with the top layer first, read from the innermost layer on.
/// let rows = [1.0, 0.0, 11.0, 10.0, 21.0, 20.0];
/// let turned = Shape { offset: 1, layer_stride: -1, ..Shape::level_fastest(3, 2) };
/// let field = Field::new(rows.as_slice().into(), turned, Location::Center, None)?;
/// assert_eq!((field.value(1, 0), field.value(2, 1)), (10.0, 21.0));
/// # Ok::<(), icoray_grid::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shape {
    /// Number of columns: cells, or corners for a field at corners.
    pub columns: usize,
    /// Number of layers with values.
    pub layers: usize,
    /// Index of value (0, 0).
    pub offset: usize,
    /// Elements from one column to the next, in the same block.
    pub column_stride: isize,
    /// Elements from one layer to the next.
    pub layer_stride: isize,
    /// Columns per block, of which the last block may have fewer; 0 if columns are not blocked.
    pub block: usize,
    /// Elements from one block to the next; ignored if `block` is 0.
    pub block_stride: isize,
}

impl Shape {
    /// Level-fastest rows, one after the other (MPAS).
    pub fn level_fastest(columns: usize, layers: usize) -> Self {
        let (column_stride, layer_stride) = (layers as isize, 1);
        Shape { columns, layers, offset: 0, column_stride, layer_stride, block: 0, block_stride: 0 }
    }

    /// Whole layers, one after the other.
    pub fn cell_fastest(columns: usize, layers: usize) -> Self {
        Shape { column_stride: 1, layer_stride: columns as isize, ..Self::level_fastest(columns, layers) }
    }

    /// Blocks of `nproma` columns, in each of them whole layers (ICON's `(nproma, nlev, nblks)`, NICAM's
    /// `(gall, kall, lall)`). The last block may be filled in part.
    pub fn blocked(columns: usize, layers: usize, nproma: usize) -> Self {
        Shape {
            columns,
            layers,
            offset: 0,
            column_stride: 1,
            layer_stride: nproma as isize,
            block: nproma,
            block_stride: nproma.wrapping_mul(layers) as isize,
        }
    }

    /// The least and greatest element that the shape touches, or `None` when it is empty or overflows.
    pub fn extent(&self) -> Option<(i128, i128)> {
        let (last, layers) = (self.columns.checked_sub(1)?, self.layers.checked_sub(1)?);
        let block = if self.block == 0 { self.columns } else { self.block };
        let last_block = last / block;
        // The position of a value is linear in the place inside the block and in the block, so the extremes are at the
        // ends of the full blocks and of the last one.
        let widest = if last_block > 0 { block - 1 } else { 0 };
        let full = last_block.saturating_sub(1);
        let ends = [(0, 0), (widest, 0), (widest, full), (0, last_block), (last % block, last_block)];
        let product = |count: usize, stride: isize| (count as i128).checked_mul(stride as i128);
        let reach = product(layers, self.layer_stride)?;
        let (mut low, mut high) = (i128::MAX, i128::MIN);
        for (inside, block) in ends {
            let column = product(inside, self.column_stride)?.checked_add(product(block, self.block_stride)?)?;
            let inner = column.checked_add(self.offset as i128)?;
            let outer = inner.checked_add(reach)?;
            low = low.min(inner).min(outer);
            high = high.max(inner).max(outer);
        }
        Some((low, high))
    }

    /// The first and the last element, if the elements between are all values too, each once.
    pub(crate) fn packed(&self) -> Option<(usize, usize)> {
        let [column, layer] = [self.column_stride, self.layer_stride].map_inline(isize::unsigned_abs);
        let is_packed = (layer == 1 && column == self.layers) || (column == 1 && layer == self.columns);
        let (low, high) = self.extent().filter(|_| is_packed && self.block == 0)?;
        Some((usize::try_from(low).ok()?, usize::try_from(high).ok()?))
    }
}

/// A checked shape, ready for reading: finds elements without a division.
#[derive(Debug, Clone, Copy)]
pub struct ElementIndexer {
    offset: isize,
    column_stride: isize,
    layer_stride: isize,
    block: u32,
    block_stride: isize,
    /// 2⁶⁴ / block, rounded up; 0 if columns are not blocked.
    reciprocal: u64,
    layers: usize,
}

impl ElementIndexer {
    /// The indexer of a shape whose extent lies inside an array; `None` for more than 2^32 columns in blocks.
    pub fn new(shape: &Shape) -> Option<Self> {
        let plain = ElementIndexer {
            offset: shape.offset as isize,
            column_stride: shape.column_stride,
            layer_stride: shape.layer_stride,
            block: 0,
            block_stride: 0,
            reciprocal: 0,
            layers: shape.layers,
        };
        if shape.block == 0 || shape.block >= shape.columns {
            return Some(plain);
        }
        if shape.block == 1 {
            return Some(ElementIndexer { column_stride: shape.block_stride, ..plain });
        }
        u32::try_from(shape.columns - 1).ok()?;
        let block = u32::try_from(shape.block).ok()?;
        let reciprocal = u64::MAX / u64::from(block) + 1;
        Some(ElementIndexer { block, block_stride: shape.block_stride, reciprocal, ..plain })
    }

    /// The same values with the last layer first.
    pub fn upside_down(self) -> Self {
        let offset = self.offset + (self.layers as isize - 1) * self.layer_stride;
        ElementIndexer { offset, layer_stride: -self.layer_stride, ..self }
    }

    /// Offset of the values of `column`, for [`Self::at`].
    #[inline(always)]
    pub fn base(&self, column: usize) -> isize {
        if self.reciprocal == 0 {
            return self.offset + column as isize * self.column_stride;
        }
        self.blocked_base(column)
    }

    /// The base of column 0 and the stride from column to column; `None` if columns lie in blocks.
    pub fn plain_column(&self) -> Option<[isize; 2]> {
        (self.reciprocal == 0).then_some([self.offset, self.column_stride])
    }

    /// [`Self::base`] of three columns.
    #[inline(always)]
    pub fn bases(&self, columns: [usize; 3]) -> [isize; 3] {
        if self.reciprocal == 0 {
            return columns.map_inline(|column| self.offset + column as isize * self.column_stride);
        }
        columns.map_inline(|column| self.blocked_base(column))
    }

    /// Separate, so that the loops that read arrays without blocks keep their registers.
    #[inline(never)]
    fn blocked_base(&self, column: usize) -> isize {
        // With a divisor from 2 to 2³² the reciprocal, rounded up, is off by less than one part in 2³² of a quotient's
        // step, so the product's high half is the quotient for every column of 32 bits (Lemire, Kaser and Kurz 2019,
        // doi:10.1002/spe.2689).
        let block = ((column as u128 * u128::from(self.reciprocal)) >> 64) as usize;
        let inside = column - block * self.block as usize;
        self.offset + inside as isize * self.column_stride + block as isize * self.block_stride
    }

    /// Elements from one layer to the next.
    pub fn layer_stride(&self) -> isize {
        self.layer_stride
    }

    /// The element at `layer` of the column with this base.
    #[inline(always)]
    pub fn at(&self, base: isize, layer: usize) -> usize {
        (base + layer as isize * self.layer_stride) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every element that a shape touches, straight from the definition.
    fn touched(s: &Shape) -> Vec<i128> {
        let all = (0..s.columns).flat_map(|c| (0..s.layers).map(move |l| (c, l)));
        all.map(|(c, l)| {
            let (inside, block) = if s.block == 0 { (c, 0) } else { (c % s.block, c / s.block) };
            let [inside, block, layer] = [inside, block, l].map(|n| n as i128);
            s.offset as i128
                + inside * s.column_stride as i128
                + block * s.block_stride as i128
                + layer * s.layer_stride as i128
        })
        .collect()
    }

    fn shapes() -> Vec<Shape> {
        let mut shapes = Vec::new();
        for columns in [1, 2, 7, 8, 9, 12] {
            for block in [0, 1, 2, 4, 7, 12, 20] {
                for (column_stride, layer_stride, block_stride) in
                    [(1, 4, 12), (-1, 4, 12), (3, -1, 12), (-3, -1, -12), (1, 50, -5), (1, -3, 2), (9, 0, -9)]
                {
                    let strides = Shape { column_stride, layer_stride, ..Shape::level_fastest(columns, 3) };
                    shapes.push(Shape { offset: 1000, block, block_stride, ..strides });
                }
            }
        }
        shapes
    }

    #[test]
    fn the_extent_is_that_of_the_touched_elements() {
        for shape in shapes() {
            let all = touched(&shape);
            let expected = (*all.iter().min().unwrap(), *all.iter().max().unwrap());
            assert_eq!(shape.extent(), Some(expected), "{shape:?}");
        }
        assert_eq!(Shape::blocked(10, 3, 4).extent(), Some((0, 2 * 12 + 2 * 4 + 1)), "npromz = 2");
        assert_eq!(Shape::blocked(0, 3, 4).extent(), None);
        assert_eq!(Shape::blocked(4, 0, 4).extent(), None);
    }

    /// Sizes that no array has, where products and sums do not fit: no panic, no wrapped answer.
    #[test]
    fn an_extent_beyond_all_numbers_is_none() {
        let huge = Shape { column_stride: isize::MIN, ..Shape::level_fastest(usize::MAX, usize::MAX) };
        assert_eq!(Shape { layer_stride: isize::MIN, ..huge }.extent(), None);
        let blocks = Shape { block: 2, block_stride: isize::MIN, ..huge };
        assert_eq!(Shape { layer_stride: isize::MIN, ..blocks }.extent(), None);
    }

    #[test]
    fn elements_are_where_the_definition_puts_them() {
        for shape in shapes() {
            let elements = ElementIndexer::new(&shape).unwrap();
            let turned = elements.upside_down();
            for (i, element) in touched(&shape).into_iter().enumerate() {
                let (column, layer) = (i / 3, i % 3);
                assert_eq!(elements.at(elements.base(column), layer) as i128, element, "{shape:?} {i}");
                assert_eq!(turned.at(turned.base(column), 2 - layer) as i128, element, "{shape:?} {i}");
            }
        }
    }

    /// The product with the reciprocal is the quotient at both sides of every kind of step, up to the last column.
    #[test]
    fn blocks_are_divided_exactly() {
        let last = u32::MAX as usize;
        for block in [2, 3, 5, 7, 8, 641, 1_000_003, 1 << 16, (1 << 31) - 1, 1 << 31, last - 1, last] {
            let shape = Shape { columns: last + 1, block, block_stride: 3 << 30, ..Shape::cell_fastest(1, 1) };
            let elements = ElementIndexer::new(&shape).unwrap();
            let steps = (0..4).flat_map(|k| [k * block, (last / block - k.min(last / block)) * block]);
            let columns = steps.flat_map(|c| [c.saturating_sub(1), c, c + 1]).chain([last]);
            for column in columns.filter(|c| *c <= last) {
                let expected = (column % block) + (column / block) * (3 << 30);
                assert_eq!(elements.base(column), expected as isize, "{column} / {block}");
            }
        }
        assert!(ElementIndexer::new(&Shape { columns: last + 2, ..Shape::blocked(1, 1, 8) }).is_none());
    }
}
