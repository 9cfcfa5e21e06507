//! Fields over arrays of Python.

use crate::array::RealArray;
use crate::error::{argument, bad_field, raised};
use icoray::{ColumnCount, Description, Dimension, Error, ErrorKind, Location, Shape};
use pyo3::prelude::*;
use std::sync::{Mutex, PoisonError};

/// A scalar field over a borrowed array.
///
/// A native, aligned array of 32- or 64-bit floats is read in place, with any strides; it is read whenever a picture is
/// rendered, and no other thread may write to it meanwhile. Anything else is copied here, once: masked arrays (masked
/// entries become NaN), integers, half and extended floats, other byte orders, arrays of dask and of GPUs. `bytes_copied`
/// counts them. Values that are NaN, infinite or equal to `fill` are missing.
///
/// Parameters
/// ----------
/// values : array_like
///     Two dimensions, layers and columns (cells, or corners) in either order; or three, of which one has the layers and
///     the others blocks of columns (ICON's nproma, layers, blocks); which is which follows from grid and layers. As
///     many layers as `Layers` has, or one fewer, midway between them. One dimension, the
///     columns, is a 2D field: it has the same values on all layers, and a volume of it without an opacity in the scene is shown as
///     a surface on the innermost layer.
/// location : {"cell", "corner"}
///     Where the values are. Values at corners are averaged to cells.
/// fill : float, optional
///     Value that marks missing ones; it is rounded to the array's type.
/// layer_axis : int, optional
///     The dimension with the layers, where two could be.
/// long_name, units : str, optional
///     For labels and texts of pictures.
/// constant : bool
///     Promise that the values do not change any more: then a renderer keeps what it derives of them from picture to
///     picture. A copy is constant by itself.
///
/// Raises
/// ------
/// FieldError
///     For values that are no real numbers, and at rendering where the shape does not fit grid and layers.
#[pyclass(frozen, module = "icoray")]
pub(crate) struct Field {
    pub array: RealArray,
    pub location: Location,
    /// Value that marks missing ones.
    #[pyo3(get)]
    pub fill: Option<f64>,
    pub layer_axis: Option<usize>,
    pub description: Description,
    is_constant: bool,
    /// The last borrow of a constant array, by which caches identify it.
    last: Mutex<Option<icoray::Field<'static>>>,
}

#[pymethods]
impl Field {
    #[new]
    #[pyo3(signature = (values, location = "cell", fill = None, *, layer_axis = None, long_name = None, units = None,
                        constant = false))]
    pub fn new(
        values: &Bound<PyAny>,
        location: &str,
        fill: Option<f64>,
        layer_axis: Option<isize>,
        long_name: Option<String>,
        units: Option<String>,
        constant: bool,
    ) -> PyResult<Self> {
        let array = RealArray::new(values, "values")?;
        let rank = array.dimensions.len();
        if rank == 0 || rank > 7 {
            return Err(bad_field(format!("values: an array of {rank} dimensions, expected 1 to 7")));
        }
        let axis = |axis: isize| {
            let from_start = if axis < 0 { axis + rank as isize } else { axis };
            let found = usize::try_from(from_start).ok().filter(|axis| *axis < rank);
            found.ok_or_else(|| argument(format!("layer_axis: {axis}, expected one of {rank} dimensions")))
        };
        let layer_axis = layer_axis.map(axis).transpose()?;
        let location = parse_location(location)?;
        // An array of floats holds the mark as a float.
        let fill = fill.map(|fill| if array.is_f32() { f64::from(fill as f32) } else { fill });
        let is_constant = constant || array.bytes_copied > 0;
        let description = Description { long_name, units };
        Ok(Field { array, location, fill, layer_axis, description, is_constant, last: Mutex::default() })
    }

    /// Bytes that were copied because the library cannot read the array in place; 0 where it is borrowed.
    #[getter]
    fn bytes_copied(&self) -> u64 {
        self.array.bytes_copied
    }

    /// The array that is read: the one that was given, or its copy.
    #[getter]
    fn values<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        self.array.owner(py)
    }

    /// Where the values are: "cell" or "corner".
    #[getter]
    fn location(&self) -> &'static str {
        if self.location == Location::Center { "cell" } else { "corner" }
    }

    /// Long name, such as "potential temperature".
    #[getter]
    fn long_name(&self) -> Option<&str> {
        self.description.long_name.as_deref()
    }

    /// Units, such as "m s-1".
    #[getter]
    fn units(&self) -> Option<&str> {
        self.description.units.as_deref()
    }

    fn __repr__(&self) -> String {
        let extents: Vec<String> = self.array.dimensions.iter().map(|d| d.extent.to_string()).collect();
        let (at, copied) = (self.location(), self.array.bytes_copied);
        let how = if copied > 0 { format!("{copied} bytes copied") } else { "borrowed".into() };
        format!("<icoray.Field: ({}) at {at}s, {how}>", extents.join(", "))
    }
}

