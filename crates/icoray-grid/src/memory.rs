//! The memory that this process can still allocate, and errors for tables that exceed it.

use crate::error::{Error, ErrorKind, Result};
use bytemuck::Zeroable;
use std::fs::read_to_string;
use std::path::Path;
use sysinfo::{MemoryRefreshKind, Pid, ProcessRefreshKind, ProcessesToUpdate, RefreshKind, System};

/// Bytes below which available memory is not checked: the check takes longer than such an allocation.
const SMALL: u64 = 64 << 20;

/// Bytes that this process can still allocate: the least of the machine's free memory and the rest of the limits of its
/// control group (containers, batch jobs) and its address space. `None` if the system does not report it.
///
/// ```
/// let available = icoray_grid::memory::available();
/// assert!(available.is_none_or(|bytes| bytes > 0));
/// ```
pub fn available() -> Option<u64> {
    available_to_each(1)
}

/// As [`available`], where this many processes of the machine share its memory and that of the control group.
fn available_to_each(processes: u64) -> Option<u64> {
    let asked = RefreshKind::nothing().with_memory(MemoryRefreshKind::everything());
    let system = System::new_with_specifics(asked);
    let machine = system.available_memory().saturating_add(system.free_swap());
    let space = address_space().and_then(|limit| limit.checked_sub(virtual_memory()?));
    // sysinfo reads the limits of the root of the hierarchy only, from 0.39 on those of the process, for Rust 1.95.
    let group = left_by_control_groups(Path::new("/"));
    let shared = [Some(machine), group].into_iter().flatten().min();
    shared.map(|bytes| bytes / processes).into_iter().chain(space).min()
}

/// Bytes of this process' address space that are taken.
fn virtual_memory() -> Option<u64> {
    let own = Pid::from_u32(std::process::id());
    let memory_alone = ProcessRefreshKind::nothing().with_memory().without_tasks();
    let mut system = System::new();
    system.refresh_processes_specifics(ProcessesToUpdate::Some(&[own]), false, memory_alone);
    system.process(own).map(sysinfo::Process::virtual_memory)
}

/// Bytes that the control groups of this process and all groups above them leave, versions 1 and 2; `None` without a
/// limit. `root` is the folder that contains `proc` and `sys`.
fn left_by_control_groups(root: &Path) -> Option<u64> {
    let groups = read_to_string(root.join("proc/self/cgroup")).ok()?;
    let left = groups.lines().filter_map(|line| {
        // number:controllers:path
        let [_, controllers, path] = line.splitn(3, ':').collect::<Vec<_>>().try_into().ok()?;
        let path = path.trim_start_matches('/');
        match controllers.split(',').find(|controller| matches!(*controller, "" | "memory"))? {
            "" => left_by_group(&root.join("sys/fs/cgroup"), path, "memory.max", ["anon ", "shmem "]),
            _ => {
                let used = ["total_rss ", "total_shmem "];
                left_by_group(&root.join("sys/fs/cgroup/memory"), path, "memory.limit_in_bytes", used)
            }
        }
    });
    left.min()
}

