//! Where the values of columns are in the host's arrays.

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

    pub fn at(&self, column: usize, layer: usize) -> u32 {
        match &self.order {
            Order::InPlace(strides) => strides.at(column as i64, layer as i64) as u32,
            Order::Table(table) => table[column * self.layers + layer],
        }
    }
}

/// Values at equal distances: value (column, layer) is element `first` + (column % block)*`column` +
/// (column / block)*`block_stride` + layer*`layer`; without blocks `block` is 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Strides {
    pub first: i64,
    pub column: i64,
    pub layer: i64,
    pub block: i64,
    pub block_stride: i64,
}

impl Strides {
    /// Column by column.
    pub fn by_column(layers: usize) -> Self {
        Strides { first: 0, column: layers as i64, layer: 1, block: 0, block_stride: 0 }
    }

    /// The strides of a table of `layers` elements for each column, if it has such an order.
    pub fn of(table: &[u32], layers: usize) -> Option<Self> {
        let at = |column: usize, layer: usize| i64::from(table[column * layers + layer]);
        let columns = table.len().checked_div(layers)?;
        if columns == 0 {
            return Some(Strides { first: 0, column: 1, layer: 1, block: 0, block_stride: 0 });
        }
        let first = at(0, 0);
        let layer = if layers > 1 { at(0, 1) - first } else { 0 };
        let column = if columns > 1 { at(1, 0) - first } else { 1 };
        // The first column that is not where the one before leads to begins a block.
        let block = (0..columns).find(|&c| at(c, 0) != first + c as i64 * column);
        let block_stride = block.map_or(0, |block| at(block, 0) - first);
        let strides = Strides { first, column, layer, block: block.unwrap_or(0) as i64, block_stride };
        let fits =
            |(i, element): (usize, &u32)| strides.at((i / layers) as i64, (i % layers) as i64) == i64::from(*element);
        table.iter().enumerate().all(fits).then_some(strides)
    }

    /// The element of a column and layer.
    pub fn at(&self, column: i64, layer: i64) -> i64 {
        let (within, block) = if self.block > 0 { (column % self.block, column / self.block) } else { (column, 0) };
        self.first + within * self.column + block * self.block_stride + layer * self.layer
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(columns: usize, layers: usize, at: impl Fn(usize, usize) -> usize) -> Vec<u32> {
        (0..columns * layers).map(|i| at(i / layers, i % layers) as u32).collect()
    }

    #[test]
    fn orders_of_models_are_read_in_place() {
        let strides =
            |first, column, layer, block, block_stride| Some(Strides { first, column, layer, block, block_stride });
        assert_eq!(Strides::of(&table(5, 4, |c, l| 4 * c + l), 4), strides(0, 4, 1, 0, 0));
        assert_eq!(Strides::of(&table(5, 4, |c, l| 5 * l + c), 4), strides(0, 1, 5, 0, 0));
        // From the top, and padded.
        assert_eq!(Strides::of(&table(5, 4, |c, l| 10 * c + 3 - l), 4), strides(3, 10, -1, 0, 0));
        // In blocks of 3, of which the last one is not full.
        let blocks = table(8, 4, |c, l| c % 3 + 3 * l + 12 * (c / 3));
        assert_eq!(Strides::of(&blocks, 4), strides(0, 1, 3, 3, 12));
        assert_eq!(Strides::of(&table(1, 4, |_, l| 2 * l), 4), strides(0, 1, 2, 0, 0));
        assert!(Strides::of(&[], 4).is_some());
    }

    #[test]
    fn other_orders_are_not() {
        let mut shuffled = table(6, 3, |c, l| 3 * c + l);
        shuffled.swap(4, 5);
        assert_eq!(Strides::of(&shuffled, 3), None);
        assert_eq!(Strides::of(&table(6, 3, |c, l| c * c * 3 + l), 3), None);
    }
}
