//! Fields that are computed from others: averaged from corners to cell centres, moved to other layers, derived.

use super::{CornerColumns, Field, Location, next_number};
use crate::error::{Error, ErrorKind, Result};
use crate::grid::Grid;
use crate::reals::OwnedReals;
use crate::shape::Shape;
use rayon::prelude::*;

/// A field that icoray computed from others; level-fastest, NaN where a value is missing.
#[derive(Debug, Clone)]
pub struct ComputedField {
    values: OwnedReals,
    shape: Shape,
    location: Location,
    /// [`Field::number`] of the field: unchanged while no value changes.
    number: u64,
}

impl ComputedField {
    /// Averages a field at corners to the cell centres, in parallel: the plain mean over those corners of a cell that
    /// have a value; NaN if none has one.
    ///
    /// # Errors
    /// [`ErrorKind::Field`] when `field` is not at corners or does not have one column per corner of `grid`.
    pub fn average(grid: &Grid, field: &Field) -> Result<Self> {
        let shape = field.shape();
        if field.location() != Location::Corner || shape.columns != grid.triangles() {
            let found = format!("{} columns at {:?}", shape.columns, field.location());
            return Err(Error::new(ErrorKind::Field, format!("{found}, expected {} at Corner", grid.triangles())));
        }
        let cells = (0..grid.cells() as u32).into_par_iter();
        Ok(Self::new(CornerColumns::new(*field).averages(grid, cells, None), Location::Center, shape.layers))
    }

    /// The field of these values, level-fastest.
    pub fn new(values: OwnedReals, location: Location, layers: usize) -> Self {
        let shape = Shape::level_fastest(values.as_reals().len() / layers, layers);
        ComputedField { values, shape, location, number: next_number() }
    }

    /// The field, borrowed.
    pub fn field(&self) -> Field<'_> {
        let field = Field::new(self.values.as_reals(), self.shape, self.location, None);
        Field { number: self.number, ..field.expect("the values were made for this shape") }
    }

    /// The values, level-fastest, for modification: the field gets a new number.
    pub fn values_mut(&mut self) -> &mut OwnedReals {
        self.number = next_number();
        &mut self.values
    }

    /// The values, level-fastest.
    pub fn into_values(self) -> OwnedReals {
        self.values
    }

    /// Bytes of the values.
    pub fn bytes(&self) -> usize {
        self.values.bytes()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::icosahedral_grid;

    #[test]
    fn corner_average_counts_each_corner_once() {
        let grid = icosahedral_grid(1);
        // Pentagons repeat a corner in the table; a plain sum over six entries would be wrong there.
        let v: Vec<f64> = (0..grid.triangles()).map(|c| c as f64).collect();
        let field = Field::level_fastest(&v, 1, Location::Corner).unwrap();
        let center = ComputedField::average(&grid, &field).unwrap();
        for cell in 0..grid.cells() as u32 {
            let around: Vec<u32> = (0..grid.triangles() as u32).filter(|&t| grid.triangle(t).contains(&cell)).collect();
            let mean = around.iter().map(|&t| f64::from(t)).sum::<f64>() / around.len() as f64;
            assert!((center.field().value(cell as usize, 0) - mean).abs() < 1e-12);
        }
    }
}
