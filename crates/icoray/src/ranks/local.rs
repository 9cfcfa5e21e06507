//! Ranks that are threads of one process: for tests, and to study what ranks would do where there is no MPI.

use super::{NodeMemory, NodeShare, Team};
use crate::error::{Error, ErrorKind, Result};
use crossbeam_channel::{Receiver, Sender, unbounded};
use std::sync::{Arc, Barrier, Mutex, PoisonError};

/// One rank of a [`local_team`].
#[derive(Debug)]
pub struct LocalTeam {
    rank: usize,
    /// To each rank, oneself included.
    to: Vec<Sender<(usize, Vec<u8>)>>,
    from: Receiver<(usize, Vec<u8>)>,
    /// What came before its turn: ranks run ahead of each other.
    early: Vec<(usize, Vec<u8>)>,
    node: Arc<LocalNode>,
    /// Among those of its node.
    node_rank: usize,
}

/// What threads of a node share.
#[derive(Debug)]
struct LocalNode {
    leader: usize,
    written: Mutex<Vec<u8>>,
    meet: Barrier,
}

/// `size` ranks, each to be moved to a thread of its own.
pub fn local_team(size: usize) -> Vec<LocalTeam> {
    local_nodes(&vec![0; size])
}

/// Ranks on nodes: `node_of` has a number for each rank, the same for those on one node.
pub fn local_nodes(node_of: &[usize]) -> Vec<LocalTeam> {
    let mut nodes: Vec<Arc<LocalNode>> = Vec::new();
    let (to, from): (Vec<_>, Vec<_>) = node_of.iter().map(|_| unbounded()).unzip();
    let team = from.into_iter().enumerate().map(|(rank, from)| {
        let known = nodes.iter().find(|node| node_of[node.leader] == node_of[rank]).cloned();
        let node = known.unwrap_or_else(|| {
            let ranks = node_of.iter().filter(|node| **node == node_of[rank]).count();
            let node = LocalNode { leader: rank, written: Mutex::default(), meet: Barrier::new(ranks) };
            nodes.push(Arc::new(node));
            nodes[nodes.len() - 1].clone()
        });
        let node_rank = node_of[..rank].iter().filter(|node| **node == node_of[rank]).count();
        LocalTeam { rank, node_rank, to: to.clone(), from, early: Vec::new(), node }
    });
    team.collect()
}

impl LocalTeam {
    fn post(&self, to: usize, bytes: Vec<u8>) -> Result<()> {
        let sent = self.to[to].send((self.rank, bytes));
        sent.map_err(|_| Error::new(ErrorKind::Mpi, format!("rank {to} is gone")))
    }

    /// The next message of a rank.
    fn receive(&mut self, of: usize) -> Result<Vec<u8>> {
        if let Some(at) = self.early.iter().position(|(rank, _)| *rank == of) {
            return Ok(self.early.remove(at).1);
        }
        loop {
            let came = self.from.recv().map_err(|_| Error::new(ErrorKind::Mpi, "all ranks are gone"))?;
            if came.0 == of {
                return Ok(came.1);
            }
            self.early.push(came);
        }
    }
}

impl Team for LocalTeam {
    fn rank(&self) -> usize {
        self.rank
    }

    fn size(&self) -> usize {
        self.to.len()
    }

    fn share(&mut self, mine: &[u8]) -> Result<Vec<Vec<u8>>> {
        for rank in 0..self.size() {
            self.post(rank, mine.to_vec())?;
        }
        (0..self.size()).map(|rank| self.receive(rank)).collect()
    }

    fn broadcast(&mut self, mine: Vec<u8>) -> Result<Vec<u8>> {
        if self.rank == 0 {
            for rank in 1..self.size() {
                self.post(rank, mine.clone())?;
            }
            return Ok(mine);
        }
        self.receive(0)
    }

    fn send(&mut self, bytes: Vec<u8>) -> Result<()> {
        self.post(0, bytes)
    }

    fn is_sent(&mut self) -> Result<bool> {
        Ok(true)
    }

    fn try_receive(&mut self) -> Result<Option<(usize, Vec<u8>)>> {
        Ok(if self.early.is_empty() { self.from.try_recv().ok() } else { Some(self.early.remove(0)) })
    }

    fn exchange(&mut self, mine: Vec<Vec<u8>>) -> Result<Vec<Vec<u8>>> {
        assert_eq!(mine.len(), self.size(), "bytes for each rank");
        for (rank, bytes) in mine.into_iter().enumerate() {
            self.post(rank, bytes)?;
        }
        (0..self.size()).map(|rank| self.receive(rank)).collect()
    }

    fn node_rank(&mut self) -> Result<usize> {
        Ok(self.node_rank)
    }

    fn node(&mut self, bytes: usize) -> Result<NodeShare> {
        let memory = LocalMemory { node: self.node.clone(), seen: vec![0; bytes.div_ceil(8)] };
        Ok(NodeShare { leader: self.node.leader, is_refused: false, memory: Box::new(memory) })
    }
}

/// What a thread sees of its node's memory: a copy, as nothing is lent across threads that are written to by turns.
struct LocalMemory {
    node: Arc<LocalNode>,
    seen: Vec<u64>,
}

impl NodeMemory for LocalMemory {
    fn begin(&mut self) -> Result<()> {
        self.node.meet.wait();
        Ok(())
    }

    fn put(&mut self, at: usize, bytes: &[u8]) {
        let mut written = self.node.written.lock().unwrap_or_else(PoisonError::into_inner);
        let most = 8 * self.seen.len();
        assert!(at + bytes.len() <= most, "bytes {at} to {} of {most}", at + bytes.len());
        if written.len() < most {
            written.resize(most, 0);
        }
        written[at..at + bytes.len()].copy_from_slice(bytes);
    }

    fn settle(&mut self) -> Result<()> {
        self.node.meet.wait();
        let written = self.node.written.lock().unwrap_or_else(PoisonError::into_inner);
        let seen: &mut [u8] = bytemuck::cast_slice_mut(&mut self.seen);
        let count = seen.len().min(written.len());
        seen[..count].copy_from_slice(&written[..count]);
        Ok(())
    }

    fn bytes(&self) -> &[u8] {
        bytemuck::cast_slice(&self.seen)
    }
}
