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
    fn send(&self, to: usize, bytes: Vec<u8>) -> Result<()> {
        let sent = self.to[to].send((self.rank, bytes));
        sent.map_err(|_| Error::new(ErrorKind::Mpi, format!("rank {to} is gone")))
    }

    /// The next message of a rank, or of any but those that have had their turn.
    fn receive(&mut self, is_due: impl Fn(usize) -> bool) -> Result<(usize, Vec<u8>)> {
        if let Some(at) = self.early.iter().position(|(rank, _)| is_due(*rank)) {
            return Ok(self.early.remove(at));
        }
        loop {
            let came = self.from.recv().map_err(|_| Error::new(ErrorKind::Mpi, "all ranks are gone"))?;
            if is_due(came.0) {
                return Ok(came);
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
            self.send(rank, mine.to_vec())?;
        }
        (0..self.size()).map(|rank| self.receive(|from| from == rank).map(|(_, bytes)| bytes)).collect()
    }

    fn broadcast(&mut self, mine: Vec<u8>) -> Result<Vec<u8>> {
        if self.rank == 0 {
            for rank in 1..self.size() {
                self.send(rank, mine.clone())?;
            }
            return Ok(mine);
        }
        self.receive(|from| from == 0).map(|(_, bytes)| bytes)
    }

    fn gather(&mut self, mine: &[u8], take: &mut dyn FnMut(usize, Vec<u8>)) -> Result<()> {
        if self.rank != 0 {
            return self.send(0, mine.to_vec());
        }
        let mut waits: Vec<bool> = (0..self.size()).map(|rank| rank != 0).collect();
        while waits.contains(&true) {
            let (rank, bytes) = self.receive(|from| waits[from])?;
            waits[rank] = false;
            take(rank, bytes);
        }
        Ok(())
    }

    fn exchange(&mut self, mine: Vec<Vec<u8>>) -> Result<Vec<Vec<u8>>> {
        assert_eq!(mine.len(), self.size(), "bytes for each rank");
        for (rank, bytes) in mine.into_iter().enumerate() {
            self.send(rank, bytes)?;
        }
        (0..self.size()).map(|rank| self.receive(|from| from == rank).map(|(_, bytes)| bytes)).collect()
    }
}
