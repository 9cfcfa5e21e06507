//! Messages between ranks in calls that return at once, on a communicator of their own: what threads that may not call MPI
//! have to send is moved on so.

use crate::host::{MpiTeam, check, is_finalized};
use crate::post::Post;
use icoray::Result;
use icoray::ranks::PointToPoint;
use mpi::ffi;
use std::ffi::c_int;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// Messages between the ranks of a team, on a duplicate of its communicator, which is freed when this is dropped. Making and
/// dropping it is collective.
///
/// Where MPI has been finalised before, or the team was given up, dropping leaves it alone.
#[derive(Debug)]
pub(crate) struct Messages {
    comm: ffi::MPI_Comm,
    rank: usize,
    size: usize,
    is_given_up: Arc<AtomicBool>,
    post: Post,
    /// The barrier at which this rank has arrived, until all have.
    barrier: Option<ffi::MPI_Request>,
}

// SAFETY: handles, which MPI lets any thread hold. Calls with them are made by the thread that makes calls on the host's
// context, one at a time, as with the team's.
unsafe impl Send for Messages {}

impl Messages {
    /// Those of a team. Collective.
    pub(crate) fn new(team: &MpiTeam) -> Result<Self> {
        // SAFETY: a handle of MPI's, which is not written to.
        let mut comm = unsafe { ffi::RSMPI_COMM_NULL };
        // SAFETY: the team's communicator; the handle is written.
        check("MPI_Comm_dup", unsafe { ffi::MPI_Comm_dup(team.comm, &mut comm) })?;
        let MpiTeam { rank, size, ref is_given_up, .. } = *team;
        let is_given_up = is_given_up.clone();
        let messages = Messages { comm, rank, size, is_given_up, post: Post::default(), barrier: None };
        // SAFETY: the communicator is ours, so its errors may be ours too.
        let code = unsafe { ffi::MPI_Comm_set_errhandler(comm, ffi::RSMPI_ERRORS_RETURN) };
        check("MPI_Comm_set_errhandler", code)?;
        Ok(messages)
    }
}

impl PointToPoint for Messages {
    fn rank(&self) -> usize {
        self.rank
    }

    fn size(&self) -> usize {
        self.size
    }

    fn is_gone(&self) -> bool {
        self.is_given_up.load(Relaxed) || is_finalized()
    }

    fn send(&mut self, to: usize, bytes: Vec<u8>) -> Result<()> {
        self.post.send(self.comm, to as c_int, bytes)
    }

    fn is_sent(&mut self) -> Result<bool> {
        self.post.is_sent()
    }

    fn try_receive(&mut self) -> Result<Option<(usize, Vec<u8>)>> {
        self.post.try_take(self.comm)
    }

    fn try_meet(&mut self) -> Result<bool> {
        let mut request = match self.barrier.take() {
            Some(request) => request,
            None => {
                // SAFETY: a handle that MPI writes, for which zero is a value.
                let mut request = unsafe { std::mem::zeroed() };
                // SAFETY: the communicator is ours.
                check("MPI_Ibarrier", unsafe { ffi::MPI_Ibarrier(self.comm, &mut request) })?;
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

impl Drop for Messages {
    fn drop(&mut self) {
        if !self.is_gone() {
            // SAFETY: the communicator is ours, and MPI has not been finalised. Nobody is left to tell of a failure.
            unsafe { ffi::MPI_Comm_free(&mut self.comm) };
        }
    }
}
