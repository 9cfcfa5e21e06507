//! Bytes between ranks.

use crate::host::{MpiTeam, check, failed, is_finalized};
use icoray::{Result, Team};
use mpi::ffi;
use std::ffi::c_int;

/// The most that one message carries: MPI counts in 32 bits.
const MOST: usize = 1 << 30;
/// The tag of messages to rank 0. The communicator is nobody else's.
const TAG: c_int = 1;

/// What has come of a rank's bytes so far.
#[derive(Default)]
struct Coming {
    /// How many there will be, which comes first.
    whole: Option<usize>,
    bytes: Vec<u8>,
}

impl MpiTeam {
    fn send(&self, bytes: &[u8]) -> Result<()> {
        // SAFETY: `bytes` is there until the call returns, and no longer than MPI can count; the communicator is ours.
        let code = unsafe {
            let (start, count) = (bytes.as_ptr().cast(), bytes.len() as c_int);
            ffi::MPI_Send(start, count, ffi::RSMPI_UINT8_T, 0, TAG, self.comm)
        };
        check("MPI_Send", code)
    }

    /// The next message of whichever rank, with its number.
    fn receive(&self) -> Result<(usize, Vec<u8>)> {
        // SAFETY: handles and a status that MPI writes, of types for which zero is a value; the buffer that is received
        // into has the length that the message was found to have.
        unsafe {
            let mut message = std::mem::zeroed();
            let mut status: ffi::MPI_Status = std::mem::zeroed();
            let any = ffi::RSMPI_ANY_SOURCE;
            check("MPI_Mprobe", ffi::MPI_Mprobe(any, TAG, self.comm, &mut message, &mut status))?;
            let mut count = 0;
            check("MPI_Get_count", ffi::MPI_Get_count(&status, ffi::RSMPI_UINT8_T, &mut count))?;
            let mut bytes = vec![0u8; usize::try_from(count).unwrap_or(0)];
            let (start, byte) = (bytes.as_mut_ptr().cast(), ffi::RSMPI_UINT8_T);
            check("MPI_Mrecv", ffi::MPI_Mrecv(start, count, byte, &mut message, &mut status))?;
            Ok((usize::try_from(status.MPI_SOURCE).unwrap_or(0), bytes))
        }
    }

    fn broadcast_part(&self, bytes: &mut [u8]) -> Result<()> {
        // SAFETY: as long as it says, on all ranks, and there until the call returns.
        let code = unsafe {
            let (start, count) = (bytes.as_mut_ptr().cast(), bytes.len() as c_int);
            ffi::MPI_Bcast(start, count, ffi::RSMPI_UINT8_T, 0, self.comm)
        };
        check("MPI_Bcast", code)
    }
}

impl Team for MpiTeam {
    fn rank(&self) -> usize {
        self.rank
    }

    fn size(&self) -> usize {
        self.size
    }

    fn is_gone(&self) -> bool {
        is_finalized()
    }

    fn give_up(&mut self) {
        self.is_given_up = true;
    }

    fn share(&mut self, mine: &[u8]) -> Result<Vec<Vec<u8>>> {
        let length = mine.len() as u64;
        let mut lengths = vec![0u64; self.size];
        // SAFETY: one number of each rank, for which there is room; both are there until the call returns.
        let code = unsafe {
            let (from, to) = ((&raw const length).cast(), lengths.as_mut_ptr().cast());
            let number = ffi::RSMPI_UINT64_T;
            ffi::MPI_Allgather(from, 1, number, to, 1, number, self.comm)
        };
        check("MPI_Allgather", code)?;
        // All ranks see the same lengths, so all of them stop here or none does.
        let total = lengths.iter().sum::<u64>();
        if total > MOST as u64 {
            return Err(failed(format!("ranks have {total} bytes to share, expected at most {MOST}")));
        }
        let counts: Vec<c_int> = lengths.iter().map(|length| *length as c_int).collect();
        let mut starts = Vec::with_capacity(self.size);
        let mut end = 0;
        for count in &counts {
            starts.push(end);
            end += count;
        }
        let mut all = vec![0u8; total as usize];
        // SAFETY: the counts are those that ranks have just told, their starts lie one behind the other, and the buffer has
        // room for all; everything is there until the call returns.
        let code = unsafe {
            let (byte, to) = (ffi::RSMPI_UINT8_T, all.as_mut_ptr().cast());
            let (from, count) = (mine.as_ptr().cast(), mine.len() as c_int);
            ffi::MPI_Allgatherv(from, count, byte, to, counts.as_ptr(), starts.as_ptr(), byte, self.comm)
        };
        check("MPI_Allgatherv", code)?;
        let parts = starts.iter().zip(&counts);
        Ok(parts.map(|(start, count)| all[*start as usize..(start + count) as usize].to_vec()).collect())
    }

    fn broadcast(&mut self, mut mine: Vec<u8>) -> Result<Vec<u8>> {
        let mut length = (mine.len() as u64).to_ne_bytes();
        self.broadcast_part(&mut length)?;
        mine.resize(u64::from_ne_bytes(length) as usize, 0);
        for part in mine.chunks_mut(MOST) {
            self.broadcast_part(part)?;
        }
        Ok(mine)
    }

    /// Messages of one rank come in the order in which they were sent, those of different ranks in any.
    fn gather(&mut self, mine: &[u8], take: &mut dyn FnMut(usize, Vec<u8>)) -> Result<()> {
        if self.rank != 0 {
            self.send(&(mine.len() as u64).to_ne_bytes())?;
            return mine.chunks(MOST).try_for_each(|part| self.send(part));
        }
        let mut coming: Vec<Coming> = (0..self.size).map(|_| Coming::default()).collect();
        let mut missing = self.size - 1;
        while missing > 0 {
            let (rank, part) = self.receive()?;
            let of_rank = &mut coming[rank];
            match of_rank.whole {
                None => {
                    let length = part.try_into().map(u64::from_ne_bytes);
                    let length = length.map_err(|_| failed(format!("rank {rank} sent no length")))?;
                    of_rank.whole = Some(length as usize);
                }
                Some(_) if of_rank.bytes.is_empty() => of_rank.bytes = part,
                Some(_) => of_rank.bytes.extend_from_slice(&part),
            }
            if of_rank.whole == Some(of_rank.bytes.len()) {
                missing -= 1;
                take(rank, std::mem::take(&mut of_rank.bytes));
            }
        }
        Ok(())
    }

    fn exchange(&mut self, mine: Vec<Vec<u8>>) -> Result<Vec<Vec<u8>>> {
        self.exchange_in_parts(mine, MOST)
    }
}
