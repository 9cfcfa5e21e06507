//! Memory as large as the grid that a frame leaves to the next one, so that a run of frames allocates it once.

use crate::error::Result;
use crate::field::{CenterField, Field};
use crate::grid::Grid;
use std::mem;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// What no frame is using. Of frames that are drawn at once all but one find nothing here.
#[derive(Debug, Default)]
pub(super) struct Spare(Mutex<Kept>);

#[derive(Debug, Default)]
struct Kept {
    average: Option<CenterField>,
    gradients: Vec<[f32; 3]>,
}

impl Spare {
    fn kept(&self) -> MutexGuard<'_, Kept> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A field at corners, averaged to the centres.
    pub fn average(&self, grid: &Grid, field: &Field) -> Result<CenterField> {
        let memory = self.kept().average.take();
        CenterField::average_in(grid, field, memory)
    }

    /// Takes an average back.
    pub fn keep_average(&self, average: Option<CenterField>) {
        let mut kept = self.kept();
        kept.average = average.or(kept.average.take());
    }

    /// Memory for gradients, with whatever was there.
    pub fn gradients(&self) -> Vec<[f32; 3]> {
        mem::take(&mut self.kept().gradients)
    }

    /// Takes gradients back.
    pub fn keep_gradients(&self, gradients: Vec<[f32; 3]>) {
        let mut kept = self.kept();
        if gradients.capacity() > kept.gradients.capacity() {
            kept.gradients = gradients;
        }
    }
}
