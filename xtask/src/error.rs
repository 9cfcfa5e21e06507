//! Errors of the subcommands.

use std::fmt;

/// Number of lines of details that a summary of an error shows.
pub const BRIEF: usize = 5;

/// Why a subcommand ended early.
#[derive(Debug, PartialEq)]
pub enum Error {
    /// A file that cannot be read, a picture that is missing, and the like.
    Failed(String),
    /// A sentence on what failed, and lines of details: the output of a command, or a reason per package.
    Detailed { sentence: String, details: String },
}

impl Error {
    /// For `map_err`: puts `what` was done, or with which file, before the cause.
    pub fn while_doing<E: fmt::Display>(what: impl fmt::Display) -> impl FnOnce(E) -> Error {
        move |cause| Error::Failed(format!("{what}: {cause}"))
    }

    /// The first line, and the last few lines of the details, indented.
    pub fn brief(&self) -> String {
        let text = self.to_string();
        let (sentence, details) = text.split_once('\n').unwrap_or((&text, ""));
        let lines = last_lines(details, BRIEF).into_iter().map(|line| format!("\n    {}", line.trim_start()));
        sentence.to_owned() + &lines.collect::<String>()
    }
}

/// The last `count` lines that are not blank.
pub fn last_lines(text: &str, count: usize) -> Vec<&str> {
    let lines: Vec<_> = text.lines().map(str::trim_end).filter(|line| !line.is_empty()).collect();
    lines[lines.len().saturating_sub(count)..].to_vec()
}

impl From<xshell::Error> for Error {
    fn from(error: xshell::Error) -> Self {
        Error::Failed(error.to_string())
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::Failed(message) => f.write_str(message),
            Error::Detailed { sentence, details } => f.write_str(format!("{sentence}\n{details}").trim_end()),
        }
    }
}
