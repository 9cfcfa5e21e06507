//! Errors of the subcommands.

use std::fmt;

/// Number of lines of details that a summary of an error shows.
pub const BRIEF: usize = 5;

/// Why a subcommand ended early: a sentence, and lines of details such as the output of a command.
#[derive(Debug, PartialEq)]
pub struct Error(pub String);

impl Error {
    /// For `map_err`: puts `what` was done, or with which file, before the cause.
    pub fn while_doing<E: fmt::Display>(what: impl fmt::Display) -> impl FnOnce(E) -> Error {
        move |cause| Error(format!("{what}: {cause}"))
    }

    /// For `map_err`: puts lines of details below a sentence.
    pub fn with(details: &[String]) -> impl FnOnce(String) -> Error {
        move |sentence| Error(format!("{sentence}\n{}", details.join("\n")).trim_end().to_owned())
    }

    /// The first line, and the last few lines of the details, indented.
    pub fn brief(&self) -> String {
        let (sentence, details) = self.0.split_once('\n').unwrap_or((&self.0, ""));
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
        Error(error.to_string())
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}
