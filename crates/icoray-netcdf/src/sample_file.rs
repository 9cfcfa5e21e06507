//! Writes the sample as a file.

use crate::guard::guarded;
use icoray::{OwnedReals, Result};
use icoray_dataset::{Sample, SampleValues};
use netcdf::{Extents, FileMut, NcTypeDescriptor, Options};
use std::path::Path;

/// Writes a sample as a classic NetCDF file with 64-bit offsets (CDF-2), and replaces a file of that name.
///
/// # Errors
/// [`ErrorKind::Io`](icoray::ErrorKind::Io) where the file cannot be written.
pub fn write_sample(path: impl AsRef<Path>, sample: &Sample) -> Result<()> {
    let path = path.as_ref();
    guarded(path, "the sample", || {
        let mut file = netcdf::create_with(path, Options::_64BIT_OFFSET)?;
        for (name, len) in &sample.dimensions {
            file.add_dimension(name, *len)?;
        }
        for (name, text) in sample.attributes {
            file.add_attribute(name, text)?;
        }
        file.add_attribute("sphere_radius", sample.sphere_radius_m)?;
        for variable in &sample.variables {
            let (name, dimensions) = (variable.name, &variable.dimensions);
            let mut declared = match &variable.values {
                SampleValues::Integers(_) => file.add_variable::<i32>(name, dimensions)?,
                SampleValues::Reals(OwnedReals::F32(_)) => file.add_variable::<f32>(name, dimensions)?,
                SampleValues::Reals(OwnedReals::F64(_)) => file.add_variable::<f64>(name, dimensions)?,
            };
            for (key, text) in &variable.attributes {
                declared.put_attribute(key, *text)?;
            }
        }
        file.enddef()?;
        for variable in &sample.variables {
            match &variable.values {
                SampleValues::Integers(values) => put(&mut file, variable.name, values)?,
                SampleValues::Reals(OwnedReals::F32(values)) => put(&mut file, variable.name, values)?,
                SampleValues::Reals(OwnedReals::F64(values)) => put(&mut file, variable.name, values)?,
            }
        }
        file.close()
    })
}

fn put<T: NcTypeDescriptor>(file: &mut FileMut, name: &str, values: &[T]) -> netcdf::Result<()> {
    let mut variable = file.variable_mut(name).ok_or("no such variable")?;
    variable.put_values(values, Extents::All)
}
