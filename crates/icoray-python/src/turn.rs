//! One frame at a time on a renderer: threads take turns, and a waiting one can be interrupted.

use crate::error::of_class;
use pyo3::PyResult;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{ThreadId, current};
use std::time::Duration;

/// How often a thread that waits looks for signals.
pub(crate) const POLL: Duration = Duration::from_millis(50);

/// Whose turn it is.
#[derive(Debug, Default)]
pub(crate) struct Turn {
    holder: Mutex<Option<ThreadId>>,
    freed: Condvar,
}

/// A turn; dropping it ends it.
pub(crate) struct Held<'a>(&'a Turn);

impl Turn {
    /// Waits for the turn; `check` is called again and again, and its error ends the wait.
    pub fn take(&self, check: impl Fn() -> PyResult<()>) -> PyResult<Held<'_>> {
        loop {
            let mut holder = self.lock();
            if *holder == Some(current().id()) {
                // A signal's handler that draws while this thread draws.
                return Err(of_class("BusyError", "this thread draws a frame with the renderer already".into()));
            }
            if holder.is_some() {
                holder = self.freed.wait_timeout(holder, POLL).unwrap_or_else(PoisonError::into_inner).0;
            }
            if holder.is_none() {
                *holder = Some(current().id());
                return Ok(Held(self));
            }
            drop(holder);
            check()?;
        }
    }

    fn lock(&self) -> MutexGuard<'_, Option<ThreadId>> {
        self.holder.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Held<'_> {
    fn drop(&mut self) {
        *self.0.lock() = None;
        self.0.freed.notify_one();
    }
}
