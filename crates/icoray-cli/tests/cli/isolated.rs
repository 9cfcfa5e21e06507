//! Damaged NetCDF-4 files, which may end or hang the process that reads them inside HDF5.

use crate::made::Made;
use crate::run::icoray;
use crate::viewer::Viewer;
use icoray_test_support::PATIENCE;
use netcdf::Options;
use std::fs;
use std::io::Read;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

/// The child of a command, once it has one.
fn child_of(command: u32) -> String {
    let children = format!("/proc/{command}/task/{command}/children");
    fs::read_to_string(children).unwrap().trim().to_owned()
}

fn wait_until(what: &str, holds: impl Fn() -> bool) {
    let start = Instant::now();
    while !holds() {
        assert!(start.elapsed() < PATIENCE, "{what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// By signals of which HDF5 ends a process, whatever damage that takes in its version.
#[test]
fn the_end_of_the_reading_process_is_an_error() {
    let (folder, _) = Made::history().write(Options::NETCDF4);
    for signal in ["ABRT", "FPE"] {
        let mut view = Viewer::start(icoray(folder.path()).args(["view", "made.nc"])).into_child();
        let child = child_of(view.id());
        assert!(Command::new("kill").args(["-s", signal, &child]).status().unwrap().success());
        assert_eq!(view.wait().unwrap().code(), Some(1));
        let mut complaint = String::new();
        view.stderr.take().unwrap().read_to_string(&mut complaint).unwrap();
        let parts = ["icoray: error: ", "made.nc", "mostly by the HDF5 library", signal];
        assert!(parts.iter().all(|part| complaint.contains(part)) && complaint.lines().count() == 1, "{complaint}");
    }
}

#[test]
fn the_reading_process_ends_with_its_parent() {
    let (folder, _) = Made::history().write(Options::NETCDF4);
    let mut view = Viewer::start(icoray(folder.path()).args(["view", "made.nc"])).into_child();
    let child = format!("/proc/{}", child_of(view.id()));
    assert!(Path::new(&child).exists());
    view.kill().unwrap();
    view.wait().unwrap();
    wait_until("the child goes on", || !Path::new(&child).exists());
}

/// Classic files are read in the command's own process: damage of them is an error.
#[test]
fn classic_files_need_no_other_process() {
    let (folder, _) = Made::history().write(Options::_64BIT_OFFSET);
    let view = Viewer::start(icoray(folder.path()).args(["view", "made.nc"])).into_child();
    assert_eq!(child_of(view.id()), "");
}
