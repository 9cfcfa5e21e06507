//! Statuses, messages and panics at the boundary: nothing unwinds into the model and nothing prints.

use crate::host::FloatingPoint;
use crate::message::fitted;
use crate::types::icoray_status;
use icoray_core::Error;
use serde::{Deserialize, Serialize};
use std::cell::RefCell;
use std::fmt::Display;
use std::sync::Once;

impl icoray_status {
    /// The status of a number that another rank sent.
    pub fn of_number(number: i32) -> Self {
        bytemuck::checked::try_cast(number).unwrap_or(icoray_status::ICORAY_ERR_INTERNAL)
    }
}

/// Why a call failed: the status for the caller and the sentence for icoray_last_error.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Failure {
    /// The status.
    pub status: icoray_status,
    /// The sentence.
    pub message: String,
}

impl Failure {
    pub(crate) fn new(status: icoray_status, message: impl Into<String>) -> Self {
        Failure { status, message: message.into() }
    }

    /// Prefixes the message with its subject.
    pub(crate) fn within(self, what: impl Display) -> Self {
        Self::new(self.status, format!("{what}: {}", self.message))
    }

    /// Prefixes the message with the step.
    pub(crate) fn at_step(self, step: i64) -> Self {
        self.within(format_args!("step {step}"))
    }

    /// Prefixes the message with the view, if it has a name.
    pub(crate) fn of_view(self, view: &str) -> Self {
        if view.is_empty() { self } else { self.within(format_args!("view {view:?}")) }
    }

    /// Prefixes the message with the step and the view.
    pub(crate) fn of_picture(self, view: &str, step: i64) -> Self {
        self.of_view(view).at_step(step)
    }

    /// A pointer that must not be NULL.
    pub(crate) fn null(what: &str) -> Self {
        Self::new(icoray_status::ICORAY_ERR_NULL, format!("{what} is NULL"))
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Self::new(icoray_status::of_number(error.kind().number()), error.to_string())
    }
}

/// Result of a call before it becomes a status.
pub type Outcome<T> = Result<T, Failure>;

/// The last failure of a thread, for calls without a context.
struct Last {
    message: String,
    /// Address of the context that refused the call, if that was the failure.
    refused_by: usize,
}

thread_local! {
    static LAST: RefCell<Last> = const { RefCell::new(Last { message: String::new(), refused_by: 0 }) };
}

/// This thread's last message; none while the thread ends.
pub(crate) fn last_message() -> String {
    LAST.try_with(|last| last.borrow().message.clone()).unwrap_or_default()
}

/// This thread's last message, if the context at `address` refused its last failed call.
pub(crate) fn last_refusal(address: usize) -> Option<String> {
    LAST.try_with(|last| {
        let last = last.borrow();
        (last.refused_by == address).then(|| last.message.clone())
    })
    .ok()
    .flatten()
}

/// Stores the address of the context that refused this thread's last failed call; 0 for none.
pub(crate) fn refused_by(address: usize) {
    let _ = LAST.try_with(|last| last.borrow_mut().refused_by = address);
}

/// Runs `call` and turns a panic into a failure.
pub(crate) fn caught<T>(call: impl FnOnce() -> Outcome<T>) -> Outcome<T> {
    // Rust's default hook prints the message of a panic, which a library must not. The library has its own copy of the
    // standard library, so replacing the hook affects no other code.
    static QUIET: Once = Once::new();
    QUIET.call_once(|| std::panic::set_hook(Box::new(|_| {})));
    Error::of_panics(|| Ok(call())).unwrap_or_else(|error| Err(error.into()))
}

/// Runs a call from outside in icoray's own floating-point state, turns a panic into a failure, shortens its message, and
/// keeps that for this thread.
pub(crate) fn guarded<T>(call: impl FnOnce() -> Outcome<T>) -> Outcome<T> {
    let _floating_point = FloatingPoint::set_default();
    caught(call).map_err(|failure| {
        let message = fitted(&failure.message).into_owned();
        // Destructors of the model's thread may call after this thread-local was destroyed.
        let _ = LAST.try_with(|last| *last.borrow_mut() = Last { message: message.clone(), refused_by: 0 });
        Failure { message, ..failure }
    })
}

/// Runs code of a binding as [`guarded`] runs calls from outside, for bindings that compute beside their calls.
///
/// # Errors
/// The message of a failure or panic, of at most 400 bytes.
pub fn protected(code: impl FnOnce() -> Result<(), String>) -> Result<(), String> {
    let call = || code().map_err(|message| Failure::new(icoray_status::ICORAY_ERR_INTERNAL, message));
    guarded(call).map_err(|failure| failure.message)
}

