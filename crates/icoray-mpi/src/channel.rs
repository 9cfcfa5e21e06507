//! Non-blocking messages between ranks on a communicator of their own, for data of threads that may not call MPI.

use crate::communicator::Communicator;
use crate::error::check;
use crate::host::MpiTeam;
use crate::queue::MessageQueue;
use icoray::Result;
use icoray::ranks::PointToPoint;
use mpi::ffi;
use std::ffi::c_int;

/// Messages between the ranks of a team, on a duplicate of its communicator.
#[derive(Debug)]
pub(crate) struct Channel {
    comm: Communicator,
    queue: MessageQueue,
    /// The barrier that this rank has entered, until all have.
    barrier: Option<ffi::MPI_Request>,
}

// SAFETY: handles, which MPI lets any thread hold. Calls with them are made by the thread that makes calls on the
// host's context, one at a time, as with the team's.
unsafe impl Send for Channel {}

impl Channel {
    /// Duplicates the communicator of a team. Collective.
    pub(crate) fn new(team: &MpiTeam) -> Result<Self> {
        let comm = Communicator::duplicate(team.comm.handle, team.comm.is_given_up.clone())?;
        Ok(Channel { comm, queue: MessageQueue::default(), barrier: None })
    }
}

impl PointToPoint for Channel {
    fn rank(&self) -> usize {
        self.comm.rank
    }

    fn size(&self) -> usize {
        self.comm.size
    }

    fn is_gone(&self) -> bool {
        self.comm.is_gone()
    }

    fn send(&mut self, to: usize, bytes: Vec<u8>) -> Result<()> {
        self.queue.send(self.comm.handle, to as c_int, bytes)
    }

    fn is_sent(&mut self) -> Result<bool> {
        self.queue.is_sent()
    }

    fn try_receive(&mut self) -> Result<Option<(usize, Vec<u8>)>> {
        self.queue.try_receive(self.comm.handle)
    }

    fn try_meet(&mut self) -> Result<bool> {
        let mut request = match self.barrier.take() {
            Some(request) => request,
            None => {
                // SAFETY: a handle that MPI writes, for which zero is a value.
                let mut request = unsafe { std::mem::zeroed() };
                // SAFETY: the communicator is ours.
                check("MPI_Ibarrier", unsafe { ffi::MPI_Ibarrier(self.comm.handle, &mut request) })?;
                request
            }
        };
        let mut flag = 0;
        // SAFETY: the request is the barrier's, which is not complete.
        let code = unsafe { ffi::MPI_Test(&mut request, &mut flag, ffi::RSMPI_STATUS_IGNORE) };
        check("MPI_Test", code)?;
        self.barrier = (flag == 0).then_some(request);
        Ok(flag != 0)
    }
}
