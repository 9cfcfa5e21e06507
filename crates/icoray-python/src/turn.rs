//! One frame at a time on a renderer: threads take turns, and a waiting one can be interrupted.

use crate::error::of_class;
use pyo3::PyResult;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{ThreadId, current};
use std::time::Duration;

/// How often a thread that waits looks for signals.
pub(crate) const POLL: Duration = Duration::from_millis(50);

/// The thread that draws.
#[derive(Debug, Default)]
pub(crate) struct Turn {
    owner: Mutex<Option<ThreadId>>,
    freed: Condvar,
}

/// A turn; dropping it ends it.
pub(crate) struct TurnGuard<'a>(&'a Turn);

impl Turn {
    /// Waits for the turn; `check` is called again and again, and its error ends the wait.
    pub fn take(&self, check: impl Fn() -> PyResult<()>) -> PyResult<TurnGuard<'_>> {
        loop {
            let mut owner = self.lock();
            if *owner == Some(current().id()) {
                // A signal's handler that draws while this thread draws.
                return Err(of_class("BusyError", "this thread draws a frame with the renderer already".into()));
            }
            if owner.is_some() {
                owner = self.freed.wait_timeout(owner, POLL).unwrap_or_else(PoisonError::into_inner).0;
            }
            if owner.is_none() {
                *owner = Some(current().id());
                return Ok(TurnGuard(self));
            }
            drop(owner);
            check()?;
        }
    }

    fn lock(&self) -> MutexGuard<'_, Option<ThreadId>> {
        self.owner.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for TurnGuard<'_> {
    fn drop(&mut self) {
        *self.0.lock() = None;
        self.0.freed.notify_one();
    }
}