pub(crate) fn status(outcome: &Outcome<()>) -> icoray_status {
    outcome.as_ref().map_or_else(|failure| failure.status, |()| icoray_status::ICORAY_OK)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::handle::icoray_ctx;
    use crate::open::icoray_last_error;
    use crate::types::icoray_config;
    use std::ffi::{CStr, c_char, c_void};
    use std::process::Command;

    /// A config with one thread, and defaults else.
    pub(crate) fn config() -> icoray_config {
        icoray_config { struct_size: size_of::<icoray_config>(), threads: 1, ..Default::default() }
    }

    /// The last failure on a context, or of this thread.
    pub(crate) fn message(ctx: *const icoray_ctx) -> String {
        let mut buf = [0; 256];
        // SAFETY: NULL or open, and a buffer of the length given.
        let status = unsafe { icoray_last_error(ctx, buf.as_mut_ptr(), buf.len()) };
        assert_eq!(status, icoray_status::ICORAY_OK);
        // SAFETY: icoray_last_error ends it with NUL.
        unsafe { CStr::from_ptr(buf.as_ptr()) }.to_str().unwrap().to_owned()
    }

    /// A log callback that keeps lines in the vector of levels and texts that `user` points to.
    pub(crate) unsafe extern "C" fn keep_line(user: *mut c_void, level: i32, line: *const c_char) {
        // SAFETY: the test lends a vector, to calls on its own thread, and the log a string.
        let (lines, line) = unsafe { (&mut *user.cast::<Vec<(i32, String)>>(), CStr::from_ptr(line)) };
        lines.push((level, line.to_str().unwrap().to_owned()));
    }

    /// Restores the printing of failed assertions, which the hook suppresses.
    pub(crate) fn loud() {
        guarded(|| Ok(())).unwrap();
        drop(std::panic::take_hook());
    }

    /// Set in the process that panics on behalf of [`a_panic_becomes_a_status_and_prints_nothing`].
    const CHILD: &str = "ICORAY_TEST_PANICS";

    /// In its own process, whose stderr is captured and where no other test replaces the hook.
    #[test]
    fn a_panic_becomes_a_status_and_prints_nothing() {
        if std::env::var_os(CHILD).is_some() {
            std::process::exit(if panics_are_kept() { 0 } else { 1 });
        }
        let name = "boundary::tests::a_panic_becomes_a_status_and_prints_nothing";
        let output = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", name, "--nocapture", "--test-threads=1"])
            .env(CHILD, "1")
            .env("RUST_BACKTRACE", "1")
            .output()
            .unwrap();
        let stdout = String::from_utf8_lossy(&output.stdout);
        assert!(stdout.contains("running 1 test"), "{stdout}");
        assert!(output.status.success(), "the outcome of a panic was not as expected");
        assert_eq!(String::from_utf8_lossy(&output.stderr), "");
    }

    fn panics_are_kept() -> bool {
        let kept = |call: &dyn Fn() -> Outcome<()>, message: &str| {
            let outcome = guarded(call);
            status(&outcome) == icoray_status::ICORAY_ERR_INTERNAL
                && outcome.is_err_and(|failure| failure.message == message)
                && last_message() == message
        };
        let renderer = icoray_core::Renderer::new(1).unwrap();
        kept(&|| panic!("a plain one"), "internal error: a plain one")
            && kept(&|| panic!("number {}", 7), "internal error: number 7")
            && kept(&|| std::panic::panic_any(7), "internal error: a panic without a message")
            && kept(&|| renderer.run(|| panic!("on another thread")), "internal error: on another thread")
    }

    #[test]
    fn each_thread_keeps_its_last_failure() {
        loud();
        let fail = |message: &'static str| guarded::<()>(|| Err(Failure::null(message))).unwrap_err();
        fail("first");
        std::thread::spawn(move || {
            assert_eq!(last_message(), "");
            fail("elsewhere");
        })
        .join()
        .unwrap();
        assert_eq!(last_message(), "first is NULL");
        guarded(|| Ok(())).unwrap();
        assert_eq!(last_message(), "first is NULL", "a call that went well leaves the message");
    }

    #[test]
    fn every_kind_of_error_has_its_status() {
        use icoray_core::ErrorKind;
        use icoray_status::*;
        for (kind, expected) in [
            (ErrorKind::Argument, ICORAY_ERR_ARGUMENT),
            (ErrorKind::Grid, ICORAY_ERR_GRID),
            (ErrorKind::Unsupported, ICORAY_ERR_UNSUPPORTED),
            (ErrorKind::Layers, ICORAY_ERR_LAYERS),
            (ErrorKind::Field, ICORAY_ERR_FIELD),
            (ErrorKind::Scene, ICORAY_ERR_SCENE),
            (ErrorKind::Order, ICORAY_ERR_ORDER),
            (ErrorKind::Io, ICORAY_ERR_IO),
            (ErrorKind::Exists, ICORAY_ERR_EXISTS),
            (ErrorKind::Internal, ICORAY_ERR_INTERNAL),
            (ErrorKind::Mpi, ICORAY_ERR_MPI),
            (ErrorKind::Memory, ICORAY_ERR_MEMORY),
        ] {
            let failure = Failure::from(Error::new(kind, "why"));
            assert_eq!(failure.status, expected);
            assert_eq!(failure.message, format!("{kind}: why"));
        }
    }
}
