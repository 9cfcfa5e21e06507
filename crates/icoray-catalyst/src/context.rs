//! The context that draws, for the calls that this library makes.

use icoray::{Error, ErrorKind, Result, Team};
use icoray_context::boundary::Failure;
use icoray_context::icoray_ctx;
use icoray_context::log::icoray_log_stderr;
use icoray_context::types::{ICORAY_DISABLE, ICORAY_LOG_WARN, ICORAY_OVERWRITE, icoray_config};
use std::ffi::CStr;
use std::ops::Deref;

/// Directory of the pictures, in the host's working directory.
const OUTPUT_DIR: &CStr = c"pictures";

/// An open context; dropping it closes it, which is collective.
pub struct Context(Option<Box<icoray_ctx>>);

impl Context {
    /// Opens a context over ranks, or for one process. Collective.
    pub fn open(team: Option<Team>) -> Result<Self> {
        let config = icoray_config {
            struct_size: size_of::<icoray_config>(),
            output_dir: OUTPUT_DIR.as_ptr(),
            existing: ICORAY_OVERWRITE,
            on_error: ICORAY_DISABLE,
            log_level: ICORAY_LOG_WARN,
            log: Some(icoray_log_stderr),
            ..Default::default()
        };
        // SAFETY: a string that lives for ever, and a callback without a log_user.
        let opened = unsafe { icoray_ctx::open(&config, team) };
        Ok(Context(Some(opened.map_err(error)?)))
    }
}

impl Deref for Context {
    type Target = icoray_ctx;

    fn deref(&self) -> &icoray_ctx {
        self.0.as_ref().expect("the context is open until it is dropped")
    }
}

impl Drop for Context {
    fn drop(&mut self) {
        // The log has what failed.
        let _ = self.close();
        if self.is_forked() {
            std::mem::forget(self.0.take());
        }
    }
}

/// The failure of a call.
pub fn error(failure: Failure) -> Error {
    Error::new(ErrorKind::Argument, failure.message)
}
