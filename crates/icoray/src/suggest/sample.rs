//! The sampled values of a field for a suggestion, and their places.

use crate::ranks::{CountedColumns, Part, RankLists, Ranks};
use glam::DVec3;
use icoray_grid::{ComputedField, Error, ErrorKind, Field, Grid, Location, Result};

/// Maximum number of sampled values; of larger fields each k-th column is sampled.
const MAX_VALUES: usize = 1 << 20;
/// A mesh has holes if its triangles cover less of the sphere.
const COVERED: f64 = 1.0 - 1e-9;

/// Columns of a field in the order of the whole grid's cells.
pub(super) struct Sample {
    /// Unit vectors to the columns.
    pub directions: Vec<DVec3>,
    pub layers: usize,
    /// Level-fastest; NaN where missing.
    values: Vec<f64>,
    /// Whether the mesh has holes.
    pub has_holes: bool,
}

/// A column between ranks: its number in the whole grid, its direction, its values.
type Column = (u64, [f64; 3], Vec<f64>);

impl Sample {
    /// The sample of a field over a whole grid.
    pub fn of_whole(name: &str, grid: &Grid, field: &Field) -> Result<Self> {
        let average = match field.location() {
            Location::Corner => Some(ComputedField::average(grid, field)?),
            Location::Center => None,
        };
        let field = average.as_ref().map_or(*field, ComputedField::field);
        let (columns, layers) = (field.shape().columns, field.shape().layers);
        if columns != grid.cells() {
            let context = format!("{name}: {columns} columns, expected {}", grid.cells());
            return Err(Error::new(ErrorKind::Field, context));
        }
        let cells = || (0..columns).step_by(step(columns, layers));
        let directions = cells().map(|cell| grid.direction(cell as u32)).collect();
        let values = cells().flat_map(|cell| (0..layers).map(move |layer| field.value(cell, layer))).collect();
        Ok(Sample { directions, layers, values, has_holes: grid.void_triangles() > 0 })
    }

    /// The sample of a field of which each node has a part: at rank 0 that of the whole field, on other ranks one
    /// without columns. Collective.
    pub fn of_parts(ranks: &mut Ranks, part: &Part, grid: &Grid, field: &Field) -> Result<Self> {
        let layers = field.shape().layers;
        let step = step(part.cells() as usize, layers) as u64;
        let column = |cell: usize| -> Column {
            let values = (0..layers).map(|layer| field.value(cell, layer)).collect();
            (grid.number(cell), grid.direction(cell as u32).to_array(), values)
        };
        let counted = CountedColumns::new(Some(part), None);
        let is_taken = |cell: &usize| counted.has(Location::Center, *cell) && grid.number(*cell).is_multiple_of(step);
        let for_root = RankLists::from([(0, (0..grid.cells()).filter(is_taken).map(column).collect())]);
        let received = ranks.exchange_lists::<Column>(&for_root)?;
        let mut columns: Vec<Column> = received.into_values().flatten().collect();
        columns.sort_unstable_by_key(|(number, ..)| *number);
        Ok(Sample {
            directions: columns.iter().map(|(_, direction, _)| DVec3::from_array(*direction)).collect(),
            layers,
            values: columns.into_iter().flat_map(|(.., values)| values).collect(),
            has_holes: part.covered() < COVERED,
        })
    }

    pub fn columns(&self) -> usize {
        self.directions.len()
    }

    /// The value of a column on a layer, NaN where it is missing.
    pub fn value(&self, column: usize, layer: usize) -> f64 {
        self.values[column * self.layers + layer]
    }
}

/// Distance between sampled columns.
fn step(columns: usize, layers: usize) -> usize {
    (columns * layers).div_ceil(MAX_VALUES).max(1)
}
