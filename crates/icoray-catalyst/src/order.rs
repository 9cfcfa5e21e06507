//! Where the values of columns are in the host's arrays.

use icoray::Shape;

/// The elements of the host's arrays, by column and layer.
#[derive(Debug)]
pub enum Order {
    /// At equal distances, so that values are read in place.
    InPlace(Shape),
    /// Anywhere: column by column, the element of each layer.
    Table(Vec<u32>),
}

/// The order of values of `columns` columns of `layers` layers.
#[derive(Debug)]
pub struct Layout {
    pub columns: usize,
    pub layers: usize,
    pub order: Order,
    /// Number of elements that the host's arrays must have.
    pub elements: usize,
}

impl Layout {
    /// The layout of a table, column by column, of arrays of `elements` elements.
    pub fn of(table: Vec<u32>, layers: usize, elements: usize) -> Self {
        let columns = table.len().checked_div(layers).unwrap_or(0);
        let order = shape_of(&table, layers).map_or_else(|| Order::Table(table), Order::InPlace);
        Layout { columns, layers, order, elements }
    }

    pub fn at(&self, column: usize, layer: usize) -> u32 {
        match &self.order {
            Order::InPlace(shape) => element(shape, column, layer) as u32,
            Order::Table(table) => table[column * self.layers + layer],
        }
    }
}

/// The shape of a table of `layers` elements for each column, if these are at equal distances.
fn shape_of(table: &[u32], layers: usize) -> Option<Shape> {
    let at = |column: usize, layer: usize| table[column * layers + layer] as isize;
    let columns = table.len().checked_div(layers)?;
    if columns == 0 {
        return Some(Shape { column_stride: 1, ..Shape::level_fastest(0, layers) });
    }
    let first = at(0, 0);
    let layer_stride = if layers > 1 { at(0, 1) - first } else { 0 };
    let column_stride = if columns > 1 { at(1, 0) - first } else { 1 };
    // The first column that is not where the one before leads to begins a block.
    let block = (0..columns).find(|&c| at(c, 0) != first + c as isize * column_stride);
    let block_stride = block.map_or(0, |block| at(block, 0) - first);
    let (offset, block) = (first as usize, block.unwrap_or(0));
    let shape = Shape { columns, layers, offset, column_stride, layer_stride, block, block_stride };
    let fits = |(i, number): (usize, &u32)| element(&shape, i / layers, i % layers) == *number as isize;
    table.iter().enumerate().all(fits).then_some(shape)
}

/// The element of a column and layer.
fn element(shape: &Shape, column: usize, layer: usize) -> isize {
    let (within, block) = if shape.block > 0 { (column % shape.block, column / shape.block) } else { (column, 0) };
    let place = within as isize * shape.column_stride + block as isize * shape.block_stride;
    shape.offset as isize + place + layer as isize * shape.layer_stride
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(columns: usize, layers: usize, at: impl Fn(usize, usize) -> usize) -> Vec<u32> {
        (0..columns * layers).map(|i| at(i / layers, i % layers) as u32).collect()
    }

    #[test]
    fn orders_of_models_are_read_in_place() {
        let of = |table: &[u32]| {
            let shape = shape_of(table, 4).unwrap();
            [shape.offset as isize, shape.column_stride, shape.layer_stride, shape.block as isize, shape.block_stride]
        };
        assert_eq!(of(&table(5, 4, |c, l| 4 * c + l)), [0, 4, 1, 0, 0]);
        assert_eq!(of(&table(5, 4, |c, l| 5 * l + c)), [0, 1, 5, 0, 0]);
        // From the top, and padded.
        assert_eq!(of(&table(5, 4, |c, l| 10 * c + 3 - l)), [3, 10, -1, 0, 0]);
        // In blocks of 3, of which the last one is not full.
        assert_eq!(of(&table(8, 4, |c, l| c % 3 + 3 * l + 12 * (c / 3))), [0, 1, 3, 3, 12]);
        assert_eq!(of(&table(1, 4, |_, l| 2 * l)), [0, 1, 2, 0, 0]);
        assert!(shape_of(&[], 4).is_some());
    }

    #[test]
    fn other_orders_are_not() {
        let mut shuffled = table(6, 3, |c, l| 3 * c + l);
        shuffled.swap(4, 5);
        assert_eq!(shape_of(&shuffled, 3), None);
        assert_eq!(shape_of(&table(6, 3, |c, l| c * c * 3 + l), 3), None);
    }
}
