//! Communicators of this crate.

use crate::error::check;
use icoray::Result;
use icoray::ranks::Communicator;
use mpi::ffi;
use std::ffi::c_int;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// A communicator whose errors are returned. It is freed on drop, unless MPI was finalised or a rank has left before
/// the others. Creation and drop are collective.
#[derive(Debug)]
pub struct MpiCommunicator {
    pub(crate) handle: ffi::MPI_Comm,
    pub(crate) rank: usize,
    pub(crate) size: usize,
    /// Whether a rank has left: then nothing is freed, as freeing is collective.
    pub(crate) is_given_up: Arc<AtomicBool>,
}

// SAFETY: a handle, which MPI lets any thread hold. Calls with it are made by the thread that makes calls on the host's
// context, one at a time; that MPI may be called there is the host's promise, checked where a team is opened.
unsafe impl Send for MpiCommunicator {}

impl MpiCommunicator {
    /// A duplicate of a communicator.
    pub(crate) fn of_duplicate(of: ffi::MPI_Comm, is_given_up: Arc<AtomicBool>) -> Result<Self> {
        // SAFETY: a communicator of the host's or ours; the handle is written.
        Self::new("MPI_Comm_dup", is_given_up, |new| unsafe { ffi::MPI_Comm_dup(of, new) })
    }

    /// The communicator that the MPI function `call` writes to the handle passed to `make`.
    pub(crate) fn new(
        call: &str,
        is_given_up: Arc<AtomicBool>,
        make: impl FnOnce(*mut ffi::MPI_Comm) -> c_int,
    ) -> Result<Self> {
        // SAFETY: a handle of MPI's, which is not written to.
        let mut handle = unsafe { ffi::RSMPI_COMM_NULL };
        check(call, make(&mut handle))?;
        let mut comm = MpiCommunicator { handle, rank: 0, size: 1, is_given_up };
        let (mut rank, mut size) = (0, 1);
        // SAFETY: the communicator is ours, so its errors may be ours too; the numbers are written.
        unsafe {
            check("MPI_Comm_set_errhandler", ffi::MPI_Comm_set_errhandler(handle, ffi::RSMPI_ERRORS_RETURN))?;
            check("MPI_Comm_rank", ffi::MPI_Comm_rank(handle, &mut rank))?;
            check("MPI_Comm_size", ffi::MPI_Comm_size(handle, &mut size))?;
        }
        (comm.rank, comm.size) = (rank as usize, size as usize);
        Ok(comm)
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
