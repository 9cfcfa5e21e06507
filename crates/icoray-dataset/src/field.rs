//! The fields of a file: over columns and layers, or 2D ones over columns alone.

use crate::mesh::{Convention, Mesh, is_coordinate};
use crate::source::{Dimension, Kind, Source, Variable};
use crate::values::ShapedValues;
use icoray::{Description, Error, ErrorKind, Field, Location, Reals, Result, Shape};
use std::fmt;
use std::ops::Range;

/// NetCDF's default fill value (`NC_FILL_FLOAT` and `NC_FILL_DOUBLE`, the same number).
const UNWRITTEN: f64 = 9.969_209_968_386_869e36;
/// That of integers of 32 and of 64 bits (`NC_FILL_INT` and `NC_FILL_INT64`); shorter ones may be any value.
const UNWRITTEN_INTEGERS: [f64; 2] = [-2_147_483_647.0, -9_223_372_036_854_775_806.0];

/// Layers of the shell of a 2D field, which has equal values on them.
const SHELL_LAYERS: usize = 2;

/// Positions and numbers of the mesh in files of MPAS and ICON, which are no fields; with blanks between.
const OF_MESH: &str = "\
    nEdgesOnCell indexToCellID indexToVertexID boundaryCell boundaryVertex obtuseTriangle cell_index vertex_index \
    parent_cell_index parent_vertex_index cell_domain_id phys_cell_id child_cell_id refin_c_ctrl refin_v_ctrl \
    parent_cell_type \
    lonCell latCell xCell yCell zCell lonVertex latVertex xVertex yVertex zVertex clon clat vlon vlat lon lat \
    lon_cell_centre lat_cell_centre longitude_vertices latitude_vertices";

/// Dimensions of ICON's tables: points, edges and neighbours of a triangle or a point, ends of an interval.
const OF_TABLES: [&str; 8] = ["nv", "ne", "nc", "no", "nvertex", "vertices", "bnds", "nb2"];

/// Precision of a variable in the file and in memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Precision {
    /// Single precision, 4 bytes (NetCDF `float`).
    F32,
    /// Double precision, 8 bytes (NetCDF `double`).
    F64,
}

impl Precision {
    /// Bytes of one value.
    pub fn bytes(self) -> usize {
        match self {
            Precision::F32 => 4,
            Precision::F64 => 8,
        }
    }
}

impl fmt::Display for Precision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Precision::F32 => "f32",
            Precision::F64 => "f64",
        })
    }
}

/// A variable that can be read as a field.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FieldInfo {
    /// The variable's name.
    pub name: String,
    /// At cells (MPAS's `nCells`, ICON's `vertex`) or at corners (MPAS's `nVertices`, ICON's `cell`, which are
    /// triangles).
    pub location: Location,
    /// Number of columns: the mesh's cells or corners.
    pub columns: usize,
    /// Number of layers; 1 of a 2D field ([`FieldInfo::is_2d`]).
    pub layers: usize,
    /// How the values are stored; of integers, how they are kept.
    pub precision: Precision,
    /// Whether there is one array per time record; otherwise one array serves all.
    pub time_dependent: bool,
    /// The attributes `long_name` and `units`.
    pub description: Description,
    /// Name of the dimension of layers; empty where the variable has none.
    pub layer_dimension: String,
    /// Whether layers are the fastest dimension, as in MPAS's files, or columns are, as in ICON's.
    pub(crate) is_level_fastest: bool,
}

