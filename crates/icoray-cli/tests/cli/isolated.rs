//! Damaged NetCDF-4 files, which may end or hang the process that reads them inside HDF5.

use crate::made::Made;
use crate::run::{Folder, icoray, wait_until};
use icoray_test_support::Random;
use std::fs;
use std::io::Read;
use std::path::Path;
use std::process::Command;

/// The child of a command, once it has one.
fn child_of(command: u32) -> String {
    let children = format!("/proc/{command}/task/{command}/children");
    fs::read_to_string(children).unwrap().trim().to_owned()
}

/// Signals by which HDF5 ends a process; the necessary damage depends on its version.
#[test]
fn the_end_of_the_reading_process_is_an_error() {
    let folder = Folder::of_netcdf4(&Made::history());
    for signal in ["ABRT", "FPE"] {
        let mut view = folder.view(&[]).into_child();
        let child = child_of(view.id());
        // The shell has this command itself: not every machine has it as a program.
        assert!(Command::new("sh").args(["-c", &format!("kill -s {signal} {child}")]).status().unwrap().success());
        assert_eq!(view.wait().unwrap().code(), Some(1));
        let mut complaint = String::new();
        view.stderr.take().unwrap().read_to_string(&mut complaint).unwrap();
        let parts = ["icoray: error: ", "made.nc", "usually in the HDF5 library", signal];
        assert!(parts.iter().all(|part| complaint.contains(part)) && complaint.lines().count() == 1, "{complaint}");
    }
}

/// Classic files are read in the command's own process: damage of them is an error.
#[test]
fn netcdf_4_files_have_a_reading_process_that_ends_with_its_parent() {
    for (folder, has_child) in [(Folder::of_netcdf4(&Made::history()), true), (Folder::of(&Made::history()), false)] {
        let mut view = folder.view(&[]).into_child();
        let child = child_of(view.id());
        view.kill().unwrap();
        view.wait().unwrap();
        assert_eq!(!child.is_empty(), has_child, "{child:?}");
        wait_until("the child goes on", || !has_child || !Path::new("/proc").join(&child).exists());
    }
}

/// A file with some bytes of its structure overwritten.
fn damaged(whole: &[u8], seed: u64) -> Vec<u8> {
    let (mut bytes, mut random) = (whole.to_vec(), Random::new(seed));
    for _ in 0..=random.below(4) {
        let at = random.below(bytes.len());
        bytes[at] = [0, 1, 0x7f, 0x80, 0xff][random.below(5)];
    }
    bytes
}

/// Whether a command succeeded without a word, or failed with one line.
fn ends_in_one_line(folder: &Folder, line: &str) -> Result<bool, String> {
    let output = icoray(folder.path()).args(line.split(' ')).output().unwrap();
    let complaint = String::from_utf8(output.stderr).unwrap();
    let is_error = complaint.starts_with("icoray: error: ") && complaint.lines().count() == 1;
    match output.status.code() {
        Some(0) if complaint.is_empty() => Ok(true),
        Some(1) if is_error => Ok(false),
        _ => Err(format!("{}: {complaint}", output.status)),
    }
}

/// Damages `made.nc` and runs commands, each of which must end well or with one line.
fn check_damaged(folder: &Folder, seeds: impl IntoIterator<Item = u64>, lines: &[&str]) {
    let whole = folder.bytes("made.nc");
    for seed in seeds {
        folder.write("made.nc", damaged(&whole, seed));
        for line in lines {
            let ended = ends_in_one_line(folder, line);
            assert!(ended.is_ok(), "{seed}: {line}: {ended:?}");
        }
    }
}

/// The first four end the process that reads them inside HDF5 1.10.8.
#[test]
fn damaged_files_end_in_one_line() {
    let folder = Folder::of_netcdf4(&Made::history());
    let lines = ["info made.nc --ranges", "plan made.nc", "render made.nc -o a.png"];
    check_damaged(&folder, [112, 163, 185, 206, 1, 2, 3, 4], &lines);
}

/// The same of a mesh that the files of a directory share, which is read before any of them comes.
#[test]
fn a_damaged_mesh_ends_a_watch_in_one_line() {
    let folder = Folder::of_netcdf4(&Made::mesh(true));
    fs::create_dir(folder.at("run")).unwrap();
    folder.write("scene.toml", "field = \"theta\"\n");
    let watch = "watch run --scene scene.toml --once --settle 0 --mesh made.nc";
    assert_eq!(ends_in_one_line(&folder, watch), Ok(true));
    let whole = folder.bytes("made.nc");
    folder.write("made.nc", &whole[..whole.len() / 2]);
    assert_eq!(ends_in_one_line(&folder, watch), Ok(false));
    folder.write("made.nc", whole);
    check_damaged(&folder, 0..8, &[watch]);
}
