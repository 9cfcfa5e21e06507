//! Dates of Python.

use crate::report::dict;
use pyo3::prelude::*;

/// A date as the library reads it.
pub(super) fn text_of(date: &Bound<PyAny>) -> PyResult<String> {
    if date.hasattr("isoformat")? {
        if !date.hasattr("hour")? {
            return Ok(at_midnight(date.call_method0("isoformat")?.extract()?));
        }
        let how = dict!(date.py(), { "timespec": "seconds" });
        return date.call_method("isoformat", (), Some(&how))?.extract();
    }
    // Fractions of seconds of numpy's dates are not in names.
    let text = date.str()?.to_string();
    let text = text.split('.').next().unwrap_or_default().to_owned();
    let is_of_numpy = date.hasattr("dtype")?;
    Ok(if is_of_numpy && !text.contains('T') { at_midnight(text) } else { text })
}

/// A date without a time, as `datetime.date` and `numpy.datetime64("2026-01-01")` are.
fn at_midnight(date: String) -> String {
    format!("{date}T00:00:00")
}
