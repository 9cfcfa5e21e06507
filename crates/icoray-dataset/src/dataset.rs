//! A dataset, with what it lacks in others.

use crate::field::{FieldInfo, OwnedField};
use crate::heights::LayerHeights;
use crate::heights::native::{self, NativeHeights, NativeInfo};
use crate::joined::Joined;
use crate::likely_fields::likely_fields;
use crate::mesh::{self, Convention, Mesh};
use crate::raster;
use crate::sea::Sea;
use crate::source::Source;
use crate::sources::Sources;
use crate::times::Times;
use icoray::{ErrorKind, Grid, Layers, Location, Result, did_you_mean};
use std::collections::HashMap;
use std::ops::Range;
use std::path::Path;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// Earth's radius in ICON and DYNAMICO, metres, for files without one.
const ICON_RADIUS_M: f64 = 6_371_229.0;

/// A dataset of a model. The mesh tables are in memory; fields, of the times and layers asked for, and heights are read
/// on demand.
#[derive(Debug)]
pub struct Dataset {
    sources: Sources,
    mesh: Arc<Mesh>,
    sphere_radius_m: f64,
    times: Times,
    /// Those of the fields' file, then those of joined files that are not among them.
    pub(crate) fields: Vec<FieldInfo>,
    /// Number of those of the fields' file.
    pub(crate) own_fields: usize,
    sea: OnceLock<Option<Sea>>,
    /// Heights that were read, by the field's name.
    heights: Mutex<HashMap<String, LayerHeights>>,
    pub(crate) joined: Vec<Joined>,
    /// The dataset whose values are subtracted.
    pub(crate) minus: Option<Box<Joined>>,
}

impl Dataset {
    /// A dataset of a source that holds fields and, mostly, the mesh, and of others with what it lacks: the mesh, in the
    /// run's init or grid file, or the heights of layers. The mesh is taken from the first of the others that has one;
    /// heights and the radius from the first of all that has them, the fields' source first. Reads the mesh tables.
    ///
    /// # Errors
    /// All name the source. [`ErrorKind::Io`]: it is damaged or cut off. [`ErrorKind::Grid`]: a mesh table or the radius
    /// is missing, or not of the dimensions that the model gives it; or a source is of another mesh, of more or fewer
    /// cells. [`ErrorKind::Unsupported`]: the mesh is planar, or `vertexDegree` is not 3. What the tables say is not
    /// checked before [`Mesh::grid`].
    pub fn new(fields: Box<dyn Source>, others: Vec<Box<dyn Source>>) -> Result<Self> {
        let sources = raster::flattened(Sources::new(fields, others))?;
        let mesh = Arc::new(mesh::read(&sources)?);
        Self::of(sources, mesh)
    }

    /// As [`Dataset::new`], for a mesh that is in memory already: no mesh tables are read.
    ///
    /// # Errors
    /// As [`Dataset::new`]; of the mesh only the numbers of cells and corners are compared.
    pub fn on_mesh(fields: Box<dyn Source>, others: Vec<Box<dyn Source>>, mesh: Arc<Mesh>) -> Result<Self> {
        Self::of(raster::flattened(Sources::new(fields, others))?, mesh)
    }

    fn of(sources: Sources, mesh: Arc<Mesh>) -> Result<Self> {
        expect_one_mesh(&sources, &mesh)?;
        let sphere_radius_m = radius(&sources, mesh.convention())?;
        let source = sources.fields();
        let times = Times::read(source)?;
        // NetCDF forbids control characters in names, and a name is printed as it is.
        let fields = source.variables().iter().filter(|variable| !variable.name.contains(char::is_control));
        let fields: Vec<FieldInfo> =
            fields.filter_map(|v| FieldInfo::of(source, v, &mesh).transpose()).collect::<Result<_>>()?;
        let (own_fields, sea, heights) = (fields.len(), OnceLock::new(), Mutex::default());
        let (joined, minus) = (Vec::new(), None);
        Ok(Dataset { sources, mesh, sphere_radius_m, times, fields, own_fields, sea, heights, joined, minus })
    }