impl FieldInfo {
    /// Describes `variable`, `None` when it is not a field on the mesh.
    pub(crate) fn of(source: &dyn Source, variable: &Variable, mesh: &Mesh) -> Result<Option<Self>> {
        let dimensions = variable.after_time();
        let is_of_mesh = OF_MESH.split(' ').any(|name| name == variable.name) || is_coordinate(source, variable);
        let Some(axes) = Axes::of(mesh, dimensions).filter(|_| !is_of_mesh) else { return Ok(None) };
        let precision = match variable.kind {
            Kind::F32 => Precision::F32,
            Kind::F64 => Precision::F64,
            Kind::Integer if is_field(source, variable, &axes)? => Precision::F64,
            _ => return Ok(None),
        };
        Ok(Some(FieldInfo {
            name: variable.name.clone(),
            location: axes.location,
            columns: axes.column.len,
            layers: axes.layer.map_or(1, |layer| layer.len),
            precision,
            time_dependent: dimensions.len() < variable.dimensions.len(),
            description: Description {
                long_name: source.text_of(&variable.name, "long_name")?,
                units: source.text_of(&variable.name, "units")?,
            },
            layer_dimension: axes.layer.map_or_else(String::new, |layer| layer.name.clone()),
            is_level_fastest: axes.is_level_fastest,
        }))
    }

    /// Whether the field has one value in each column, as surface pressure and sea surface height have. Such a field is
    /// shown as a surface, and read with the same value on all the layers that are asked for.
    pub fn is_2d(&self) -> bool {
        self.layers == 1
    }

    /// The layers that [`Dataset::read_field`](crate::Dataset::read_field) reads: all; of a 2D field those of a
    /// thin shell, 2.
    pub fn all_layers(&self) -> Range<usize> {
        if self.is_2d() { 0..SHELL_LAYERS } else { 0..self.layers }
    }

    /// Bytes that one time record takes in memory.
    pub fn bytes(&self) -> usize {
        self.columns.saturating_mul(self.layers).saturating_mul(self.precision.bytes())
    }

    /// The dimensions of a block along which columns and layers follow each other.
    fn places(&self) -> [Option<usize>; 2] {
        let first = usize::from(self.time_dependent);
        let is_first = self.layer_dimension.is_empty() || self.is_level_fastest;
        let (column, layer) = if is_first { (first, first + 1) } else { (first + 1, first) };
        [Some(column), (!self.is_2d()).then_some(layer)]
    }

    /// How an array with `layers` of the layers lies in memory. All layers of a 2D field are the same values.
    fn shape(&self, layers: usize) -> Shape {
        if self.is_2d() {
            Shape { layer_stride: 0, ..Shape::cell_fastest(self.columns, layers) }
        } else if self.is_level_fastest {
            Shape::level_fastest(self.columns, layers)
        } else {
            Shape::cell_fastest(self.columns, layers)
        }
    }
}

/// The dimensions of a field after time.
struct Axes<'a> {
    location: Location,
    column: &'a Dimension,
    layer: Option<&'a Dimension>,
    is_level_fastest: bool,
}

impl<'a> Axes<'a> {
    /// `None` where the dimensions are not columns of the mesh, with layers or without.
    fn of(mesh: &Mesh, dimensions: &'a [Dimension]) -> Option<Self> {
        let place = |column: &Dimension| location(mesh, column).filter(|_| column.len > 0);
        let (location, column, layer, is_level_fastest) = match dimensions {
            [only] => (place(only)?, only, None, true),
            [one, two] => match (place(one), place(two)) {
                (Some(location), None) => (location, one, Some(two), true),
                (None, Some(location)) => (location, two, Some(one), false),
                _ => return None,
            },
            _ => return None,
        };
        let is_layer = |layer: &Dimension| match mesh.convention() {
            Convention::Mpas => layer.name.starts_with("nVertLevels"),
            Convention::Icon | Convention::Cf => !layer.is_time() && !OF_TABLES.contains(&layer.name.as_str()),
        };
        let is_layered = layer.is_none_or(|layer| layer.len > 0 && is_layer(layer));
        is_layered.then_some(Axes { location, column, layer, is_level_fastest })
    }
}

