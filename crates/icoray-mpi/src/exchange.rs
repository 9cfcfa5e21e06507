//! All-to-all exchange of bytes, with all messages in flight at once.

use crate::error::check;
use crate::host::MpiTeam;
use icoray::Result;
use mpi::ffi;
use std::ffi::c_int;

/// The tag of these messages, which no other operation uses.
const TAG: c_int = 2;

impl MpiTeam {
    /// Exchanges in messages of at most `max_bytes` bytes. Two ranks agree on the lengths first, so both know how many
    /// messages there will be, and those between two ranks stay in order.
    pub(crate) fn exchange_in_parts(&self, mut mine: Vec<Vec<u8>>, max_bytes: usize) -> Result<Vec<Vec<u8>>> {
        assert_eq!(mine.len(), self.comm().size, "bytes for each rank");
        // The own part is neither copied nor sent.
        let own = std::mem::take(&mut mine[self.comm().rank]);
        let lengths = self.exchange_lengths(&mine)?;
        let mut theirs: Vec<Vec<u8>> = lengths.iter().map(|length| vec![0; *length as usize]).collect();
        let mut requests = Vec::new();
        let started = self.start(&mine, &mut theirs, max_bytes, &mut requests);
        // SAFETY: each request is one that MPI has started; the bytes they read and write are in `mine` and `theirs`,
        // which are not accessed until this returns. It is called even if some requests could not be started,
        // so that the others complete.
        let code = unsafe {
            let count = requests.len() as c_int;
            ffi::MPI_Waitall(count, requests.as_mut_ptr(), ffi::RSMPI_STATUSES_IGNORE)
        };
        if let Err(e) = check("MPI_Waitall", code) {
            // MPI may still write to them.
            std::mem::forget((mine, theirs));
            return Err(started.err().unwrap_or(e));
        }
        started?;
        theirs[self.comm().rank] = own;
        Ok(theirs)
    }

    /// Number of bytes that each rank sends to this one.
    fn exchange_lengths(&self, mine: &[Vec<u8>]) -> Result<Vec<u64>> {
        let lengths: Vec<u64> = mine.iter().map(|bytes| bytes.len() as u64).collect();
        let mut theirs = vec![0u64; self.comm().size];
        // SAFETY: one number for each rank and one of each, in arrays as long as there are ranks.
        let code = unsafe {
            let (from, to) = (lengths.as_ptr().cast(), theirs.as_mut_ptr().cast());
            let number = ffi::RSMPI_UINT64_T;
            ffi::MPI_Alltoall(from, 1, number, to, 1, number, self.comm().handle)
        };
        check("MPI_Alltoall", code)?;
        Ok(theirs)
    }

    /// Starts all receives, then all sends. `requests` has those that were started, even if some failed. The bytes must
    /// neither move nor be accessed until each request is complete.
    fn start(
        &self,
        mine: &[Vec<u8>],
        theirs: &mut [Vec<u8>],
        max_bytes: usize,
        requests: &mut Vec<ffi::MPI_Request>,
    ) -> Result<()> {
        // SAFETY: a handle that MPI writes, for which zero is a value.
        let none: ffi::MPI_Request = unsafe { std::mem::zeroed() };
        for (rank, bytes) in (0..).zip(theirs) {
            for part in bytes.chunks_mut(max_bytes) {
                let mut request = none;
                // SAFETY: the part is as long as it says and stays, as the caller sees to; the request is written.
                let code = unsafe {
                    let (to, count) = (part.as_mut_ptr().cast(), part.len() as c_int);
                    ffi::MPI_Irecv(to, count, ffi::RSMPI_UINT8_T, rank, TAG, self.comm().handle, &mut request)
                };
                check("MPI_Irecv", code)?;
                requests.push(request);
            }
        }
        for (rank, bytes) in (0..).zip(mine) {
            for part in bytes.chunks(max_bytes) {
                let mut request = none;
                // SAFETY: as above; the part is only read.
                let code = unsafe {
                    let (from, count) = (part.as_ptr().cast(), part.len() as c_int);
                    ffi::MPI_Isend(from, count, ffi::RSMPI_UINT8_T, rank, TAG, self.comm().handle, &mut request)
                };
                check("MPI_Isend", code)?;
                requests.push(request);
            }
        }
        Ok(())
    }
}
