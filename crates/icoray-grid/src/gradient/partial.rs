//! Gradients of the cells that pictures of a field can read, completed from picture to picture.

use super::{GradientInput, GradientOptions, Gradients, MissingCells, PreparedSample};
use crate::error::Result;
use crate::grid::Grid;
use crate::samples::Samples;
use crate::visible_cells::VisibleCells;

/// Gradients at the vertices of a whole grid, of which those over some cells may not be computed yet.
#[derive(Debug)]
pub struct PartialGradients {
    values: Gradients,
    /// Whether each cell's gradients are computed; empty if none or all are.
    is_computed: Vec<bool>,
    is_complete: bool,
}

impl PartialGradients {
    /// Gradients of no cell, in the memory of these.
    pub fn of_none(self) -> Self {
        let mut is_computed = self.is_computed;
        is_computed.clear();
        PartialGradients { values: self.values, is_computed, is_complete: false }
    }

    /// Computes the gradients over the `seen` cells, or over all, unless they are there. Grid, radii, samples and
    /// options must be those of the earlier calls; other arguments are as for [`gradients`](super::gradients).
    ///
    /// # Errors
    /// [`ErrorKind::Memory`](crate::error::ErrorKind::Memory) if they do not fit.
    pub fn with_cells<S: PreparedSample>(
        self,
        grid: &Grid,
        radius: &[f64],
        samples: &Samples<S>,
        wanted: GradientOptions,
        seen: Option<&VisibleCells>,
    ) -> Result<Self> {
        if self.is_complete {
            return Ok(self);
        }
        let mut is_computed = self.is_computed;
        let mut values = self.values.with_room(grid.cells() * radius.len(), wanted.packed)?;
        let missing = seen.map(|seen| {
            is_computed.resize(grid.cells(), false);
            MissingCells { seen, is_computed: &mut is_computed }
        });
        let is_complete = missing.is_none();
        S::fill_gradients(&GradientInput::new(grid, radius, samples, 0..grid.cells(), wanted), &mut values, missing);
        Ok(PartialGradients { values, is_computed, is_complete })
    }

    /// Number of cells whose gradients are computed, of `cells` in all.
    pub fn computed_cells(&self, cells: usize) -> usize {
        if self.is_complete { cells } else { self.is_computed.iter().filter(|is_computed| **is_computed).count() }
    }

    /// The gradients; those that are not computed have arbitrary values.
    pub fn values(&self) -> &Gradients {
        &self.values
    }

    /// The gradients, to be modified.
    pub fn values_mut(&mut self) -> &mut Gradients {
        &mut self.values
    }

    /// The gradients, by value.
    pub fn into_values(self) -> Gradients {
        self.values
    }

    /// Bytes of memory.
    pub fn bytes(&self) -> usize {
        self.values.bytes() + self.is_computed.len()
    }
}

impl From<Gradients> for PartialGradients {
    /// Gradients of all cells.
    fn from(values: Gradients) -> Self {
        PartialGradients { values, is_computed: Vec::new(), is_complete: true }
    }
}