/// Whether integers over columns are values of a field, not a table of the mesh, which looks like layers that never
/// change.
fn is_field(source: &dyn Source, variable: &Variable, axes: &Axes) -> Result<bool> {
    let is_changing = variable.after_time().len() < variable.dimensions.len();
    let is_layered = axes.layer.is_some_and(|layer| layer.len > 1);
    Ok(packing(source, &variable.name)?.is_some()
        || (is_changing || !is_layered) && source.attribute(Some(&variable.name), "cf_role")?.is_none())
}

/// Factor and offset of values that are stored packed, as CF conventions 1.11, §8.1, have them.
fn packing(source: &dyn Source, name: &str) -> Result<Option<[f64; 2]>> {
    let first = |attribute: &str| Ok(source.numbers_of(name, attribute)?.first().copied());
    let (scale, offset) = (first("scale_factor")?, first("add_offset")?);
    let is_packed = scale.is_some() || offset.is_some();
    Ok(is_packed.then(|| [scale.unwrap_or(1.0), offset.unwrap_or(0.0)]))
}

/// Location of a dimension on the mesh: by name in MPAS's files, by length in ICON's, whose dimensions have various
/// names.
fn location(mesh: &Mesh, dimension: &Dimension) -> Option<Location> {
    match (mesh.convention(), dimension.name.as_str()) {
        (Convention::Mpas, "nCells") => Some(Location::Center),
        (Convention::Mpas, "nVertices") => Some(Location::Corner),
        (Convention::Icon | Convention::Cf, _) if dimension.len == mesh.corners_in_file() => Some(Location::Corner),
        (Convention::Icon | Convention::Cf, _) if dimension.len == mesh.cells() => Some(Location::Center),
        _ => None,
    }
}

/// Start and count of `layers` of record `time` along each dimension of the variable.
fn block(info: &FieldInfo, time: usize, layers: Range<usize>) -> (Vec<usize>, Vec<usize>) {
    let (mut start, mut count) = (vec![0], vec![info.columns]);
    if !info.layer_dimension.is_empty() {
        let stored = if info.is_2d() { 0..1 } else { layers };
        let at = usize::from(info.is_level_fastest);
        start.insert(at, stored.start);
        count.insert(at, stored.len());
    }
    if info.time_dependent {
        start.insert(0, time);
        count.insert(0, 1);
    }
    (start, count)
}

/// The values that a variable's `valid_range`, `valid_min` and `valid_max` admit, as CF conventions 1.11, §2.5.1, have
/// them.
struct Valid {
    ends: [f64; 2],
    /// Whether the ends are of values as they are stored, as CF §8.1 wants of packed ones. The NetCDF Users Guide lets
    /// real ends of packed integers be of unpacked values.
    is_of_stored: bool,
}

impl Valid {
    fn of(source: &dyn Source, variable: &Variable) -> Result<Self> {
        let name = &variable.name;
        let (mut ends, mut is_real) = ([f64::NEG_INFINITY, f64::INFINITY], false);
        for (attribute, which) in [("valid_range", [0, 1]), ("valid_min", [0, 0]), ("valid_max", [1, 1])] {
            let numbers = source.numbers_of(name, attribute)?;
            is_real |= !numbers.is_empty() && source.is_real_of(name, attribute)?;
            for (end, number) in which.into_iter().zip(numbers) {
                ends[end] = if end == 0 { ends[0].max(number) } else { ends[1].min(number) };
            }
        }
        Ok(Valid { ends, is_of_stored: variable.kind != Kind::Integer || !is_real })
    }

    /// Puts NaN for what lies outside, where `applies`.
    fn mask_outside(&self, values: &mut ShapedValues, applies: bool) {
        if applies && self.ends != [f64::NEG_INFINITY, f64::INFINITY] {
            let [low, high] = self.ends.map(|end| values.rounded(end));
            values.mask(|value| value < low || value > high);
        }
    }
}

/// One time record of a field: its values in the source's order and precision.
#[derive(Debug, Clone)]
pub struct OwnedField {
    info: FieldInfo,
    pub(crate) values: ShapedValues,
    pub(crate) fill: f64,
}

