//! The collective operations and messages of a team.

use super::attached;
use super::communicator::Communicator;
use super::exchange::exchange;
use icoray::ranks::{MessageQueue, PointToPoint};
use icoray::{Result, Team};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::sync::atomic::Ordering::Relaxed;

/// Maximum bytes of one message: MPI counts in 32 bits.
const MAX_MESSAGE: usize = 1 << 30;

/// The ranks of a communicator of mpi4py, which is duplicated on creation and freed on drop. Both are collective.
#[derive(Debug)]
pub(crate) struct PyTeam {
    pub(super) queue: MessageQueue<Communicator>,
}

impl PyTeam {
    fn comm(&self) -> &Communicator {
        self.queue.comm()
    }

    /// The ranks of this host. Collective.
    fn host_group(&self, py: Python) -> PyResult<Communicator> {
        let mpi = self.comm().mpi.bind(py);
        let shared = mpi.getattr("COMM_TYPE_SHARED")?;
        let group = self.comm().handle.bind(py).call_method1("Split_type", (shared, self.comm().rank))?;
        Communicator::new(mpi, group, self.comm().is_given_up.clone())
    }
}

impl Team for PyTeam {
    fn rank(&self) -> usize {
        self.comm().rank
    }

    fn size(&self) -> usize {
        self.comm().size
    }

    fn is_gone(&self) -> bool {
        self.comm().is_gone()
    }

    fn give_up(&mut self) {
        self.comm().is_given_up.store(true, Relaxed);
    }

    fn share(&mut self, mine: &[u8]) -> Result<Vec<Vec<u8>>> {
        attached(|py| self.comm().handle.bind(py).call_method1("allgather", (PyBytes::new(py, mine),))?.extract())
    }

    fn broadcast(&mut self, mine: Vec<u8>) -> Result<Vec<u8>> {
        attached(|py| self.comm().handle.bind(py).call_method1("bcast", (PyBytes::new(py, &mine), 0))?.extract())
    }

    fn send(&mut self, bytes: Vec<u8>) -> Result<()> {
        self.queue.send(0, bytes)
    }

    fn is_sent(&mut self) -> Result<bool> {
        self.queue.is_sent()
    }

    fn try_receive(&mut self) -> Result<Option<(usize, Vec<u8>)>> {
        self.queue.try_receive()
    }

    fn exchange(&mut self, mine: Vec<Vec<u8>>) -> Result<Vec<Vec<u8>>> {
        attached(|py| exchange(py, self.comm(), mine, MAX_MESSAGE))
    }

    fn point_to_point(&mut self) -> Result<Box<dyn PointToPoint>> {
        let comm = self.comm();
        let copy =
            attached(|py| Communicator::duplicate(comm.mpi.bind(py), comm.handle.bind(py), comm.is_given_up.clone()))?;
        Ok(Box::new(MessageQueue::new(copy)))
    }

    fn node_rank(&mut self) -> Result<usize> {
        attached(|py| Ok(self.host_group(py)?.rank))
    }

    fn node_leader(&mut self) -> Result<usize> {
        attached(|py| {
            let group = self.host_group(py)?;
            group.handle.bind(py).call_method1("bcast", (self.comm().rank, 0))?.extract()
        })
    }
}
