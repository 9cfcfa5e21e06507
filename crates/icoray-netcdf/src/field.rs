//! The layered fields of a file.

use crate::floor::Floor;
use crate::mesh::{Convention, Mesh};
use crate::reals::OwnedReals;
use crate::source::{Dimension, Kind, Source, Variable};
use crate::times::is_time;
use icoray::{Description, Error, ErrorKind, Field, Location, Reals, Result, Shape};
use std::fmt;
use std::ops::Range;

/// What the NetCDF library leaves where nothing was written (`NC_FILL_FLOAT` and `NC_FILL_DOUBLE`, the same number).
const UNWRITTEN: f64 = 9.969_209_968_386_869e36;

/// Dimensions of ICON's tables: points, edges and neighbours of a triangle or a point, ends of an interval.
const OF_TABLES: [&str; 8] = ["nv", "ne", "nc", "no", "nvertex", "vertices", "bnds", "nb2"];

/// How a variable's values are stored, and kept in memory.
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
    /// At cells (MPAS's `nCells`, ICON's `vertex`) or at corners (MPAS's `nVertices`, ICON's `cell`, which are triangles).
    pub location: Location,
    /// Number of columns: the mesh's cells or corners.
    pub columns: usize,
    /// Number of layers.
    pub layers: usize,
    /// How the values are stored; of integers that are packed, how they are kept.
    pub precision: Precision,
    /// Whether there is one array per time record; otherwise one array serves all.
    pub time_dependent: bool,
    /// The attributes `long_name` and `units`.
    pub description: Description,
    /// Name of the dimension of layers.
    pub layer_dimension: String,
    /// Whether layers are the fastest dimension, as in MPAS's files, or columns are, as in ICON's.
    pub(crate) is_level_fastest: bool,
}

impl FieldInfo {
    /// Describes `variable`, `None` when it is not a layered field on the mesh.
    pub(crate) fn of(source: &Source, variable: &Variable, mesh: &Mesh) -> Result<Option<Self>> {
        let (time_dependent, [one, two]) = match variable.dimensions.as_slice() {
            [time, one, two] if is_time(&time.name) => (true, [one, two]),
            [one, two] => (false, [one, two]),
            _ => return Ok(None),
        };
        let place = |column: &Dimension| location(mesh, column);
        let (location, column, layer, is_level_fastest) = match (place(one), place(two)) {
            (Some(location), None) => (location, one, two, true),
            (None, Some(location)) => (location, two, one, false),
            _ => return Ok(None),
        };
        let is_layered = match mesh.convention() {
            Convention::Mpas => layer.name.starts_with("nVertLevels") && layer.len > 0,
            Convention::Icon => {
                layer.len > 1 && !is_time(&layer.name) && !OF_TABLES.contains(&layer.name.as_str())
            }
        };
        if !is_layered || column.len == 0 {
            return Ok(None);
        }
        let precision = match variable.kind {
            Kind::F32 => Precision::F32,
            Kind::F64 => Precision::F64,
            Kind::Integer if packing(source, &variable.name)?.is_some() => Precision::F64,
            _ => return Ok(None),
        };
        Ok(Some(FieldInfo {
            name: variable.name.clone(),
            location,
            columns: column.len,
            layers: layer.len,
            precision,
            time_dependent,
            description: Description {
                long_name: source.text_of(&variable.name, "long_name")?,
                units: source.text_of(&variable.name, "units")?,
            },
            layer_dimension: layer.name.clone(),
            is_level_fastest,
        }))
    }

    /// Bytes that one time record takes in memory.
    pub fn bytes(&self) -> usize {
        self.columns.saturating_mul(self.layers).saturating_mul(self.precision.bytes())
    }

    /// How an array with `layers` of the layers lies in memory.
    fn shape(&self, layers: usize) -> Shape {
        if self.is_level_fastest {
            Shape::level_fastest(self.columns, layers)
        } else {
            Shape::cell_fastest(self.columns, layers)
        }
    }
}

