//! Made files in other formats, and without or with other parts.

use crate::made::Made;
use netcdf::{AttributeValue, Options};

/// The formats that MPAS writes, by name.
pub fn formats() -> [(&'static str, Options); 4] {
    [
        ("CDF-1", Options::empty()),
        ("CDF-2", Options::_64BIT_OFFSET),
        ("CDF-5", Options::_64BIT_DATA),
        ("NetCDF-4", Options::NETCDF4),
    ]
}

impl Made {
    pub fn remove(&mut self, name: &str) {
        self.variables.retain(|v| v.name != name);
        self.attributes.retain(|(n, _)| *n != name);
    }

    pub fn set(&mut self, attribute: &'static str, value: impl Into<AttributeValue>) {
        self.remove(attribute);
        self.attributes.push((attribute, value.into()));
    }
}
