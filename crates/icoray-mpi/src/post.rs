//! Messages under way while ranks draw: nobody waits in a call of MPI's, which would take a processor from those that draw.

use crate::host::{check, failed};
use icoray::Result;
use mpi::ffi;
use std::collections::VecDeque;
use std::ffi::c_int;
use std::mem::ManuallyDrop;

/// The tag of these messages, which no other call takes for its own.
const TAG: c_int = 1;

/// Messages that are on their way.
#[derive(Debug, Default)]
pub(crate) struct Post {
    sending: VecDeque<UnderWay>,
    /// In the order in which they were sent, as far as one rank's go.
    coming: VecDeque<(usize, UnderWay)>,
}

/// Bytes that MPI reads or writes until its request is complete. Dropped before that, they stay where they are for good.
#[derive(Debug)]
struct UnderWay {
    request: ffi::MPI_Request,
    bytes: ManuallyDrop<Vec<u8>>,
}

impl UnderWay {
    /// Whether it is done, after which the bytes may be taken.
    fn is_done(&mut self) -> Result<bool> {
        let mut flag = 0;
        // SAFETY: the request is one that MPI has started, or what MPI has put in its place when it was done.
        let code = unsafe { ffi::MPI_Test(&mut self.request, &mut flag, ffi::RSMPI_STATUS_IGNORE) };
        check("MPI_Test", code)?;
        Ok(flag != 0)
    }

    /// The bytes of one that is done.
    fn taken(self) -> Vec<u8> {
        ManuallyDrop::into_inner(self.bytes)
    }
}

impl Post {
    /// Begins to send a message to rank `to` of a communicator.
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
        self.sending.push_back(UnderWay { request, bytes });
        Ok(())
    }

    /// Lets go of what has been sent; whether that is all. In calls of this, MPI moves the rest on.
    pub(crate) fn is_sent(&mut self) -> Result<bool> {
        while let Some(first) = self.sending.front_mut() {
            if !first.is_done()? {
                return Ok(false);
            }
            self.sending.pop_front().map(UnderWay::taken);
        }
        Ok(true)
    }

    /// The first of the messages that are coming over a communicator, if all of it is there, and the rank that sent it.
    pub(crate) fn try_take(&mut self, comm: ffi::MPI_Comm) -> Result<Option<(usize, Vec<u8>)>> {
        while let Some(coming) = next_message(comm)? {
            self.coming.push_back(coming);
        }
        let Some((_, first)) = self.coming.front_mut() else {
            return Ok(None);
        };
        let is_there = first.is_done()?;
        let taken = is_there.then(|| self.coming.pop_front()).flatten();
        Ok(taken.map(|(rank, first)| (rank, first.taken())))
    }
}

/// Begins to receive a message, of whichever rank, if there is one.
fn next_message(comm: ffi::MPI_Comm) -> Result<Option<(usize, UnderWay)>> {
    // SAFETY: handles and a status that MPI writes, of types for which zero is a value; the buffer that is received into has
    // the length that the message was found to have, and stays until the request is complete.
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
        Ok(Some((usize::try_from(status.MPI_SOURCE).unwrap_or(0), UnderWay { request, bytes })))
    }
}
