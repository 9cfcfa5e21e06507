//! Runs work that Ctrl-C can interrupt.

use crate::turn::POLL;
use pyo3::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::thread;

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
        stop.store(interrupted.is_err(), Ordering::Relaxed);
        let result = worker.join();
        stop.store(false, Ordering::Relaxed);
        interrupted?;
        Ok(result.unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
    })
}