/// Factor and offset of values that are stored packed, as CF conventions 1.11, §8.1, have them.
fn packing(source: &Source, name: &str) -> Result<Option<[f64; 2]>> {
    let first = |attribute: &str| Ok(source.numbers_of(name, attribute)?.first().copied());
    let (scale, offset) = (first("scale_factor")?, first("add_offset")?);
    let is_packed = scale.is_some() || offset.is_some();
    Ok(is_packed.then(|| [scale.unwrap_or(1.0), offset.unwrap_or(0.0)]))
}

/// Where a dimension's values live on the mesh: by its name in MPAS's files, by its length in ICON's, whose dimensions bear
/// several names.
fn location(mesh: &Mesh, dimension: &Dimension) -> Option<Location> {
    match (mesh.convention(), dimension.name.as_str()) {
        (Convention::Mpas, "nCells") => Some(Location::Center),
        (Convention::Mpas, "nVertices") => Some(Location::Corner),
        (Convention::Icon, _) if dimension.len == mesh.corners() => Some(Location::Corner),
        (Convention::Icon, _) if dimension.len == mesh.cells() => Some(Location::Center),
        _ => None,
    }
}

/// One time record of a field: its values in the file's order and precision.
#[derive(Debug, Clone)]
pub struct OwnedField {
    info: FieldInfo,
    shape: Shape,
    values: OwnedReals,
    fill: f64,
}

impl OwnedField {
    /// Reads `layers` of record `time` of the variable that `info` describes.
    pub(crate) fn read(
        source: &Source,
        info: &FieldInfo,
        time: usize,
        layers: Range<usize>,
        floor: Option<&Floor>,
    ) -> Result<Self> {
        let name = &info.name;
        let variable = source
            .variable(name)
            .ok_or_else(|| source.error(ErrorKind::Field, format_args!("{name} is missing")))?;
        let (mut start, mut count) = (vec![0, layers.start], vec![info.columns, layers.len()]);
        if !info.is_level_fastest {
            start.reverse();
            count.reverse();
        }
        if info.time_dependent {
            start.insert(0, time);
            count.insert(0, 1);
        }
        let mut values = source.reals(variable, &start, &count)?;
        let mut marks = source.numbers_of(name, "_FillValue")?;
        if marks.is_empty() {
            marks.push(UNWRITTEN);
        }
        let mut fill = values.rounded(marks[0]);
        // A field has one mark; further ones become NaN, which is missing as well.
        marks.extend(source.numbers_of(name, "missing_value")?);
        for mark in marks
            .into_iter()
            .map(|mark| values.rounded(mark))
            .filter(|mark| *mark != fill)
            .collect::<Vec<_>>()
        {
            values.void(mark);
        }
        if let Some([scale, offset]) = packing(source, name)? {
            values.void(fill);
            values.each(|value| scale * value + offset);
            fill = f64::NAN;
        }
        let shape = info.shape(layers.len());
        if let Some(floor) = floor {
            floor.void_outside(info, &shape, layers, &mut values);
        }
        Ok(OwnedField { info: FieldInfo { layers: shape.layers, ..info.clone() }, shape, values, fill })
    }

    /// The field, borrowed.
    ///
    /// # Errors
    /// As [`Field::new`], with the field's name before the sentence.
    pub fn field(&self) -> Result<Field<'_>> {
        Field::new(self.values(), self.shape, self.info.location, Some(self.fill))
            .map_err(|e: Error| e.within(&self.info.name))
    }

    /// What the variable is: name, location, what it is called and measured in; `layers` are those that were read.
    pub fn info(&self) -> &FieldInfo {
        &self.info
    }

    /// The values, in the file's order; [`OwnedField::field`] knows which.
    pub fn values(&self) -> Reals<'_> {
        self.values.as_reals()
    }

    /// The value that marks a missing sample: the attribute `_FillValue`, or else what the NetCDF library leaves where
    /// nothing was written. Values equal to `missing_value`, those
    /// below the sea floor, and missing ones among packed values are NaN.
    pub fn fill(&self) -> f64 {
        self.fill
    }

    /// Bytes that the values take.
    pub fn bytes(&self) -> usize {
        self.values.bytes()
    }
}
