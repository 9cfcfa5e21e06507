//! The calls by which messages are sent and received.

use super::attached;
use super::communicator::PyCommunicator;
use icoray::Result;
use icoray::ranks::Communicator;
use numpy::{PyArray1, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;
use std::sync::atomic::Ordering::Relaxed;

/// The tag of all messages.
const TAG: i32 = 1;

/// A request of mpi4py with the bytes that MPI reads or writes until it is complete.
#[derive(Debug)]
pub(crate) struct PendingMessage {
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

    fn place_on_host(&self) -> Result<[usize; 2]> {
        attached(|py| {
            let mpi = self.mpi.bind(py);
            let shared = mpi.getattr("COMM_TYPE_SHARED")?;
            let group = self.handle.bind(py).call_method1("Split_type", (shared, self.rank))?;
            let host = PyCommunicator::new(mpi, group, self.is_given_up.clone())?;
            Ok([host.rank, host.handle.bind(py).call_method1("bcast", (self.rank, 0))?.extract()?])
        })
    }
}
