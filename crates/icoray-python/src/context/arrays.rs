//! Fields and heights as arrays of C.

use super::c_string;
use crate::array::Pointer;
use crate::field::Field;
use icoray::Location;
use icoray_context::boundary::Failure;
use icoray_context::icoray_ctx;
use icoray_context::types::{ICORAY_CENTER, ICORAY_CORNER, ICORAY_F32, ICORAY_F64, ICORAY_MAX_RANK, icoray_ndarray};
use pyo3::prelude::*;
use std::ffi::CString;

/// Names of the grid and layers of an array.
pub(super) struct ArrayNames {
    grid: CString,
    layers: CString,
}

impl ArrayNames {
    pub fn new(grid: &str, layers: &str) -> PyResult<Self> {
        Ok(ArrayNames { grid: c_string(grid, "grid")?, layers: c_string(layers, "layers")? })
    }
}

/// The field of an argument: as given, or one of an array of which no two elements share memory, which C refuses.
pub(super) fn given<'py>(
    values: &Bound<'py, PyAny>,
    location: &str,
    fill: Option<f64>,
    layer_axis: Option<isize>,
) -> PyResult<Bound<'py, Field>> {
    if let Ok(field) = values.cast::<Field>() {
        return Ok(field.clone());
    }
    let field = Field::new(values, location, fill, layer_axis, None, None, false)?;
    Bound::new(values.py(), field.without_shared_elements(values.py())?)
}

/// An array as C describes it, which borrows the names.
pub(super) struct CArray(icoray_ndarray);

// SAFETY: addresses that the field and the names keep alive; the call is made on the thread that has them.
unsafe impl Send for CArray {}

impl CArray {
    pub fn new(field: &Field, names: &ArrayNames) -> Self {
        let (data, r#type) = match field.array.first {
            Pointer::F32(first) => (first.cast(), ICORAY_F32),
            Pointer::F64(first) => (first.cast(), ICORAY_F64),
        };
        let (dimensions, _) = field.ordered_dimensions();
        let (mut extent, mut stride) = ([0; ICORAY_MAX_RANK], [0; ICORAY_MAX_RANK]);
        for (at, dimension) in dimensions.iter().enumerate() {
            extent[at] = dimension.extent as i64;
            stride[at] = dimension.stride as i64;
        }
        CArray(icoray_ndarray {
            struct_size: size_of::<icoray_ndarray>(),
            data,
            r#type,
            location: if field.location == Location::Center { ICORAY_CENTER } else { ICORAY_CORNER },
            rank: dimensions.len() as i32,
            has_fill: field.fill.is_some().into(),
            fill_value: field.fill.unwrap_or(0.0),
            extent,
            stride,
            grid_name: names.grid.as_ptr(),
            layers_name: names.layers.as_ptr(),
        })
    }

    pub fn set_field(&self, context: &icoray_ctx, name: &str) -> Result<(), Failure> {
        // SAFETY: names that live until the call returns, and memory that the context keeps afterwards.
        unsafe { context.set_field_ndarray(name, &self.0) }
    }

    pub fn set_heights(&self, context: &icoray_ctx) -> Result<(), Failure> {
        // SAFETY: as above.
        unsafe { context.set_heights_ndarray(&self.0) }
    }
}
