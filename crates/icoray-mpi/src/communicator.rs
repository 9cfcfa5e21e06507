//! Communicators of this crate, which send and receive messages.

use icoray::ranks::Communicator;
use icoray::{Error, ErrorKind, Result};
use mpi::ffi;
use std::ffi::{c_char, c_int};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::atomic::Ordering::Relaxed;

/// The tag of all messages.
const TAG: c_int = 1;

/// A communicator whose errors are returned. It is freed on drop, unless MPI was finalised or a rank has left before
/// the others. Creation and drop are collective.
#[derive(Debug)]
pub(crate) struct MpiCommunicator {
    handle: ffi::MPI_Comm,
    rank: usize,
    size: usize,
    /// Whether a rank has left: then nothing is freed, as freeing is collective.
    is_given_up: Arc<AtomicBool>,
}

// SAFETY: a handle, which MPI lets any thread hold. Calls with it are made by the thread that makes calls on the host's
// context, one at a time; that MPI may be called there is the host's promise, checked where a team is opened.
unsafe impl Send for MpiCommunicator {}

impl MpiCommunicator {
    /// A duplicate of a communicator.
    pub fn of_duplicate(of: ffi::MPI_Comm, is_given_up: Arc<AtomicBool>) -> Result<Self> {
        // SAFETY: a communicator of the host's or ours; the handle is written.
        Self::new("MPI_Comm_dup", is_given_up, |new| unsafe { ffi::MPI_Comm_dup(of, new) })
    }

    /// The communicator that the MPI function `call` writes to the handle passed to `make`.
    fn new(call: &str, is_given_up: Arc<AtomicBool>, make: impl FnOnce(*mut ffi::MPI_Comm) -> c_int) -> Result<Self> {
        // SAFETY: a handle of MPI's, which is not written to.
        let mut handle = unsafe { ffi::RSMPI_COMM_NULL };
        check(call, make(&mut handle))?;
        let mut comm = MpiCommunicator { handle, rank: 0, size: 1, is_given_up };
        // SAFETY: the communicator is ours, so its errors may be ours too.
        let code = unsafe { ffi::MPI_Comm_set_errhandler(handle, ffi::RSMPI_ERRORS_RETURN) };
        check("MPI_Comm_set_errhandler", code)?;
        [comm.rank, comm.size] = rank_in(handle)?;
        Ok(comm)
    }
}

impl Communicator for MpiCommunicator {
    type Pending = PendingMessage;

    fn rank(&self) -> usize {
        self.rank
    }

    fn size(&self) -> usize {
        self.size
    }

    fn is_gone(&self) -> bool {
        self.is_given_up.load(Relaxed) || is_finalized()
    }

    fn start_send(&self, to: usize, bytes: Vec<u8>) -> Result<PendingMessage> {
        let length = bytes.len();
        let count = c_int::try_from(length)
            .map_err(|_| failed(format!("a message of {length} bytes, expected at most {}", c_int::MAX)))?;
        // SAFETY: a handle that MPI writes, for which zero is a value.
        let mut request = unsafe { std::mem::zeroed() };
        // SAFETY: the bytes are as many as it says, and stay until the request is complete.
        let code = unsafe {
            let (start, byte) = (bytes.as_ptr().cast(), ffi::RSMPI_UINT8_T);
            ffi::MPI_Isend(start, count, byte, to as c_int, TAG, self.handle, &mut request)
        };
        check("MPI_Isend", code)?;
        Ok(PendingMessage { request, bytes })
    }

    fn start_receive(&self) -> Result<Option<(usize, PendingMessage)>> {
        // SAFETY: handles and a status that MPI writes, of types for which zero is a value; the buffer that is received
        // into has the length that the message was found to have, and stays until the request is complete.
        unsafe {
            let mut message = std::mem::zeroed();
            let mut status: ffi::MPI_Status = std::mem::zeroed();
            let (mut flag, mut count, any) = (0, 0, ffi::RSMPI_ANY_SOURCE);
            let code = ffi::MPI_Improbe(any, TAG, self.handle, &mut flag, &mut message, &mut status);
            check("MPI_Improbe", code)?;
            if flag == 0 {
                return Ok(None);
            }
            check("MPI_Get_count", ffi::MPI_Get_count(&status, ffi::RSMPI_UINT8_T, &mut count))?;
            let mut bytes = vec![0u8; usize::try_from(count).unwrap_or(0)];
            let (start, byte) = (bytes.as_mut_ptr().cast(), ffi::RSMPI_UINT8_T);
            let mut request = std::mem::zeroed();
            check("MPI_Imrecv", ffi::MPI_Imrecv(start, count, byte, &mut message, &mut request))?;
            Ok(Some((usize::try_from(status.MPI_SOURCE).unwrap_or(0), PendingMessage { request, bytes })))
        }
    }

