//! Fields of several files of one mesh, joined by the dates of their times.

use crate::dataset::Dataset;
use icoray::{Error, ErrorKind, Result};

/// A file whose fields are joined to those of another.
#[derive(Debug)]
pub(crate) struct Joined {
    pub(crate) file: Dataset,
    /// The record of each time of the other file; `None` where this file has none of that date.
    records: Vec<Option<usize>>,
    /// Dates of the other file, for errors.
    dates: Vec<Option<String>>,
}

impl Joined {
    /// The record of a field at a time of the other file. A field that does not depend on time has all.
    pub(crate) fn record(&self, name: &str, time: usize) -> Result<usize> {
        if !self.file.field_info(name)?.time_dependent {
            return Ok(0);
        }
        self.records.get(time).copied().flatten().ok_or_else(|| {
            let date = self.dates.get(time).and_then(Option::as_deref).unwrap_or("no date");
            let context = format!("{}: {name} has no record of time {time} ({date})", self.file.path().display());
            Error::new(ErrorKind::Field, context)
        })
    }
}

impl Dataset {
    /// Joins the fields of a file of the same mesh, as of another output stream: those that this file lacks are read
    /// there, at the record of the same date. Times, steps and the mesh stay those of this file.
    ///
    /// # Errors
    /// [`ErrorKind::Grid`] when the other mesh has more or fewer cells or corners.
    pub fn join(&mut self, file: Dataset) -> Result<()> {
        let (own, other) = (self.mesh(), file.mesh());
        if (own.cells(), own.corners()) != (other.cells(), other.corners()) {
            let context = format!(
                "{}: a mesh of {} cells, expected {} as in {}",
                file.path().display(),
                other.cells(),
                own.cells(),
                self.path().display()
            );
            return Err(Error::new(ErrorKind::Grid, context));
        }
        let record = |date: &Option<String>| {
            let date = date.as_ref()?;
            file.times().iter().position(|its| its.as_ref() == Some(date))
        };
        let records = self.times().iter().map(record).collect();
        let dates = self.times().to_vec();
        let lacking = file.fields().iter().filter(|info| self.fields.iter().all(|known| known.name != info.name));
        let lacking: Vec<_> = lacking.cloned().collect();
        self.fields.extend(lacking);
        self.joined.push(Joined { file, records, dates });
        Ok(())
    }

    /// The joined file that a field is read from; `None` for the fields of this file.
    pub(crate) fn joined_with(&self, name: &str) -> Option<&Joined> {
        if self.joined.is_empty() || self.has_own(name) {
            return None;
        }
        self.joined.iter().find(|joined| joined.file.fields().iter().any(|info| info.name == name))
    }
}
