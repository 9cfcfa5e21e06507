//! Fields as they were in the first frame that asked for them.

use super::run::{Operation, fill};
use super::{At, Values};
use crate::error::{Error, ErrorKind, Result};
use crate::field::Field;
use crate::grid::Reals;
use crate::threads::Threads;
use std::sync::{Arc, Mutex, PoisonError};

/// More are not remembered: a host that makes up names without end must not fill the memory.
const MOST: usize = 64;

/// The fields that are remembered, as long as the renderer lives.
#[derive(Debug, Default)]
pub(super) struct Firsts(Mutex<Vec<First>>);

/// A field is known by what it is made of, the model's name of it in the end, and by its shape: one of another shape has a first
/// frame of its own.
#[derive(Debug)]
struct First {
    origin: String,
    at: At,
    values: Arc<Values>,
}

impl Firsts {
    /// What the field was the first time, which is now where it is not known.
    pub fn of(&self, origin: &str, field: &Field, threads: &Threads) -> Result<Arc<Values>> {
        let at = At::of(field);
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(first) = all.iter().find(|first| first.at == at && first.origin == origin) {
            return Ok(first.values.clone());
        }
        if all.len() == MOST {
            let context =
                format!("{MOST} fields of first steps are remembered already, and none more than that are");
            return Err(Error::new(ErrorKind::Scene, context));
        }
        let room = match field.samples() {
            Reals::F32(_) => Values::F32(Vec::new()),
            Reals::F64(_) => Values::F64(Vec::new()),
        };
        let values = threads.run(|| fill(room, &[*field], &Operation::Sum(vec![1.0])));
        let values = Arc::new(values);
        all.push(First { origin: origin.to_owned(), at, values: values.clone() });
        Ok(values)
    }

    /// Bytes of all of them.
    pub fn bytes(&self) -> usize {
        let all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        all.iter().map(|first| first.values.bytes()).sum()
    }
}
