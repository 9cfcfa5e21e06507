//! The log: lines for the host's callback, on the host's thread.

use crate::host::as_caller;
use crate::message::fitted;
use crate::types::{
    ICORAY_LOG_DEBUG, ICORAY_LOG_ERROR, ICORAY_LOG_INFO, ICORAY_LOG_OFF, ICORAY_LOG_WARN, icoray_log_fn,
};
use std::ffi::{CStr, CString, c_char, c_void};
use std::io::Write;

/// Severity of a line; the numbers are the ABI's.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Level {
    Error = ICORAY_LOG_ERROR as isize,
    Warn = ICORAY_LOG_WARN as isize,
    Info = ICORAY_LOG_INFO as isize,
    Debug = ICORAY_LOG_DEBUG as isize,
}

/// The callback of the host.
pub(crate) struct Log {
    callback: icoray_log_fn,
    user: *mut c_void,
    max_level: i32,
}

// SAFETY: `user` is only passed on, to the callback, inside calls on the context, on the thread that makes the call.
unsafe impl Send for Log {}

impl Log {
    pub const LEVELS: std::ops::RangeInclusive<i32> = ICORAY_LOG_OFF..=ICORAY_LOG_DEBUG;

    pub fn new(callback: icoray_log_fn, user: *mut c_void, max_level: i32) -> Self {
        Log { callback, user, max_level }
    }

    /// Whether lines of `level` are logged: for lines that are costly to build.
    pub fn takes(&self, level: Level) -> bool {
        self.callback.is_some() && level as i32 <= self.max_level
    }

    pub fn say(&self, level: Level, message: &str) {
        if !self.takes(level) {
            return;
        }
        // Without a NUL inside, as control characters are escaped.
        let line = CString::new(fitted(message).as_bytes()).unwrap_or_default();
        if let Some(callback) = self.callback {
            // SAFETY: the host promises a callback that takes a string for the time of the call.
            as_caller(|| unsafe { callback(self.user, level as i32, line.as_ptr()) });
        }
    }
}

/// A log callback for icoray_config.log that writes lines such as "icoray: warning: ..." to stderr.
///
/// # Safety
/// `message` is NULL or a string.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn icoray_log_stderr(user: *mut c_void, level: i32, message: *const c_char) {
    let _ = user;
    if message.is_null() {
        return;
    }
    let word = match level {
        ICORAY_LOG_ERROR => "error: ",
        ICORAY_LOG_WARN => "warning: ",
        _ => "",
    };
    // SAFETY: not NULL; the caller promises the NUL at its end.
    let message = unsafe { CStr::from_ptr(message) }.to_string_lossy();
    // One write, so that the lines of several ranks do not mix; a closed stderr is no reason to fail.
    let _ = std::io::stderr().write_all(format!("icoray: {word}{message}\n").as_bytes());
}
