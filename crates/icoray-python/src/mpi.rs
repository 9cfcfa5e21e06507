//! Ranks of an MPI communicator by way of mpi4py: the module links no MPI, and runs with the one that mpi4py was built
//! for.
//!
//! Calls are made on the thread that calls the context, with Python's lock, which mpi4py releases while it waits. As in
//! icoray-mpi, the communicator is duplicated, so that messages of the host are not received here.

mod communicator;
mod messages;

use crate::error::of_class;
use communicator::PyCommunicator;
use icoray::ranks::CommunicatorTeam;
use icoray::{Error, ErrorKind};
use pyo3::prelude::*;

/// The team of a communicator of mpi4py, or of Fortran's integer of one. Collective.
pub(crate) fn team(comm: &Bound<PyAny>) -> PyResult<CommunicatorTeam<PyCommunicator>> {
    let py = comm.py();
    let mpi = py.import("mpi4py.MPI").map_err(|error| {
        let message = format!("not supported: comm= needs the package mpi4py, which cannot be imported: {error}");
        of_class("UnsupportedError", message)
    })?;
    refuse_unusable(&mpi)?;
    let class = mpi.getattr("Comm")?;
    let comm = match comm.extract::<i64>() {
        Ok(fortran) => class.call_method1("f2py", (fortran,))?,
        Err(_) => comm.clone(),
    };
    if !comm.is_instance(&class)? {
        let message = format!("comm: {comm}, expected a communicator of mpi4py or Fortran's integer of one");
        return Err(crate::error::argument(message));
    }
    if comm.eq(mpi.getattr("COMM_NULL")?)? {
        return Err(crate::error::argument("comm: COMM_NULL, expected a communicator".into()));
    }
    if comm.call_method0("Is_inter")?.is_truthy()? {
        return Err(bad("the communicator is between two groups; expected one of one group"));
    }
    let comm = PyCommunicator::of_duplicate(&mpi, &comm, Default::default())?;
    CommunicatorTeam::new(comm).map_err(crate::error::raised)
}

/// MPI must be initialised, and callable on this thread.
fn refuse_unusable(mpi: &Bound<PyModule>) -> PyResult<()> {
    let is = |name: &str| mpi.call_method0(name)?.is_truthy();
    if !is("Is_initialized")? {
        return Err(bad("MPI is not initialised; call MPI.Init before"));
    }
    if is("Is_finalized")? {
        return Err(bad("MPI is finalised already"));
    }
    let level: i32 = mpi.call_method0("Query_thread")?.extract()?;
    let serialized: i32 = mpi.getattr("THREAD_SERIALIZED")?.extract()?;
    if level < serialized && !is("Is_thread_main")? {
        return Err(bad("MPI is initialised for one thread, and this is another"));
    }
    Ok(())
}

fn bad(message: &str) -> PyErr {
    of_class("MpiError", format!("MPI: {message}"))
}

/// Does work with Python's lock; its errors are MPI's.
fn attached<R>(work: impl FnOnce(Python) -> PyResult<R>) -> icoray::Result<R> {
    let done = Python::try_attach(|py| work(py).map_err(|error| Error::new(ErrorKind::Mpi, error.to_string())));
    done.unwrap_or_else(|| Err(Error::new(ErrorKind::Mpi, "Python has ended")))
}