impl OwnedField {
    /// Reads `layers` of record `time` of the variable that `info` describes; of a 2D field its values, for as many
    /// layers.
    pub(crate) fn read(source: &dyn Source, info: &FieldInfo, time: usize, layers: Range<usize>) -> Result<Self> {
        let name = &info.name;
        let variable =
            source.variable(name).ok_or_else(|| source.error(ErrorKind::Field, format_args!("{name} is missing")))?;
        let (start, count) = block(info, time, layers.clone());
        let shape = info.shape(layers.len());
        let values = source.values(variable, &start, &count)?;
        let mut values = ShapedValues::new(values, shape, info.places());
        let mut marks = source.numbers_of(name, "_FillValue")?;
        if marks.is_empty() {
            let unwritten = if variable.kind == Kind::Integer { &UNWRITTEN_INTEGERS[..] } else { &[UNWRITTEN] };
            marks.extend(unwritten);
        }
        let mut fill = values.rounded(marks[0]);
        // A field has one mark; further ones become NaN, which is missing as well.
        marks.extend(source.numbers_of(name, "missing_value")?);
        for mark in marks {
            let mark = values.rounded(mark);
            if mark != fill {
                values.mask(|value| value == mark);
            }
        }
        let valid = Valid::of(source, variable)?;
        valid.mask_outside(&mut values, valid.is_of_stored);
        if let Some([scale, offset]) = packing(source, name)? {
            values.mask(|value| value == fill);
            values.each(|value| scale * value + offset);
            valid.mask_outside(&mut values, !valid.is_of_stored);
            fill = f64::NAN;
        }
        Ok(OwnedField { info: FieldInfo { layers: shape.layers, ..info.clone() }, values, fill })
    }

    /// Puts the values of the file's corners at the mesh's, whose rows in the file `rows` are; where these are `None`, they
    /// stay.
    pub(crate) fn spread(&mut self, rows: Option<&[u32]>) {
        if let Some(rows) = rows {
            self.values = self.values.of_columns(rows);
            self.info.columns = rows.len();
        }
    }

    /// The values less those of another field.
    ///
    /// # Errors
    /// [`ErrorKind::Field`] where that has other columns or layers.
    pub(crate) fn less(self, other: &OwnedField) -> Result<Self> {
        let shape = |field: &OwnedField| (field.info.location, field.values.shape.columns, field.values.shape.layers);
        if shape(&self) != shape(other) {
            let context = format!(
                "{}: {:?} less {:?}, expected the same place, columns and layers",
                self.info.name,
                shape(&self),
                shape(other)
            );
            return Err(Error::new(ErrorKind::Field, context));
        }
        let values = self.values.less(self.fill, &other.values, other.fill);
        Ok(OwnedField { values, fill: f64::NAN, ..self })
    }

    /// The field, borrowed.
    ///
    /// # Errors
    /// As [`Field::new`], with the field's name before the sentence.
    pub fn field(&self) -> Result<Field<'_>> {
        Field::new(self.values(), self.values.shape, self.info.location, Some(self.fill))
            .map_err(|e: Error| e.within(&self.info.name))
    }

    /// Name, location, long name and units of the variable; `layers` are those that were read.
    pub fn info(&self) -> &FieldInfo {
        &self.info
    }

    /// The array that has the values, which may have others too; [`OwnedField::field`] knows where they are.
    pub fn values(&self) -> Reals<'_> {
        self.values.as_reals()
    }

    /// The value that marks a missing sample: the attribute `_FillValue`, or else what the NetCDF library leaves where
    /// nothing was written. Values equal to `missing_value`, those outside `valid_range`, `valid_min` and `valid_max`,
    /// those below the sea floor or on land, and missing ones among packed values are NaN.
    pub fn fill(&self) -> f64 {
        self.fill
    }

    /// Bytes that were read or copied: none of values that lay in memory and are borrowed.
    pub fn bytes(&self) -> usize {
        self.values.owned_bytes()
    }
}
