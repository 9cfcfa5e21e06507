//! Files that are read together: the one with the fields, and others with mesh or heights.

use crate::source::{Source, SourceVariable};
use icoray::{Error, ErrorKind, Result};

/// Advice for missing tables or heights; option and argument have this name.
pub(crate) const IN_ANOTHER_FILE: &str =
    "what is missing may be in another file, such as the run's init or grid file: give that file as `mesh`";

/// Earth's radius in ICON and DYNAMICO, metres, for files without one.
pub(crate) const EARTH_M: f64 = 6_371_229.0;

/// Facts that the files of a dataset lack, and entries of dimensions that are neither columns, layers nor time.
#[derive(Debug, Clone, Default)]
pub struct DatasetOptions {
    /// Name of a dimension, and the entry along it, from 0, that is read for every variable.
    pub at: Vec<(String, usize)>,
    /// Heights above the sphere of the first and of the last layer of every field with layers, metres; those between
    /// are evenly spaced. They replace the heights of files.
    pub heights_m: Option<[f64; 2]>,
    /// Radius of the sphere, metres; it replaces that of files.
    pub radius_m: Option<f64>,
    /// Values that mark missing samples of every field, beside those of attributes.
    pub missing: Vec<f64>,
}

/// Open files, of which the first has the fields, and the user's options for them.
#[derive(Debug)]
pub(crate) struct Sources {
    files: Vec<Box<dyn Source>>,
    pub(crate) options: DatasetOptions,
}

impl Sources {
    pub(crate) fn new(fields: Box<dyn Source>, others: Vec<Box<dyn Source>>, options: DatasetOptions) -> Self {
        Sources { files: std::iter::once(fields).chain(others).collect(), options }
    }

    /// Checks the user's options.
    pub(crate) fn expect_options(&self) -> Result<()> {
        let bad = |what: String| Err(Error::new(ErrorKind::Argument, what));
        let DatasetOptions { at, heights_m, radius_m, .. } = &self.options;
        for (name, entry) in at {
            let mut found = None;
            for source in self.all() {
                found = found.max(source.dimension_len(name)?);
            }
            match found {
                None => return bad(format!("at {name}={entry}: no file has a dimension {name}")),
                Some(len) if *entry >= len => {
                    return bad(format!("at {name}={entry}: {name} has {len} entries, expected one below {len}"));
                }
                Some(_) => {}
            }
        }
        match (heights_m, radius_m) {
            (Some([first, last]), _) if !(first - last).is_normal() => {
                bad(format!("heights {first}..{last}: expected two different numbers of metres"))
            }
            (_, Some(radius_m)) if !(radius_m.is_finite() && *radius_m > 0.0) => {
                bad(format!("radius {radius_m}: expected a positive number of metres"))
            }
            _ => Ok(()),
        }
    }

    /// Replaces each file.
    pub(crate) fn map(self, change: impl Fn(Box<dyn Source>) -> Box<dyn Source>) -> Self {
        Sources { files: self.files.into_iter().map(change).collect(), ..self }
    }

    /// The file with the fields.
    pub(crate) fn fields(&self) -> &dyn Source {
        self.files[0].as_ref()
    }

    /// All files, the one with the fields first.
    pub(crate) fn all(&self) -> impl Iterator<Item = &dyn Source> {
        self.files.iter().map(AsRef::as_ref)
    }

    /// All files, the one with the fields last: the order of the search for mesh tables.
    pub(crate) fn others_first(&self) -> impl Iterator<Item = &dyn Source> {
        self.files[1..].iter().chain(&self.files[..1]).map(AsRef::as_ref)
    }

    /// The first file that has the variable, and the variable.
    pub(crate) fn find(&self, name: &str) -> Option<SourceVariable<'_>> {
        self.all().find_map(|source| source.find(name))
    }

    /// The sphere's radius in metres: that from the user, or of the files, or from positions of cells; else that of the
    /// Earth.
    pub(crate) fn sphere_radius_m(&self) -> Result<f64> {
        if let Some(radius_m) = self.options.radius_m {
            return Ok(radius_m);
        }
        let stated = self.all().find_map(|source| source.number("sphere_radius").transpose()).transpose()?;
        match stated {
            Some(r) if r.is_finite() && r > 0.0 => Ok(r),
            Some(r) => {
                let context = format!("sphere_radius: {r}, expected a positive number");
                Err(self.fields().error(ErrorKind::Grid, context))
            }
            None => Ok(self.radius_of_positions()?.unwrap_or(EARTH_M)),
        }
    }

    /// The distance of the first of MPAS's cells from the centre of the sphere.
    fn radius_of_positions(&self) -> Result<Option<f64>> {
        let mut square = 0.0;
        for name in ["xCell", "yCell", "zCell"] {
            let Some(SourceVariable { source, variable }) = self.find(name) else { return Ok(None) };
            let (start, count) = (vec![0; variable.dimensions.len()], vec![1; variable.dimensions.len()]);
            if !variable.kind.is_real() || variable.dimensions.iter().any(|dimension| dimension.len == 0) {
                return Ok(None);
            }
            square += source.reals(variable, &start, &count)?.as_reals().get(0).powi(2);
        }
        // Rounded, so that a unit sphere has radius 1.
        Ok(Some((1e3 * square.sqrt()).round() / 1e3).filter(|radius| radius.is_finite() && *radius > 0.0))
    }

    /// Length of a dimension in the first file that has it.
    pub(crate) fn dimension_len(&self, name: &str) -> Result<Option<usize>> {
        self.all().find_map(|source| source.dimension_len(name).transpose()).transpose()
    }

    /// Whether a variable has one record for each time of the fields.
    pub(crate) fn changes(&self, SourceVariable { source, variable }: SourceVariable) -> bool {
        std::ptr::addr_eq(source, self.fields()) && variable.changes()
    }

    /// The record of a variable for a field's `time`: the first in files without the fields.
    pub(crate) fn record(&self, found: SourceVariable, time: usize) -> Result<usize> {
        let SourceVariable { source, variable } = found;
        let records = variable.dimensions.first().map_or(0, |dimension| dimension.len);
        let record = if std::ptr::addr_eq(source, self.fields()) { time } else { 0 };
        if record < records {
            return Ok(record);
        }
        let context = format!("variable {variable} has no record {record}");
        Err(source.error(ErrorKind::Layers, context))
    }

    /// An error about all files.
    pub(crate) fn error(&self, kind: ErrorKind, context: impl std::fmt::Display) -> Error {
        let paths: Vec<String> = self.all().map(|source| source.path().display().to_string()).collect();
        Error::new(kind, format!("{}: {context}", paths.join(", ")))
    }
}
