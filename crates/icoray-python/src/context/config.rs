//! Settings of a context, and its log: Python's logger "icoray".

use super::handle::in_python;
use crate::error::argument;
use icoray::did_you_mean;
use icoray_context::types::{ICORAY_LOG_DEBUG, ICORAY_LOG_ERROR, ICORAY_LOG_INFO, ICORAY_LOG_WARN, icoray_config};
use pyo3::prelude::*;
use std::ffi::{CStr, CString, c_char, c_void};
use std::ptr;

/// A config, with the addresses in it.
pub(super) struct Config(icoray_config);

// SAFETY: the directory is read, and the callback may be called, on any thread.
unsafe impl Send for Config {}

impl Config {
    /// The settings with Python's log and the directory, which is borrowed.
    pub fn new(settings: icoray_config, output_dir: Option<&CString>) -> Self {
        Config(icoray_config {
            struct_size: size_of::<icoray_config>(),
            output_dir: output_dir.map_or(ptr::null(), |directory| directory.as_ptr()),
            // The logger of Python chooses.
            log_level: ICORAY_LOG_DEBUG,
            log: Some(log_to_python),
            ..settings
        })
    }

    pub fn get(&self) -> &icoray_config {
        &self.0
    }
}

/// The number of a word.
pub(super) fn chosen(name: &str, word: &str, words: &[(&str, i32)]) -> PyResult<i32> {
    let found = words.iter().find(|(known, _)| *known == word).map(|(_, number)| *number);
    found.ok_or_else(|| {
        let known: Vec<&str> = words.iter().map(|(known, _)| *known).collect();
        let hint = did_you_mean(word, known.iter().copied());
        argument(format!("{name}: {word:?}{hint}, expected one of {known:?}"))
    })
}

/// Passes a line on to the logger. A failure there is reported as Python reports those of destructors.
///
/// # Safety
/// `message` is a string for the time of the call.
unsafe extern "C" fn log_to_python(_user: *mut c_void, level: i32, message: *const c_char) {
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