impl Field {
    /// The field of an argument: a field, or an array of values at cells.
    pub fn of<'py>(values: &Bound<'py, PyAny>) -> PyResult<Bound<'py, Self>> {
        match values.cast::<Self>() {
            Ok(field) => Ok(field.clone()),
            Err(_) => Bound::new(values.py(), Self::new(values, "cell", None, None, None, None, false)?),
        }
    }

    /// The same field of an array of which no two elements share memory.
    pub fn without_shared_elements(self, py: Python) -> PyResult<Self> {
        Ok(Field { array: self.array.without_shared_elements(py)?, ..self })
    }

    /// Borrows the array for a picture.
    ///
    /// # Safety
    /// The result is used while `self` lives, and no thread writes to the array meanwhile.
    pub unsafe fn borrowed(&self, grid: &icoray::Grid, layers: usize) -> icoray::Result<icoray::Field<'static>> {
        // SAFETY: passed on.
        let (samples, offset) = unsafe { self.array.reals() };
        let shape = Shape { offset, ..self.shape(&ColumnCount::new(grid, self.location), layers)? };
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = last.filter(|known| self.is_constant && *known.shape() == shape) {
            return Ok(known);
        }
        let field = icoray::Field::new(samples, shape, self.location, self.fill)?;
        *last = Some(field);
        Ok(field)
    }

    /// Dimensions in Fortran's order, in which blocks come after the columns inside of them; and the one of the layers, if
    /// `layer_axis` says it, which is then put where it is looked for first: the second of three, the first of two.
    pub fn ordered_dimensions(&self) -> (Vec<Dimension>, Option<Dimension>) {
        let mut dimensions = self.array.dimensions.clone();
        let level = self.layer_axis.map(|axis| dimensions.remove(axis));
        let strides: Vec<usize> =
            dimensions.iter().filter(|d| d.extent != 1).map(|d| d.stride.unsigned_abs()).collect();
        // Two dimensions without layers are columns and blocks; of two others either may have the layers.
        let has_blocks = strides.len() + usize::from(level.is_some()) > 2;
        if has_blocks && strides.first() > strides.last() {
            dimensions.reverse();
        }
        if let Some(level) = level {
            dimensions.insert(usize::from(has_blocks), level);
        }
        (dimensions, level)
    }

    /// Which dimensions are layers and columns.
    fn shape(&self, expected: &ColumnCount, layers: usize) -> icoray::Result<Shape> {
        let (dimensions, level) = self.ordered_dimensions();
        let shape = Shape::of_dimensions(&dimensions, expected, layers)?;
        match level {
            Some(level) if (shape.layers, shape.layer_stride) != (level.extent, level.stride) => {
                let extents: Vec<usize> = self.array.dimensions.iter().map(|d| d.extent).collect();
                let context = format!(
                    "an array of extents {extents:?} with layers in dimension {}, expected {layers} layers there and {} \
                     columns in the others",
                    self.layer_axis.unwrap_or(0),
                    expected.columns
                );
                Err(Error::new(ErrorKind::Field, context))
            }
            _ => Ok(shape),
        }
    }
}

/// The location of values.
pub(crate) fn parse_location(location: &str) -> PyResult<Location> {
    match location {
        "cell" => Ok(Location::Center),
        "corner" => Ok(Location::Corner),
        other => Err(argument(format!("location: {other:?}, expected \"cell\" or \"corner\""))),
    }
}

/// Where an icoray error of a field belongs.
pub(crate) fn of_field(name: &str, error: Error) -> PyErr {
    raised(if name.is_empty() { error } else { error.within(format_args!("field {name:?}")) })
}
