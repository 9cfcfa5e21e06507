//! The collective operations and messages of a team.

use crate::communicator::{Communicator, is_finalized};
use crate::error::{check, failed};
use crate::host::MpiTeam;
use icoray::ranks::{MessageQueue, NodeShare, PointToPoint};
use icoray::{Result, Team};
use mpi::ffi;
use std::ffi::c_int;
use std::sync::atomic::Ordering::Relaxed;

/// Maximum bytes of one message: MPI counts in 32 bits.
const MAX_MESSAGE: usize = 1 << 30;

impl MpiTeam {
    fn broadcast_part(&self, bytes: &mut [u8]) -> Result<()> {
        // SAFETY: as long as it says, on all ranks, and there until the call returns.
        let code = unsafe {
            let (start, count) = (bytes.as_mut_ptr().cast(), bytes.len() as c_int);
            ffi::MPI_Bcast(start, count, ffi::RSMPI_UINT8_T, 0, self.comm().handle)
        };
        check("MPI_Bcast", code)
    }
}

impl Team for MpiTeam {
    fn rank(&self) -> usize {
        self.comm().rank
    }

    fn size(&self) -> usize {
        self.comm().size
    }

    fn is_gone(&self) -> bool {
        is_finalized()
    }

    fn give_up(&mut self) {
        self.comm().is_given_up.store(true, Relaxed);
    }

    fn share(&mut self, mine: &[u8]) -> Result<Vec<Vec<u8>>> {
        let (comm, length) = (self.comm().handle, mine.len() as u64);
        let mut lengths = vec![0u64; self.comm().size];
        // SAFETY: one number of each rank, for which there is room; both are there until the call returns.
        let code = unsafe {
            let (from, to) = ((&raw const length).cast(), lengths.as_mut_ptr().cast());
            let number = ffi::RSMPI_UINT64_T;
            ffi::MPI_Allgather(from, 1, number, to, 1, number, comm)
        };
        check("MPI_Allgather", code)?;
        // All ranks see the same lengths, so all of them stop here or none does.
        let total = lengths.iter().sum::<u64>();
        if total > MAX_MESSAGE as u64 {
            return Err(failed(format!("ranks have {total} bytes to share, expected at most {MAX_MESSAGE}")));
        }
        let counts: Vec<c_int> = lengths.iter().map(|length| *length as c_int).collect();
        let mut starts = Vec::with_capacity(self.comm().size);
        let mut end = 0;
        for count in &counts {
            starts.push(end);
            end += count;
        }
        let mut all = vec![0u8; total as usize];
        // SAFETY: the counts are those that ranks have just sent, their starts lie one behind the other, and the buffer
        // has room for all; everything is there until the call returns.
        let code = unsafe {
            let (byte, to) = (ffi::RSMPI_UINT8_T, all.as_mut_ptr().cast());
            let (from, count) = (mine.as_ptr().cast(), mine.len() as c_int);
            ffi::MPI_Allgatherv(from, count, byte, to, counts.as_ptr(), starts.as_ptr(), byte, comm)
        };
        check("MPI_Allgatherv", code)?;
        let parts = starts.iter().zip(&counts);
        Ok(parts.map(|(start, count)| all[*start as usize..(start + count) as usize].to_vec()).collect())
    }

    fn broadcast(&mut self, mut mine: Vec<u8>) -> Result<Vec<u8>> {
        let mut length = (mine.len() as u64).to_ne_bytes();
        self.broadcast_part(&mut length)?;
        mine.resize(u64::from_ne_bytes(length) as usize, 0);
        for part in mine.chunks_mut(MAX_MESSAGE) {
            self.broadcast_part(part)?;
        }
        Ok(mine)
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
        self.exchange_in_parts(mine, MAX_MESSAGE)
    }

    fn point_to_point(&mut self) -> Result<Box<dyn PointToPoint>> {
        let comm = Communicator::duplicate(self.comm().handle, self.comm().is_given_up.clone())?;
        Ok(Box::new(MessageQueue::new(comm)))
    }

    fn node_rank(&mut self) -> Result<usize> {
        Ok(self.host_group()?.rank)
    }

    fn node_leader(&mut self) -> Result<usize> {
        self.leader(&self.host_group()?)
    }

    fn memory_leader(&mut self) -> Result<usize> {
        self.leader(&self.node_group()?)
    }

    fn node(&mut self, bytes: usize) -> Result<NodeShare> {
        self.share_node(bytes)
    }
}
