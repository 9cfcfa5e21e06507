//! Shared memory of the ranks of a node: an MPI window.
//!
//! MPI usually backs it by a file in `/dev/shm`. Writing to a page for which there is no space there ends the process
//! by a signal, so the free space is checked first and every page is populated before it is used. Without enough space
//! each rank has memory of its own.

use crate::communicator::MpiCommunicator;
use crate::error::check;
use icoray::Result;
use icoray::ranks::{Communicator, NodeMemory, NodeShare};
use mpi::ffi;
use std::ffi::{CString, c_int, c_void};
use std::io::Error;
use std::ptr;

/// Environment variable: maximum number of ranks that share memory. 1 disables sharing; fewer than the ranks of a node
/// give one copy per NUMA domain.
const NODE_RANKS: &str = "ICORAY_NODE_RANKS";

/// Environment variable of Open MPI: directory of windows, if not the default, which MPICH has too.
const BACKING: &str = "OMPI_MCA_osc_sm_backing_directory";

/// Space beside the bytes of a window, for MPI's own state.
const STATE: usize = 1 << 20;

/// Alignment of the window: a cache line.
const LINE: usize = 64;

impl MpiCommunicator {
    /// Memory shared by the ranks of this rank's node. Collective.
    pub(crate) fn share_node(&self, bytes: usize) -> Result<NodeShare> {
        let group = self.node_group()?;
        let mine = [self.rank as u64, u64::from(has_room(&window_directory(), bytes + STATE))];
        let [leader, has_room] = group.broadcast(mine)?;
        if group.size == 1 {
            return Ok(NodeShare::alone(self.rank, bytes));
        }
        let window = if has_room == 1 { Window::new(group, bytes)? } else { None };
        Ok(match window {
            Some(window) => NodeShare { leader: leader as usize, is_refused: false, memory: Box::new(window) },
            None => NodeShare { is_refused: true, ..NodeShare::alone(self.rank, bytes) },
        })
    }

    /// The team's number of the first rank of this rank's `group`. Collective over the group.
    pub(crate) fn leader(&self, group: &MpiCommunicator) -> Result<usize> {
        let [leader, _] = group.broadcast([self.rank as u64, 0])?;
        Ok(leader as usize)
    }

    /// The ranks of this host. Collective.
    pub(crate) fn host_group(&self) -> Result<MpiCommunicator> {
        let comm = self.handle;
        self.split(|key, new| {
            // SAFETY: a communicator and a handle that is written.
            unsafe { ffi::MPI_Comm_split_type(comm, ffi::RSMPI_COMM_TYPE_SHARED, key, ffi::RSMPI_INFO_NULL, new) }
        })
    }

    /// The ranks of this host that share memory: all, or groups of the size that the environment sets.
    pub(crate) fn node_group(&self) -> Result<MpiCommunicator> {
        let host = self.host_group()?;
        let max_ranks = std::env::var(NODE_RANKS).ok().and_then(|max_ranks| max_ranks.parse::<usize>().ok());
        let color = host.rank / max_ranks.filter(|max_ranks| *max_ranks > 0).unwrap_or(host.size);
        // SAFETY: as above; `host` is there until this returns.
        self.split(|key, new| unsafe { ffi::MPI_Comm_split(host.handle, color as c_int, key, new) })
    }

    /// The group that `split` creates from this communicator, in the order of its ranks.
    fn split(&self, split: impl FnOnce(c_int, *mut ffi::MPI_Comm) -> c_int) -> Result<MpiCommunicator> {
        let key = self.rank as c_int;
        MpiCommunicator::new("MPI_Comm_split", self.is_given_up.clone(), |new| split(key, new))
    }
}

/// Collective operations of a group.
impl MpiCommunicator {
    fn barrier(&self) -> Result<()> {
        // SAFETY: a communicator of ours.
        check("MPI_Barrier", unsafe { ffi::MPI_Barrier(self.handle) })
    }

    /// Broadcasts the first rank's numbers.
    fn broadcast(&self, mut mine: [u64; 2]) -> Result<[u64; 2]> {
        // SAFETY: two numbers on each rank, there until the call returns.
        let code = unsafe { ffi::MPI_Bcast(mine.as_mut_ptr().cast(), 2, ffi::RSMPI_UINT64_T, 0, self.handle) };
        check("MPI_Bcast", code)?;
        Ok(mine)
    }

    /// Logical and over all ranks.
    fn is_on_all(&self, mine: bool) -> Result<bool> {
        let (mine, mut min) = (i32::from(mine), 0i32);
        // SAFETY: a number that is read and one that is written, both there until the call returns.
        let code = unsafe {
            let (from, to) = ((&raw const mine).cast(), (&raw mut min).cast());
            ffi::MPI_Allreduce(from, to, 1, ffi::RSMPI_INT32_T, ffi::RSMPI_MIN, self.handle)
        };
        check("MPI_Allreduce", code)?;
        Ok(min == 1)
    }
}

/// A window that the first rank of a group allocated and all ranks have mapped.
struct Window {
    win: ffi::MPI_Win,
    start: *mut u8,
    bytes: usize,
    /// Whether ranks may write to it.
    is_open: bool,
    /// Dropped last.
    group: MpiCommunicator,
}

// SAFETY: handles, which MPI lets any thread hold, and memory that stays until it is dropped; calls with them are made
// by the thread that makes calls on the host's context.
unsafe impl Send for Window {}

// SAFETY: a shared reference gives the memory to be read only.
unsafe impl Sync for Window {}

