//! The memory that this process can still take, and tables that are refused with an error where it is too little.

use crate::error::{Error, ErrorKind, Result};
use bytemuck::Zeroable;
use sysinfo::{CGroupLimits, MemoryRefreshKind, Pid, ProcessRefreshKind, ProcessesToUpdate, RefreshKind, System};

/// Bytes below which available memory is not checked: the check takes longer than such an allocation.
const SMALL: u64 = 64 << 20;

/// Bytes that this process can still take: the least of what the machine has, what its control group leaves
/// (containers, batch jobs), and what the limit of its address space leaves. `None` where the system does not tell.
///
/// ```
/// let available = icoray_grid::memory::available();
/// assert!(available.is_none_or(|bytes| bytes > 0));
/// ```
pub fn available() -> Option<u64> {
    let asked = RefreshKind::nothing().with_memory(MemoryRefreshKind::everything());
    let mut system = System::new_with_specifics(asked).ok()?;
    let machine = system.available_memory().saturating_add(system.free_swap());
    let own = Pid::from_u32(std::process::id());
    system.refresh_processes_specifics(
        ProcessesToUpdate::Some(&[own]),
        false,
        ProcessRefreshKind::nothing().with_memory(),
    );
    let process = system.process(own);
    let group = process.and_then(sysinfo::Process::cgroup_limits).as_ref().map(left_by);
    let space = process.and_then(|process| address_space()?.checked_sub(process.virtual_memory()));
    [Some(machine), group, space].into_iter().flatten().min()
}

/// What a control group leaves. Its cached files do not count: the system drops them where memory is short.
fn left_by(group: &CGroupLimits) -> u64 {
    group.total_memory.saturating_sub(group.rss)
}

/// The limit of this process' address space (`ulimit -v`).
#[cfg(unix)]
fn address_space() -> Option<u64> {
    rustix::process::getrlimit(rustix::process::Resource::As).current
}

#[cfg(not(unix))]
fn address_space() -> Option<u64> {
    None
}

/// Checks that `what` fits into `limit`, or where there is none into what is [`available`].
///
/// # Errors
/// [`ErrorKind::Memory`] says how many bytes it takes, how many are available, and how many are missing.
pub fn require(what: &str, bytes: u64, limit: Option<u64>) -> Result<()> {
    let known = limit.or_else(|| if bytes < SMALL { None } else { available() });
    match known.filter(|known| *known < bytes) {
        Some(known) => Err(short(what, bytes, Some(known))),
        None => Ok(()),
    }
}

/// The error of `what` that takes too many bytes.
fn short(what: &str, bytes: u64, available: Option<u64>) -> Error {
    let left = match available.filter(|available| *available < bytes) {
        Some(available) => format!("{available} are available, {} are missing", bytes - available),
        None => "the system refuses them".into(),
    };
    Error::new(ErrorKind::Memory, format!("{what}: {bytes} bytes ({}) are needed, {left}", readable(bytes)))
}

/// Bytes in the largest unit of which there is at least one.
pub fn readable(bytes: u64) -> String {
    let units = [(1u64 << 30, "GiB"), (1 << 20, "MiB"), (1 << 10, "KiB")];
    match units.into_iter().find(|(size, _)| bytes >= *size) {
        Some((size, unit)) => format!("{:.2} {unit}", bytes as f64 / size as f64),
        None => format!("{bytes} B"),
    }
}

fn bytes_of<X>(count: usize) -> u64 {
    (count as u64).saturating_mul(size_of::<X>() as u64)
}

/// An empty vector with room for `count` elements.
///
/// # Errors
/// [`ErrorKind::Memory`] where they do not fit.
pub fn room_for<X>(what: &str, count: usize) -> Result<Vec<X>> {
    let bytes = bytes_of::<X>(count);
    require(what, bytes, None)?;
    let mut room = Vec::new();
    room.try_reserve_exact(count).map_err(|_| short(what, bytes, available()))?;
    Ok(room)
}

/// A vector of `count` zeros, whose pages take memory when they are first written to.
///
/// # Errors
/// [`ErrorKind::Memory`] where the system refuses the address space.
pub fn zeros<X: Zeroable>(what: &str, count: usize) -> Result<Vec<X>> {
    bytemuck::allocation::try_zeroed_vec(count).map_err(|()| short(what, bytes_of::<X>(count), available()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_fit_is_refused_with_the_bytes_that_are_missing() {
        let error = require("a table", 5000, Some(4096)).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::Memory);
        assert_eq!(error.context(), "a table: 5000 bytes (4.88 KiB) are needed, 4096 are available, 904 are missing");
        require("a table", 4096, Some(4096)).unwrap();
        require("a table", SMALL - 1, None).unwrap();
        // More than any machine has.
        let error = require("a table", 1 << 55, None).unwrap_err();
        assert!(error.context().contains("(33554432.00 GiB) are needed"), "{error}");
    }

    #[test]
    fn impossible_tables_are_errors() {
        let errors = [room_for::<u64>("rows", 1 << 58).unwrap_err(), zeros::<u64>("rows", 1 << 58).unwrap_err()];
        for error in errors {
            assert_eq!(error.kind(), ErrorKind::Memory, "{error}");
        }
        assert_eq!(zeros::<u16>("rows", 3).unwrap(), [0; 3]);
        assert!(room_for::<u16>("rows", 3).unwrap().capacity() >= 3);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn this_process_has_memory_and_less_than_the_machine() {
        let bytes = available().expect("Linux tells");
        assert!(bytes > 1 << 20 && bytes < 1 << 50, "{bytes}");
    }
}
