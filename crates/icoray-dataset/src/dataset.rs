//! A dataset, completed from others.

use crate::edges::{self, Edges, EdgesInFiles};
use crate::field::{FieldInfo, OwnedField};
use crate::heights::LayerHeights;
use crate::heights::native::{self, NativeHeights, NativeInfo};
use crate::mesh::{self, Mesh, MeshLayout};
use crate::raster;
use crate::sea::Sea;
use crate::source::Source;
use crate::sources::{DatasetOptions, Sources};
use crate::times::Times;
use crate::values::AssumedMark;
use icoray::{Error, ErrorKind, Grid, Layers, Location, Result, did_you_mean};
use std::collections::{BTreeMap, HashMap};
use std::fmt;
use std::ops::Range;
use std::path::Path;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// A dataset of a model. The mesh tables are in memory; requested times and layers of fields, and heights, are read on
/// demand.
#[derive(Debug)]
pub struct Dataset {
    sources: Sources,
    mesh: Arc<Mesh>,
    sphere_radius_m: f64,
    times: Times,
    /// The fields of the fields' file, followed by those of joined files that are not among them.
    pub(crate) fields: Vec<FieldInfo>,
    /// Number of fields of the fields' file.
    pub(crate) own_fields: usize,
    sea: OnceLock<Option<Sea>>,
    edges: OnceLock<Edges>,
    /// Heights that were read, by the field's name.
    heights: Mutex<HashMap<String, LayerHeights>>,
    /// Values of fields that were taken for marks of missing values, by the field's name.
    assumed_marks: Mutex<BTreeMap<String, Vec<AssumedMark>>>,
    pub(crate) joined: Vec<Dataset>,
    /// The dataset whose values are subtracted.
    pub(crate) minus: Option<Box<Dataset>>,
}

impl Dataset {
    /// A dataset of a source with fields and, mostly, the mesh, and of other sources that complete it: the mesh, in the
    /// run's init or grid file, or the heights of layers. The mesh is taken from the first of the others that has one;
    /// heights and the radius from the first of all that has them, the fields' source first. Fields over time that the
    /// fields' source lacks are those of the others with the same times.
    ///
    /// Reads the mesh tables, unless a `mesh` is given that is in memory already: then only sizes, the name of ICON's
    /// grid and positions of columns of the files are compared with it. `options` are facts that the files lack.
    ///
    /// # Errors
    /// All name the source. [`ErrorKind::Io`]: it is damaged or cut off. [`ErrorKind::Grid`]: a mesh table is
    /// missing or does not have the dimensions of the model, the radius is not positive, or a source has another mesh.
    /// [`ErrorKind::Unsupported`]: the mesh is planar, or `vertexDegree` is not 3. [`Mesh::grid`] checks the
    /// contents of the tables. [`ErrorKind::Argument`]: no file has a dimension or an entry of [`DatasetOptions::at`],
    /// the radius is not positive or the heights are equal.
    pub fn new(
        fields: Box<dyn Source>,
        others: Vec<Box<dyn Source>>,
        mesh: Option<Arc<Mesh>>,
        options: DatasetOptions,
    ) -> Result<Self> {
        let sources = Sources::new(fields, others, options);
        sources.expect_options()?;
        let sources = raster::flattened(sources)?;
        let mesh = mesh.map_or_else(|| mesh::read(&sources).map(Arc::new), Ok)?;
        mesh::expect_one_mesh(&sources, &mesh)?;
        let sphere_radius_m = sources.sphere_radius_m()?;
        let times = Times::read(sources.fields())?;
        let mut fields = fields_of(sources.fields(), &sources, &mesh)?;
        // With one variable per file, those that the file with the mesh lacks are in others of the same times.
        for other in sources.all().skip(1) {
            let is_its = |name: &str| sources.find(name).is_some_and(|found| std::ptr::addr_eq(found.source, other));
            let is_new = |info: &FieldInfo| info.time_dependent && is_its(&info.variable);
            let lacking: Vec<_> = fields_of(other, &sources, &mesh)?.into_iter().filter(is_new).collect();
            if !lacking.is_empty() && Times::read(other)?.dates == times.dates {
                fields.extend(lacking);
            }
        }
        Ok(Dataset {
            mesh,
            sphere_radius_m,
            times,
            own_fields: fields.len(),
            fields,
            sea: OnceLock::new(),
            edges: OnceLock::new(),
            heights: Mutex::default(),
            assumed_marks: Mutex::default(),
            joined: Vec::new(),
            minus: None,
            sources,
        })
    }

    /// The path of the fields' source, or its name.
    pub fn path(&self) -> &Path {
        self.sources.fields().path()
    }