    /// The path of the fields' source, or its name.
    pub fn path(&self) -> &Path {
        self.sources.fields().path()
    }

    /// The mesh.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// The mesh, to keep when the file is closed.
    pub fn shared_mesh(&self) -> Arc<Mesh> {
        Arc::clone(&self.mesh)
    }

    /// The sphere's radius (`sphere_radius`); that of ICON's Earth where a file of ICON or of CF polygons does not
    /// tell.
    ///
    /// # Units
    /// Metres; 1 in a mesh on the unit sphere.
    pub fn sphere_radius_m(&self) -> f64 {
        self.sphere_radius_m
    }

    /// The date of each record as MPAS writes it (`2013-10-25_00:00:00`): of `xtime`, or made of CF's time in its
    /// calendar. At least one: a file without a time record has one all the same, for its fields that do not depend
    /// on time. `None` where there is no readable time.
    pub fn times(&self) -> &[Option<String>] {
        &self.times.dates
    }

    /// Seconds from the first record to each, in the calendar that the file names (`calendar` of its time, MPAS's
    /// `config_calendar_type`), else the standard one. Records at the end that have no date yet, as in a file that is being
    /// written, have no entry; `None` where another record has no readable time.
    pub fn seconds(&self) -> Option<Vec<f64>> {
        self.times.seconds.clone()
    }

    /// The variables that can be read as fields, in the file's order: `float`, `double` or packed integers, over cells
    /// or corners, with or without layers and time. Positions of the mesh are none.
    pub fn fields(&self) -> &[FieldInfo] {
        &self.fields
    }

    /// The fields that are worth showing, the likeliest first: those of at least 2 layers that change with time, in the
    /// file's order, then others with layers, then 2D fields in the same way. Heights, thicknesses, base states,
    /// weights of the vertical grid, and areas and qualities of the mesh are left out.
    pub fn likely_fields(&self) -> Vec<&FieldInfo> {
        likely_fields(&self.fields)
    }

    /// The likeliest of [`Dataset::likely_fields`]: what is shown where no field is named.
    ///
    /// # Errors
    /// [`ErrorKind::Field`] where there is none, with the fields that there are.
    pub fn first_field(&self) -> Result<&FieldInfo> {
        self.likely_fields().first().copied().ok_or_else(|| {
            let names: Vec<&str> = self.fields.iter().map(|info| info.name.as_str()).collect();
            let what = match names[..] {
                [] => "a mesh without a field, expected a history or output file or dataset".to_owned(),
                _ => {
                    format!("no variable looks like a physical field, expected the name of one of {}", names.join(", "))
                }
            };
            self.sources.fields().error(ErrorKind::Field, what)
        })
    }

    /// Properties of the field `name`, without its values.
    ///
    /// # Errors
    /// [`ErrorKind::Field`] when there is no such field, with the list of those that there are.
    pub fn field_info(&self, name: &str) -> Result<&FieldInfo> {
        if let Some(info) = self.fields.iter().find(|f| f.name == name) {
            return Ok(info);
        }
        let expected = match self.mesh.convention() {
            Convention::Mpas => {
                "(Time, nCells or nVertices, nVertLevels or nVertLevelsP1), without time or layers too".to_owned()
            }
            Convention::Icon => format!(
                "(time, layers, {} triangles or {} points), without time or layers too",
                self.mesh.corners_in_file(),
                self.mesh.cells()
            ),
            Convention::Cf => {
                format!(
                    "(time, layers, {} cells or {} corners), without time or layers too",
                    self.mesh.cells(),
                    self.mesh.corners_in_file()
                )
            }
        };
        let source = self.sources.fields();
        let reason = match source.variable(name) {
            Some(variable) => {
                format!("variable {variable} is not a field, expected numbers over {expected}")
            }
            None => {
                let names = self.fields.iter().map(|f| f.name.as_str());
                format!("there is no field {name}{}", did_you_mean(name, names))
            }
        };
        let names: Vec<&str> = self.fields.iter().map(|f| f.name.as_str()).collect();
        let there = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
        Err(source.error(ErrorKind::Field, format_args!("{reason}; fields in the file: {there}")))
    }

