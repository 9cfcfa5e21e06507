//! The log of contexts: Python's logger "icoray".

use super::handle::in_python;
use icoray_context::types::{ICORAY_LOG_ERROR, ICORAY_LOG_INFO, ICORAY_LOG_WARN};
use pyo3::prelude::*;
use std::ffi::{CStr, c_char, c_void};

/// Passes a line on to the logger. A failure there is reported as Python reports those of destructors.
///
/// # Safety
/// `message` is a string for the time of the call.
pub(super) unsafe extern "C" fn log_to_python(_user: *mut c_void, level: i32, message: *const c_char) {
    // SAFETY: the caller's.
    let message = unsafe { CStr::from_ptr(message) }.to_string_lossy();
    // Python's logger is not available while the interpreter ends.
    let _ = Python::try_attach(|py| {
        if let Err(error) = log(py, level, &message) {
            error.write_unraisable(py, None);
        }
    });
}

fn log(py: Python, level: i32, message: &str) -> PyResult<()> {
    let level = match level {
        ICORAY_LOG_ERROR => 40,
        ICORAY_LOG_WARN => 30,
        ICORAY_LOG_INFO => 20,
        _ => 10,
    };
    let logger = py.import("logging")?.call_method1("getLogger", ("icoray",))?;
    logger.call_method1("log", (level, "%s", in_python(message)))?;
    Ok(())
}
