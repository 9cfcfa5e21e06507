//! Memory that the ranks of a node share: a window of MPI's.
//!
//! MPI makes it of a file in `/dev/shm`, as a rule. Whoever writes to a page for which there is no room there is ended by a
//! signal, so room is looked for before, and every page is had before anybody writes. Where there is none, each rank gets
//! memory of its own.

use crate::host::{MpiTeam, check, failed, is_finalized};
use icoray::Result;
use icoray::ranks::{NodeMemory, NodeShare};
use mpi::ffi;
use std::ffi::{CString, c_int, c_void};
use std::io::Error;
use std::ptr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// A number in this says how many ranks of a node share memory at most: 1 where none is to be shared, fewer than all for a
/// copy in each part of a machine whose parts are far from each other.
const NODE_RANKS: &str = "ICORAY_NODE_RANKS";

/// Where Open MPI is told to put windows, if not in the usual place, which is MPICH's too.
const BACKING: &str = "OMPI_MCA_osc_sm_backing_directory";

/// What windows have to spare beside their bytes, which MPI keeps its own state in.
const STATE: usize = 1 << 20;

/// Where memory for the processor's cache lines begins.
const LINE: usize = 64;

impl MpiTeam {
    /// Memory for the ranks of this one's node. Collective.
    pub(crate) fn share_node(&self, bytes: usize) -> Result<NodeShare> {
        let group = self.node_group()?;
        let mine = [self.rank as u64, u64::from(has_room(&backing(), bytes + STATE))];
        let [leader, has_room] = group.broadcast(mine)?;
        if group.size == 1 {
            return Ok(NodeShare::alone(self.rank, bytes));
        }
        let window = if has_room == 1 { Window::new(group, bytes)? } else { None };
        Ok(match window {
            Some(window) => {
                NodeShare { leader: leader as usize, is_refused: false, memory: Box::new(window) }
            }
            None => NodeShare { is_refused: true, ..NodeShare::alone(self.rank, bytes) },
        })
    }

    /// The first of those that share memory with this rank. Collective.
    pub(crate) fn leader(&self) -> Result<usize> {
        let [leader, _] = self.node_group()?.broadcast([self.rank as u64, 0])?;
        Ok(leader as usize)
    }

    /// This rank's number on its host. Collective.
    pub(crate) fn rank_on_host(&self) -> Result<usize> {
        Ok(self.host_group()?.rank)
    }

    /// The number of the first rank on this one's host. Collective.
    pub(crate) fn first_on_host(&self) -> Result<usize> {
        let [first, _] = self.host_group()?.broadcast([self.rank as u64, 0])?;
        Ok(first as usize)
    }

    /// Those that share memory with this rank.
    fn host_group(&self) -> Result<Group> {
        self.split(|comm, key, new| {
            // SAFETY: a communicator and a handle that is written.
            unsafe {
                ffi::MPI_Comm_split_type(comm, ffi::RSMPI_COMM_TYPE_SHARED, key, ffi::RSMPI_INFO_NULL, new)
            }
        })
    }

    /// The same, or as many of them as the environment says.
    fn node_group(&self) -> Result<Group> {
        let host = self.host_group()?;
        let most = std::env::var(NODE_RANKS).ok().and_then(|most| most.parse::<usize>().ok());
        let color = host.rank / most.filter(|most| *most > 0).unwrap_or(host.size);
        let comm = host.comm;
        self.split(|_, key, new| {
            // SAFETY: as above; `host` is there until this returns.
            unsafe { ffi::MPI_Comm_split(comm, color as c_int, key, new) }
        })
    }

    /// A group that `split` makes of this communicator, in the order of its ranks.
    fn split(&self, split: impl FnOnce(ffi::MPI_Comm, c_int, *mut ffi::MPI_Comm) -> c_int) -> Result<Group> {
        // SAFETY: a handle of MPI's, which is not written to.
        let mut comm = unsafe { ffi::RSMPI_COMM_NULL };
        check("MPI_Comm_split", split(self.comm, self.rank as c_int, &mut comm))?;
        let mut group = Group { comm, rank: 0, size: 1, is_given_up: self.is_given_up.clone() };
        let (mut rank, mut size) = (0, 1);
        // SAFETY: a communicator of ours, whose errors may be ours; the numbers are written.
        unsafe {
            check("MPI_Comm_set_errhandler", ffi::MPI_Comm_set_errhandler(comm, ffi::RSMPI_ERRORS_RETURN))?;
            check("MPI_Comm_rank", ffi::MPI_Comm_rank(comm, &mut rank))?;
            check("MPI_Comm_size", ffi::MPI_Comm_size(comm, &mut size))?;
        }
        (group.rank, group.size) = (rank as usize, size as usize);
        Ok(group)
    }
}