    /// The mesh.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// The mesh, which can outlive the file.
    pub fn shared_mesh(&self) -> Arc<Mesh> {
        Arc::clone(&self.mesh)
    }

    /// The sphere's radius: that of [`DatasetOptions`], or `sphere_radius`, or the distance of MPAS's cells from the
    /// centre (`xCell`, `yCell`, `zCell`), or that of ICON's Earth.
    ///
    /// # Units
    /// Metres; 1 in a mesh on the unit sphere.
    pub fn sphere_radius_m(&self) -> f64 {
        self.sphere_radius_m
    }

    /// The date of each record in MPAS's notation (`2013-10-25_00:00:00`): from `xtime`, or from CF's time in its
    /// calendar. At least one: a file without a time record has one for its fields that do not depend on time. `None`
    /// if there is no readable time.
    pub fn times(&self) -> &[Option<String>] {
        &self.times.dates
    }

    /// Seconds from the first record to each, in the calendar of the file (`calendar` of its time, MPAS's
    /// `config_calendar_type`), else the standard one. Records at the end without a date yet, as in a file that is
    /// being written, have no entry; `None` if another record has no readable time.
    pub fn seconds(&self) -> Option<Vec<f64>> {
        self.times.seconds.clone()
    }

    /// The variables that can be read as fields, in the file's order: `float`, `double` or packed integers, over cells
    /// or corners, with or without layers and time. Positions of the mesh are excluded.
    pub fn fields(&self) -> &[FieldInfo] {
        &self.fields
    }

    /// The likeliest of [`Dataset::likely_fields`]: the one shown if no field is named.
    ///
    /// # Errors
    /// [`ErrorKind::Field`] if there is none, with the list of all fields.
    pub fn first_field(&self) -> Result<&FieldInfo> {
        self.likely_fields().first().copied().ok_or_else(|| {
            let source = self.sources.fields();
            let what = if !self.fields.is_empty() {
                let names = self.field_names();
                format!("no variable looks like a physical field, expected the name of one of {names}")
            } else if self.mesh.path() == source.path() {
                "a mesh without a field, expected a history or output file or dataset".to_owned()
            } else {
                format!(
                    "no variable lies on the mesh of {}, which has {}: the file has {}; give the mesh of these data as \
                     `mesh`",
                    self.mesh.path().display(),
                    self.sizes_in_words(),
                    source.numbers_in_words()
                )
            };
            source.error(ErrorKind::Field, what)
        })
    }

    /// An error about the fields' source.
    pub(crate) fn error(&self, kind: ErrorKind, context: impl fmt::Display) -> Error {
        self.sources.fields().error(kind, context)
    }

    /// The names of all fields, separated by commas.
    fn field_names(&self) -> String {
        let names: Vec<&str> = self.fields.iter().map(|info| info.name.as_str()).collect();
        names.join(", ")
    }

    /// The locations of fields, with their sizes.
    fn sizes_in_words(&self) -> String {
        let (cells, corners) = (self.mesh.cells(), self.mesh.corners_in_file());
        match self.mesh.layout() {
            MeshLayout::Mpas => format!("{cells} cells (nCells) or {corners} vertices (nVertices)"),
            MeshLayout::Triangles => format!("{corners} triangles or their {cells} points"),
            MeshLayout::Polygons => format!("{cells} cells or {corners} corners"),
        }
    }

    /// Properties of the field `name`, without its values.
    ///
    /// # Errors
    /// [`ErrorKind::Field`] when there is no such field, with the list of all fields.
    pub fn field_info(&self, name: &str) -> Result<&FieldInfo> {
        if let Some(info) = self.fields.iter().find(|f| f.name == name) {
            return Ok(info);
        }
        let source = self.sources.fields();
        let reason = match source.variable(name).filter(|variable| variable.name == name) {
            Some(variable) => {
                let made = self.fields.iter().filter(|info| info.variable == name);
                let made: Vec<&str> = made.map(|info| info.name.as_str()).collect();
                let of_edges = edges::reason(&self.sources, &self.mesh, variable, &made);
                of_edges.unwrap_or_else(|| format!(
                    "variable {variable} is not a field, expected numbers over {}, with times and one dimension of layers or \
                     without (`at` picks an entry of a further dimension)",
                    self.sizes_in_words()
                ))
            }
            None => {
                let names = self.fields.iter().map(|f| f.name.as_str());
                let elsewhere =
                    self.sources.find(name).filter(|found| found.name() == name).map_or_else(String::new, |found| {
                        let path = found.source.path().display();
                        format!(", but {path} has {name}: give that file among those with fields, not as `mesh`")
                    });
                format!("there is no field {name}{}{elsewhere}", did_you_mean(name, names))
            }
        };
        let there = if self.fields.is_empty() { "none".to_owned() } else { self.field_names() };
        Err(source.error(ErrorKind::Field, format_args!("{reason}; fields in the file: {there}")))
    }

