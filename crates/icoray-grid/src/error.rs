//! The one error type of the library.
//!
//! Wrong user data gives an [`Error`] whose message names the table, the row, the value and the expected value. A
//! broken invariant of icoray itself panics instead; the C boundary turns that into [`ErrorKind::Internal`].

use crate::printable;
use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// The kind of an error; its value is its status number in the C ABI.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ErrorKind {
    /// An argument is null, mis-sized, non-finite or out of its range.
    Argument = 3,
    /// A connectivity or coordinate table contradicts itself or another table.
    Grid = 4,
    /// The mesh is valid but of a kind that is not rendered (planar meshes, corners that join four cells).
    Unsupported = 5,
    /// Layer radii are not strictly monotone, not positive or not finite.
    Layers = 6,
    /// A field is missing or its shape does not fit the grid and layers.
    Field = 7,
    /// The scene text has a syntax error, an unknown key or a bad value.
    Scene = 8,
    /// A call came before the calls that it requires (for example execute before a grid was set).
    Order = 9,
    /// A file could not be read or written.
    Io = 10,
    /// A bug in icoray.
    Internal = 11,
    /// A file exists already and is not modified.
    Exists = 12,
    /// MPI failed, or ranks that draw one picture disagree.
    Mpi = 16,
    /// A grid or a frame needs more memory than is available.
    Memory = 17,
}

impl ErrorKind {
    /// Every kind, with the text that messages begin with.
    const TEXTS: [(ErrorKind, &str); 12] = [
        (ErrorKind::Argument, "bad argument"),
        (ErrorKind::Grid, "bad grid"),
        (ErrorKind::Unsupported, "not supported"),
        (ErrorKind::Layers, "bad layers"),
        (ErrorKind::Field, "bad field"),
        (ErrorKind::Scene, "bad scene"),
        (ErrorKind::Order, "call out of order"),
        (ErrorKind::Io, "input or output failed"),
        (ErrorKind::Exists, "file exists"),
        (ErrorKind::Internal, "internal error"),
        (ErrorKind::Mpi, "MPI"),
        (ErrorKind::Memory, "not enough memory"),
    ];

    /// The number of the kind: the status of the C ABI, also sent between ranks.
    pub fn number(self) -> i32 {
        self as i32
    }

    /// The kind with this number; [`ErrorKind::Internal`] if there is none.
    pub fn of_number(number: i32) -> Self {
        let found = Self::TEXTS.iter().find(|(kind, _)| kind.number() == number);
        found.map_or(ErrorKind::Internal, |(kind, _)| *kind)
    }
}

impl fmt::Display for ErrorKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let found = Self::TEXTS.iter().find(|(kind, _)| kind == self);
        f.write_str(found.map_or("error", |(_, text)| text))
    }
}

/// An error: its kind and a sentence that names the place, the value and the expected value, in one line: control
/// characters are escaped ([`printable`]).
#[derive(Debug, Clone, thiserror::Error)]
#[error("{kind}: {context}")]
pub struct Error {
    kind: ErrorKind,
    context: String,
}

/// Result with icoray's [`Error`].
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// Makes an error of `kind` with the sentence `context`.
    pub fn new(kind: ErrorKind, context: impl Into<String>) -> Self {
        Error { kind, context: printable(&context.into()).into_owned() }
    }

    /// An error of kind [`ErrorKind::Grid`].
    pub fn grid(context: impl Into<String>) -> Self {
        Error::new(ErrorKind::Grid, context)
    }

    /// The broad kind.
    pub fn kind(&self) -> ErrorKind {
        self.kind
    }

    /// The sentence without the kind.
    pub fn context(&self) -> &str {
        &self.context
    }

    /// Puts `prefix: ` before the sentence, for a caller that has the name of the file or field.
    #[must_use]
    pub fn within(self, prefix: impl fmt::Display) -> Self {
        Error::new(self.kind, format!("{prefix}: {}", self.context))
    }

    /// Puts the rank of the error before the sentence if there are several ranks.
    #[must_use]
    pub fn of_rank(self, rank: usize, ranks: usize) -> Self {
        if ranks == 1 { self } else { self.within(format_args!("rank {rank}")) }
    }

    /// Puts ` (note)` after the sentence.
    #[must_use]
    pub fn after(self, note: impl fmt::Display) -> Self {
        Error::new(self.kind, format!("{} ({note})", self.context))
    }

    /// Calls `work`; a panic in it becomes an error of kind [`ErrorKind::Internal`] with the panic's message, so that a
    /// thread continues. A panic must not leave data that `work` can reach half-changed.
    ///
    /// # Errors
    /// Those of `work`, and [`ErrorKind::Internal`] for a panic.
    pub fn of_panics<T>(work: impl FnOnce() -> Result<T>) -> Result<T> {
        catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|payload| {
            let text = payload.downcast_ref::<&str>().map(ToString::to_string);
            let text = text.or_else(|| payload.downcast_ref::<String>().cloned());
            Err(Error::new(ErrorKind::Internal, text.unwrap_or_else(|| "a panic without a message".into())))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_is_one_line() {
        let error = Error::grid("a\nb").within("dir\u{1b}[31m").after("c\r");
        assert_eq!(error.to_string(), r"bad grid: dir\u{1b}[31m: a\nb (c\r)");
    }
}