    /// Reads record `time` (from 0) of the field `name`, and nothing else. A field that does not depend on time reads
    /// the same at every `time` that [`Dataset::times`] has. A 2D field has its values on each of 2 layers.
    ///
    /// Missing are values that equal `_FillValue` or `missing_value`, those outside `valid_range`, `valid_min` and
    /// `valid_max`, those below MPAS-Ocean's sea floor (`maxLevelCell`), and those of ICON-O's land (`wet_c` is 0).
    ///
    /// # Errors
    /// [`ErrorKind::Field`] when there is no such field or record; [`ErrorKind::Io`] when the file is damaged or cut
    /// off.
    pub fn read_field(&self, name: &str, time: usize) -> Result<OwnedField> {
        let layers = self.field_info(name)?.all_layers();
        self.read_layers(name, time, layers)
    }

    /// Reads some of the layers, counted from 0, as [`Dataset::read_field`] does all. A 2D field has the same values
    /// on any layers, so that it can be shown with a field that has these.
    ///
    /// # Errors
    /// As [`Dataset::read_field`]; also [`ErrorKind::Field`] when the field has not all these layers, or these are
    /// none.
    pub fn read_layers(&self, name: &str, time: usize, layers: Range<usize>) -> Result<OwnedField> {
        if let Some(joined) = self.joined_with(name) {
            return joined.file.read_layers(name, joined.record(name, time)?, layers);
        }
        let info = self.field_info(name)?;
        let bad = |what: String| self.sources.fields().error(ErrorKind::Field, format_args!("{name}: {what}"));
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
        let mut field = OwnedField::read(self.sources.fields(), info, time, layers.clone())?;
        if info.location == Location::Corner {
            field.spread(self.mesh.corner_rows());
        }
        if let Some(sea) = sea {
            sea.mask_dry(info, layers.clone(), &mut field);
        }
        match &self.minus {
            Some(minus) => field.less(&minus.file.read_layers(name, minus.record(name, time)?, layers)?),
            None => Ok(field),
        }
    }

    /// Reads the heights on which a field's layers lie, and how far terrain bends them.
    ///
    /// Heights that differ between columns are read whole, in blocks, and their mean over all columns is taken; their
    /// own are [`Dataset::native_heights`]. They are read once: later calls return the same.
    ///
    /// # Errors
    /// [`ErrorKind::Field`] when there is no such field; [`ErrorKind::Layers`] when no variable gives heights (the
    /// sentence says which were looked for), or when they are not finite, not strictly monotone or larger than the
    /// sphere; [`ErrorKind::Io`] when the file is damaged or cut off.
    pub fn layer_heights(&self, field: &str) -> Result<LayerHeights> {
        self.heights_of(field, false)
    }