/// Some of a team's ranks, with a communicator that is freed when this is dropped. Collective.
struct Group {
    comm: ffi::MPI_Comm,
    rank: usize,
    size: usize,
    is_given_up: Arc<AtomicBool>,
}

impl Group {
    /// Whether ranks can still be met to free things.
    fn is_there(&self) -> bool {
        !self.is_given_up.load(Relaxed) && !is_finalized()
    }

    fn meet(&self) -> Result<()> {
        // SAFETY: a communicator of ours.
        check("MPI_Barrier", unsafe { ffi::MPI_Barrier(self.comm) })
    }

    /// The first rank's numbers.
    fn broadcast(&self, mut mine: [u64; 2]) -> Result<[u64; 2]> {
        // SAFETY: two numbers on each rank, there until the call returns.
        let code = unsafe { ffi::MPI_Bcast(mine.as_mut_ptr().cast(), 2, ffi::RSMPI_UINT64_T, 0, self.comm) };
        check("MPI_Bcast", code)?;
        Ok(mine)
    }

    /// Whether it is so on all ranks.
    fn is_on_all(&self, mine: bool) -> Result<bool> {
        let (mine, mut least) = (i32::from(mine), 0i32);
        // SAFETY: a number that is read and one that is written, both there until the call returns.
        let code = unsafe {
            let (from, to) = ((&raw const mine).cast(), (&raw mut least).cast());
            ffi::MPI_Allreduce(from, to, 1, ffi::RSMPI_INT32_T, ffi::RSMPI_MIN, self.comm)
        };
        check("MPI_Allreduce", code)?;
        Ok(least == 1)
    }
}

impl Drop for Group {
    fn drop(&mut self) {
        if self.is_there() {
            // SAFETY: the communicator is ours. Nobody is left to tell of a failure.
            unsafe { ffi::MPI_Comm_free(&mut self.comm) };
        }
    }
}

/// A window that the first rank of a group has made, and all of it have in their memory.
struct Window {
    win: ffi::MPI_Win,
    start: *mut u8,
    bytes: usize,
    /// Whether ranks write to it.
    is_open: bool,
    /// Dropped last.
    group: Group,
}

// SAFETY: handles, which MPI lets any thread hold, and memory that stays until it is dropped; calls with them are made by the
// thread that makes calls on the host's context.
unsafe impl Send for Window {}

impl Window {
    /// `None` on all ranks where MPI cannot make it, or the system has not so much memory. Collective.
    fn new(group: Group, bytes: usize) -> Result<Option<Self>> {
        // SAFETY: a handle of MPI's, which is not written to.
        let mut win = unsafe { ffi::RSMPI_WIN_NULL };
        let mut start: *mut u8 = ptr::null_mut();
        let size = if group.rank == 0 { bytes + LINE } else { 0 };
        // SAFETY: no more than the host can address; the handle and the pointer are written.
        let code = unsafe {
            let (none, to) = (ffi::RSMPI_INFO_NULL, (&raw mut start).cast());
            ffi::MPI_Win_allocate_shared(size as ffi::MPI_Aint, 1, none, group.comm, to, &mut win)
        };
        let is_made = check("MPI_Win_allocate_shared", code).is_ok();
        if !group.is_on_all(is_made)? {
            // Where it was made it stays: freeing it takes all ranks.
            return Ok(None);
        }
        let mut window = Window { win, start, bytes, is_open: false, group };
        window.find(bytes)?;
        let is_had = window.have_pages();
        let is_had = window.group.is_on_all(is_had)?;
        Ok(is_had.then_some(window))
    }

    /// Finds the first rank's memory, and begins the time in which all may read and write it.
    fn find(&mut self, bytes: usize) -> Result<()> {
        let (mut size, mut unit) = (0, 0);
        let mut start: *mut c_void = ptr::null_mut();
        // SAFETY: a window of ours; numbers and a pointer are written.
        unsafe {
            check("MPI_Win_set_errhandler", ffi::MPI_Win_set_errhandler(self.win, ffi::RSMPI_ERRORS_RETURN))?;
            let to = (&raw mut start).cast();
            check("MPI_Win_shared_query", ffi::MPI_Win_shared_query(self.win, 0, &mut size, &mut unit, to))?;
            let nobody_locks = ffi::MPI_MODE_NOCHECK as c_int;
            check("MPI_Win_lock_all", ffi::MPI_Win_lock_all(nobody_locks, self.win))?;
        }
        // The same place on all ranks, whose memory begins at different addresses.
        let skipped = start.align_offset(LINE) as u64;
        let [skipped, _] = self.group.broadcast([skipped, 0])?;
        self.start = start.cast::<u8>().wrapping_add(skipped as usize);
        let is_fit = self.start.align_offset(8) == 0 && size as usize >= bytes + skipped as usize;
        if self.group.is_on_all(is_fit)? {
            return Ok(());
        }
        Err(failed("MPI_Win_allocate_shared gave memory of another size or alignment".into()))
    }

