//! Sends and receives messages.

use crate::communicator::{MpiCommunicator, is_finalized};
use crate::error::{check, failed};
use icoray::Result;
use icoray::ranks::Communicator;
use mpi::ffi;
use std::ffi::c_int;
use std::sync::atomic::Ordering::Relaxed;

/// The tag of all messages.
const TAG: c_int = 1;

/// A request with the bytes that MPI reads or writes until it is complete.
#[derive(Debug)]
pub struct PendingMessage {
    request: ffi::MPI_Request,
    bytes: Vec<u8>,
}

// SAFETY: as a communicator.
unsafe impl Send for PendingMessage {}

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

    fn place_on_host(&self) -> Result<[usize; 2]> {
        let (comm, key) = (self.handle, self.rank as c_int);
        let host = MpiCommunicator::new("MPI_Comm_split_type", self.is_given_up.clone(), |new| {
            // SAFETY: a communicator of ours and a handle that is written.
            unsafe { ffi::MPI_Comm_split_type(comm, ffi::RSMPI_COMM_TYPE_SHARED, key, ffi::RSMPI_INFO_NULL, new) }
        })?;
        let mut leader = self.rank as u64;
        // SAFETY: a number on each rank, there until the call returns.
        let code = unsafe { ffi::MPI_Bcast((&raw mut leader).cast(), 1, ffi::RSMPI_UINT64_T, 0, host.handle) };
        check("MPI_Bcast", code)?;
        Ok([host.rank, leader as usize])
    }
}
