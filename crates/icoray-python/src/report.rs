//! Reports as dicts of Python.

use icoray::output::figures::{Figure, Value};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// A dict of names and values.
macro_rules! dict {
    ($py:expr, { $($name:literal: $value:expr),* $(,)? }) => {{
        let dict = pyo3::types::PyDict::new($py);
        $(dict.set_item($name, $value)?;)*
        dict
    }};
}
pub(crate) use dict;

/// Figures by name.
pub(crate) fn of_figures<'py>(
    py: Python<'py>,
    figures: impl Iterator<Item = (&'static Figure, Value)>,
) -> PyResult<Bound<'py, PyDict>> {
    let report = PyDict::new(py);
    for (figure, value) in figures {
        match value {
            Value::None => report.set_item(figure.name, py.None()),
            Value::Flag(flag) => report.set_item(figure.name, flag),
            Value::Integer(number) => report.set_item(figure.name, number),
            Value::Float(number) => report.set_item(figure.name, number),
            Value::Text(text) => report.set_item(figure.name, text),
            Value::Texts(texts) => report.set_item(figure.name, texts),
            Value::ColorMaps(maps) => {
                let maps = maps
                    .iter()
                    .map(|map| Ok(dict!(py, { "field": &map.field, "range": map.range.to_vec(), "how": &map.how })));
                report.set_item(figure.name, maps.collect::<PyResult<Vec<_>>>()?)
            }
        }?;
    }
    Ok(report)
}
