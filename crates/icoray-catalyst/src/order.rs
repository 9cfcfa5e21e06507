//! Where the values of columns are in the host's arrays.

use crate::strides::Strides;

/// The elements of the host's arrays, by column and layer.
#[derive(Debug)]
pub enum Order {
    /// At equal distances, so that values are read in place.
    InPlace(Strides),
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
        let order = Strides::of(&table, layers).map_or_else(|| Order::Table(table), Order::InPlace);
        Layout { columns, layers, order, elements }
    }

    /// The element of a column and layer.
    pub fn at(&self, column: usize, layer: usize) -> u32 {
        match &self.order {
            Order::InPlace(strides) => strides.at(column as i64, layer as i64) as u32,
            Order::Table(table) => table[column * self.layers + layer],
        }
    }
}
