//! A mapped file of `/dev/shm`.

use std::fs::{File, OpenOptions, remove_file};
use std::io::{Error, ErrorKind, Result};
use std::os::fd::AsRawFd;
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::ptr;
use std::slice;

/// Where files are in memory.
const DIRECTORY: &str = "/dev/shm";

#[derive(Debug)]
pub(crate) struct Mapping {
    start: *mut u8,
    bytes: usize,
}

// SAFETY: memory that stays until it is dropped, by any thread.
unsafe impl Send for Mapping {}

// SAFETY: a shared reference gives the memory to be read only.
unsafe impl Sync for Mapping {}

impl Mapping {
    pub fn create(name: &str, bytes: usize) -> Result<Self> {
        let file = OpenOptions::new().read(true).write(true).create_new(true).mode(0o600).open(path(name))?;
        let mapped =
            expect_room(&file, bytes).and_then(|()| file.set_len(bytes as u64)).and_then(|()| Self::of(&file, bytes));
        if mapped.is_err() {
            Self::remove(name);
        }
        mapped
    }

    pub fn open(name: &str, bytes: usize) -> Result<Self> {
        let file = OpenOptions::new().read(true).write(true).open(path(name))?;
        if file.metadata()?.len() < bytes as u64 {
            return Err(ErrorKind::UnexpectedEof.into());
        }
        Self::of(&file, bytes)
    }

    pub fn remove(name: &str) {
        // If it cannot be removed it stays until somebody else removes it.
        let _ = remove_file(path(name));
    }

    fn of(file: &File, bytes: usize) -> Result<Self> {
        let access = libc::PROT_READ | libc::PROT_WRITE;
        // SAFETY: a new mapping at an address that the system chooses, of a file that is open.
        let start = unsafe { libc::mmap(ptr::null_mut(), bytes.max(1), access, libc::MAP_SHARED, file.as_raw_fd(), 0) };
        if start == libc::MAP_FAILED {
            return Err(Error::last_os_error());
        }
        Ok(Mapping { start: start.cast(), bytes })
    }

    pub fn populate(&self, part: usize, parts: usize) -> Result<()> {
        let page = page();
        let share = self.bytes.div_ceil(parts.max(1)).next_multiple_of(page);
        let first = part.saturating_mul(share).min(self.bytes);
        let length = share.min(self.bytes - first);
        if length == 0 {
            return Ok(());
        }
        // SAFETY: whole pages of the mapping. What is in them stays.
        let code = unsafe { libc::madvise(self.start.add(first).cast(), length, libc::MADV_POPULATE_WRITE) };
        match Error::last_os_error() {
            _ if code == 0 => Ok(()),
            // Not known to kernels before 5.14.
            error if [libc::EINVAL, libc::ENOSYS].map(Some).contains(&error.raw_os_error()) => Ok(()),
            error => Err(error),
        }
    }

    pub fn put(&mut self, at: usize, bytes: &[u8]) {
        let end = at.checked_add(bytes.len()).filter(|end| *end <= self.bytes);
        assert!(end.is_some(), "{} bytes at {at} of {}", bytes.len(), self.bytes);
        // SAFETY: inside of the mapping, of which no slice is there, as it is borrowed mutably here and no other process
        // reads it.
        unsafe { ptr::copy_nonoverlapping(bytes.as_ptr(), self.start.add(at), bytes.len()) };
    }

    pub fn bytes(&self) -> &[u8] {
        // SAFETY: the mapping, which lives as long as this; no process writes to it while others read.
        unsafe { slice::from_raw_parts(self.start, self.bytes) }
    }
}

impl Drop for Mapping {
    fn drop(&mut self) {
        // SAFETY: the mapping, of which nothing is borrowed any more.
        unsafe { libc::munmap(self.start.cast(), self.bytes.max(1)) };
    }
}

fn path(name: &str) -> PathBuf {
    Path::new(DIRECTORY).join(name)
}

/// The size of a page of memory.
fn page() -> usize {
    // SAFETY: asks for a number.
    usize::try_from(unsafe { libc::sysconf(libc::_SC_PAGESIZE) }).unwrap_or(1 << 12)
}

/// Fails where the file's system has fewer free bytes; one without a limit has enough.
fn expect_room(file: &File, bytes: usize) -> Result<()> {
    // SAFETY: numbers, for which zero is a value.
    let mut stat: libc::statvfs = unsafe { std::mem::zeroed() };
    // SAFETY: an open file, and a struct that is written.
    let is_known = unsafe { libc::fstatvfs(file.as_raw_fd(), &mut stat) } == 0 && stat.f_blocks > 0;
    let has_room = !is_known || stat.f_bavail.saturating_mul(stat.f_frsize) >= bytes as u64;
    if has_room { Ok(()) } else { Err(ErrorKind::StorageFull.into()) }
}
