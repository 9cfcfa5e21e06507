//! Wrong input and wrong usage: an exit code, one line with the fault, and no picture.

use crate::files::folder;
use crate::made::Made;
use crate::run::scene;

/// Renders with `more` arguments, which must fail and leave no picture.
#[track_caller]
fn refused(scene: &str, more: &[&str], code: i32, parts: &[&str]) {
    let folder = folder(&Made::history(), scene);
    folder.render_fails(more, code, parts);
    let left = folder.count();
    assert_eq!(left, 2, "files in the folder: made.nc, scene.toml and no more");
}

#[test]
fn unknown_fields_list_those_that_there_are() {
    let parts = ["made.nc", "there is no field thita", "zgrid, theta, w, vorticity, rho"];
    refused(&scene("thita", 0.0, 1.0), &[], 1, &parts);
}

#[test]
fn scene_errors_show_file_and_line() {
    let bad = scene("theta", 0.0, 1.0).replace("map = \"viridis\"", "map = \"viridian\"");
    refused(&bad, &[], 1, &["scene.toml", "line 13", "transfer.map", "viridis"]);
    let folder = folder(&Made::history(), "");
    let parts = ["none.toml", "cannot read the scene"];
    folder.fails(["render", "made.nc", "--scene", "none.toml"], 1, &parts);
}

#[test]
fn times_and_layers_that_there_are_not() {
    for time in ["3", "-4", "9223372036854775807", "-9223372036854775808", "2..4"] {
        let of = format!("--time={time}");
        refused(&scene("theta", 0.0, 1.0), &[&of], 1, &[&format!("--time {time}: expected -3 to 2")]);
    }
    let none = "--time 2014-01: no time of the file, which has 2013-10-25_00:00:00 to 2013-10-27_00:00:00";
    refused(&scene("theta", 0.0, 1.0), &["--time", "2014-01"], 1, &[none]);
    for layers in ["0..5", "3..", "2..2", "..1", "5..2"] {
        let said = ["layers ", ": expected at least 2 of the 4 layers of theta"];
        refused(&scene("theta", 0.0, 1.0), &["--layers", layers], 1, &said);
    }
}

#[test]
fn several_times_need_several_names() {
    let good = scene("theta", 0.0, 1.0);
    refused(&good, &["--time", "all", "-o", "one.png"], 1, &["one.png", "expected a directory"]);
    let same = good.clone() + "[output]\nfile = \"same.png\"\n";
    refused(&same, &["--time", "all"], 1, &["output.file", "times 0 and 1 both \"same.png\"", "{step}"]);
    refused(&good, &["-o", "one.jpg"], 1, &["one.jpg", ".png or .exr"]);
    refused(&good, &["-o", "made.nc/one.png"], 1, &["made.nc/one.png: cannot write the file: Not a directory"]);
    refused(&good, &["-o", "/proc/no/one.png"], 1, &["/proc/no: cannot make the directory"]);
    refused(&good, &["-o", "one.png", "--error", "/proc/map.png"], 1, &["/proc/map.png: cannot write to the folder"]);
}

#[test]
fn maps_of_errors_that_cannot_be_written() {
    let good = scene("theta", 0.0, 1.0);
    refused(&good, &["--error", "map.exr"], 1, &["--error map.exr", "expected a name that ends in .png"]);
    refused(&good, &["--error", "map.png", "--time", "all"], 1, &["--error map.png", "output.error"]);
    for more in [&["--error", "./one.png", "-o", "one.png"][..], &["--error", "theta_000002.png"]] {
        refused(&good, more, 1, &[&format!("--error {}: names the picture too", more[1])]);
    }
    let same = good + "[output]\nerror = \"same.png\"\n";
    refused(&same, &["--time", "all"], 1, &["output.error", "times 0 and 1 both \"same.png\"", "{step}"]);
}

#[test]
fn wrong_usage_exits_with_2() {
    let good = scene("theta", 0.0, 1.0);
    for (option, values) in [
        ("--size", "0x9 64"),
        ("--time", "now 0..2013-10"),
        ("--layers", "3"),
        ("--colour", "red"),
        ("--tolerance", "0 -1 nan 1"),
    ] {
        values.split(' ').for_each(|value| refused(&good, &[option, value], 2, &[option]));
    }
    let folder = folder(&Made::history(), &good);
    folder.fails(["render"], 2, &["FILE.nc"]);
    folder.fails([""; 0], 2, &["Usage: icoray"]);
}

/// They would all write the same pictures.
#[cfg(not(feature = "mpi"))]
#[test]
fn ranks_without_mpi_are_refused() {
    use crate::run::{fails, icoray};
    let folder = folder(&Made::history(), &scene("theta", 0.0, 42.0));
    for name in ["OMPI_COMM_WORLD_SIZE", "PMI_SIZE"] {
        let mut command = icoray(folder.path());
        command.args(["render", "made.nc", "--scene", "scene.toml"]).env(name, "2");
        fails(&mut command, 1, &["2 ranks were started", "--features mpi"]);
    }
}

#[test]
fn files_that_are_none() {
    let folder = folder(&Made::history(), &scene("theta", 0.0, 1.0));
    for name in ["scene.toml", "absent.nc"] {
        folder.fails(["info", name], 1, &[name]);
    }
}
