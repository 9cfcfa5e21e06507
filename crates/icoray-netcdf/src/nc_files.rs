//! Files that are read together: the one with the fields, and others with mesh or heights.

use crate::nc_file::{Dimension, NcFile, Variable};
use icoray::{Error, ErrorKind, Result};
use std::path::Path;

/// Open files, of which the first has the fields.
#[derive(Debug)]
pub(crate) struct NcFiles(Vec<NcFile>);

impl NcFiles {
    pub(crate) fn open(path: &Path, others: &[impl AsRef<Path>]) -> Result<Self> {
        let mut sources = vec![NcFile::open(path)?];
        for other in others {
            sources.push(NcFile::open(other.as_ref())?);
        }
        Ok(NcFiles(sources))
    }

    /// The file with the fields.
    pub(crate) fn fields(&self) -> &NcFile {
        &self.0[0]
    }

    /// All files, the one with the fields first.
    pub(crate) fn all(&self) -> &[NcFile] {
        &self.0
    }

    /// All files, the one with the fields last: the order of the search for mesh tables.
    pub(crate) fn others_first(&self) -> impl Iterator<Item = &NcFile> {
        self.0[1..].iter().chain(&self.0[..1])
    }

    /// The first file that has the variable, and the variable.
    pub(crate) fn find(&self, name: &str) -> Option<(&NcFile, &Variable)> {
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

    /// Whether a variable has one record for each time of the fields.
    pub(crate) fn changes(&self, source: &NcFile, variable: &Variable) -> bool {
        std::ptr::eq(source, self.fields()) && variable.dimensions.first().is_some_and(Dimension::is_time)
    }

    /// The record of a variable for a field's `time`: the first in files without the fields.
    pub(crate) fn record(&self, source: &NcFile, variable: &Variable, time: usize) -> Result<usize> {
        let records = variable.dimensions.first().map_or(0, |dimension| dimension.len);
        let record = if std::ptr::eq(source, self.fields()) { time } else { 0 };
        if record < records {
            return Ok(record);
        }
        let context = format!("variable {variable} has no record {record}");
        Err(source.error(ErrorKind::Layers, context))
    }

    /// An error about all files.
    pub(crate) fn error(&self, kind: ErrorKind, context: impl std::fmt::Display) -> Error {
        let paths: Vec<String> = self.0.iter().map(|source| source.path().display().to_string()).collect();
        Error::new(kind, format!("{}: {context}", paths.join(", ")))
    }
}
