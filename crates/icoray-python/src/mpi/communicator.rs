//! Communicators of this module.

use super::attached;
use icoray::ranks::Communicator;
use pyo3::prelude::*;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// A communicator whose errors are exceptions. It is freed on drop, unless MPI was finalised or a rank has left before
/// the others. Creation and drop are collective.
#[derive(Debug)]
pub(crate) struct PyCommunicator {
    pub mpi: Py<PyModule>,
    pub handle: Py<PyAny>,
    pub rank: usize,
    pub size: usize,
    /// Whether a rank has left: then nothing is freed, as that is collective.
    pub is_given_up: Arc<AtomicBool>,
}

impl PyCommunicator {
    /// A duplicate of a communicator.
    pub fn of_duplicate(mpi: &Bound<PyModule>, of: &Bound<PyAny>, is_given_up: Arc<AtomicBool>) -> PyResult<Self> {
        Self::new(mpi, of.call_method0("Dup")?, is_given_up)
    }

    /// A communicator that is this module's own.
    pub fn new(mpi: &Bound<PyModule>, handle: Bound<PyAny>, is_given_up: Arc<AtomicBool>) -> PyResult<Self> {
        handle.call_method1("Set_errhandler", (mpi.getattr("ERRORS_RETURN")?,))?;
        let number = |call: &str| handle.call_method0(call)?.extract::<usize>();
        let (rank, size) = (number("Get_rank")?, number("Get_size")?);
        Ok(PyCommunicator { mpi: mpi.clone().unbind(), handle: handle.unbind(), rank, size, is_given_up })
    }
}

impl Drop for PyCommunicator {
    fn drop(&mut self) {
        if !self.is_gone() {
            // A failure cannot be reported any more.
            let _ = attached(|py| self.handle.bind(py).call_method0("Free").map(drop));
        }
    }
}
