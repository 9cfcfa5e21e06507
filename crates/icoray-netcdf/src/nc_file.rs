//! One NetCDF file: its list of variables, attributes and typed reads. Only this module calls the NetCDF binding,
//! through `guarded`.

use crate::classic::ClassicLayout;
use crate::guard::guarded;
use crate::{filters, groups, names};
use icoray::{Error, ErrorKind, OwnedReals, Result};
use icoray_dataset::{Attribute, Kind, Source, Variable};
use netcdf::types::NcVariableType;
use netcdf::{AttributeValue, Extents, NcTypeDescriptor};
use std::fmt;
use std::path::{Path, PathBuf};

/// Maximum bytes of values per byte of a file: deflate packs up to 1032, and numbers may be widened when read.
const MAX_RATIO: u64 = 8192;

/// An open file.
#[derive(Debug)]
pub(crate) struct NcFile {
    file: netcdf::File,
    path: PathBuf,
    is_address: bool,
    classic: Option<ClassicLayout>,
    variables: Vec<Variable>,
}

/// A byte of a `char` variable.
#[repr(transparent)]
#[derive(Clone, Copy, Default)]
struct Char(u8);

// SAFETY: NC_CHAR is one byte, and any byte is a valid `Char`.
unsafe impl NcTypeDescriptor for Char {
    fn type_descriptor() -> NcVariableType {
        NcVariableType::Char
    }
}

impl NcFile {
    pub(crate) fn open(path: &Path) -> Result<Self> {
        let damaged = |e| format!("{}: the header is damaged or cut off: {e}", path.display());
        let address = names::address(path);
        let (classic, what) = if address.is_some() {
            (None, "the NetCDF library cannot open this address")
        } else {
            names::expect_netcdf(path)?;
            let classic = ClassicLayout::read(path).map_err(|e| Error::new(ErrorKind::Io, damaged(e)))?;
            (classic, "not a NetCDF file, or damaged or cut off")
        };
        let file = guarded(path, what, || netcdf::open(address.as_deref().unwrap_or(path)))?;
        let variables = guarded(path, "the list of variables", || Ok(groups::variables(&file)))?;
        let mut opened = NcFile { file, path: path.to_owned(), is_address: address.is_some(), classic, variables };
        opened.variables = (&opened as &dyn Source).with_time_marked();
        Ok(opened)
    }

    /// Reads the attributes of a variable and drops them.
    pub(crate) fn try_attributes(&self, variable: &str) -> Result<()> {
        guarded(&self.path, format_args!("attributes of {variable}"), || {
            let variable = self.file.variable(variable).ok_or("no such variable")?;
            variable.attributes().try_for_each(|attribute| attribute.value().map(drop))
        })
    }

    fn error(&self, kind: ErrorKind, context: impl fmt::Display) -> Error {
        (self as &dyn Source).error(kind, context)
    }

    /// The places of the variables in a classic file.
    pub(crate) fn classic(&self) -> Option<&ClassicLayout> {
        self.classic.as_ref()
    }

    /// Length of the file, bytes.
    pub(crate) fn length(&self) -> Result<u64> {
        Ok(std::fs::metadata(&self.path).map_err(|e| self.error(ErrorKind::Io, e))?.len())
    }

    fn block<T>(&self, variable: &Variable, start: &[usize], count: &[usize]) -> Result<Vec<T>>
    where
        T: NcTypeDescriptor + Copy + Default,
    {
        let name = &variable.name;
        self.expect_stored(name, start.first().copied().unwrap_or(0) + count.first().copied().unwrap_or(1))?;
        let entries = count.iter().try_fold(1usize, |n, &c| n.checked_mul(c));
        self.expect_plausible(
            variable,
            entries.map_or(u64::MAX, |n| (n as u64).saturating_mul(size_of::<T>() as u64)),
        )?;
        let mut values = Vec::new();
        // A damaged header may promise more than there can be; running out of memory must not end the process.
        let room = entries.filter(|&n| values.try_reserve_exact(n).is_ok());
        let Some(entries) = room else {
            return Err(self.error(ErrorKind::Io, format_args!("{variable}: too large for the memory")));
        };
        if entries == 0 {
            return Ok(values);
        }
        values.resize(entries, T::default());
        guarded(&self.path, format_args!("variable {name}"), || {
            let variable = self.file.variable(name).ok_or("no such variable")?;
            let read = variable.get_values_into(&mut values, Extents::try_from((start, count))?);
            read.map_err(|error| match filters::missing(&self.path, name) {
                Some(missing) => missing.into(),
                None => error,
            })
        })?;
        Ok(values)
    }

    /// Fails if a NetCDF-4 file is too small for the bytes of a variable at any compression: memory that the system
    /// promises and does not have would end the process. The length at an address is not known.
    fn expect_plausible(&self, variable: &Variable, bytes: u64) -> Result<()> {
        if self.is_address || self.classic.is_some() {
            return Ok(());
        }
        let length = self.length()?;
        if bytes / MAX_RATIO <= length {
            return Ok(());
        }
        let context = format!("{variable}: {bytes} bytes, more than a file of {length} bytes can hold");
        Err(self.error(ErrorKind::Io, context))
    }

