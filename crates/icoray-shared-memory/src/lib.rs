//! Memory that the processes of a host share: a file in `/dev/shm` that all of them have mapped.
//!
//! Writing to a page for which there is no space there ends the process by a signal, so the free space is checked first
//! and every page is populated before it is used.

#[cfg_attr(not(target_os = "linux"), path = "unsupported.rs")]
mod system;

use std::io::Result;
use std::{ptr, slice};

/// Memory in a file that this process has mapped. Processes write to it together, then read: each calls
/// [`Self::begin`], [`Self::put`] and [`Self::settle`], and no process is between the first and the last of these while
/// another one reads. Barriers are the caller's.
#[derive(Debug)]
pub struct SharedMemory {
    start: *mut u8,
    bytes: usize,
    /// Whether processes may write to it.
    is_open: bool,
}

// SAFETY: memory that stays until it is dropped, by any thread.
unsafe impl Send for SharedMemory {}

// SAFETY: a shared reference gives the memory to be read only.
unsafe impl Sync for SharedMemory {}

impl SharedMemory {
    /// Creates the file `name`, of zeros, for this user alone. `name` has no slash.
    ///
    /// # Errors
    /// The file exists, or there is no room for it.
    pub fn create(name: &str, bytes: usize) -> Result<Self> {
        Ok(SharedMemory { start: system::create(name, bytes)?, bytes, is_open: false })
    }

    /// Maps the file `name`, which another process has created with as many bytes.
    ///
    /// # Errors
    /// There is no such file, or it cannot be mapped.
    pub fn open(name: &str, bytes: usize) -> Result<Self> {
        Ok(SharedMemory { start: system::open(name, bytes)?, bytes, is_open: false })
    }

    /// Removes the file's name, once all processes have opened it. The memory lives until the last of them drops it.
    pub fn remove(name: &str) {
        system::remove(name);
    }

    /// Populates the pages of one of `parts` equal parts of the memory, so that they are near this process.
    ///
    /// # Errors
    /// The system lacks memory, where it reports that (Linux from 5.14).
    pub fn populate(&self, part: usize, parts: usize) -> Result<()> {
        let share = self.bytes.div_ceil(parts.max(1)).next_multiple_of(system::page());
        let first = part.saturating_mul(share).min(self.bytes);
        let length = share.min(self.bytes - first);
        if length == 0 {
            return Ok(());
        }
        // SAFETY: whole pages of the mapping. What is in them stays.
        unsafe { system::populate(self.start.add(first), length) }
    }

    /// Begins to write.
    pub fn begin(&mut self) {
        self.is_open = true;
    }

    /// Writes bytes at offset `at`, which no other process writes to.
    ///
    /// # Panics
    /// Outside of [`Self::begin`] and [`Self::settle`], or beyond the memory.
    pub fn put(&mut self, at: usize, bytes: &[u8]) {
        assert!(self.is_open, "bytes are written between `begin` and `settle` only");
        let end = at.checked_add(bytes.len()).filter(|end| *end <= self.bytes);
        assert!(end.is_some(), "{} bytes at {at} of {}", bytes.len(), self.bytes);
        // SAFETY: inside of the mapping, of which no slice is there, as it is borrowed mutably here and no other
        // process reads it.
        unsafe { ptr::copy_nonoverlapping(bytes.as_ptr(), self.start.add(at), bytes.len()) };
    }

    /// Ends writing.
    pub fn settle(&mut self) {
        self.is_open = false;
    }

    /// All bytes, aligned to a page.
    ///
    /// # Panics
    /// Between [`Self::begin`] and [`Self::settle`].
    pub fn bytes(&self) -> &[u8] {
        assert!(!self.is_open, "processes are writing");
        // SAFETY: the mapping, which lives as long as this; no process writes to it while others read.
        unsafe { slice::from_raw_parts(self.start, self.bytes) }
    }
}

/// Returns this process's freed memory to the system, where its C library keeps it for later allocations (glibc).
pub fn trim_heap() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: nothing is asked of the caller; memory that is in use stays.
    unsafe {
        libc::malloc_trim(0);
    }
}

impl Drop for SharedMemory {
    fn drop(&mut self) {
        // SAFETY: the mapping, of which nothing is borrowed any more.
        unsafe { system::unmap(self.start, self.bytes) };
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;
    use std::io::ErrorKind;

    /// The name of a file of this process.
    fn name(of: &str) -> String {
        format!("icoray-test-{}-{of}", std::process::id())
    }

    #[test]
    fn one_writes_and_the_other_reads() {
        let name = name("two");
        let mut writer = SharedMemory::create(&name, 10_001).unwrap();
        let reader = SharedMemory::open(&name, 10_001).unwrap();
        assert_eq!(SharedMemory::create(&name, 1).unwrap_err().kind(), ErrorKind::AlreadyExists);
        assert!(SharedMemory::open(&name, 20_000).is_err(), "beyond its end");
        SharedMemory::remove(&name);
        assert_eq!(SharedMemory::open(&name, 1).unwrap_err().kind(), ErrorKind::NotFound);
        for memory in [&writer, &reader] {
            (0..3).for_each(|part| memory.populate(part, 3).unwrap());
        }
        assert!(reader.bytes().len() == 10_001 && reader.bytes().iter().all(|byte| *byte == 0));
        writer.begin();
        writer.put(9_999, &[7, 8]);
        writer.settle();
        assert_eq!(reader.bytes()[9_998..], [0, 7, 8]);
    }

    #[test]
    fn memory_beyond_the_free_space_is_refused() {
        let name = name("large");
        assert_eq!(SharedMemory::create(&name, 1 << 50).unwrap_err().kind(), ErrorKind::StorageFull);
        assert_eq!(SharedMemory::open(&name, 1).unwrap_err().kind(), ErrorKind::NotFound, "no file is left");
    }

    #[test]
    #[should_panic = "processes are writing"]
    fn nothing_is_read_while_processes_write() {
        let name = name("open");
        let mut memory = SharedMemory::create(&name, 8).unwrap();
        SharedMemory::remove(&name);
        memory.begin();
        memory.bytes();
    }
}
