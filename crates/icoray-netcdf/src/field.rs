//! The layered fields of an MPAS file.

use crate::reals::OwnedReals;
use crate::source::{Kind, Source, Variable};
use icoray::{Error, ErrorKind, Field, Location, Reals, Result, Shape};
use std::fmt;

/// What the NetCDF library leaves where nothing was written (`NC_FILL_FLOAT` and `NC_FILL_DOUBLE`, the same number).
const UNWRITTEN: f64 = 9.969_209_968_386_869e36;

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
    /// At cells (`nCells`) or at corners (`nVertices`).
    pub location: Location,
    /// Number of columns: the mesh's cells or corners.
    pub columns: usize,
    /// Number of layers (`nVertLevels` or `nVertLevelsP1`).
    pub layers: usize,
    /// How the values are stored.
    pub precision: Precision,
    /// Whether there is one array per time record; otherwise one array serves all.
    pub time_dependent: bool,
    /// The attribute `units`.
    pub units: Option<String>,
    /// The attribute `long_name`.
    pub long_name: Option<String>,
}

impl FieldInfo {
    /// Describes `variable`, `None` when it is not a layered field.
    pub(crate) fn of(source: &Source, variable: &Variable) -> Result<Option<Self>> {
        let precision = match variable.kind {
            Kind::F32 => Precision::F32,
            Kind::F64 => Precision::F64,
            _ => return Ok(None),
        };
        let (time_dependent, [column, layer]) = match variable.dimensions.as_slice() {
            [time, column, layer] if time.name == "Time" => (true, [column, layer]),
            [column, layer] => (false, [column, layer]),
            _ => return Ok(None),
        };
        let location = match column.name.as_str() {
            "nCells" => Location::Center,
            "nVertices" => Location::Corner,
            _ => return Ok(None),
        };
        if !layer.name.starts_with("nVertLevels") || layer.len == 0 || column.len == 0 {
            return Ok(None);
        }
        Ok(Some(FieldInfo {
            name: variable.name.clone(),
            location,
            columns: column.len,
            layers: layer.len,
            precision,
            time_dependent,
            units: source.text_of(&variable.name, "units")?,
            long_name: source.text_of(&variable.name, "long_name")?,
        }))
    }

    /// Bytes that one time record takes in memory.
    pub fn bytes(&self) -> usize {
        self.columns.saturating_mul(self.layers).saturating_mul(self.precision.bytes())
    }
}

/// One time record of a field: its values as stored, level-fastest.
#[derive(Debug, Clone)]
pub struct OwnedField {
    info: FieldInfo,
    values: OwnedReals,
    fill: f64,
}

impl OwnedField {
    /// Reads record `time` of the variable that `info` describes.
    pub(crate) fn read(source: &Source, info: &FieldInfo, time: usize) -> Result<Self> {
        let name = &info.name;
        let variable = source
            .variable(name)
            .ok_or_else(|| source.error(ErrorKind::Field, format_args!("{name} is missing")))?;
        let (mut start, mut count) = (vec![0, 0], vec![info.columns, info.layers]);
        if info.time_dependent {
            start.insert(0, time);
            count.insert(0, 1);
        }
        let mut values = source.reals(variable, &start, &count)?;
        let mut marks = source.numbers_of(name, "_FillValue")?;
        if marks.is_empty() {
            marks.push(UNWRITTEN);
        }
        let fill = values.rounded(marks[0]);
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
        Ok(OwnedField { info: info.clone(), values, fill })
    }

    /// The field, borrowed.
    ///
    /// # Errors
    /// As [`Field::new`], with the field's name before the sentence.
    pub fn field(&self) -> Result<Field<'_>> {
        let shape = Shape::level_fastest(self.info.columns, self.info.layers);
        Field::new(self.values(), shape, self.info.location, Some(self.fill))
            .map_err(|e: Error| e.within(&self.info.name))
    }

    /// What the variable is: name, location, layers, units.
    pub fn info(&self) -> &FieldInfo {
        &self.info
    }

    /// The values, `columns` rows of `layers`.
    pub fn values(&self) -> Reals<'_> {
        self.values.as_reals()
    }

    /// The value that marks a missing sample: the attribute `_FillValue`, or else what the NetCDF library leaves where
    /// nothing was written. Values equal to `missing_value` are NaN.
    pub fn fill(&self) -> f64 {
        self.fill
    }

    /// Bytes that the values take.
    pub fn bytes(&self) -> usize {
        self.values.bytes()
    }
}
