//! Dates of Python.

use pyo3::prelude::*;
use pyo3::types::PyDict;

/// A date as the library reads it.
pub(super) fn text_of(date: &Bound<PyAny>) -> PyResult<String> {
    if date.hasattr("isoformat")? {
        let how = PyDict::new(date.py());
        how.set_item("timespec", "seconds")?;
        return date.call_method("isoformat", (), Some(&how))?.extract();
    }
    // Fractions of seconds of numpy's dates are not in names.
    let text = date.str()?.to_string();
    Ok(text.split('.').next().unwrap_or_default().to_owned())
}
