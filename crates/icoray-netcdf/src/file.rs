//! An open MPAS file, with the mesh in it or in another.

use crate::field::{FieldInfo, OwnedField};
use crate::heights::LayerHeights;
use crate::mesh::{MpasMesh, expect_sphere};
use crate::source::{Kind, Source};
use icoray::{ErrorKind, Layers, Result};
use std::path::Path;

/// More time records than any file has: hourly ones for a century are fewer.
const MAX_RECORDS: usize = 1 << 20;

/// An MPAS file, opened: the mesh tables are in memory, fields and heights are read on demand.
///
/// The NetCDF library takes one call at a time, in the whole process; reading from several threads gains nothing. Damaged
/// classic files give errors; for damaged NetCDF-4 files that holds as far as the HDF5 library is proof against them.
#[derive(Debug)]
pub struct MpasFile {
    source: Source,
    mesh_source: Option<Source>,
    mesh: MpasMesh,
    sphere_radius_m: f64,
    times: Vec<Option<String>>,
    records: usize,
    fields: Vec<FieldInfo>,
}

impl MpasFile {
    /// Opens a file that holds the mesh and, mostly, fields; reads the mesh tables.
    ///
    /// # Errors
    /// All name the file. [`ErrorKind::Io`]: the file is absent, not NetCDF, damaged or cut off.
    /// [`ErrorKind::Grid`]: a mesh table or `sphere_radius` is missing, or not of the dimensions that MPAS gives it.
    /// [`ErrorKind::Unsupported`]: `on_a_sphere` is `NO`, or `vertexDegree` is not 3. What the tables say is not
    /// checked before [`MpasMesh::grid`].
    pub fn open(path: impl AsRef<Path>) -> Result<Self> {
        Self::new(Source::open(path.as_ref())?, None)
    }

    /// Opens a file that holds fields, and another that holds the mesh, such as the run's init or grid file. Layer
    /// heights and the radius are taken from the first of the two that has them, the fields' file first.
    ///
    /// # Errors
    /// As [`MpasFile::open`]; also [`ErrorKind::Grid`] when the two files differ in `nCells` or `nVertices`.
    pub fn open_with_mesh(path: impl AsRef<Path>, mesh_path: impl AsRef<Path>) -> Result<Self> {
        Self::new(Source::open(path.as_ref())?, Some(Source::open(mesh_path.as_ref())?))
    }

    fn new(source: Source, mesh_source: Option<Source>) -> Result<Self> {
        let of_mesh = mesh_source.as_ref().unwrap_or(&source);
        expect_sphere(&source)?;
        let mesh = MpasMesh::read(of_mesh)?;
        for (dimension, expected) in [("nCells", mesh.cells()), ("nVertices", mesh.corners())] {
            let there = source.dimension_len(dimension)?.unwrap_or(expected);
            if there != expected {
                let mesh_path = of_mesh.path().display();
                let context =
                    format!("{dimension} is {there}, expected {expected} as in the mesh of {mesh_path}");
                return Err(source.error(ErrorKind::Grid, context));
            }
        }
        let radius = match source.number("sphere_radius")? {
            None => of_mesh.number("sphere_radius")?,
            known => known,
        };
        let sphere_radius_m = match radius {
            Some(r) if r.is_finite() && r > 0.0 => r,
            Some(r) => {
                return Err(source
                    .error(ErrorKind::Grid, format_args!("sphere_radius: {r}, expected a positive number")));
            }
            None => {
                return Err(of_mesh.error(
                    ErrorKind::Grid,
                    "attribute sphere_radius is missing, expected a radius in metres",
                ));
            }
        };
        let records = source.dimension_len("Time")?.unwrap_or(0);
        if records > MAX_RECORDS {
            let context = format!("Time is {records}, expected at most {MAX_RECORDS}: the header is damaged");
            return Err(source.error(ErrorKind::Io, context));
        }
        let times = (0..records.max(1)).map(|record| time(&source, record)).collect();
        let fields = source
            .variables()
            .iter()
            .filter_map(|v| FieldInfo::of(&source, v).transpose())
            .collect::<Result<_>>()?;
        Ok(MpasFile { source, mesh_source, mesh, sphere_radius_m, times, records, fields })
    }

    /// The path of the fields' file, as given.
    pub fn path(&self) -> &Path {
        self.source.path()
    }

    /// The mesh.
    pub fn mesh(&self) -> &MpasMesh {
        &self.mesh
    }

