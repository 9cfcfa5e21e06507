//! Communicators of this module.

use super::attached;
use pyo3::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// A communicator whose errors are exceptions. It is freed on drop, unless MPI was finalised or a rank has left before
/// the others. Creation and drop are collective.
#[derive(Debug)]
pub(super) struct Communicator {
    pub mpi: Py<PyModule>,
    pub handle: Py<PyAny>,
    pub rank: usize,
    pub size: usize,
    /// Whether a rank has left: then nothing is freed, as that is collective.
    pub is_given_up: Arc<AtomicBool>,
}

impl Communicator {
    /// A duplicate of a communicator.
    pub fn duplicate(mpi: &Bound<PyModule>, of: &Bound<PyAny>, is_given_up: Arc<AtomicBool>) -> PyResult<Self> {
        Self::new(mpi, of.call_method0("Dup")?, is_given_up)
    }

    /// A communicator that is this module's own.
    pub fn new(mpi: &Bound<PyModule>, handle: Bound<PyAny>, is_given_up: Arc<AtomicBool>) -> PyResult<Self> {
        handle.call_method1("Set_errhandler", (mpi.getattr("ERRORS_RETURN")?,))?;
        let number = |call: &str| handle.call_method0(call)?.extract::<usize>();
        let (rank, size) = (number("Get_rank")?, number("Get_size")?);
        Ok(Communicator { mpi: mpi.clone().unbind(), handle: handle.unbind(), rank, size, is_given_up })
    }

    /// Whether MPI was finalised or a rank has left: then no collective operation is possible.
    pub fn is_gone(&self) -> bool {
        self.is_given_up.load(Relaxed)
            || attached(|py| self.mpi.bind(py).call_method0("Is_finalized")?.is_truthy()).unwrap_or(true)
    }
}

impl Drop for Communicator {
    fn drop(&mut self) {
        if !self.is_gone() {
            // A failure cannot be reported any more.
            let _ = attached(|py| self.handle.bind(py).call_method0("Free").map(drop));
        }
    }
}