impl Window {
    /// `None` on all ranks if MPI cannot allocate or map it on some, or the system lacks memory. Collective.
    fn new(group: MpiCommunicator, bytes: usize) -> Result<Option<Self>> {
        // SAFETY: a handle of MPI's, which is not written to.
        let mut win = unsafe { ffi::RSMPI_WIN_NULL };
        let mut start: *mut u8 = ptr::null_mut();
        let size = if group.rank == 0 { bytes + LINE } else { 0 };
        // SAFETY: no more than the host can address; the handle and the pointer are written.
        let code = unsafe {
            let (none, to) = (ffi::RSMPI_INFO_NULL, (&raw mut start).cast());
            ffi::MPI_Win_allocate_shared(size as ffi::MPI_Aint, 1, none, group.handle, to, &mut win)
        };
        let is_made = check("MPI_Win_allocate_shared", code).is_ok();
        if !group.is_on_all(is_made)? {
            // Ranks that allocated it leak it: freeing is collective.
            return Ok(None);
        }
        let mut window = Window { win, start, bytes, is_open: false, group };
        if !window.map(bytes)? {
            // Leaked as above: on some ranks MPI may fail to free it.
            std::mem::forget(window);
            return Ok(None);
        }
        let is_populated = window.populate_pages();
        let is_populated = window.group.is_on_all(is_populated)?;
        Ok(is_populated.then_some(window))
    }

    /// Finds the first rank's memory and begins this rank's access epoch; returns the address and the size.
    fn lock(&self) -> Result<(*mut c_void, ffi::MPI_Aint)> {
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
        Ok((start, size))
    }

    /// Maps the first rank's memory; false on all ranks if that failed on some. Collective.
    fn map(&mut self, bytes: usize) -> Result<bool> {
        let locked = self.lock();
        // Before the next collective call, which a rank that failed would not enter.
        if !self.group.is_on_all(locked.is_ok())? {
            return Ok(false);
        }
        let (start, size) = locked?;
        // Skips as many bytes on all ranks, whose memory begins at different addresses.
        let skipped = start.align_offset(LINE) as u64;
        let [skipped, _] = self.group.broadcast([skipped, 0])?;
        self.start = start.cast::<u8>().wrapping_add(skipped as usize);
        let is_fit = self.start.align_offset(8) == 0 && size as usize >= bytes + skipped as usize;
        self.group.is_on_all(is_fit)
    }

    /// Populates this rank's share of the pages, so that they are near it; false if there was not enough memory, where
    /// the system reports that (Linux from 5.14).
    fn populate_pages(&self) -> bool {
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
        let unsupported = [libc::EINVAL, libc::ENOSYS];
        code == 0 || Error::last_os_error().raw_os_error().is_some_and(|e| unsupported.contains(&e))
    }
}

impl NodeMemory for Window {
    fn begin(&mut self) -> Result<()> {
        // No rank that is here holds a slice of it, as this borrows it mutably.
        self.group.barrier()?;
        self.is_open = true;
        Ok(())
    }

    fn put(&mut self, at: usize, bytes: &[u8]) {
        let end = at.checked_add(bytes.len()).filter(|end| *end <= self.bytes);
        assert!(self.is_open && end.is_some(), "{} bytes at {at} of {}", bytes.len(), self.bytes);
        // SAFETY: inside of the window, which lives as long as this. No slice of it is there on any rank, as all have
        // begun to write and none has settled.
        unsafe { ptr::copy_nonoverlapping(bytes.as_ptr(), self.start.add(at), bytes.len()) };
    }

    fn settle(&mut self) -> Result<()> {
        // Makes own writes visible, waits for all ranks, then sees their writes.
        // SAFETY: a window of ours, between lock and unlock.
        let is_visible = check("MPI_Win_sync", unsafe { ffi::MPI_Win_sync(self.win) });
        // The others wait in it, even after a failure here.
        self.group.barrier()?;
        self.is_open = false;
        // SAFETY: as above.
        is_visible.and(check("MPI_Win_sync", unsafe { ffi::MPI_Win_sync(self.win) }))
    }

    fn bytes(&self) -> &[u8] {
        assert!(!self.is_open, "ranks are writing");
        // SAFETY: the window's memory, which lives as long as this; no rank writes to it before all have begun to, for
        // which this one would need the window for itself.
        unsafe { std::slice::from_raw_parts(self.start, self.bytes) }
    }
}

impl Drop for Window {
    fn drop(&mut self) {
        if !self.group.is_gone() {
            // SAFETY: the window is ours, and no code of this rank reads it any more; freeing it waits for the others.
            // A failure cannot be reported any more.
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

/// The directory of windows.
fn window_directory() -> String {
    std::env::var(BACKING).unwrap_or_else(|_| "/dev/shm".into())
}

/// Whether a file system has `bytes` free bytes; true if that is unknown or it has no limit.
fn has_room(directory: &str, bytes: usize) -> bool {
    let Ok(path) = CString::new(directory) else {
        return true;
    };
    // SAFETY: numbers, for which zero is a value.
    let mut stat: libc::statvfs = unsafe { std::mem::zeroed() };
    // SAFETY: a string and a struct that is written.
    let is_known = unsafe { libc::statvfs(path.as_ptr(), &mut stat) } == 0 && stat.f_blocks > 0;
    !is_known || stat.f_bavail.saturating_mul(stat.f_frsize) >= bytes as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn free_space_is_checked() {
        let here = std::env::temp_dir();
        let here = here.to_str().unwrap();
        assert!(has_room(here, 1) && !has_room(here, usize::MAX));
        assert!(has_room("/no/such/place", usize::MAX) && has_room("\0", usize::MAX));
    }
}
