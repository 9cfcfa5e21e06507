//! What can go wrong, told apart by the exit code it leads to.

use std::fmt;

/// Why a subcommand ended early.
#[derive(Debug, PartialEq)]
pub enum Error {
    /// The arguments make no sense; the usage is shown beside the message.
    Usage(String),
    /// Anything else: a command that failed, a file that cannot be read.
    Failed(String),
}

impl Error {
    /// For use with `map_err`: says what was being done when `cause` came up.
    pub fn while_doing<E: fmt::Display>(what: impl fmt::Display) -> impl FnOnce(E) -> Error {
        move |cause| Error::Failed(format!("{what}: {cause}"))
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::Usage(message) | Error::Failed(message) => f.write_str(message),
        }
    }
}
