//! Why a command stopped.

use std::fmt;
use std::io;

/// An error of the library, or of writing to stdout.
pub enum Failure {
    /// The library's.
    Icoray(icoray::Error),
    /// What came of writing to stdout.
    Stdout(io::Error),
    /// What rank 0 says.
    SaidElsewhere,
}

impl Failure {
    /// Whether the reader of stdout went away, as `head` does: it has all that it wants.
    pub fn is_closed_pipe(&self) -> bool {
        matches!(self, Failure::Stdout(e) if e.kind() == io::ErrorKind::BrokenPipe)
    }

    /// The error that other ranks hear of.
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
            Failure::SaidElsewhere => f.write_str("said by rank 0"),
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
