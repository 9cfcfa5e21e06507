//! Messages in flight while ranks render. No call blocks in MPI, which would occupy a processor.

use crate::error::{check, failed};
use icoray::Result;
use mpi::ffi;
use std::collections::VecDeque;
use std::ffi::c_int;
use std::mem::ManuallyDrop;

/// The tag of these messages, which no other operation uses.
const TAG: c_int = 1;

/// Pending sends and receives.
#[derive(Debug, Default)]
pub(crate) struct MessageQueue {
    sending: VecDeque<PendingMessage>,
    /// In the order in which each rank sent them.
    receiving: VecDeque<(usize, PendingMessage)>,
}

/// A request with the bytes that MPI reads or writes until it is complete. If dropped earlier, the bytes are leaked.
#[derive(Debug)]
struct PendingMessage {
    request: ffi::MPI_Request,
    bytes: ManuallyDrop<Vec<u8>>,
}

impl PendingMessage {
    /// Whether the request is complete; then the bytes may be taken.
    fn is_done(&mut self) -> Result<bool> {
        let mut flag = 0;
        // SAFETY: the request is one that MPI has started, or what MPI has put in its place when it was done.
        let code = unsafe { ffi::MPI_Test(&mut self.request, &mut flag, ffi::RSMPI_STATUS_IGNORE) };
        check("MPI_Test", code)?;
        Ok(flag != 0)
    }

    /// The bytes of a complete request.
    fn taken(self) -> Vec<u8> {
        ManuallyDrop::into_inner(self.bytes)
    }
}

impl MessageQueue {
    /// Starts to send a message to rank `to` of a communicator.
    pub(crate) fn send(&mut self, comm: ffi::MPI_Comm, to: c_int, bytes: Vec<u8>) -> Result<()> {
        let (length, bytes) = (bytes.len(), ManuallyDrop::new(bytes));
        let count = c_int::try_from(length)
            .map_err(|_| failed(format!("a message of {length} bytes, expected at most {}", c_int::MAX)))?;
        // SAFETY: a handle that MPI writes, for which zero is a value.
        let mut request = unsafe { std::mem::zeroed() };
        // SAFETY: the bytes are as many as it says, and stay until the request is complete.
        let code = unsafe {
            let (start, byte) = (bytes.as_ptr().cast(), ffi::RSMPI_UINT8_T);
            ffi::MPI_Isend(start, count, byte, to, TAG, comm, &mut request)
        };
        check("MPI_Isend", code)?;
        self.sending.push_back(PendingMessage { request, bytes });
        Ok(())
    }

    /// Frees completed sends; whether none are left. MPI progresses the others in this call.
    pub(crate) fn is_sent(&mut self) -> Result<bool> {
        while let Some(first) = self.sending.front_mut() {
            if !first.is_done()? {
                return Ok(false);
            }
            self.sending.pop_front().map(PendingMessage::taken);
        }
        Ok(true)
    }

    /// The next complete message from a communicator, with the rank that sent it.
    pub(crate) fn try_receive(&mut self, comm: ffi::MPI_Comm) -> Result<Option<(usize, Vec<u8>)>> {
        while let Some(receiving) = next_message(comm)? {
            self.receiving.push_back(receiving);
        }
        let Some((_, first)) = self.receiving.front_mut() else {
            return Ok(None);
        };
        let is_done = first.is_done()?;
        let taken = is_done.then(|| self.receiving.pop_front()).flatten();
        Ok(taken.map(|(rank, first)| (rank, first.taken())))
    }
}

/// Starts to receive the next message from any rank, if there is one.
fn next_message(comm: ffi::MPI_Comm) -> Result<Option<(usize, PendingMessage)>> {
    // SAFETY: handles and a status that MPI writes, of types for which zero is a value; the buffer that is received
    // into has the length that the message was found to have, and stays until the request is complete.
    unsafe {
        let mut message = std::mem::zeroed();
        let mut status: ffi::MPI_Status = std::mem::zeroed();
        let (mut flag, mut count, any) = (0, 0, ffi::RSMPI_ANY_SOURCE);
        let code = ffi::MPI_Improbe(any, TAG, comm, &mut flag, &mut message, &mut status);
        check("MPI_Improbe", code)?;
        if flag == 0 {
            return Ok(None);
        }
        check("MPI_Get_count", ffi::MPI_Get_count(&status, ffi::RSMPI_UINT8_T, &mut count))?;
        let mut bytes = ManuallyDrop::new(vec![0u8; usize::try_from(count).unwrap_or(0)]);
        let (start, byte) = (bytes.as_mut_ptr().cast(), ffi::RSMPI_UINT8_T);
        let mut request = std::mem::zeroed();
        check("MPI_Imrecv", ffi::MPI_Imrecv(start, count, byte, &mut message, &mut request))?;
        Ok(Some((usize::try_from(status.MPI_SOURCE).unwrap_or(0), PendingMessage { request, bytes })))
    }
}
