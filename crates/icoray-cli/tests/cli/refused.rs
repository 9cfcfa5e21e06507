//! Wrong input and wrong usage: an exit code, one line with the fault, and no picture.

use crate::files::folder;
use crate::made::Made;
use crate::run::scene;

/// How commands begin that draw with the scene and without one.
const DRAW: &str = "render made.nc --scene scene.toml";
const ALONE: &str = "render made.nc";

/// Runs commands, each of which must fail with the code, say the parts, and leave no file.
#[track_caller]
fn refused(scene: &str, command: &str, cases: &[(&str, i32, &[&str])]) {
    let folder = folder(&Made::history(), scene);
    for (options, code, parts) in cases {
        folder.fails(&format!("{command} {options}"), *code, parts);
        assert_eq!(folder.count(), 2, "{options}: made.nc, scene.toml and no more");
    }
}

#[test]
fn scenes_that_do_not_fit_the_file() {
    let good = scene("theta", 0.0, 1.0);
    let known = "zgrid, theta, w, vorticity, rho";
    for (more, options, parts) in [
        ("[[views]]\nname = \"b\"\nfield = \"thita\"\n", "", &["made.nc", "there is no field thita", known][..]),
        ("[[views]]\nname = \"a\"\nwhen = \"max(voticity) > 1\"\n", "", &["there is no field voticity", known]),
        ("[sweep]\nfield = [\"theta\", \"rhu\"]\n", "", &["there is no field rhu", known]),
        ("[sweep]\nlon = [0, 90]\n", "--lat 3", &["--lon, --lat, --distance: sweep places the camera"]),
        ("[sweep]\nlon = [0, 9]\n", "-o one.png", &["-o one.png: one name for 2 pictures; expected a directory"]),
        ("[output]\nfile = \"a.png\"\n", "--time all", &["output.file", "times 0 and 1 both \"a.png\"", "{step}"]),
        ("[output]\nerror = \"a.png\"\n", "--time all", &["output.error", "times 0 and 1 both \"a.png\"", "{step}"]),
    ] {
        refused(&format!("{good}{more}"), DRAW, &[(options, 1, parts)]);
    }
    let unknown = ["made.nc", "there is no field thita", known];
    refused(&scene("thita", 0.0, 1.0), DRAW, &[("", 1, &unknown)]);
    let line = ["scene.toml", "line 13", "transfer.map", "viridis"];
    refused(&good.replace("\"viridis\"", "\"viridian\""), DRAW, &[("", 1, &line)]);
    refused(&good, ALONE, &[("--scene none.toml", 1, &["none.toml", "cannot read the scene"])]);
}

#[test]
fn options_that_do_not_fit_the_file_or_the_scene() {
    let good = scene("theta", 0.0, 1.0);
    for time in ["3", "-4", "9223372036854775807", "-9223372036854775808", "2..4"] {
        refused(&good, DRAW, &[(&format!("--time={time}"), 1, &[&format!("--time {time}: expected -3 to 2")])]);
    }
    for layers in ["0..5", "3..", "2..2", "..1", "5..2"] {
        let said = ["layers ", ": expected at least 2 of the 4 layers of theta"];
        refused(&good, DRAW, &[(&format!("--layers {layers}"), 1, &said)]);
    }
    let none = "--time 2014-01: no time of the file, which has 2013-10-25_00:00:00 to 2013-10-27_00:00:00";
    let written = "made.nc/one.png: cannot write the file: Not a directory";
    refused(
        &good,
        DRAW,
        &[
            ("--time 2014-01", 1, &[none]),
            ("--time all -o one.png", 1, &["one.png", "expected a directory"]),
            ("-o one.jpg", 1, &["one.jpg", ".png or .exr"]),
            ("-o made.nc/one.png", 1, &[written]),
            ("-o /proc/no/one.png", 1, &["/proc/no: cannot make the directory"]),
            ("-o one.png --error /proc/map.png", 1, &["/proc/map.png: cannot write to the folder"]),
            ("--error map.exr", 1, &["--error map.exr", "expected a name that ends in .png"]),
            ("--error map.png --time all", 1, &["--error map.png", "output.error"]),
            ("--error ./one.png -o one.png", 1, &["--error ./one.png: names the picture too"]),
            ("--error theta_000002.png", 1, &["--error theta_000002.png: names the picture too"]),
            ("--samples 65", 2, &["--samples", "65", "1..=64"]),
            ("--backend vulkan", 2, &["auto, cpu, gpu"]),
            ("--colormap vik", 2, &["--colormap", "cannot be used with", "--scene"]),
            ("--range 0..1", 2, &["--range", "cannot be used with", "--scene"]),
            ("--save-scene s.toml", 2, &["--save-scene", "cannot be used with", "--scene"]),
        ],
    );
    refused(
        &good,
        ALONE,
        &[
            ("--surface 4", 1, &["surface on layer 4, expected 0 to 3"]),
            ("--field thita", 1, &["--field thita", "no field thita (did you mean \"theta\"?); fields in the file: "]),
            ("--save-scene made.nc/s.toml", 1, &["--save-scene: made.nc/s.toml"]),
            ("--field surface_pressure --isosurface 3", 1, &["isosurface 3: surface_pressure is a 2D field"]),
            ("--field surface_pressure --surface 1", 1, &["surface 1: surface_pressure is a 2D field, expected 0"]),
            (
                "--field surface_pressure --layers 0..2",
                1,
                &["layers 0..2: surface_pressure is a 2D field, expected a field with layers"],
            ),
        ],
    );
    refused(&good, "sample", &[("made.nc/a.nc", 1, &["made.nc/a.nc: cannot write the file"])]);
    // A page has the scene of the file.
    let beside = "expected no such option beside --scene";
    let view = "view made.nc --scene scene.toml";
    refused(&good, view, &[("--lon 3", 1, &["--lon", beside]), ("--backend cpu", 1, &["--backend", beside])]);
    refused(&good, "watch . --scene scene.toml --live", &[("--lon 3", 1, &["--lon", beside])]);
}

#[test]
fn wrong_usage_exits_with_2() {
    let good = scene("theta", 0.0, 1.0);
    for (option, values, part) in [
        ("--size", "0x9 64", ""),
        ("--time", "now 0..2013-10", ""),
        ("--layers", "3", ""),
        ("--tolerance", "0 -1 nan 1", ""),
        ("--lat", "95", "expected a number from -90 to 90"),
        ("--lon", "west", "expected a number from -360 to 360"),
        ("--distance", "0", "expected a number from"),
        ("--exaggeration", "-3", "expected a number from"),
        ("--range", "3..1", "the lower first"),
        ("--colormap", "jet2", "viridis"),
        ("--surface", "-1", "from 0, the innermost"),
        ("--background", "mauvish", "expected an opaque CSS colour"),
        ("--light", "sun", "longitude and latitude below a sun"),
    ] {
        for value in values.split(' ') {
            refused(&good, ALONE, &[(&format!("{option} {value}"), 2, &[option, value, part])]);
        }
    }
    refused(&good, "render", &[("", 2, &["FILE.nc"]), ("made.nc --colour red", 2, &["--colour"])]);
    refused(&good, "", &[("", 2, &["Usage: icoray"])]);
    let hint = "icoray: the studies are a program of their own: icoray-study speed --quick\n";
    refused(&good, "study", &[("speed --quick", 2, &[hint])]);
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
    for name in ["scene.toml", "absent.nc"] {
        refused(&scene("theta", 0.0, 1.0), "info", &[(name, 1, &[name])]);
    }
}
