//! Statuses, messages and panics at the boundary: nothing unwinds into the model and nothing prints.

use crate::types::icoray_status;
use icoray_core::{Error, ErrorKind};
use std::cell::RefCell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Once;

/// Why a call failed: the status for the caller and the sentence for icoray_last_error.
#[derive(Debug, Clone)]
pub(crate) struct Failure {
    pub status: icoray_status,
    pub message: String,
}

impl Failure {
    pub fn new(status: icoray_status, message: impl Into<String>) -> Self {
        Failure { status, message: message.into() }
    }

    /// A pointer that must not be NULL.
    pub fn null(what: &str) -> Self {
        Self::new(icoray_status::ICORAY_ERR_NULL, format!("{what} is NULL"))
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        use icoray_status::*;
        let status = match error.kind() {
            ErrorKind::Argument => ICORAY_ERR_ARGUMENT,
            ErrorKind::Grid => ICORAY_ERR_GRID,
            ErrorKind::Unsupported => ICORAY_ERR_UNSUPPORTED,
            ErrorKind::Layers => ICORAY_ERR_LAYERS,
            ErrorKind::Field => ICORAY_ERR_FIELD,
            ErrorKind::Scene => ICORAY_ERR_SCENE,
            ErrorKind::Order => ICORAY_ERR_ORDER,
            ErrorKind::Io => ICORAY_ERR_IO,
            _ => ICORAY_ERR_INTERNAL,
        };
        Self::new(status, error.to_string())
    }
}

/// Result of a call before it becomes a status.
pub(crate) type Outcome<T> = Result<T, Failure>;

thread_local! {
    static LAST: RefCell<String> = const { RefCell::new(String::new()) };
}

/// This thread's last message, for calls that have no context to keep it.
pub(crate) fn last_message() -> String {
    LAST.with_borrow(Clone::clone)
}

/// Runs `call`, turns a panic into a failure, and keeps the message for this thread.
pub(crate) fn guarded(call: impl FnOnce() -> Outcome<()>) -> Outcome<()> {
    // Rust prints a panic's message by itself; a library in someone's model must not. The library has its own copy
    // of the standard library, so the hook is nobody else's.
    static QUIET: Once = Once::new();
    QUIET.call_once(|| std::panic::set_hook(Box::new(|_| {})));
    let outcome = catch_unwind(AssertUnwindSafe(call)).unwrap_or_else(|payload| {
        let text = payload
            .downcast_ref::<&str>()
            .map(ToString::to_string)
            .or_else(|| payload.downcast_ref::<String>().cloned());
        let text = text.unwrap_or_else(|| "a panic without a message".into());
        Err(Failure::new(icoray_status::ICORAY_ERR_INTERNAL, format!("internal error: {text}")))
    });
    if let Err(failure) = &outcome {
        LAST.with_borrow_mut(|last| last.clone_from(&failure.message));
    }
    outcome
}

/// The status of an outcome.
pub(crate) fn status(outcome: &Outcome<()>) -> icoray_status {
    outcome.as_ref().map_or_else(|failure| failure.status, |()| icoray_status::ICORAY_OK)
}
