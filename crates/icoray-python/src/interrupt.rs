//! Work that Ctrl-C can interrupt: frames, one at a time on a renderer, and their progress.

use crate::error::of_class;
use pyo3::prelude::*;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, ThreadId, current};
use std::time::Duration;

/// How often a thread that waits looks for signals.
const POLL: Duration = Duration::from_millis(50);

/// Runs Python's handlers of signals that have come; the error is what they raise, such as KeyboardInterrupt.
pub(crate) fn check_signals() -> PyResult<()> {
    Python::attach(|py| py.check_signals())
}

/// Whether this is the thread on which Python handles signals.
pub(crate) fn is_main_thread(py: Python) -> PyResult<bool> {
    let threading = py.import("threading")?;
    Ok(threading.call_method0("current_thread")?.is(&threading.call_method0("main_thread")?))
}

/// Does `work` on another thread while this one calls `tick` again and again, which looks for signals. Its error, such
/// as that of a signal's handler, sets `stop`, at which the work ends soon. Called without Python's lock.
pub(crate) fn interruptible<R: Send>(
    stop: &AtomicBool,
    tick: impl Fn() -> PyResult<()>,
    work: impl FnOnce() -> R + Send,
) -> PyResult<R> {
    thread::scope(|threads| {
        let (done, is_done) = sync_channel::<()>(1);
        let worker = threads.spawn(move || {
            let result = work();
            // The receiver is gone after an interruption.
            let _ = done.send(());
            result
        });
        let mut interrupted = Ok(());
        while interrupted.is_ok() && is_done.recv_timeout(POLL) == Err(RecvTimeoutError::Timeout) {
            interrupted = tick();
        }
        stop.store(interrupted.is_err(), Relaxed);
        let result = worker.join();
        stop.store(false, Relaxed);
        interrupted?;
        Ok(result.unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
    })
}

/// The thread that draws with a renderer: threads take turns, and a waiting one can be interrupted.
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

/// Numbers of tiles that are drawn, and of all: rendering threads count, the waiting thread reports.
#[derive(Debug, Default)]
pub(crate) struct Tiles {
    drawn: AtomicUsize,
    all: AtomicUsize,
}

impl Tiles {
    pub fn reset(&self) {
        self.drawn.store(0, Relaxed);
        self.all.store(0, Relaxed);
    }

    /// Calls come in no order.
    pub fn count(&self, drawn: usize, all: usize) {
        self.drawn.fetch_max(drawn, Relaxed);
        self.all.store(all, Relaxed);
    }

    /// Reports the numbers to a function of Python, and looks for signals.
    pub fn report(&self, progress: &Py<PyAny>) -> PyResult<()> {
        let (drawn, all) = (self.drawn.load(Relaxed), self.all.load(Relaxed));
        Python::attach(|py| if all > 0 { progress.call1(py, (drawn, all)).map(drop) } else { Ok(()) })?;
        check_signals()
    }
}
