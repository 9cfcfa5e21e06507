//! Non-blocking messages between ranks on a communicator of their own, for data of threads that may not call MPI.

use super::attached;
use super::communicator::Communicator;
use super::queue::MessageQueue;
use icoray::Result;
use icoray::ranks::PointToPoint;
use pyo3::prelude::*;

/// Messages between the ranks of a team, on a duplicate of its communicator.
#[derive(Debug)]
pub(super) struct Channel {
    comm: Communicator,
    queue: MessageQueue,
    /// The barrier that this rank has entered, until all have.
    barrier: Option<Py<PyAny>>,
}

impl Channel {
    /// Duplicates the communicator of a team. Collective.
    pub fn new(py: Python, of: &Communicator) -> PyResult<Self> {
        let comm = Communicator::duplicate(of.mpi.bind(py), of.handle.bind(py), of.is_given_up.clone())?;
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
        attached(|py| self.queue.send(py, &self.comm, to, bytes))
    }

    fn is_sent(&mut self) -> Result<bool> {
        attached(|py| self.queue.is_sent(py))
    }

    fn try_receive(&mut self) -> Result<Option<(usize, Vec<u8>)>> {
        attached(|py| self.queue.try_receive(py, &self.comm))
    }

    fn try_meet(&mut self) -> Result<bool> {
        attached(|py| {
            let barrier = match self.barrier.take() {
                Some(barrier) => barrier,
                None => self.comm.handle.bind(py).call_method0("Ibarrier")?.unbind(),
            };
            let have_met = barrier.bind(py).call_method0("Test")?.is_truthy()?;
            self.barrier = (!have_met).then_some(barrier);
            Ok(have_met)
        })
    }
}
