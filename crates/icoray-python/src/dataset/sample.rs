//! The sample of icoray-dataset for xarray.

use crate::error::raised;
use crate::report::dict;
use icoray::OwnedReals;
use icoray_dataset::{Sample, SampleValues};
use numpy::{Element, PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict};

/// The sample in the form that xarray.Dataset.from_dict takes.
#[pyfunction]
pub fn sample(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let Sample { attributes, sphere_radius_m, dimensions, variables } = Sample::new().map_err(raised)?;
    let len = |name: &&str| dimensions.iter().find(|(known, _)| known == name).expect("all are listed").1;
    let described = PyDict::new(py);
    for variable in variables {
        let shape: Vec<usize> = variable.dimensions.iter().map(len).collect();
        let data = match variable.values {
            SampleValues::Integers(values) => array(py, values, shape)?,
            SampleValues::Reals(OwnedReals::F32(values)) => array(py, values, shape)?,
            SampleValues::Reals(OwnedReals::F64(values)) => array(py, values, shape)?,
        };
        let attrs = variable.attributes.into_py_dict(py)?;
        described.set_item(variable.name, dict!(py, { "dims": variable.dimensions, "attrs": attrs, "data": data }))?;
    }
    let attrs = attributes.into_py_dict(py)?;
    attrs.set_item("sphere_radius", sphere_radius_m)?;
    Ok(dict!(py, { "attrs": attrs, "coords": PyDict::new(py), "data_vars": described }))
}

fn array<T: Element>(py: Python<'_>, values: Vec<T>, shape: Vec<usize>) -> PyResult<Bound<'_, PyAny>> {
    Ok(PyArray1::from_vec(py, values).reshape(shape)?.into_any())
}
