//! Pictures.

use crate::error::{argument, raised};
use crate::report;
use icoray::Frame;
use icoray::output::figures::Scope;
use icoray::output::{Existing, png_bytes, write_error_map, write_picture};
use numpy::ndarray::{ArrayView, ShapeBuilder};
use numpy::{IntoPyArray, PyArray, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::path::PathBuf;

/// A picture, with what it cost and how far it may be off.
#[pyclass(frozen, module = "icoray")]
pub(crate) struct Image {
    frame: Frame,
}

impl Image {
    pub fn new(frame: Frame) -> Self {
        Image { frame }
    }

    /// Numbers of the frame as a read-only array that keeps the image.
    fn viewed<'py, S: ShapeBuilder>(
        slf: &Bound<'py, Self>,
        shape: S,
        values: &[f32],
    ) -> PyResult<Bound<'py, PyArray<f32, S::Dim>>> {
        let view =
            ArrayView::from_shape(shape.into_shape_with_order(), values).expect("as many numbers as the shape has");
        // SAFETY: the array keeps the image, which never changes.
        let array = unsafe { PyArray::borrow_from_array(&view, slf.clone().into_any()) };
        array.readwrite().make_nonwriteable();
        Ok(array)
    }

    fn size(&self) -> [usize; 2] {
        [self.frame.height as usize, self.frame.width as usize]
    }
}

/// Writes PNGs of one size as an animation: `Dataset.animate`.
#[pyfunction]
pub(crate) fn write_animation(py: Python, path: PathBuf, pictures: Vec<PathBuf>, fps: f64) -> PyResult<()> {
    let written = py.detach(|| icoray::output::write_animation(&path, &pictures, fps, Existing::Overwrite));
    written.map(drop).map_err(raised)
}

#[pymethods]
impl Image {
    /// Width, pixels.
    #[getter]
    fn width(&self) -> u32 {
        self.frame.width
    }

    /// Height, pixels.
    #[getter]
    fn height(&self) -> u32 {
        self.frame.height
    }

    /// Premultiplied linear RGBA, float32 of shape (height, width, 4), rows from the top: a read-only view of the
    /// picture's memory.
    #[getter]
    fn pixels<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray3<f32>>> {
        let [height, width] = slf.get().size();
        Self::viewed(slf, (height, width, 4), bytemuck::cast_slice(&slf.get().frame.pixels))
    }

    /// For each pixel, how far any of its channels may be from the exact integral: float32 of shape (height, width), a
    /// read-only view.
    #[getter]
    fn error<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let [height, width] = slf.get().size();
        Self::viewed(slf, (height, width), &slf.get().frame.error)
    }

    /// Cost, error and statistics of the frame by name, as in the columns of report.csv: a dict of plain numbers, texts
    /// and lists, None for what there is not. The page "The report of a frame" lists them.
    #[getter]
    fn report<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        report::of_figures(py, self.frame.figures(Scope::Frame))
    }

    /// The texts that a picture's file carries: field, range, error, camera, colours, version.
    #[getter]
    fn notes(&self) -> std::collections::BTreeMap<String, String> {
        self.frame.describe().into_iter().collect()
    }

    /// Straight 8-bit sRGB, uint8 of shape (height, width, 4), for PIL and matplotlib; without labels.
    fn to_rgba8<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<u8>>> {
        let [height, width] = self.size();
        let bytes = py.detach(|| icoray::output::rgba8(&self.frame));
        bytes.into_pyarray(py).reshape([height, width, 4])
    }

    /// The pixels of `to_rgba8`, for `numpy.asarray` and `matplotlib.pyplot.imshow`.
    #[pyo3(signature = (dtype = None, copy = None))]
    fn __array__<'py>(
        &self,
        py: Python<'py>,
        dtype: Option<&Bound<'py, PyAny>>,
        copy: Option<bool>,
    ) -> PyResult<Bound<'py, PyAny>> {
        if copy == Some(false) {
            return Err(argument("copy: False, expected True or None; `pixels` is an array without a copy".into()));
        }
        let pixels = self.to_rgba8(py)?.into_any();
        dtype.map_or(Ok(pixels.clone()), |dtype| pixels.call_method1("astype", (dtype,)))
    }

    /// Shows the picture: a notebook below the cell, elsewhere the program that opens PNGs, which is given a temporary
    /// file.
    ///
    /// Raises
    /// ------
    /// UnsupportedError
    ///     Where there is no such program.
    fn show(slf: &Bound<Self>) -> PyResult<()> {
        slf.py().import("icoray._show")?.call_method1("show", (slf,)).map(drop)
    }

    /// Writes the picture: PNG (8-bit sRGB, with labels and texts) or EXR (linear floats, with the error as a fifth
    /// channel), as the name's ending says. An existing file is replaced when the new one is complete.
    ///
    /// Parameters
    /// ----------
    /// path : str or os.PathLike
    ///
    /// Raises
    /// ------
    /// FileError
    ///     If the file cannot be written.
    /// ArgumentError
    ///     For another ending.
    #[pyo3(signature = (path))]
    fn save(&self, py: Python, path: PathBuf) -> PyResult<()> {
        py.detach(|| write_picture(&path, &self.frame)).map_err(raised)
    }

    /// Writes a map of the pixels' errors as PNG.
    #[pyo3(signature = (path))]
    fn error_map(&self, py: Python, path: PathBuf) -> PyResult<()> {
        py.detach(|| write_error_map(&path, &self.frame, Existing::Overwrite)).map_err(raised)
    }

    /// The PNG that notebooks show, with the scene's labels.
    fn _repr_png_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = py.detach(|| png_bytes(&self.frame)).map_err(raised)?;
        Ok(PyBytes::new(py, &bytes))
    }

    fn __repr__(&self) -> String {
        let Frame { width, height, field, report, .. } = &self.frame;
        format!("<icoray.Image: field {field:?}, {width} x {height} pixels, error {}>", report.error)
    }
}