    /// As [`Self::layer_heights`], or the layers of a thin shell where no variable gives heights and the layers are shown
    /// as surfaces alone (`is_flat`).
    pub(crate) fn heights_of(&self, field: &str, is_flat: bool) -> Result<LayerHeights> {
        if let Some(joined) = self.joined_with(field) {
            return joined.file.heights_of(field, is_flat);
        }
        let mut known = self.heights.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(heights) = known.get(field) {
            return Ok(heights.clone());
        }
        let (sources, mesh, radius_m, info) =
            (&self.sources, &self.mesh, self.sphere_radius_m, self.field_info(field)?);
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

    /// What heights of its own each column of a field has, in words; `None` where all columns share the layers'
    /// heights, or no file tells. Nothing is read of them.
    ///
    /// # Errors
    /// [`ErrorKind::Field`] when there is no such field; [`ErrorKind::Layers`] when the variable that should have the
    /// heights is of other dimensions.
    pub fn native_heights_in_words(&self, field: &str) -> Result<Option<String>> {
        if let Some(joined) = self.joined_with(field) {
            return joined.file.native_heights_in_words(field);
        }
        native::describe(&self.sources, &self.mesh, self.field_info(field)?)
    }

    /// What is known of the heights that each column of a field has of its own. Nothing is read of them.
    ///
    /// # Errors
    /// As [`Dataset::native_heights_in_words`]; [`ErrorKind::Layers`] where there are none, with what was looked for.
    pub fn native_info(&self, field: &str) -> Result<NativeInfo> {
        if let Some(joined) = self.joined_with(field) {
            return joined.file.native_info(field);
        }
        native::info(&self.sources, &self.mesh, self.field_info(field)?)
    }

    /// Reads the heights that each column of a field has of its own, at record `time` where they change; those of a
    /// file that has not the fields, at its first. `grid` is the mesh's. `None` as in
    /// [`Dataset::native_heights_in_words`].
    ///
    /// # Errors
    /// As [`Dataset::native_heights_in_words`]; [`ErrorKind::Layers`] when there is no such record or a thickness is
    /// none; [`ErrorKind::Io`] when the file is damaged or cut off.
    pub fn native_heights(&self, grid: &Grid, field: &str, time: usize) -> Result<Option<NativeHeights>> {
        if let Some(joined) = self.joined_with(field) {
            return joined.file.native_heights(grid, field, joined.record(field, time)?);
        }
        let info = self.field_info(field)?;
        NativeHeights::read(&self.sources, (&self.mesh, grid), info, self.sea()?.and_then(Sea::floor), time)
    }

    /// Whether a field is in the fields' file itself.
    pub(crate) fn has_own(&self, name: &str) -> bool {
        self.fields[..self.own_fields].iter().any(|info| info.name == name)
    }

    /// The water mask, read once.
    fn sea(&self) -> Result<Option<&Sea>> {
        if let Some(known) = self.sea.get() {
            return Ok(known.as_ref());
        }
        let sea = Sea::read(&self.sources, &self.mesh)?;
        Ok(self.sea.get_or_init(|| sea).as_ref())
    }
}

/// Checks that all files are of the mesh that was read.
fn expect_one_mesh(sources: &Sources, mesh: &Mesh) -> Result<()> {
    let dimensions: &[(&str, usize)] = match mesh.convention() {
        Convention::Mpas => &[("nCells", mesh.cells()), ("nVertices", mesh.corners())],
        Convention::Icon => &[("ncells", mesh.corners_in_file()), ("cell", mesh.corners_in_file())],
        Convention::Cf => &[("ncells", mesh.cells()), ("cell", mesh.cells())],
    };
    for source in sources.all() {
        for &(dimension, expected) in dimensions {
            let there = source.dimension_len(dimension)?.unwrap_or(expected);
            if there != expected {
                let mesh_path = mesh.path().display();
                let context = format!("{dimension} is {there}, expected {expected} as in the mesh of {mesh_path}");
                return Err(source.error(ErrorKind::Grid, context));
            }
        }
    }
    Ok(())
}

fn radius(sources: &Sources, convention: Convention) -> Result<f64> {
    match (sources.number("sphere_radius")?, convention) {
        (Some(r), _) if r.is_finite() && r > 0.0 => Ok(r),
        (Some(r), _) => {
            let context = format!("sphere_radius: {r}, expected a positive number");
            Err(sources.fields().error(ErrorKind::Grid, context))
        }
        (None, Convention::Icon | Convention::Cf) => Ok(ICON_RADIUS_M),
        (None, Convention::Mpas) => {
            let context = "attribute sphere_radius is missing, expected a radius in metres";
            Err(sources.error(ErrorKind::Grid, context))
        }
    }
}