    /// Fails where a classic file ends before the first `records` records of a variable.
    fn expect_stored(&self, name: &str, records: usize) -> Result<()> {
        let Some(end) = self.classic.as_ref().and_then(|layout| layout.end(name, records)) else {
            return Ok(());
        };
        let length = self.length()?;
        if length < end {
            let context = format!("variable {name} ends at byte {end}, the file at byte {length}: the file is cut off");
            return Err(self.error(ErrorKind::Io, context));
        }
        Ok(())
    }
}

impl Source for NcFile {
    fn path(&self) -> &Path {
        &self.path
    }

    fn variables(&self) -> &[Variable] {
        &self.variables
    }

    fn dimension_len(&self, name: &str) -> Result<Option<usize>> {
        // Those of groups are known by the variables over them.
        let mut dimensions = self.variables.iter().flat_map(|variable| &variable.dimensions);
        if let Some(known) = dimensions.find(|dimension| dimension.name == name) {
            return Ok(Some(known.len));
        }
        guarded(&self.path, format_args!("dimension {name}"), || Ok(self.file.dimension_len(name)))
    }

    fn attribute(&self, variable: Option<&str>, name: &str) -> Result<Option<Attribute>> {
        let Some(variable) = variable else {
            let value = guarded(&self.path, format_args!("attribute {name}"), || {
                let found = self.file.root().and_then(|root| groups::attribute(&root, name));
                found.or_else(|| self.file.attribute(name).map(|a| a.value())).transpose()
            });
            return value.map(|value| value.and_then(attribute));
        };
        let value = guarded(&self.path, format_args!("attribute {name} of {variable}"), || {
            let variable = self.file.variable(variable).ok_or("no such variable")?;
            variable.attribute_value(name).transpose()
        });
        value.map(|value| value.and_then(attribute))
    }

    fn reals(&self, variable: &Variable, start: &[usize], count: &[usize]) -> Result<OwnedReals> {
        match variable.kind {
            Kind::F32 => self.block(variable, start, count).map(OwnedReals::F32),
            Kind::F64 | Kind::Integer => self.block(variable, start, count).map(OwnedReals::F64),
            _ => Err(self.error(ErrorKind::Field, format_args!("{variable}, expected float or double"))),
        }
    }

    fn integers(&self, variable: &Variable) -> Result<Vec<i32>> {
        let (start, count) = variable.whole();
        self.block(variable, &start, &count)
    }

    fn text_rows(&self, variable: &Variable, rows: usize) -> Vec<Option<String>> {
        let [stored, width] = [0, 1].map(|i| variable.dimensions[i].len);
        let read = |first: usize, count: usize| -> Result<Vec<Option<String>>> {
            let bytes: Vec<Char> = self.block(variable, &[first, 0], &[count, width])?;
            let bytes: Vec<u8> = bytes.iter().map(|c| c.0).collect();
            let row = |i| Some(trimmed(&String::from_utf8_lossy(&bytes[i * width..(i + 1) * width])));
            Ok((0..count).map(row).collect())
        };
        let count = rows.min(stored);
        let mut texts = read(0, count)
            .unwrap_or_else(|_| (0..count).flat_map(|row| read(row, 1).unwrap_or_else(|_| vec![None])).collect());
        texts.resize(rows, None);
        texts
    }
}

pub(crate) fn trimmed(text: &str) -> String {
    text.trim_matches(|c: char| c == '\0' || c.is_whitespace()).to_owned()
}

fn attribute(value: AttributeValue) -> Option<Attribute> {
    use AttributeValue::{Double, Doubles, Float, Floats, Str, Strs};
    match value {
        Str(text) => Some(Attribute::Text(trimmed(&text))),
        Strs(texts) => texts.first().map(|text| Attribute::Text(trimmed(text))),
        other => {
            let is_real = matches!(other, Float(_) | Floats(_) | Double(_) | Doubles(_));
            Some(Attribute::Numbers { values: numbers(other), is_real })
        }
    }
}

fn numbers(value: AttributeValue) -> Vec<f64> {
    match value {
        AttributeValue::Floats(v) => v.into_iter().map(f64::from).collect(),
        AttributeValue::Doubles(v) => v,
        AttributeValue::Schars(v) => v.into_iter().map(f64::from).collect(),
        AttributeValue::Uchars(v) => v.into_iter().map(f64::from).collect(),
        AttributeValue::Shorts(v) => v.into_iter().map(f64::from).collect(),
        AttributeValue::Ushorts(v) => v.into_iter().map(f64::from).collect(),
        AttributeValue::Ints(v) => v.into_iter().map(f64::from).collect(),
        AttributeValue::Uints(v) => v.into_iter().map(f64::from).collect(),
        one => f64::try_from(one).map(|v| vec![v]).unwrap_or_default(),
    }
}
