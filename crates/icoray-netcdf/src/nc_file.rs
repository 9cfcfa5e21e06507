//! One NetCDF file: its list of variables, those of NetCDF-4's groups by their paths, attributes and typed reads. Only
//! this module calls the NetCDF binding, through `guarded`.

use crate::classic::ClassicLayout;
use crate::filters;
use crate::guard::guarded;
use icoray::{Error, ErrorKind, OwnedReals, Result};
use icoray_dataset::{Attribute, Dimension, Kind, Source, Variable};
use netcdf::types::{FloatType, NcVariableType};
use netcdf::{AttributeValue, Extents, Group, NcTypeDescriptor};
use std::collections::HashMap;
use std::fmt;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Maximum bytes of values per byte of a file: deflate packs up to 1032, and numbers may be widened when read.
const MAX_RATIO: u64 = 8192;

/// An open file.
#[derive(Debug)]
pub(crate) struct NcFile {
    file: netcdf::File,
    path: PathBuf,
    is_address: bool,
    /// The places of the variables in a classic file.
    pub(crate) classic: Option<ClassicLayout>,
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
        let address = address(path);
        let (classic, what) = if address.is_some() {
            (None, "the NetCDF library cannot open this address")
        } else {
            expect_netcdf(path)?;
            let classic = ClassicLayout::read(path).map_err(|e| Error::new(ErrorKind::Io, damaged(e)))?;
            (classic, "not a NetCDF file, or damaged or cut off")
        };
        let file = guarded(path, what, || netcdf::open(address.as_deref().unwrap_or(path)))?;
        let variables = guarded(path, "the list of variables", || Ok(variables_of(&file)))?;
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
        let what = variable.map_or_else(String::new, |variable| format!(" of {variable}"));
        let value = guarded(&self.path, format_args!("attribute {name}{what}"), || {
            if let Some(variable) = variable {
                return self.file.variable(variable).ok_or("no such variable")?.attribute_value(name).transpose();
            }
            let found = self.file.root().and_then(|root| attribute_of(&root, name));
            found.or_else(|| self.file.attribute(name).map(|a| a.value())).transpose()
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

/// The names in a [`Variable`] of the dimensions that a group and those around it declare.
type Names = HashMap<String, String>;

/// All variables: those of the root first, then those of each group as `group/name`.
///
/// A dimension of a group has the group's path before its name where it has a coordinate there, and where one of that
/// name is another: it is in a group around, or its length differs.
fn variables_of(file: &netcdf::File) -> Vec<Variable> {
    let mut found = Vec::new();
    match file.root() {
        Some(root) => collect(&root, "", &Names::new(), &mut found),
        None => found.extend(file.variables().map(|variable| describe(&variable, "", &Names::new()))),
    }
    found
}

/// The attribute of a group itself, else that of the first group inside which has one of this name.
fn attribute_of(group: &Group<'_>, name: &str) -> Option<netcdf::Result<AttributeValue>> {
    let own = group.attribute(name).map(|attribute| attribute.value());
    own.or_else(|| group.groups().find_map(|inner| attribute_of(&inner, name)))
}

/// Appends the variables of a group and of those in it; `path` ends with `/`, and is empty of the root.
fn collect(group: &Group<'_>, path: &str, around: &Names, found: &mut Vec<Variable>) {
    let mut names = around.clone();
    for dimension in group.dimensions() {
        let (name, len) = (dimension.name(), dimension.len());
        let mut dimensions = found.iter().flat_map(|variable| &variable.dimensions);
        let is_other = around.contains_key(&name) || dimensions.any(|known| known.name == name && known.len != len);
        let is_of_group = is_other || group.variable(&name).is_some();
        let shown = if is_of_group { format!("{path}{name}") } else { name.clone() };
        names.insert(name, shown);
    }
    found.extend(group.variables().map(|variable| describe(&variable, path, &names)));
    for inner in group.groups() {
        collect(&inner, &format!("{path}{}/", inner.name()), &names, found);
    }
}

fn describe(variable: &netcdf::Variable<'_>, path: &str, names: &Names) -> Variable {
    let kind = match variable.vartype() {
        NcVariableType::Float(FloatType::F32) => Kind::F32,
        NcVariableType::Float(FloatType::F64) => Kind::F64,
        NcVariableType::Int(_) => Kind::Integer,
        NcVariableType::Char => Kind::Text,
        _ => Kind::Other,
    };
    let dimension = |dimension: &netcdf::Dimension<'_>| {
        let name = dimension.name();
        Dimension::new(names.get(&name).cloned().unwrap_or(name), dimension.len())
    };
    let dimensions = variable.dimensions().iter().map(dimension).collect();
    Variable { name: format!("{path}{}", variable.name()), kind, dimensions }
}

/// The address that the NetCDF library opens: a name that is one (`https://`, `s3://`), or that of a file whose name is
/// followed by `#mode=`; `None` for other local files.
pub(crate) fn address(path: &Path) -> Option<PathBuf> {
    let text = path.to_string_lossy();
    let of_file = |file: &Path, mode: &str| {
        let absolute = std::path::absolute(file).unwrap_or_else(|_| file.to_owned());
        PathBuf::from(format!("file://{}#mode={mode}", absolute.display()))
    };
    match text.split_once("#mode=") {
        _ if path.exists() => None,
        _ if text.contains("://") => Some(path.to_owned()),
        Some((file, mode)) => Some(of_file(file.as_ref(), mode)),
        None => None,
    }
}

/// Fails where a local file is absent or none, and says what to do with GRIB.
fn expect_netcdf(path: &Path) -> Result<()> {
    let shown = path.display();
    let error = |what: String| Error::new(ErrorKind::Io, format!("{shown}: {what}"));
    let io = |e: std::io::Error| error(e.to_string());
    if !std::fs::metadata(path).map_err(io)?.is_file() {
        return Err(error("not a file".to_owned()));
    }
    let mut begin = Vec::new();
    File::open(path).and_then(|file| file.take(8).read_to_end(&mut begin)).map_err(io)?;
    match begin[..] {
        [b'G', b'R', b'I', b'B', _, _, _, edition] => Err(error(format!(
            "a file of GRIB {edition}, expected NetCDF: `cdo -f nc copy {shown} NEW.nc` converts it; in Python \
             `icoray.open(\"{shown}\")` reads it with xarray and cfgrib"
        ))),
        _ => Ok(()),
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