    fn start_barrier(&self) -> Result<PendingMessage> {
        // SAFETY: a handle that MPI writes, for which zero is a value.
        let mut request = unsafe { std::mem::zeroed() };
        // SAFETY: the communicator is ours.
        check("MPI_Ibarrier", unsafe { ffi::MPI_Ibarrier(self.handle, &mut request) })?;
        Ok(PendingMessage { request, bytes: Vec::new() })
    }

    fn is_done(&self, pending: &mut PendingMessage) -> Result<bool> {
        let mut flag = 0;
        // SAFETY: the request is one that MPI has started, and is not complete.
        let code = unsafe { ffi::MPI_Test(&mut pending.request, &mut flag, ffi::RSMPI_STATUS_IGNORE) };
        check("MPI_Test", code)?;
        Ok(flag != 0)
    }

    fn bytes_of(&self, complete: PendingMessage) -> Result<Vec<u8>> {
        Ok(complete.bytes)
    }

    fn duplicate(&self) -> Result<Self> {
        MpiCommunicator::of_duplicate(self.handle, self.is_given_up.clone())
    }

    fn give_up(&self) {
        self.is_given_up.store(true, Relaxed);
    }

    fn place_on_host(&self) -> Result<[usize; 3]> {
        let (comm, key) = (self.handle, self.rank as c_int);
        let host = MpiCommunicator::new("MPI_Comm_split_type", self.is_given_up.clone(), |new| {
            // SAFETY: a communicator of ours and a handle that is written.
            unsafe { ffi::MPI_Comm_split_type(comm, ffi::RSMPI_COMM_TYPE_SHARED, key, ffi::RSMPI_INFO_NULL, new) }
        })?;
        let mut leader = self.rank as u64;
        // SAFETY: a number on each rank, there until the call returns.
        let code = unsafe { ffi::MPI_Bcast((&raw mut leader).cast(), 1, ffi::RSMPI_UINT64_T, 0, host.handle) };
        check("MPI_Bcast", code)?;
        Ok([host.rank, host.size, leader as usize])
    }
}

impl Drop for MpiCommunicator {
    fn drop(&mut self) {
        if !self.is_gone() {
            // SAFETY: the communicator is ours, and MPI has not been finalised. A failure cannot be reported any more.
            unsafe { ffi::MPI_Comm_free(&mut self.handle) };
        }
    }
}

/// A request with the bytes that MPI reads or writes until it is complete.
#[derive(Debug)]
pub(crate) struct PendingMessage {
    request: ffi::MPI_Request,
    bytes: Vec<u8>,
}

// SAFETY: as a communicator.
unsafe impl Send for PendingMessage {}

/// Rank and size of this process in a communicator of MPI that runs.
pub(crate) fn rank_in(comm: ffi::MPI_Comm) -> Result<[usize; 2]> {
    let (mut rank, mut size) = (0, 1);
    // SAFETY: a communicator; the numbers are written.
    unsafe {
        check("MPI_Comm_rank", ffi::MPI_Comm_rank(comm, &mut rank))?;
        check("MPI_Comm_size", ffi::MPI_Comm_size(comm, &mut size))?;
    }
    Ok([rank as usize, size as usize])
}

/// Whether the host has finalised MPI, after which no rank can be reached any more.
pub(crate) fn is_finalized() -> bool {
    flag(ffi::MPI_Finalized)
}

/// The result of MPI_Initialized or MPI_Finalized, which may be called at any time.
pub(crate) fn flag(ask: unsafe extern "C" fn(*mut c_int) -> c_int) -> bool {
    let mut flag = 0;
    // SAFETY: one of the two, each of which writes a number.
    unsafe { ask(&mut flag) };
    flag != 0
}

pub(crate) fn failed(message: String) -> Error {
    Error::new(ErrorKind::Mpi, message)
}

/// Converts the error code of an MPI function, with MPI's own description.
pub(crate) fn check(call: &str, code: c_int) -> Result<()> {
    if code == ffi::MPI_SUCCESS as c_int {
        return Ok(());
    }
    let mut text = [0u8; 1024];
    let mut length = 0;
    // SAFETY: longer than MPI_MAX_ERROR_STRING of either MPI; a code that is none of MPI's is an error of this call.
    unsafe { ffi::MPI_Error_string(code, text.as_mut_ptr().cast::<c_char>(), &mut length) };
    let text = String::from_utf8_lossy(&text[..usize::try_from(length).unwrap_or(0).min(text.len())]);
    Err(failed(format!("{call} failed with {code}: {text}")))
}
