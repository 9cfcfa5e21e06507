//! Python's classes of errors, which `_errors.py` defines.

use icoray::{Error, ErrorKind, printable};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyType;

/// The class of a kind of error.
pub(crate) fn class(kind: ErrorKind) -> &'static str {
    match kind {
        ErrorKind::Argument => "ArgumentError",
        ErrorKind::Grid => "GridError",
        ErrorKind::Unsupported => "UnsupportedError",
        ErrorKind::Layers => "LayersError",
        ErrorKind::Field => "FieldError",
        ErrorKind::Scene => "SceneError",
        ErrorKind::Order => "OrderError",
        ErrorKind::Io => "FileError",
        ErrorKind::Exists => "ExistsError",
        ErrorKind::Mpi => "MpiError",
        ErrorKind::Memory => "OutOfMemoryError",
        _ => "InternalError",
    }
}

/// An error of the class `name` with a message, whose control characters are escaped.
pub(crate) fn of_class(name: &str, message: String) -> PyErr {
    let message = printable(&message).into_owned();
    static MODULE: PyOnceLock<Py<PyModule>> = PyOnceLock::new();
    Python::attach(|py| {
        let module = MODULE.get_or_try_init(py, || py.import("icoray._errors").map(Bound::unbind));
        let class = module.and_then(|module| Ok(module.bind(py).getattr(name)?.cast_into::<PyType>()?));
        class.map_or_else(|error| error, |class| PyErr::from_type(class, message))
    })
}

/// The Python error of one of the library's.
pub(crate) fn raised(error: Error) -> PyErr {
    of_class(class(error.kind()), error.to_string())
}

/// An argument that is out of range.
pub(crate) fn argument(message: String) -> PyErr {
    raised(Error::new(ErrorKind::Argument, message))
}

/// Values that are no field.
pub(crate) fn bad_field(message: String) -> PyErr {
    raised(Error::new(ErrorKind::Field, message))
}
