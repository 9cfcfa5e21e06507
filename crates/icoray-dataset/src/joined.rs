//! Fields of several files of one mesh, joined by the dates of their times.

use crate::dataset::Dataset;
use crate::field::FieldInfo;
use icoray::{ErrorKind, Result};

impl Dataset {
    /// Joins the fields of a file of the same mesh, such as another output stream: those that this file lacks are read
    /// there, at the record of the same date. Times, steps and the mesh stay those of this file.
    ///
    /// # Errors
    /// [`ErrorKind::Grid`] when the other mesh has more or fewer cells or corners.
    pub fn join(&mut self, file: Dataset) -> Result<()> {
        self.expect_mesh_of(&file)?;
        let lacking = file.fields().iter().filter(|info| self.fields.iter().all(|known| known.name != info.name));
        let lacking: Vec<_> = lacking.cloned().collect();
        self.fields.extend(lacking);
        self.joined.push(file);
        Ok(())
    }

    /// Makes this a dataset of differences: the values of each field minus those of another dataset of the same mesh
    /// and layers, at the same date, or at the same record if there are no dates. Fields that the other lacks are left
    /// out.
    ///
    /// # Errors
    /// As [`Dataset::join`]. Reading a field fails where the other has no record of its date, or other layers.
    pub fn subtract(&mut self, other: Dataset) -> Result<()> {
        self.expect_mesh_of(&other)?;
        let from = other.path().file_name().unwrap_or_default().to_string_lossy().into_owned();
        self.fields.retain(|info| other.fields().iter().any(|other| other.name == info.name));
        self.own_fields = self.fields.len();
        for FieldInfo { name, description, .. } in &mut self.fields {
            description.long_name = Some(format!("{}, less {from}", description.long_name.as_ref().unwrap_or(name)));
        }
        self.minus = Some(Box::new(other));
        Ok(())
    }

    fn expect_mesh_of(&self, other: &Dataset) -> Result<()> {
        let (own, its) = (self.mesh(), other.mesh());
        if (own.cells(), own.corners()) == (its.cells(), its.corners()) {
            return Ok(());
        }
        let (cells, expected, path) = (its.cells(), own.cells(), self.path().display());
        let context = format!("a mesh of {cells} cells, expected {expected} as in {path}");
        Err(other.error(ErrorKind::Grid, context))
    }

    /// The record of a field in another dataset at a time of this one: records of the same date belong together, or in
    /// datasets without dates those of the same number. A field that does not depend on time has one at all times.
    pub(crate) fn record_in(&self, other: &Dataset, name: &str, time: usize) -> Result<usize> {
        if !other.field_info(name)?.time_dependent {
            return Ok(0);
        }
        let date = self.times().get(time);
        let is_same = |its: &Option<String>| Some(its) == date;
        let record = match date {
            Some(None) => other.times().get(time).filter(|its| is_same(its)).map(|_| time),
            _ => other.times().iter().position(is_same),
        };
        record.ok_or_else(|| {
            let date = date.and_then(Option::as_deref).unwrap_or("no date");
            other.error(ErrorKind::Field, format_args!("{name} has no record of time {time} ({date})"))
        })
    }

    /// The dataset of the file that contains a field: this one or a joined one.
    pub(crate) fn owner(&self, name: &str) -> &Dataset {
        self.joined_with(name).unwrap_or(self)
    }

    /// The joined file that contains a field; `None` for the fields of this file.
    pub(crate) fn joined_with(&self, name: &str) -> Option<&Dataset> {
        if self.joined.is_empty() || self.has_own(name) {
            return None;
        }
        self.joined.iter().find(|file| file.fields().iter().any(|info| info.name == name))
    }
}