    /// The sphere's radius (`sphere_radius`).
    ///
    /// # Units
    /// Metres; 1 in a mesh on the unit sphere.
    pub fn sphere_radius_m(&self) -> f64 {
        self.sphere_radius_m
    }

    /// The time of each record as `xtime` gives it (`2013-10-25_00:00:00`), at least one: a file without a `Time` record
    /// has one all the same, for its fields that do not depend on time. `None` where there is no readable `xtime`.
    pub fn times(&self) -> &[Option<String>] {
        &self.times
    }

    /// The variables that can be read as fields, in the file's order: `float` or `double`, over `nCells` or `nVertices` and
    /// `nVertLevels` or `nVertLevelsP1`, with or without `Time`.
    pub fn fields(&self) -> &[FieldInfo] {
        &self.fields
    }

    /// What is known of the field `name`.
    ///
    /// # Errors
    /// [`ErrorKind::Field`] when there is no such field, with the list of those that there are.
    pub fn field_info(&self, name: &str) -> Result<&FieldInfo> {
        if let Some(info) = self.fields.iter().find(|f| f.name == name) {
            return Ok(info);
        }
        let reason = match self.source.variable(name) {
            Some(variable) => format!(
                "variable {variable} is not a field, expected float or double over (Time, nCells or nVertices, \
                 nVertLevels or nVertLevelsP1)"
            ),
            None => format!("there is no field {name}"),
        };
        let names: Vec<&str> = self.fields.iter().map(|f| f.name.as_str()).collect();
        let there = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
        Err(self.source.error(ErrorKind::Field, format_args!("{reason}; fields in the file: {there}")))
    }

    /// Reads record `time` (from 0) of the field `name`, and nothing else. A field that does not depend on time reads the
    /// same at every `time` that [`MpasFile::times`] has.
    ///
    /// # Errors
    /// [`ErrorKind::Field`] when there is no such field or record; [`ErrorKind::Io`] when the file is damaged or cut off.
    pub fn read_field(&self, name: &str, time: usize) -> Result<OwnedField> {
        let info = self.field_info(name)?;
        let records = if info.time_dependent { self.records } else { self.times.len() };
        if time >= records {
            let expected = match records {
                0 => "but the file holds no time record".to_owned(),
                1 => "expected 0: the file holds 1 time record".to_owned(),
                n => format!("expected 0 to {}: the file holds {n} time records", n - 1),
            };
            return Err(self
                .source
                .error(ErrorKind::Field, format_args!("{name}: time index {time}, {expected}")));
        }
        OwnedField::read(&self.source, info, time)
    }

    /// Whether the file (or the mesh's file) has a variable that gives layer heights. Without one, as in a bare mesh file,
    /// a caller may space layers as it likes.
    pub fn has_layer_heights(&self) -> bool {
        LayerHeights::are_in(&self.sources())
    }

    /// Reads the interfaces between layers and how far terrain bends them.
    ///
    /// `zgrid` is read whole, in blocks. icoray renders concentric layers, so the mean over all cells is taken.
    ///
    /// # Errors
    /// [`ErrorKind::Layers`] when neither `zgrid` nor `refBottomDepth` is there (the sentence names both), or when the
    /// heights are not finite, not strictly monotone or larger than the sphere; [`ErrorKind::Io`] when the file is damaged
    /// or cut off.
    pub fn layer_heights(&self) -> Result<LayerHeights> {
        LayerHeights::read(&self.sources(), self.sphere_radius_m)
    }

    /// The interfaces of [`MpasFile::layer_heights`] as radii; [`Layers::for_field`] gives those of a field.
    ///
    /// # Errors
    /// As [`MpasFile::layer_heights`].
    pub fn layers(&self) -> Result<Layers> {
        self.layer_heights().map(|heights| heights.layers)
    }

    fn sources(&self) -> Vec<&Source> {
        std::iter::once(&self.source).chain(&self.mesh_source).collect()
    }
}

/// `xtime` of a record: a label, so whatever is wrong with it gives none and stops nothing.
fn time(source: &Source, record: usize) -> Option<String> {
    let variable = source.variable("xtime").filter(|v| v.kind == Kind::Text && v.dimensions.len() == 2)?;
    if variable.dimensions[0].name != "Time" || record >= variable.dimensions[0].len {
        return None;
    }
    source.text_row(variable, record).ok().filter(|text| !text.is_empty())
}
