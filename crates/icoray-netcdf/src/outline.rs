//! The contents of a file, read from its header and its times alone.

use crate::classic::{self, ClassicLayout};
use crate::nc_file::{NcFile, address};
use crate::zarr::Location;
use icoray::{Error, ErrorKind, Result};
use icoray_dataset::{Source, Times, Variable, variable_at_edges};
use std::path::Path;

/// Times and variables of a file, without its mesh: for a look at a file that a model may be writing. The file is
/// closed again.
#[derive(Debug, Clone)]
pub struct Outline {
    /// The time records.
    pub times: Times,
    /// The places of the variables in a classic file.
    classic: Option<ClassicLayout>,
    /// Length of a classic file, bytes.
    length: u64,
    variables: Vec<Variable>,
}

impl Outline {
    /// Reads header and times.
    ///
    /// # Errors
    /// [`ErrorKind::Io`]: the file is absent, not NetCDF, damaged or cut off.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let source = NcFile::open(path.as_ref())?;
        let times = Times::read(&source)?;
        let classic = source.classic.clone();
        let length = if classic.is_some() { source.length()? } else { 0 };
        Ok(Outline { times, classic, length, variables: source.variables().to_vec() })
    }

    /// Number of records of which a classic file has any byte, or that any other file says it has.
    pub fn begun_records(&self) -> usize {
        let begun = self.classic.as_ref().and_then(|layout| layout.begun_records(self.length));
        begun.unwrap_or(usize::MAX).min(self.times.dates.len())
    }

    /// Names of the variables of which there is one array per record.
    pub fn fields(&self) -> impl Iterator<Item = &str> {
        self.variables.iter().filter(|variable| variable.changes()).map(|variable| variable.name.as_str())
    }

    /// The variable of a field: that of its name, or the one at edges of which it is a component.
    fn variable(&self, field: &str) -> Option<&Variable> {
        let known = |name: &str| self.variables.iter().find(|variable| variable.name == name);
        known(field).or_else(|| known(variable_at_edges(field)?))
    }

    /// Whether the file has the variable of a field.
    pub fn has(&self, field: &str) -> bool {
        self.variable(field).is_some()
    }

    /// Whether the file has the variable of a field, and by its header a record of it. A variable that does not depend
    /// on time has all records.
    pub fn promises(&self, field: &str, record: usize) -> bool {
        let records =
            |variable: &Variable| if variable.changes() { self.times.records } else { self.times.dates.len() };
        self.variable(field).is_some_and(|variable| record < records(variable))
    }

    /// As [`Outline::promises`], of a record that a classic file does not end before.
    pub fn has_record(&self, field: &str, record: usize) -> bool {
        let end = self.classic.as_ref().zip(self.variable(field));
        let end = end.and_then(|(layout, variable)| layout.end(&variable.name, record + 1));
        self.promises(field, record) && end.is_none_or(|end| end <= self.length)
    }

    /// Whether the file is a classic one (CDF-1, CDF-2, CDF-5). Damaged ones are read safely; in NetCDF-4 files, and so
    /// in those that are being written, damage may end or hang the process inside the HDF5 library. What an address
    /// names is taken for NetCDF-4.
    ///
    /// # Errors
    /// [`ErrorKind::Io`]: the file cannot be opened.
    pub fn is_classic(path: impl AsRef<Path>) -> Result<bool> {
        let path = path.as_ref();
        if address(path).is_some() || Location::of(path).is_some() {
            return Ok(false);
        }
        classic::is_classic(path).map_err(|e| Error::new(ErrorKind::Io, format!("{}: {e}", path.display())))
    }

    /// Opens a file and reads `record` of the variables of `fields`, and all variables that do not change, as far as
    /// they are numbers; keeps nothing. For a process of its own, which may end by it.
    ///
    /// # Errors
    /// As [`Outline::read`].
    pub fn try_reading(path: impl AsRef<Path>, fields: &[String], record: usize) -> Result<()> {
        let source = NcFile::open(path.as_ref())?;
        Times::read(&source)?;
        for variable in source.variables() {
            source.try_attributes(&variable.name)?;
            let changes = variable.changes();
            let is_of = |field: &String| *field == variable.name || variable_at_edges(field) == Some(&variable.name);
            if !variable.kind.is_number() || changes && !fields.iter().any(is_of) {
                continue;
            }
            let (mut start, mut count) = variable.whole();
            if changes {
                start[0] = record;
                count[0] = 1;
            }
            source.reals(variable, &start, &count)?;
        }
        Ok(())
    }
}
