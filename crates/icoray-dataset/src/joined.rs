//! Fields of several files of one mesh, joined by the dates of their times.

use crate::dataset::Dataset;
use crate::field::FieldInfo;
use icoray::{Error, ErrorKind, Result};

/// A file whose fields are joined to those of another.
#[derive(Debug)]
pub(crate) struct Joined {
    pub(crate) file: Dataset,
    /// The record of each time of the other file; `None` if this file has none of that date.
    records: Vec<Option<usize>>,
    /// Dates of the other file, for errors.
    dates: Vec<Option<String>>,
}

impl Joined {
    /// A file of the same mesh beside another, `own`: records of the same date belong together, or in files without
    /// dates those of the same number.
    fn new(own: &Dataset, file: Dataset) -> Result<Self> {
        if (own.mesh().cells(), own.mesh().corners()) != (file.mesh().cells(), file.mesh().corners()) {
            let context = format!(
                "{}: a mesh of {} cells, expected {} as in {}",
                file.path().display(),
                file.mesh().cells(),
                own.mesh().cells(),
                own.path().display()
            );
            return Err(Error::new(ErrorKind::Grid, context));
        }
        let record = |(number, date): (usize, &Option<String>)| match date {
            Some(date) => file.times().iter().position(|its| its.as_ref() == Some(date)),
            None => file.times().get(number).filter(|its| its.is_none()).map(|_| number),
        };
        let records = own.times().iter().enumerate().map(record).collect();
        Ok(Joined { records, dates: own.times().to_vec(), file })
    }

    /// The record of a field at a time of the other file. A field that does not depend on time has one at all times.
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
    /// Joins the fields of a file of the same mesh, such as another output stream: those that this file lacks are read
    /// there, at the record of the same date. Times, steps and the mesh stay those of this file.
    ///
    /// # Errors
    /// [`ErrorKind::Grid`] when the other mesh has more or fewer cells or corners.
    pub fn join(&mut self, file: Dataset) -> Result<()> {
        let joined = Joined::new(self, file)?;
        let lacking =
            joined.file.fields().iter().filter(|info| self.fields.iter().all(|known| known.name != info.name));
        let lacking: Vec<_> = lacking.cloned().collect();
        self.fields.extend(lacking);
        self.joined.push(joined);
        Ok(())
    }

    /// Makes this a dataset of differences: the values of each field minus those of another dataset of the same mesh
    /// and layers, at the same date, or at the same record if there are no dates. Fields that the other lacks are left
    /// out.
    ///
    /// # Errors
    /// As [`Dataset::join`]. Reading a field fails where the other has no record of its date, or other layers.
    pub fn subtract(&mut self, other: Dataset) -> Result<()> {
        let minus = Joined::new(self, other)?;
        let from = minus.file.path().file_name().unwrap_or_default().to_string_lossy().into_owned();
        self.fields.retain(|info| minus.file.fields().iter().any(|other| other.name == info.name));
        self.own_fields = self.fields.len();
        for FieldInfo { name, description, .. } in &mut self.fields {
            description.long_name = Some(format!("{}, less {from}", description.long_name.as_ref().unwrap_or(name)));
        }
        self.minus = Some(Box::new(minus));
        Ok(())
    }

    /// The dataset of the file that contains a field: this one or a joined one.
    pub(crate) fn owner(&self, name: &str) -> &Dataset {
        self.joined_with(name).map_or(self, |joined| &joined.file)
    }

    /// The joined file that contains a field; `None` for the fields of this file.
    pub(crate) fn joined_with(&self, name: &str) -> Option<&Joined> {
        if self.joined.is_empty() || self.has_own(name) {
            return None;
        }
        self.joined.iter().find(|joined| joined.file.fields().iter().any(|info| info.name == name))
    }
}
