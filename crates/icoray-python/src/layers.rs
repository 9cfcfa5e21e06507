//! Layers.

use crate::array::RealArray;
use crate::error::raised;
use numpy::PyArray1;
use pyo3::prelude::*;

/// The radii of a field's layers.
///
/// Parameters
/// ----------
/// radius_m : array_like, shape (layers,)
///     Distances from the planet's centre, metres, strictly rising or strictly falling, in the order of the fields'
///     layers. At least two. Copied.
/// planet_radius_m : float
///     Radius of the planet's surface, metres. A scene's exaggeration stretches heights above it.
///
/// Raises
/// ------
/// LayersError
///     Names the first layer that is not finite, positive or strictly monotone.
#[pyclass(frozen, module = "icoray")]
pub(crate) struct Layers {
    pub inner: icoray::Layers,
}

#[pymethods]
impl Layers {
    #[new]
    #[pyo3(signature = (radius_m, planet_radius_m))]
    fn new(radius_m: &Bound<PyAny>, planet_radius_m: f64) -> PyResult<Self> {
        let inner = icoray::Layers::new(numbers(radius_m, "radius_m")?, planet_radius_m).map_err(raised)?;
        Ok(Layers { inner })
    }

    /// Layers at heights above the planet's surface, metres; negative ones are below it.
    ///
    /// Parameters
    /// ----------
    /// height_m : array_like, shape (layers,)
    ///     Heights in the order of the fields' layers, strictly rising or falling.
    /// planet_radius_m : float
    ///     Radius of the planet's surface, metres.
    #[staticmethod]
    #[pyo3(signature = (height_m, planet_radius_m))]
    fn from_heights(height_m: &Bound<PyAny>, planet_radius_m: f64) -> PyResult<Self> {
        let heights = numbers(height_m, "height_m")?;
        Ok(Layers { inner: icoray::Layers::from_heights(&heights, planet_radius_m).map_err(raised)? })
    }

    /// Radii from the planet's centre, metres: float64 of shape (layers,).
    #[getter]
    fn radius_m<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, self.inner.radius_m())
    }

    /// Radius of the planet's surface, metres.
    #[getter]
    fn planet_radius_m(&self) -> f64 {
        self.inner.planet_radius_m()
    }

    fn __len__(&self) -> usize {
        self.inner.count()
    }

    fn __repr__(&self) -> String {
        format!("<icoray.Layers: {}>", self.inner.describe())
    }
}

/// The numbers of an array of one dimension.
fn numbers(values: &Bound<PyAny>, name: &str) -> PyResult<Vec<f64>> {
    let array = RealArray::packed(values, &[0], name)?;
    // SAFETY: read at once, with Python's lock held.
    let (reals, _) = unsafe { array.reals() };
    Ok((0..reals.len()).map(|i| reals.get(i)).collect())
}
