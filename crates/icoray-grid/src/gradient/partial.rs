//! Gradients of the cells that pictures of a field can read, completed from picture to picture.

use super::{GradientInput, GradientOptions, Gradients, PreparedSample};
use crate::error::Result;
use crate::grid::Grid;
use crate::samples::Samples;
use std::borrow::Cow;

/// Gradients at the vertices of a whole grid, of which those over some cells may not be computed yet.
#[derive(Debug)]
pub struct PartialGradients<'m> {
    values: Gradients<'m>,
    /// Whether each cell's gradients are computed; empty if none or all are.
    is_computed: Vec<bool>,
    is_complete: bool,
}

impl PartialGradients<'static> {
    /// Gradients of no cell, in the memory of these.
    pub fn of_none(self) -> Self {
        let mut is_computed = self.is_computed;
        is_computed.clear();
        PartialGradients { values: self.values, is_computed, is_complete: false }
    }

    /// Computes the gradients that are `wanted`, unless they are there. Grid, radii, samples and options, but for
    /// [`seen`](GradientOptions::seen), must be those of the earlier calls; other arguments are as for
    /// [`gradients`](super::gradients).
    ///
    /// # Errors
    /// [`ErrorKind::Memory`](crate::error::ErrorKind::Memory) if they do not fit.
    pub fn with_cells<S: PreparedSample>(
        self,
        grid: &Grid,
        radius: &[f64],
        samples: &Samples<S>,
        wanted: GradientOptions,
    ) -> Result<Self> {
        if self.is_complete {
            return Ok(self);
        }
        let mut is_computed = self.is_computed;
        let mut values = self.values.with_room(grid.cells() * radius.len(), wanted.packed)?;
        let is_complete = wanted.seen.is_none();
        let marks = (!is_complete).then(|| {
            is_computed.resize(grid.cells(), false);
            is_computed.as_mut_slice()
        });
        S::fill_gradients(&GradientInput::new(grid, radius, samples, 0..grid.cells(), wanted), &mut values, marks);
        Ok(PartialGradients { values, is_computed, is_complete })
    }

    /// The gradients, by value.
    pub fn into_values(self) -> Gradients<'static> {
        self.values
    }
}

impl<'m> PartialGradients<'m> {
    /// Gradients of no cell.
    pub fn none() -> Self {
        Gradients::none().into()
    }

    /// Number of cells whose gradients are computed, of `cells` in all.
    pub fn computed_cells(&self, cells: usize) -> usize {
        if self.is_complete { cells } else { self.is_computed.iter().filter(|is_computed| **is_computed).count() }
    }

    /// The gradients; those that are not computed have arbitrary values.
    pub fn values(&self) -> &Gradients<'m> {
        &self.values
    }

    /// The gradients, to be modified.
    pub fn values_mut(&mut self) -> &mut Gradients<'m> {
        &mut self.values
    }

    /// These, if they are in memory of their own.
    pub fn into_own(self) -> Option<PartialGradients<'static>> {
        let PartialGradients { values, is_computed, is_complete } = self;
        let values = match values {
            Gradients::Whole(Cow::Owned(all)) => Gradients::Whole(all.into()),
            Gradients::Packed(Cow::Owned(all)) => Gradients::Packed(all.into()),
            _ => return None,
        };
        Some(PartialGradients { values, is_computed, is_complete })
    }

    /// Bytes of memory of their own.
    pub fn own_bytes(&self) -> usize {
        self.values.own_bytes() + self.is_computed.len()
    }
}

impl<'m> From<Gradients<'m>> for PartialGradients<'m> {
    /// Gradients of all cells.
    fn from(values: Gradients<'m>) -> Self {
        PartialGradients { values, is_computed: Vec::new(), is_complete: true }
    }
}
