//! What became of frames that were handed to another thread, kept for a caller who may ask often, late or never.

use crate::error::Error;

/// Outcomes since the caller asked last, the oldest first.
///
/// No more than [`Outcomes::KEPT`] are kept one by one, so that a caller who never asks costs no memory; of the rest
/// there are numbers. Failures push successes out: the first failures are kept whatever comes before and after them.
#[derive(Debug, Clone)]
pub struct Outcomes<T> {
    /// What is kept, in the order in which it happened.
    pub kept: Vec<T>,
    /// How many frames went well that are not in `kept`.
    pub more_done: u64,
    /// How many frames failed that are not in `kept`.
    pub more_failed: u64,
}

/// What [`Outcomes`] can hold: something that went well or failed.
pub trait Outcome {
    /// Why it failed, if it did.
    fn error(&self) -> Option<&Error>;
}

impl<T> Default for Outcomes<T> {
    fn default() -> Self {
        Outcomes { kept: Vec::new(), more_done: 0, more_failed: 0 }
    }
}

impl<T: Outcome> Outcomes<T> {
    /// How many outcomes are kept one by one.
    pub const KEPT: usize = 256;

    /// Adds the latest outcome.
    pub(crate) fn push(&mut self, outcome: T) {
        if self.kept.len() < Self::KEPT {
            self.kept.push(outcome);
            return;
        }
        if outcome.error().is_none() {
            self.more_done += 1;
            return;
        }
        match self.kept.iter().rposition(|o| o.error().is_none()) {
            Some(last_done) => {
                self.kept.remove(last_done);
                self.kept.push(outcome);
                self.more_done += 1;
            }
            None => self.more_failed += 1,
        }
    }

    /// How many frames went well.
    pub fn done(&self) -> u64 {
        self.kept.iter().filter(|o| o.error().is_none()).count() as u64 + self.more_done
    }

    /// How many frames failed.
    pub fn failed(&self) -> u64 {
        self.errors().count() as u64 + self.more_failed
    }

    /// The failures that are kept, the first one first.
    pub fn errors(&self) -> impl Iterator<Item = &Error> {
        self.kept.iter().filter_map(Outcome::error)
    }
}
