//! The files that are read together: the one with the fields, and those with what it lacks.

use crate::source::{Source, Variable};
use icoray::{Error, ErrorKind, Result};
use std::path::Path;

/// Open files, of which the first has the fields.
#[derive(Debug)]
pub(crate) struct Sources(Vec<Source>);

impl Sources {
    pub(crate) fn open(path: &Path, others: &[impl AsRef<Path>]) -> Result<Self> {
        let mut sources = vec![Source::open(path)?];
        for other in others {
            sources.push(Source::open(other.as_ref())?);
        }
        Ok(Sources(sources))
    }

    /// The one with the fields.
    pub(crate) fn fields(&self) -> &Source {
        &self.0[0]
    }

    /// All of them, that with the fields first.
    pub(crate) fn all(&self) -> &[Source] {
        &self.0
    }

    /// All of them, that with the fields last: where tables of the mesh are looked for.
    pub(crate) fn others_first(&self) -> impl Iterator<Item = &Source> {
        self.0[1..].iter().chain(&self.0[..1])
    }

    /// The first file that has the variable, and the variable.
    pub(crate) fn find(&self, name: &str) -> Option<(&Source, &Variable)> {
        self.0.iter().find_map(|source| source.variable(name).map(|variable| (source, variable)))
    }

    /// The first number that a global attribute of a file has.
    pub(crate) fn number(&self, attribute: &str) -> Result<Option<f64>> {
        for source in self.all() {
            if let Some(number) = source.number(attribute)? {
                return Ok(Some(number));
            }
        }
        Ok(None)
    }

    /// An error about what none of the files has.
    pub(crate) fn error(&self, kind: ErrorKind, context: impl std::fmt::Display) -> Error {
        let paths: Vec<String> = self.0.iter().map(|source| source.path().display().to_string()).collect();
        Error::new(kind, format!("{}: {context}", paths.join(", ")))
    }
}
