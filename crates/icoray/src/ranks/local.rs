//! Ranks that are threads of one process: for tests, and to study what ranks would do where there is no MPI.

use super::Team;
use crate::error::{Error, ErrorKind, Result};
use crossbeam_channel::{Receiver, Sender, unbounded};

/// One rank of a [`local_team`].
#[derive(Debug)]
pub struct LocalTeam {
    rank: usize,
    /// To each rank, oneself included.
    to: Vec<Sender<(usize, Vec<u8>)>>,
    from: Receiver<(usize, Vec<u8>)>,
    /// What came before its turn: ranks run ahead of each other.
    early: Vec<(usize, Vec<u8>)>,
}

/// `size` ranks, each to be moved to a thread of its own.
pub fn local_team(size: usize) -> Vec<LocalTeam> {
    let (to, from): (Vec<_>, Vec<_>) = (0..size).map(|_| unbounded()).unzip();
    let team = from.into_iter().enumerate();
    team.map(|(rank, from)| LocalTeam { rank, to: to.clone(), from, early: Vec::new() }).collect()
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
}
