//! All-to-all exchange of bytes, with all messages in flight at once.

use super::communicator::Communicator;
use super::queue::taken;
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::{PyList, PySlice};
use std::mem::take;

/// The tag of these messages, which no other operation uses.
const TAG: i32 = 2;

/// Hands `mine[j]` to rank `j`, in messages of at most `max_bytes` bytes. Two ranks agree on the lengths first, so both
/// know how many messages there will be, and those between two ranks stay in order.
pub(super) fn exchange(
    py: Python,
    comm: &Communicator,
    mut mine: Vec<Vec<u8>>,
    max_bytes: usize,
) -> PyResult<Vec<Vec<u8>>> {
    assert_eq!(mine.len(), comm.size, "bytes for each rank");
    let handle = comm.handle.bind(py);
    // The own part is neither copied nor sent.
    let own = take(&mut mine[comm.rank]);
    let lengths: Vec<usize> = mine.iter().map(Vec::len).collect();
    let lengths: Vec<usize> = handle.call_method1("alltoall", (lengths,))?.extract()?;
    let theirs: Vec<_> = lengths.iter().map(|length| PyArray1::<u8>::zeros(py, *length, false)).collect();
    let mine: Vec<_> = mine.into_iter().map(|bytes| (bytes.len(), PyArray1::from_vec(py, bytes))).collect();
    let requests = PyList::empty(py);
    for (rank, (bytes, length)) in theirs.iter().zip(&lengths).enumerate() {
        for part in parts(py, *length, max_bytes) {
            requests.append(handle.call_method1("Irecv", (bytes.get_item(part)?, rank, TAG))?)?;
        }
    }
    for (rank, (length, bytes)) in mine.iter().enumerate() {
        for part in parts(py, *length, max_bytes) {
            requests.append(handle.call_method1("Isend", (bytes.get_item(part)?, rank, TAG))?)?;
        }
    }
    comm.mpi.bind(py).getattr("Request")?.call_method1("Waitall", (requests,))?;
    let mut all = theirs.iter().map(taken).collect::<PyResult<Vec<_>>>()?;
    all[comm.rank] = own;
    Ok(all)
}

/// Ranges of at most `max_bytes` bytes.
fn parts(py: Python<'_>, length: usize, max_bytes: usize) -> impl Iterator<Item = Bound<'_, PySlice>> {
    let starts = (0..length).step_by(max_bytes);
    starts.map(move |start| PySlice::new(py, start as isize, length.min(start + max_bytes) as isize, 1))
}
