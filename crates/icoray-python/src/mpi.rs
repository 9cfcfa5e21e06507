//! Ranks of an MPI communicator by way of mpi4py: the module links no MPI, and runs with the one that mpi4py was built
//! for.
//!
//! Calls are made on the thread that calls the context, with Python's lock, which mpi4py releases while it waits. As in
//! icoray-mpi, the communicator is duplicated, so that messages of the host are not received here.

use crate::error::of_class;
use icoray::ranks::Communicator;
use icoray::{Error, ErrorKind, Result, Team};
use numpy::{PyArray1, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::atomic::Ordering::Relaxed;

/// The tag of all messages.
const TAG: i32 = 1;

/// The team of a communicator of mpi4py, or of Fortran's integer of one. Collective.
pub(crate) fn team(comm: &Bound<PyAny>) -> PyResult<Team> {
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
    Team::over(comm).map_err(crate::error::raised)
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
fn attached<R>(work: impl FnOnce(Python) -> PyResult<R>) -> Result<R> {
    let done = Python::try_attach(|py| work(py).map_err(|error| Error::new(ErrorKind::Mpi, error.to_string())));
    done.unwrap_or_else(|| Err(Error::new(ErrorKind::Mpi, "Python has ended")))
}

/// A communicator whose errors are exceptions. It is freed on drop, unless MPI was finalised or a rank has left before
/// the others. Creation and drop are collective.
#[derive(Debug)]
struct PyCommunicator {
    mpi: Py<PyModule>,
    handle: Py<PyAny>,
    rank: usize,
    size: usize,
    /// Whether a rank has left: then nothing is freed, as that is collective.
    is_given_up: Arc<AtomicBool>,
}

impl PyCommunicator {
    /// A duplicate of a communicator.
    fn of_duplicate(mpi: &Bound<PyModule>, of: &Bound<PyAny>, is_given_up: Arc<AtomicBool>) -> PyResult<Self> {
        Self::new(mpi, of.call_method0("Dup")?, is_given_up)
    }

    /// A communicator that is this module's own.
    fn new(mpi: &Bound<PyModule>, handle: Bound<PyAny>, is_given_up: Arc<AtomicBool>) -> PyResult<Self> {
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

/// A request of mpi4py with the bytes that MPI reads or writes until it is complete.
#[derive(Debug)]
struct PendingMessage {
    request: Py<PyAny>,
    bytes: Py<PyArray1<u8>>,
}

impl PendingMessage {
    fn new(request: Bound<PyAny>, bytes: Bound<PyArray1<u8>>) -> Self {
        PendingMessage { request: request.unbind(), bytes: bytes.unbind() }
    }
}

impl Communicator for PyCommunicator {
    type Pending = PendingMessage;

    fn rank(&self) -> usize {
        self.rank
    }

    fn size(&self) -> usize {
        self.size
    }

    fn is_gone(&self) -> bool {
        self.is_given_up.load(Relaxed)
            || attached(|py| self.mpi.bind(py).call_method0("Is_finalized")?.is_truthy()).unwrap_or(true)
    }

    fn start_send(&self, to: usize, bytes: Vec<u8>) -> Result<PendingMessage> {
        attached(|py| {
            let bytes = PyArray1::from_vec(py, bytes);
            Ok(PendingMessage::new(self.handle.bind(py).call_method1("Isend", (&bytes, to, TAG))?, bytes))
        })
    }

    fn start_receive(&self) -> Result<Option<(usize, PendingMessage)>> {
        attached(|py| {
            let mpi = self.mpi.bind(py);
            let status = mpi.getattr("Status")?.call0()?;
            let arguments = (mpi.getattr("ANY_SOURCE")?, TAG, &status);
            let message = self.handle.bind(py).call_method1("Improbe", arguments)?;
            if message.is_none() {
                return Ok(None);
            }
            let count: usize = status.call_method0("Get_count")?.extract()?;
            let rank: usize = status.call_method0("Get_source")?.extract()?;
            let bytes = PyArray1::<u8>::zeros(py, count, false);
            Ok(Some((rank, PendingMessage::new(message.call_method1("Irecv", (&bytes,))?, bytes))))
        })
    }

    fn start_barrier(&self) -> Result<PendingMessage> {
        attached(|py| {
            let request = self.handle.bind(py).call_method0("Ibarrier")?;
            Ok(PendingMessage::new(request, PyArray1::zeros(py, 0, false)))
        })
    }

    fn is_done(&self, pending: &mut PendingMessage) -> Result<bool> {
        attached(|py| pending.request.bind(py).call_method0("Test")?.is_truthy())
    }

    fn bytes_of(&self, complete: PendingMessage) -> Result<Vec<u8>> {
        attached(|py| {
            let bytes = complete.bytes.bind(py);
            // An array without elements has no address.
            if bytes.len() == 0 { Ok(Vec::new()) } else { Ok(bytes.to_vec()?) }
        })
    }

    fn duplicate(&self) -> Result<Self> {
        attached(|py| PyCommunicator::of_duplicate(self.mpi.bind(py), self.handle.bind(py), self.is_given_up.clone()))
    }

    fn give_up(&self) {
        self.is_given_up.store(true, Relaxed);
    }

    fn place_on_host(&self) -> Result<[usize; 3]> {
        attached(|py| {
            let mpi = self.mpi.bind(py);
            let shared = mpi.getattr("COMM_TYPE_SHARED")?;
            let group = self.handle.bind(py).call_method1("Split_type", (shared, self.rank))?;
            let host = PyCommunicator::new(mpi, group, self.is_given_up.clone())?;
            let leader = host.handle.bind(py).call_method1("bcast", (self.rank, 0))?.extract()?;
            Ok([host.rank, host.size, leader])
        })
    }
}
