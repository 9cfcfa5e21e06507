//! Writes synthetic datasets as NetCDF files.

use crate::made::{Made, MadeVariable, Values};
use netcdf::types::NcVariableType;
use netcdf::{AttributeValue, Extents, FileMut, NcTypeDescriptor, Options};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// The formats that MPAS writes, by name.
pub fn formats() -> [(&'static str, Options); 4] {
    [
        ("CDF-1", Options::empty()),
        ("CDF-2", Options::_64BIT_OFFSET),
        ("CDF-5", Options::_64BIT_DATA),
        ("NetCDF-4", Options::NETCDF4),
    ]
}

#[repr(transparent)]
#[derive(Clone, Copy)]
struct Char(u8);

// SAFETY: NC_CHAR is one byte.
unsafe impl NcTypeDescriptor for Char {
    fn type_descriptor() -> NcVariableType {
        NcVariableType::Char
    }
}

impl Made {
    /// Writes the file into a folder of its own, which is removed when dropped.
    pub fn write(&self, options: Options) -> (TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("made.nc");
        self.write_to(&path, options);
        (folder, path)
    }

    pub fn write_to(&self, path: &Path, options: Options) {
        let mut file = netcdf::create_with(path, options).unwrap();
        for (name, len) in &self.dimensions {
            file.add_dimension(name, *len).unwrap();
        }
        for (name, value) in &self.attributes {
            file.add_attribute(name, attribute(value)).unwrap();
        }
        for variable in &self.variables {
            variable.declare(&mut file);
        }
        file.enddef().unwrap();
        for variable in self.variables.iter().filter(|variable| variable.values.len() > 0) {
            variable.put(&mut file, 0);
        }
        file.close().unwrap();
    }
}

impl MadeVariable {
    fn declare(&self, file: &mut FileMut) {
        let mut variable = match self.values {
            Values::F32(_) => file.add_variable::<f32>(self.name, &self.dimensions),
            Values::F64(_) => file.add_variable::<f64>(self.name, &self.dimensions),
            Values::I32(_) => file.add_variable::<i32>(self.name, &self.dimensions),
            Values::Text(_) => file.add_variable::<Char>(self.name, &self.dimensions),
        }
        .unwrap();
        for (name, value) in &self.attributes {
            variable.put_attribute(name, attribute(value)).unwrap();
        }
    }

    /// Writes the values, of a record variable from a record on.
    pub fn put(&self, file: &mut FileMut, record: usize) {
        let mut variable = file.variable_mut(self.name).unwrap();
        let mut count: Vec<usize> = variable.dimensions().iter().map(|dimension| dimension.len()).collect();
        let mut start = vec![0; count.len()];
        if variable.dimensions().first().is_some_and(netcdf::Dimension::is_unlimited) {
            start[0] = record;
            count[0] = self.values.len() / count[1..].iter().product::<usize>();
        }
        let extents = Extents::try_from((start, count)).unwrap();
        match &self.values {
            Values::F32(values) => variable.put_values(values, extents),
            Values::F64(values) => variable.put_values(values, extents),
            Values::I32(values) => variable.put_values(values, extents),
            Values::Text(text) => variable.put_values(&text.iter().map(|c| Char(*c)).collect::<Vec<_>>(), extents),
        }
        .unwrap();
    }
}

fn attribute(values: &Values) -> AttributeValue {
    match values.clone() {
        Values::F32(values) => AttributeValue::Floats(values),
        Values::F64(values) => AttributeValue::Doubles(values),
        Values::I32(values) => AttributeValue::Ints(values),
        Values::Text(text) => AttributeValue::Str(String::from_utf8(text).unwrap()),
    }
}
