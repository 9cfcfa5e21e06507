//! The collective operations and messages of a team.

use super::attached;
use super::channel::Channel;
use super::communicator::Communicator;
use super::exchange::exchange;
use super::queue::MessageQueue;
use icoray::ranks::PointToPoint;
use icoray::{Result, Team};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::sync::atomic::Ordering::Relaxed;

/// Maximum bytes of one message: MPI counts in 32 bits.
const MAX_MESSAGE: usize = 1 << 30;

/// The ranks of a communicator of mpi4py, which is duplicated on creation and freed on drop. Both are collective.
#[derive(Debug)]
pub(crate) struct PyTeam {
    pub(super) comm: Communicator,
    pub(super) queue: MessageQueue,
}

impl PyTeam {
    /// The ranks of this host. Collective.
    fn host_group(&self, py: Python) -> PyResult<Communicator> {
        let mpi = self.comm.mpi.bind(py);
        let shared = mpi.getattr("COMM_TYPE_SHARED")?;
        let group = self.comm.handle.bind(py).call_method1("Split_type", (shared, self.comm.rank))?;
        Communicator::new(mpi, group, self.comm.is_given_up.clone())
    }
}

impl Team for PyTeam {
    fn rank(&self) -> usize {
        self.comm.rank
    }

    fn size(&self) -> usize {
        self.comm.size
    }

    fn is_gone(&self) -> bool {
        self.comm.is_gone()
    }

    fn give_up(&mut self) {
        self.comm.is_given_up.store(true, Relaxed);
    }

    fn share(&mut self, mine: &[u8]) -> Result<Vec<Vec<u8>>> {
        attached(|py| self.comm.handle.bind(py).call_method1("allgather", (PyBytes::new(py, mine),))?.extract())
    }

    fn broadcast(&mut self, mine: Vec<u8>) -> Result<Vec<u8>> {
        attached(|py| self.comm.handle.bind(py).call_method1("bcast", (PyBytes::new(py, &mine), 0))?.extract())
    }

    fn send(&mut self, bytes: Vec<u8>) -> Result<()> {
        attached(|py| self.queue.send(py, &self.comm, 0, bytes))
    }

    fn is_sent(&mut self) -> Result<bool> {
        attached(|py| self.queue.is_sent(py))
    }

    fn try_receive(&mut self) -> Result<Option<(usize, Vec<u8>)>> {
        attached(|py| self.queue.try_receive(py, &self.comm))
    }

    fn exchange(&mut self, mine: Vec<Vec<u8>>) -> Result<Vec<Vec<u8>>> {
        attached(|py| exchange(py, &self.comm, mine, MAX_MESSAGE))
    }

    fn point_to_point(&mut self) -> Result<Box<dyn PointToPoint>> {
        Ok(Box::new(attached(|py| Channel::new(py, &self.comm))?))
    }

    fn node_rank(&mut self) -> Result<usize> {
        attached(|py| Ok(self.host_group(py)?.rank))
    }

    fn node_leader(&mut self) -> Result<usize> {
        attached(|py| {
            let group = self.host_group(py)?;
            group.handle.bind(py).call_method1("bcast", (self.comm.rank, 0))?.extract()
        })
    }
}
