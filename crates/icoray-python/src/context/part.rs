//! The part of a rank.

use crate::array::IndexArray;
use crate::error::argument;
use icoray::{Indices, Owned};
use pyo3::prelude::*;

/// Cells or corners of a rank: numbers of rows of the whole grid, and which are own.
pub(super) struct Rows {
    global: IndexArray,
    owned: usize,
    is_owned: Option<Vec<i32>>,
}

impl Rows {
    /// The rows of the arguments of a call; `names` are those of the first three.
    pub fn new(
        global: &Bound<PyAny>,
        owned: Option<i64>,
        is_owned: Option<&Bound<PyAny>>,
        names: [&str; 3],
    ) -> PyResult<Self> {
        let [global_name, owned_name, marks_name] = names;
        let global = IndexArray::new(global, &[0], global_name)?;
        let count = global.shape[0];
        let owned = owned.map_or(Ok(count), |owned| {
            usize::try_from(owned).map_err(|_| argument(format!("{owned_name}: {owned}, expected 0 or more")))
        })?;
        let mark = |mark: PyResult<Bound<PyAny>>| PyResult::Ok(i32::from(mark?.is_truthy()?));
        let marks = |marks: &Bound<PyAny>| marks.try_iter()?.map(mark).collect::<PyResult<Vec<i32>>>();
        let is_owned = is_owned.map(marks).transpose()?;
        if let Some(marks) = is_owned.as_ref().filter(|marks| marks.len() != count) {
            return Err(argument(format!("{marks_name}: {} marks, expected {count}", marks.len())));
        }
        Ok(Rows { global, owned, is_owned })
    }

    /// The numbers and the own rows.
    ///
    /// # Safety
    /// As [`IndexArray::indices`].
    pub unsafe fn borrowed(&self, py: Python) -> (Indices<'static>, Owned<'_>) {
        // SAFETY: passed on.
        let global = unsafe { self.global.indices(py) };
        (global, self.is_owned.as_deref().map_or(Owned::First(self.owned), Owned::Marked))
    }
}
