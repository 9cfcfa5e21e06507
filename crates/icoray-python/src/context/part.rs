//! The part of a rank.

use super::text;
use crate::array::IndexArray;
use crate::error::argument;
use icoray::Indices;
use icoray_context::types::{ICORAY_I32, ICORAY_I64, icoray_part};
use pyo3::prelude::*;
use std::ffi::CString;
use std::ptr;

/// A part of C, with what it borrows.
pub(super) struct Part {
    part: icoray_part,
    _cell_global: IndexArray,
    _is_owned: Option<Vec<i32>>,
    _grid: CString,
}

impl Part {
    pub fn as_c(&self) -> *const icoray_part {
        &raw const self.part
    }
}

/// The part of these arrays.
pub(super) fn of_arrays(
    cell_global: &Bound<PyAny>,
    owned_cells: Option<i64>,
    is_owned: Option<&Bound<PyAny>>,
    grid: &str,
) -> PyResult<Part> {
    let py = cell_global.py();
    let cell_global = IndexArray::new(cell_global, &[0], "cell_global")?;
    let (cells, grid) = (cell_global.shape[0], text(grid, "grid")?);
    let mark = |mark: PyResult<Bound<PyAny>>| PyResult::Ok(i32::from(mark?.is_truthy()?));
    let marks = |marks: &Bound<PyAny>| marks.try_iter()?.map(mark).collect::<PyResult<Vec<i32>>>();
    let is_owned = is_owned.map(marks).transpose()?;
    if let Some(marks) = is_owned.as_ref().filter(|marks| marks.len() != cells) {
        return Err(argument(format!("is_owned: {} marks, expected {cells}", marks.len())));
    }
    // SAFETY: the table lives as long as the part.
    let (index_type, numbers) = match unsafe { cell_global.indices(py) } {
        Indices::I32(numbers) => (ICORAY_I32, numbers.as_ptr().cast()),
        Indices::I64(numbers) => (ICORAY_I64, numbers.as_ptr().cast()),
    };
    let part = icoray_part {
        struct_size: size_of::<icoray_part>(),
        grid: grid.as_ptr(),
        cells: cells as i64,
        index_type,
        cell_global: numbers,
        owned_cells: owned_cells.unwrap_or(cells as i64),
        is_owned: is_owned.as_ref().map_or(ptr::null(), |marks| marks.as_ptr()),
    };
    Ok(Part { part, _cell_global: cell_global, _is_owned: is_owned, _grid: grid })
}