/// The least number of bytes that a group in the hierarchy `mount` and the groups above it leave beside what these count
/// as `used`: memory of processes, and memory that they share. Their cached files do not count: the system drops them
/// when memory is short.
fn left_by_group(mount: &Path, path: &str, limit: &str, used: [&str; 2]) -> Option<u64> {
    let group = mount.join(path);
    let folders = group.ancestors().take_while(|folder| folder.starts_with(mount));
    let left = folders.filter_map(|folder| {
        let limit: u64 = read_to_string(folder.join(limit)).ok()?.trim().parse().ok()?;
        let statistics = read_to_string(folder.join("memory.stat")).ok()?;
        let of = |name: &str| statistics.lines().find_map(|line| line.strip_prefix(name)?.parse::<u64>().ok());
        Some(limit.saturating_sub(of(used[0])? + of(used[1]).unwrap_or(0)))
    });
    left.min()
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

/// Checks that `what` fits into `limit` or, without one, into the [`available`] memory.
///
/// # Errors
/// [`ErrorKind::Memory`] states the bytes needed, available and missing.
pub fn require(what: &str, bytes: u64, limit: Option<u64>) -> Result<()> {
    require_each(what, bytes, limit, 1)
}

/// As [`require`], in each of a number of processes of this machine that allocate as much at once: without a limit they
/// have equal shares of the available memory.
///
/// # Errors
/// As [`require`].
pub fn require_each(what: &str, bytes: u64, limit: Option<u64>, processes: usize) -> Result<()> {
    let processes = processes as u64;
    let is_small = bytes.saturating_mul(processes) < SMALL;
    let each = format!("{what}, in each of {processes} processes of this machine");
    let what = if limit.is_none() && processes > 1 { &each } else { what };
    let known = limit.or_else(|| if is_small { None } else { available_to_each(processes) });
    match known.filter(|known| *known < bytes) {
        Some(known) => Err(short(what, bytes, Some(known))),
        None => Ok(()),
    }
}

/// The error for `what`, which needs too many bytes.
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
/// [`ErrorKind::Memory`] if they do not fit.
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
/// [`ErrorKind::Memory`] if the system refuses the address space.
pub fn zeros<X: Zeroable>(what: &str, count: usize) -> Result<Vec<X>> {
    bytemuck::allocation::try_zeroed_vec(count).map_err(|()| short(what, bytes_of::<X>(count), available()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_that_do_not_fit_are_refused_with_the_missing_bytes() {
        let error = require("a table", 5000, Some(4096)).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::Memory);
        assert_eq!(error.context(), "a table: 5000 bytes (4.88 KiB) are needed, 4096 are available, 904 are missing");
        require("a table", 4096, Some(4096)).unwrap();
        require_each("a table", 4096, Some(4096), 8).unwrap();
        require("a table", SMALL - 1, None).unwrap();
        // More than any machine has.
        if let Some(available) = available() {
            let error = require_each("a table", available / 2, None, 1000).unwrap_err();
            assert!(error.context().starts_with("a table, in each of 1000 processes of this machine: "), "{error}");
        }
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

    /// A limit of a batch job is that of a group above the process' own, which has none.
    #[test]
    fn control_groups_leave_the_least_of_all_above_them() {
        let root = std::env::temp_dir().join(format!("icoray-groups-{}", std::process::id()));
        let write = |path: &str, text: &str| {
            let path = root.join(path);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        };
        assert_eq!(left_by_control_groups(&root), None);
        write("proc/self/cgroup", "0::/job/step/user\n");
        assert_eq!(left_by_control_groups(&root), None);
        for (group, limit) in [("job/step/user", "max"), ("job/step", "9000"), ("job", "5000")] {
            write(&format!("sys/fs/cgroup/{group}/memory.max"), &format!("{limit}\n"));
            write(&format!("sys/fs/cgroup/{group}/memory.stat"), "file 4000\nanon 900\nshmem 100\n");
        }
        assert_eq!(left_by_control_groups(&root), Some(4000));
        // In a container the group's path is that of the host, and its limit is at the root.
        write("proc/self/cgroup", "5:cpu,memory:/host/id\n1:pids:/host/id\n");
        write("sys/fs/cgroup/memory/memory.limit_in_bytes", "3000\n");
        write("sys/fs/cgroup/memory/memory.stat", "rss 1\ntotal_rss 400\ntotal_shmem 100\n");
        assert_eq!(left_by_control_groups(&root), Some(2500));
        std::fs::remove_dir_all(&root).unwrap();
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn this_process_has_memory_and_less_than_the_machine() {
        let bytes = available().expect("Linux reports it");
        assert!(bytes > 1 << 20 && bytes < 1 << 50, "{bytes}");
    }
}
