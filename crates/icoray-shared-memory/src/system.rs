//! Mapped files of `/dev/shm`.

use std::fs::{File, OpenOptions, remove_file};
use std::io::{Error, ErrorKind, Result};
use std::os::fd::AsRawFd;
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::ptr;

/// Where files are in memory.
const DIRECTORY: &str = "/dev/shm";

pub fn create(name: &str, bytes: usize) -> Result<*mut u8> {
    let file = OpenOptions::new().read(true).write(true).create_new(true).mode(0o600).open(path(name))?;
    let mapped = expect_room(&file, bytes).and_then(|()| file.set_len(bytes as u64)).and_then(|()| map(&file, bytes));
    if mapped.is_err() {
        remove(name);
    }
    mapped
}

pub fn open(name: &str, bytes: usize) -> Result<*mut u8> {
    let file = OpenOptions::new().read(true).write(true).open(path(name))?;
    if file.metadata()?.len() < bytes as u64 {
        return Err(ErrorKind::UnexpectedEof.into());
    }
    map(&file, bytes)
}

pub fn remove(name: &str) {
    // If it cannot be removed it stays until somebody else removes it.
    let _ = remove_file(path(name));
}

fn map(file: &File, bytes: usize) -> Result<*mut u8> {
    let access = libc::PROT_READ | libc::PROT_WRITE;
    // SAFETY: a new mapping at an address that the system chooses, of a file that is open.
    let start = unsafe { libc::mmap(ptr::null_mut(), bytes.max(1), access, libc::MAP_SHARED, file.as_raw_fd(), 0) };
    if start == libc::MAP_FAILED { Err(Error::last_os_error()) } else { Ok(start.cast()) }
}

/// # Safety
/// `start` and `bytes` are those of a mapping, of which nothing is borrowed.
pub unsafe fn unmap(start: *mut u8, bytes: usize) {
    // SAFETY: as promised.
    unsafe { libc::munmap(start.cast(), bytes.max(1)) };
}

/// # Safety
/// The bytes lie in a mapping, from the start of a page.
pub unsafe fn populate(start: *mut u8, bytes: usize) -> Result<()> {
    // SAFETY: as promised.
    let code = unsafe { libc::madvise(start.cast(), bytes, libc::MADV_POPULATE_WRITE) };
    match Error::last_os_error() {
        _ if code == 0 => Ok(()),
        // Not known to kernels before 5.14.
        error if [libc::EINVAL, libc::ENOSYS].map(Some).contains(&error.raw_os_error()) => Ok(()),
        error => Err(error),
    }
}

/// The size of a page of memory.
pub fn page() -> usize {
    // SAFETY: asks for a number.
    usize::try_from(unsafe { libc::sysconf(libc::_SC_PAGESIZE) }).unwrap_or(1 << 12)
}

fn path(name: &str) -> PathBuf {
    Path::new(DIRECTORY).join(name)
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
