//! The sample of icoray-dataset for xarray.

use crate::error::raised;
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
        let entry = PyDict::new(py);
        entry.set_item("dims", variable.dimensions)?;
        entry.set_item("attrs", variable.attributes.into_py_dict(py)?)?;
        entry.set_item("data", data)?;
        described.set_item(variable.name, entry)?;
    }
    let attrs = attributes.into_py_dict(py)?;
    attrs.set_item("sphere_radius", sphere_radius_m)?;
    let dataset = PyDict::new(py);
    dataset.set_item("attrs", attrs)?;
    dataset.set_item("coords", PyDict::new(py))?;
    dataset.set_item("data_vars", described)?;
    Ok(dataset)
}

fn array<T: Element>(py: Python<'_>, values: Vec<T>, shape: Vec<usize>) -> PyResult<Bound<'_, PyAny>> {
    Ok(PyArray1::from_vec(py, values).reshape(shape)?.into_any())
}
