//! Messages in flight while ranks render. No call waits in MPI, which would occupy a processor.

use super::communicator::Communicator;
use numpy::{PyArray1, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;
use std::collections::VecDeque;
use std::mem::{forget, take};

/// The tag of these messages, which no other operation uses.
const TAG: i32 = 1;

/// Pending sends and receives.
#[derive(Debug, Default)]
pub(super) struct MessageQueue {
    sending: VecDeque<PendingMessage>,
    /// In the order in which each rank sent them.
    receiving: VecDeque<(usize, PendingMessage)>,
}

/// A request of mpi4py with the bytes that MPI reads or writes until it is complete.
#[derive(Debug)]
pub(super) struct PendingMessage {
    pub request: Py<PyAny>,
    pub bytes: Py<PyArray1<u8>>,
}

impl PendingMessage {
    /// Whether the request is complete.
    fn is_done(&self, py: Python) -> PyResult<bool> {
        self.request.bind(py).call_method0("Test")?.is_truthy()
    }
}

/// The bytes of an array of a complete request.
pub(super) fn taken(bytes: &Bound<PyArray1<u8>>) -> PyResult<Vec<u8>> {
    // An array without elements has no address.
    if bytes.len() == 0 { Ok(Vec::new()) } else { Ok(bytes.to_vec()?) }
}

impl MessageQueue {
    /// Starts to send a message to rank `to`.
    pub fn send(&mut self, py: Python, comm: &Communicator, to: usize, bytes: Vec<u8>) -> PyResult<()> {
        let bytes = PyArray1::from_vec(py, bytes);
        let request = comm.handle.bind(py).call_method1("Isend", (&bytes, to, TAG))?.unbind();
        self.sending.push_back(PendingMessage { request, bytes: bytes.unbind() });
        Ok(())
    }

    /// Frees completed sends; whether none are left. MPI progresses the others in this call.
    pub fn is_sent(&mut self, py: Python) -> PyResult<bool> {
        while let Some(first) = self.sending.front() {
            if !first.is_done(py)? {
                return Ok(false);
            }
            self.sending.pop_front();
        }
        Ok(true)
    }

    /// The next complete message, with the rank that sent it.
    pub fn try_receive(&mut self, py: Python, comm: &Communicator) -> PyResult<Option<(usize, Vec<u8>)>> {
        while let Some(receiving) = next_message(py, comm)? {
            self.receiving.push_back(receiving);
        }
        let Some((rank, first)) = self.receiving.front() else { return Ok(None) };
        if !first.is_done(py)? {
            return Ok(None);
        }
        let (rank, bytes) = (*rank, taken(first.bytes.bind(py))?);
        self.receiving.pop_front();
        Ok(Some((rank, bytes)))
    }
}

impl Drop for MessageQueue {
    /// MPI may still read or write what is not complete.
    fn drop(&mut self) {
        forget((take(&mut self.sending), take(&mut self.receiving)));
    }
}

/// Starts to receive the next message from any rank, if there is one.
fn next_message(py: Python, comm: &Communicator) -> PyResult<Option<(usize, PendingMessage)>> {
    let mpi = comm.mpi.bind(py);
    let status = mpi.getattr("Status")?.call0()?;
    let arguments = (mpi.getattr("ANY_SOURCE")?, TAG, &status);
    let message = comm.handle.bind(py).call_method1("Improbe", arguments)?;
    if message.is_none() {
        return Ok(None);
    }
    let count: usize = status.call_method0("Get_count")?.extract()?;
    let rank: usize = status.call_method0("Get_source")?.extract()?;
    let bytes = PyArray1::<u8>::zeros(py, count, false);
    let request = message.call_method1("Irecv", (&bytes,))?.unbind();
    Ok(Some((rank, PendingMessage { request, bytes: bytes.unbind() })))
}
