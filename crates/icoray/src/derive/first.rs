//! Stores fields as they were in the first frame that requested them.

use super::run::{Operation, fill};
use crate::fields::FieldLayout;
use icoray_grid::threads::Threads;
use icoray_grid::{Error, ErrorKind, Field, OwnedReals, Result};
use std::sync::{Arc, Mutex, PoisonError};

/// Maximum number of stored fields: bounds the memory if a host generates ever new names.
const MAX_STEPS: usize = 64;

/// The stored fields; they live as long as the renderer.
#[derive(Debug, Default)]
pub(super) struct FirstFrames(Mutex<Vec<FirstFrame>>);

/// Identified by the definition of the field, down to the model's names, and by its shape: each shape has a first frame
/// of its own.
#[derive(Debug)]
struct FirstFrame {
    origin: String,
    at: FieldLayout,
    values: Arc<OwnedReals>,
}

impl FirstFrames {
    /// The field's values in the first frame; stores the current ones if there are none.
    pub fn of(&self, origin: &str, field: &Field, threads: &Threads) -> Result<Arc<OwnedReals>> {
        let at = FieldLayout::of(field);
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(first) = all.iter().find(|first| first.at == at && first.origin == origin) {
            return Ok(first.values.clone());
        }
        if all.len() == MAX_STEPS {
            let context = format!("fields of {MAX_STEPS} first steps are stored already, expected no further one");
            return Err(Error::new(ErrorKind::Scene, context));
        }
        let room = OwnedReals::buffer(field.samples(), None);
        let values = threads.run(|| fill(room, &[*field], &Operation::Sum(vec![1.0])));
        let values = Arc::new(values);
        all.push(FirstFrame { origin: origin.to_owned(), at, values: values.clone() });
        Ok(values)
    }

    /// Bytes of all stored fields.
    pub fn bytes(&self) -> usize {
        let all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        all.iter().map(|first| first.values.bytes()).sum()
    }
}
