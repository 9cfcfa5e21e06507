//! Errors of MPI.

use icoray::{Error, ErrorKind, Result};
use mpi::ffi;
use std::ffi::{c_char, c_int};

pub(crate) fn failed(message: String) -> Error {
    Error::new(ErrorKind::Mpi, message)
}

/// Converts the error code of an MPI function, with MPI's own description.
pub(crate) fn check(call: &str, code: c_int) -> Result<()> {
    if code == ffi::MPI_SUCCESS as c_int {
        return Ok(());
    }
    let mut text = [0u8; 1024];
    let mut length = 0;
    // SAFETY: longer than MPI_MAX_ERROR_STRING of either MPI; a code that is none of MPI's is an error of this call.
    unsafe { ffi::MPI_Error_string(code, text.as_mut_ptr().cast::<c_char>(), &mut length) };
    let text = String::from_utf8_lossy(&text[..usize::try_from(length).unwrap_or(0).min(text.len())]);
    Err(failed(format!("{call} failed with {code}: {text}")))
}
