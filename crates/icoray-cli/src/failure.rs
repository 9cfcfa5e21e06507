//! Errors of commands.

use std::{fmt, io};

pub type CommandResult<T = ()> = Result<T, Failure>;

/// An error of the library, or of writing to stdout.
pub enum Failure {
    Icoray(icoray::Error),
    Stdout(io::Error),
    /// The error is reported by rank 0.
    ReportedByRoot,
}

impl Failure {
    /// The error as sent to other ranks.
    pub fn to_error(&self) -> icoray::Error {
        match self {
            Failure::Icoray(e) => e.clone(),
            other => icoray::Error::new(icoray::ErrorKind::Io, other.to_string()),
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Failure::Icoray(e) => e.fmt(f),
            Failure::Stdout(e) => write!(f, "cannot write to stdout: {e}"),
            Failure::ReportedByRoot => f.write_str("reported by rank 0"),
        }
    }
}

impl From<icoray::Error> for Failure {
    fn from(e: icoray::Error) -> Self {
        Failure::Icoray(e)
    }
}

impl From<io::Error> for Failure {
    fn from(e: io::Error) -> Self {
        Failure::Stdout(e)
    }
}