    /// Reads only record `time` (from 0) of the field `name`. A field that does not depend on time is the same at every
    /// `time` of [`Dataset::times`]. A 2D field has its values on each of 2 layers.
    ///
    /// Missing are values that equal `_FillValue` or `missing_value`, those outside `valid_range`, `valid_min` and
    /// `valid_max`, those below MPAS-Ocean's sea floor (`maxLevelCell`), and those of ICON-O's land (`wet_c` is 0).
    ///
    /// # Errors
    /// [`ErrorKind::Field`] when there is no such field or record; [`ErrorKind::Grid`] when the table of the cells
    /// beside edges is invalid; [`ErrorKind::Io`] when the file is damaged or cut off.
    pub fn read_field(&self, name: &str, time: usize) -> Result<OwnedField> {
        let layers = self.field_info(name)?.all_layers();
        self.read_layers(name, time, layers)
    }

    /// Reads some of the layers, counted from 0, like [`Dataset::read_field`]. A 2D field has the same values on any
    /// layers, so that it can be shown with a field that has these.
    ///
    /// # Errors
    /// As [`Dataset::read_field`]; also [`ErrorKind::Field`] when the field does not have all these layers, or there
    /// are none.
    pub fn read_layers(&self, name: &str, time: usize, layers: Range<usize>) -> Result<OwnedField> {
        if let Some(joined) = self.joined_with(name) {
            return joined.read_layers(name, self.record_in(joined, name, time)?, layers);
        }
        let info = self.field_info(name)?;
        let bad = |what: String| self.error(ErrorKind::Field, format_args!("{name}: {what}"));
        let records = if info.time_dependent { self.times.records } else { self.times.dates.len() };
        if time >= records {
            let expected = match records {
                0 => "but the file holds no time record".to_owned(),
                1 => "expected 0: the file holds 1 time record".to_owned(),
                n => format!("expected 0 to {}: the file holds {n} time records", n - 1),
            };
            return Err(bad(format!("time index {time}, {expected}")));
        }
        if layers.is_empty() || layers.end > info.layers && !info.is_2d() {
            return Err(bad(format!("layers {layers:?}, expected some of 0..{}", info.layers)));
        }
        let sea = self.sea()?;
        let found = self.sources.find(&info.variable).ok_or_else(|| bad("its variable is missing".to_owned()))?;
        let mut field = OwnedField::read(found, info, time, layers.clone(), &self.sources.options)?;
        let assumed_marks = field.assumed_marks.clone();
        self.assumed_marks.lock().unwrap_or_else(PoisonError::into_inner).insert(name.to_owned(), assumed_marks);
        if let Some(part) = info.part {
            let edges = read_once(&self.edges, || Edges::read(&self.sources, &self.mesh, info))?;
            let values = edges.at_centers(&self.mesh, &field.values, field.fill, part);
            field.values = values.map_err(|e| bad(e.to_string()))?;
        }
        if info.location == Location::Corner {
            field.spread(self.mesh.corner_rows());
        }
        if let Some(sea) = sea {
            sea.mask_dry(info, layers.clone(), &mut field);
        }
        match &self.minus {
            Some(minus) => field.less(&minus.read_layers(name, self.record_in(minus, name, time)?, layers)?),
            None => Ok(field),
        }
    }

    /// Values of a field, at its last reading, that were taken for marks of missing values, as they look like marks and
    /// neither an attribute nor the user specifies one.
    pub fn assumed_marks(&self, field: &str) -> Vec<AssumedMark> {
        let found = self.owner(field).assumed_marks.lock().unwrap_or_else(PoisonError::into_inner);
        found.get(field).cloned().unwrap_or_default()
    }

    /// Reads the heights of a field's layers, and their largest deviation due to terrain.
    ///
    /// Heights that differ between columns are read whole, in blocks, and averaged over all columns;
    /// [`Dataset::native_heights`] reads their own. They are read once: later calls return the same.
    ///
    /// # Errors
    /// [`ErrorKind::Field`] when there is no such field; [`ErrorKind::Layers`] when no variable gives heights (the
    /// message lists those that were searched), or when they are not finite, not strictly monotone or larger than the
    /// sphere; [`ErrorKind::Io`] when the file is damaged or cut off.
    pub fn layer_heights(&self, field: &str) -> Result<LayerHeights> {
        self.heights_of(field, false)
    }