    /// Has the system find memory for this rank's share of the pages, each rank near itself; whether there was enough, as far
    /// as the system can tell (Linux from 5.14).
    fn have_pages(&self) -> bool {
        let page = page();
        let start = self.start.addr() / page * page;
        let all = self.start.addr() + self.bytes - start;
        let share = all.div_ceil(self.group.size).next_multiple_of(page);
        let first = (self.group.rank * share).min(all);
        let length = share.min(all - first);
        if length == 0 {
            return true;
        }
        let from = self.start.with_addr(start + first);
        // SAFETY: whole pages that the window's bytes lie in. What is in them stays.
        let code = unsafe { libc::madvise(from.cast(), length, libc::MADV_POPULATE_WRITE) };
        let cannot_tell = [libc::EINVAL, libc::ENOSYS];
        code == 0 || Error::last_os_error().raw_os_error().is_some_and(|e| cannot_tell.contains(&e))
    }
}

impl NodeMemory for Window {
    fn begin(&mut self) -> Result<()> {
        // Whoever is here has no slice of it any more, as this borrows it for writing.
        self.group.meet()?;
        self.is_open = true;
        Ok(())
    }

    fn put(&mut self, at: usize, bytes: &[u8]) {
        let end = at.checked_add(bytes.len()).filter(|end| *end <= self.bytes);
        assert!(self.is_open && end.is_some(), "{} bytes at {at} of {}", bytes.len(), self.bytes);
        // SAFETY: inside of the window, which lives as long as this. No slice of it is there on any rank, as all have begun to
        // write and none has settled.
        unsafe { ptr::copy_nonoverlapping(bytes.as_ptr(), self.start.add(at), bytes.len()) };
    }

    fn settle(&mut self) -> Result<()> {
        // What was written here goes to memory, then all meet, then what others wrote comes.
        // SAFETY: a window of ours, between lock and unlock.
        check("MPI_Win_sync", unsafe { ffi::MPI_Win_sync(self.win) })?;
        self.group.meet()?;
        // SAFETY: as above.
        check("MPI_Win_sync", unsafe { ffi::MPI_Win_sync(self.win) })?;
        self.is_open = false;
        Ok(())
    }

    fn bytes(&self) -> &[u8] {
        assert!(!self.is_open, "ranks are writing");
        // SAFETY: the window's memory, which lives as long as this; no rank writes to it before all have begun to, for which
        // this one would need the window for itself.
        unsafe { std::slice::from_raw_parts(self.start, self.bytes) }
    }
}

impl Drop for Window {
    fn drop(&mut self) {
        if self.group.is_there() {
            // SAFETY: the window is ours, and nobody on this rank reads it any more; freeing it waits for the others. Nobody is
            // left to tell of a failure.
            unsafe {
                ffi::MPI_Win_unlock_all(self.win);
                ffi::MPI_Win_free(&mut self.win);
            }
        }
    }
}

/// The size of a page of memory.
fn page() -> usize {
    // SAFETY: asks for a number.
    usize::try_from(unsafe { libc::sysconf(libc::_SC_PAGESIZE) }).unwrap_or(1 << 12)
}

/// Where windows lie.
fn backing() -> String {
    std::env::var(BACKING).unwrap_or_else(|_| "/dev/shm".into())
}

/// Whether a file system has so many bytes to spare; one that cannot be asked, or has no limit, is taken to have them.
fn has_room(directory: &str, bytes: usize) -> bool {
    let Ok(path) = CString::new(directory) else {
        return true;
    };
    // SAFETY: numbers, for which zero is a value.
    let mut stat: libc::statvfs = unsafe { std::mem::zeroed() };
    // SAFETY: a string and a struct that is written.
    let is_told = unsafe { libc::statvfs(path.as_ptr(), &mut stat) } == 0 && stat.f_blocks > 0;
    !is_told || stat.f_bavail.saturating_mul(stat.f_frsize) >= bytes as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn room_is_looked_for() {
        let here = std::env::temp_dir();
        let here = here.to_str().unwrap();
        assert!(has_room(here, 1) && !has_room(here, usize::MAX));
        assert!(has_room("/no/such/place", usize::MAX) && has_room("\0", usize::MAX));
    }
}
