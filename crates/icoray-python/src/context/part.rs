//! The part of a rank.

use super::text;
use crate::array::IndexArray;
use crate::error::argument;
use icoray::Indices;
use icoray_context::types::{ICORAY_I32, ICORAY_I64, icoray_part};
use pyo3::prelude::*;
use std::ffi::{CString, c_void};
use std::ptr;

/// A part of C, with what it borrows.
pub(super) struct Part {
    part: icoray_part,
    _cells: Rows,
    _corners: Option<Rows>,
    _grid: CString,
}

impl Part {
    pub fn as_c(&self) -> *const icoray_part {
        &raw const self.part
    }
}

/// Cells or corners of a rank, as a call gives them.
pub(super) struct GivenRows<'a, 'py> {
    /// `cell` or `corner`, for messages.
    pub of: &'static str,
    pub global: &'a Bound<'py, PyAny>,
    pub owned: Option<i64>,
    pub is_owned: Option<&'a Bound<'py, PyAny>>,
}

/// Numbers of rows of the whole grid, and which are own.
struct Rows {
    global: IndexArray,
    owned: i64,
    is_owned: Option<Vec<i32>>,
}

impl Rows {
    /// The rows; their numbers have 64 bits where `is_wide` asks for it.
    fn new(given: &GivenRows, is_wide: bool) -> PyResult<Self> {
        let GivenRows { of, global, owned, is_owned } = given;
        let name = format!("{of}_global");
        let mut global = IndexArray::new(global, &[0], &name)?;
        if is_wide && !global.is_wide {
            let py = given.global.py();
            global = IndexArray::new(&global.owner(py).call_method1("astype", ("int64",))?, &[0], &name)?;
        }
        let count = global.shape[0];
        let mark = |mark: PyResult<Bound<PyAny>>| PyResult::Ok(i32::from(mark?.is_truthy()?));
        let marks = |marks: &&Bound<PyAny>| marks.try_iter()?.map(mark).collect::<PyResult<Vec<i32>>>();
        let is_owned = is_owned.as_ref().map(marks).transpose()?;
        if let Some(marks) = is_owned.as_ref().filter(|marks| marks.len() != count) {
            let name = if *of == "cell" { "is_owned" } else { "is_corner_owned" };
            return Err(argument(format!("{name}: {} marks, expected {count}", marks.len())));
        }
        Ok(Rows { global, owned: owned.unwrap_or(count as i64), is_owned })
    }

    fn count(&self) -> i64 {
        self.global.shape[0] as i64
    }

    fn numbers(&self, py: Python) -> *const c_void {
        // SAFETY: the table lives as long as the part.
        match unsafe { self.global.indices(py) } {
            Indices::I32(numbers) => numbers.as_ptr().cast(),
            Indices::I64(numbers) => numbers.as_ptr().cast(),
        }
    }

    fn marks(&self) -> *const i32 {
        self.is_owned.as_ref().map_or(ptr::null(), |marks| marks.as_ptr())
    }
}

/// The part of these cells and, with the whole grid's tables, corners.
pub(super) fn of_rows(py: Python, cells: &GivenRows, corners: Option<&GivenRows>, grid: &str) -> PyResult<Part> {
    let grid = text(grid, "grid")?;
    let mut cells_read = Rows::new(cells, false)?;
    let corners = corners.map(|corners| Rows::new(corners, cells_read.global.is_wide)).transpose()?;
    if corners.as_ref().is_some_and(|corners| corners.global.is_wide) {
        cells_read = Rows::new(cells, true)?;
    }
    let part = icoray_part {
        struct_size: size_of::<icoray_part>(),
        grid: grid.as_ptr(),
        cells: cells_read.count(),
        index_type: if cells_read.global.is_wide { ICORAY_I64 } else { ICORAY_I32 },
        cell_global: cells_read.numbers(py),
        owned_cells: cells_read.owned,
        is_owned: cells_read.marks(),
        corners: corners.as_ref().map_or(0, Rows::count),
        corner_global: corners.as_ref().map_or(ptr::null(), |corners| corners.numbers(py)),
        owned_corners: corners.as_ref().map_or(0, |corners| corners.owned),
        is_corner_owned: corners.as_ref().map_or(ptr::null(), Rows::marks),
    };
    Ok(Part { part, _cells: cells_read, _corners: corners, _grid: grid })
}