    /// As [`Self::layer_heights`], or the layers of a thin shell if no variable gives heights and the layers are shown
    /// only as surfaces (`is_flat`).
    pub(crate) fn heights_of(&self, field: &str, is_flat: bool) -> Result<LayerHeights> {
        let owner = self.owner(field);
        let Dataset { sources, mesh, .. } = owner;
        let mut known = owner.heights.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(heights) = known.get(field) {
            return Ok(heights.clone());
        }
        let radius_m = owner.sphere_radius_m;
        let info = owner.field_info(field)?;
        match LayerHeights::read(sources, mesh, info, radius_m)? {
            Some(heights) => Ok(known.entry(field.to_owned()).or_insert(heights).clone()),
            None if is_flat => LayerHeights::of_layers(sources, mesh, info, radius_m),
            None => Err(LayerHeights::missing(sources, mesh, info)),
        }
    }

    /// The heights of [`Dataset::layer_heights`] as the field's radii; of a 2D field those of a thin shell.
    ///
    /// # Errors
    /// As [`Dataset::layer_heights`] and [`Layers::for_field`].
    pub fn layers(&self, field: &str) -> Result<Layers> {
        self.layer_heights(field)?.layers.for_field(self.field_info(field)?.all_layers().len())
    }

    /// Properties of the native heights of a field's columns; `None` if all columns share the layers' heights, or no
    /// file has native ones. Does not read the heights.
    ///
    /// # Errors
    /// [`ErrorKind::Field`] when there is no such field; [`ErrorKind::Layers`] when the variable of the heights has
    /// other dimensions.
    pub fn find_native_info(&self, field: &str) -> Result<Option<NativeInfo>> {
        let owner = self.owner(field);
        NativeInfo::find(&owner.sources, &owner.mesh, owner.field_info(field)?)
    }

    /// As [`Dataset::find_native_info`], for a field that must have native heights.
    ///
    /// # Errors
    /// As [`Dataset::find_native_info`]; [`ErrorKind::Layers`] if there are none, with the variables that were
    /// searched.
    pub fn native_info(&self, field: &str) -> Result<NativeInfo> {
        let Dataset { sources, mesh, .. } = self.owner(field);
        let info = self.field_info(field)?;
        self.find_native_info(field)?.ok_or_else(|| native::missing(sources, mesh, info))
    }

    /// Reads the native heights of a field's columns, at record `time` if they change; from a file without the fields,
    /// at its first record. `grid` is the mesh's. `None` as in [`Dataset::find_native_info`].
    ///
    /// # Errors
    /// As [`Dataset::find_native_info`]; [`ErrorKind::Layers`] when there is no such record or a thickness is
    /// invalid; [`ErrorKind::Io`] when the file is damaged or cut off.
    pub fn native_heights(&self, grid: &Grid, field: &str, time: usize) -> Result<Option<NativeHeights>> {
        if let Some(joined) = self.joined_with(field) {
            return joined.native_heights(grid, field, self.record_in(joined, field, time)?);
        }
        let info = self.field_info(field)?;
        NativeHeights::read(&self.sources, &self.mesh, grid, info, self.sea()?.and_then(Sea::floor), time)
    }

    /// Whether a field is in the files of this dataset, not in joined ones.
    pub(crate) fn has_own(&self, name: &str) -> bool {
        self.fields[..self.own_fields].iter().any(|info| info.name == name)
    }

    /// The water mask, read once.
    fn sea(&self) -> Result<Option<&Sea>> {
        read_once(&self.sea, || Sea::read(&self.sources, &self.mesh)).map(Option::as_ref)
    }
}

/// The value of `cell`, which is read on first use.
fn read_once<T>(cell: &OnceLock<T>, read: impl FnOnce() -> Result<T>) -> Result<&T> {
    match cell.get() {
        Some(known) => Ok(known),
        None => read().map(|value| cell.get_or_init(|| value)),
    }
}

/// The fields of a file. NetCDF forbids control characters in names, so a name is printed unchanged.
fn fields_of(source: &dyn Source, sources: &Sources, mesh: &Mesh) -> Result<Vec<FieldInfo>> {
    let edges = EdgesInFiles::find(sources, mesh);
    let mut fields = Vec::new();
    for found in source.each_variable().filter(|found| !found.name().contains(char::is_control)) {
        fields.extend(FieldInfo::of(found, mesh, &sources.options)?);
        if let Some(edges) = &edges {
            fields.extend(FieldInfo::at_edges(found, mesh, edges, &sources.options)?);
        }
    }
    Ok(fields)
}
