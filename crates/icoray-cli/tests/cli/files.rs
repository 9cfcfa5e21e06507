//! The commands on small MPAS files, whose fields have the values `1000·time + column + 0.125·layer` in 42 columns.

use crate::made::{Made, RECORDS, Values};
use crate::run::{Folder, has, icoray, row, says, scene, shows_something, software};
use netcdf::Options;
use std::fs;
use std::process::Stdio;

/// A folder with `made.nc` and `scene.toml`.
pub fn folder(made: &Made, scene: &str) -> Folder {
    let folder = Folder::of(made);
    folder.write("scene.toml", scene);
    folder
}

#[test]
fn a_named_picture_is_written_and_reported() {
    let folder = folder(&Made::history(), &scene("theta", 0.0, 42.0));
    let picture = folder.at("new/er/out.png");
    let draw = "--time 0 -o new/er/out.png";
    let brief = "picture   new/er/out.png (96 x 96)\n\
                 field     theta at cells, 4 layers, time 0 (2013-10-25_00:00:00)\n\
                 range     0 to 41.375 K, 0 missing\n";
    assert_eq!(folder.prints(&format!("made.nc --scene scene.toml {draw}")), brief);
    let text = folder.render(draw);
    let expected = [
        brief,
        "error     at most ",
        "rays      ",
        "quality   tolerance 1e-3, light ",
        "sampling  1 ray per pixel; cells per pixel mean 0.",
        "seconds   open ",
        "drawn on  ",
        "left out  table corner; the far side behind the core",
    ];
    has(&text, &expected);
    assert_eq!(text.lines().count(), 10, "{text}");
    shows_something(&picture, 96, 96);
    let date = "2013-10-25_00:00:00";
    says(&picture, &[("Software", &software()), ("field", "theta"), ("step", "0"), ("date", date)]);
    assert!(!folder.at("report.csv").exists());
}

#[test]
fn the_scene_names_the_picture_where_the_command_does_not() {
    let scene = scene("theta", 2000.0, 2042.0) + "[output]\nfile = \"{field}_$Y-$M-$D_{step:03}.exr\"\n";
    let folder = folder(&Made::history(), &scene);
    let text = folder.render("--time -1 --size 64x48");
    has(&text, &["picture   theta_2013-10-27_002.exr (64 x 48)", "time 2 (2013-10-27"]);
    shows_something(&folder.at("theta_2013-10-27_002.exr"), 64, 48);
    has(&folder.text("report.csv"), &["theta_2013-10-27_002.exr"]);
}

#[test]
fn the_command_may_set_the_tolerance_and_name_the_map_of_errors() {
    let folder = folder(&Made::history(), &(scene("theta", 0.0, 42.0) + "[output]\nerror = \"e{step}.png\"\n"));
    let is_there = |name: &str| folder.at(name).exists();
    let text = folder.render("-o out.png --error map.png --tolerance 2e-5");
    has(&text, &["quality   tolerance 2e-5, light "]);
    let map = folder.at("map.png");
    says(&folder.at("out.png"), &[("tolerance", "2e-5"), ("lights", "full"), ("pixel_step", "1")]);
    says(&map, &[("field", "theta"), ("scale range", "1e-8 to 1e-1")]);
    assert_eq!(image::image_dimensions(map).unwrap(), (96, 96));
    assert!(!is_there("e0.png"));
    folder.render("--time all -o all");
    assert!(["all/e0.png", "all/e2.png", "all/theta_000002.png"].into_iter().all(is_there));
    let parts = [
        "error_max,error_mean,error_p999,tolerance,error_is_bound,pixel_step,lights,threads,",
        ",pixels_over_tolerance,",
    ];
    has(&folder.text("all/report.csv"), &parts);
}

#[test]
fn pictures_that_are_there_are_replaced_unless_they_are_to_stay() {
    let folder = folder(&Made::history(), &(scene("theta", 0.0, 42.0) + "[output]\nerror = \"e{step}.png\"\n"));
    let keep = |more: &str, there: &str| {
        let before = folder.bytes(there);
        let parts = [there, "file exists", "is there already and is not modified"];
        folder.render_fails(&format!("{more} --existing never-modify"), 1, &parts);
        assert!(folder.bytes(there) == before);
    };
    for (more, there) in [
        ("-o out.png --error map.png", "map.png"),
        ("-o one", "one/theta_000002.png"),
        ("-o all --time all", "all/theta_000000.png"),
    ] {
        folder.render(&format!("{more} --existing never-modify"));
        keep(more, there);
        folder.render(more);
    }
    // A map is a picture too, and the last time's name is known to be taken before the first time is drawn.
    fs::remove_file(folder.at("out.png")).unwrap();
    keep("-o out.png --error map.png", "map.png");
    fs::remove_file(folder.at("all/theta_000000.png")).unwrap();
    keep("-o all --time all", "all/e0.png");
    fs::remove_file(folder.at("all/e0.png")).unwrap();
    keep("-o all --time all", "all/theta_000001.png");
    assert!(!folder.at("out.png").exists() && !folder.at("all/theta_000000.png").exists());
    folder.write("out.png", "no picture");
    folder.render("-o out.png");
    shows_something(&folder.at("out.png"), 96, 96);
}

#[test]
fn other_files_that_are_there_stay_where_they_are_to() {
    let folder = Folder::of(&Made::history());
    for (line, file) in [
        ("sample", "mine.nc"),
        ("colormaps -o", "mine.png"),
        ("animate made.nc -o", "mine.mp4"),
        ("made.nc --save-scene", "mine.toml"),
    ] {
        folder.write(file, "mine");
        folder.fails(&format!("{line} {file} --existing never-modify"), 1, &[file, "is there already"]);
        assert_eq!(folder.text(file), "mine");
    }
}

#[test]
fn a_picture_that_cannot_be_written_stops_the_command() {
    let names = "[output]\nfile = \"{field}/$D/x.png\"\n";
    let folder = folder(&Made::history(), &(scene("theta", 0.0, 42.0) + names));
    let stops = |parts: &[&str]| {
        folder.render_fails("--time all --size 8x8", 1, parts);
    };
    fs::create_dir(folder.at("theta")).unwrap();
    folder.write("theta/26", "");
    stops(&["theta/26/x.png: cannot write the file: Not a directory"]);
    fs::remove_file(folder.at("theta/26")).unwrap();
    std::os::unix::fs::symlink("nowhere", folder.at("theta/26")).unwrap();
    stops(&["theta/26/x.png: cannot write to the folder ", "theta/26: No such file"]);
    assert!(!folder.at("theta/25").exists(), "known before the first time is drawn");
}

#[test]
fn the_number_of_threads_does_not_change_the_picture() {
    let folder = folder(&Made::history(), &scene("theta", 0.0, 42.0));
    for threads in ["1", "3"] {
        let text = folder.render(&format!("--threads {threads} -o {threads}.exr"));
        has(&text, &[&format!("({threads} threads)")]);
    }
    assert!(folder.bytes("1.exr") == folder.bytes("3.exr"), "the pictures differ");
}

#[test]
fn corner_fields_and_terrain_are_noted() {
    let mut made = Made::history();
    // One column's second interface is 40 m higher: 40·41/42 above the mean.
    made.f32s("zgrid")[1] += 40.0;
    let folder = folder(&made, &scene("vorticity", 0.0, 80.0));
    let text = folder.render("-o out.png");
    let bytes = 42 * 4 * 8;
    has(
        &text,
        &[
            &format!("vorticity is at corners: averaged to cell centres (derived, {bytes} bytes)"),
            "concentric mean heights are rendered; columns deviate by up to 39.0 m",
            "field     vorticity at corners",
        ],
    );
    let picture = folder.at("out.png");
    shows_something(&picture, 96, 96);
    let note = "concentric mean heights are rendered; columns deviate by up to 39.0 m (heights = \"native\" in the scene \
                shows each column's own)";
    says(&picture, &[("note", note)]);
}

#[test]
fn info_lists_the_contents_of_a_file() {
    let mut made = Made::history();
    made.add("vn", &["Time", "nEdges"], Values::F64(vec![1.0; RECORDS * 120]));
    let folder = Folder::of_netcdf4(&made);
    let text = folder.prints("info made.nc");
    let parts = [
        "MPAS: 42 cells, 80 corners, 120 edges",
        "12 with 5 corners, 30 with 6 corners",
        "radius     6371229 m",
        "positions  f32",
        "passes the check",
        "0: 2013-10-25_00:00:00, 1: 2013-10-26_00:00:00, 2: 2013-10-27_00:00:00",
        "4 between 5 interfaces (zgrid): from 0.0 m to 9000.0 m, 100.0 to 7500.0 m apart",
        "5 on heights (zgrid): from 0.0 m to 9000.0 m",
        "heights = \"native\" in a scene shows zgrid of each column\n",
        "Potential temperature",
    ];
    has(&text, &parts);
    assert_eq!(row(&text, "theta"), ["theta", "cells", "4", "f32", "K", "Potential", "temperature"]);
    assert_eq!(row(&text, "vorticity"), ["vorticity", "corners", "4", "f64", "-", "-"]);
    assert_eq!(row(&text, "vn_zonal")[..7], ["vn_zonal", "cells,", "from", "edges", "1", "f64", "-"]);
    // The last time is 2, and w has five layers.
    has(&folder.prints("info made.nc --ranges"), &["range at the last time", "2000 to 2041.5"]);
}

#[test]
fn info_goes_on_where_grid_and_layers_are_bad() {
    let mut made = Made::mesh(false);
    made.i32s("cellsOnVertex")[4] = 0;
    let folder = Folder::of(&made);
    has(&folder.prints("info made.nc"), &["grid       ", "bad grid", "cells in common", "fields     none"]);
}

#[test]
fn plan_prints_the_data_that_are_left_out() {
    let dark = scene("theta", 0.0, 42.0).replace("\"headlight\"", "\"none\"");
    let folder = folder(&Made::history(), &dark);
    let text = folder.prints("plan made.nc --scene scene.toml");
    let bytes = 42 * 4 * 4;
    let read = format!("read: theta at cells, 4 layers ({bytes} bytes each time)\n");
    has(&text, &[&read, "left out: gradients (", "left out: table corner\n", "left out: native heights\n"]);
    assert_eq!(text.matches("read: ").count(), 1, "{text}");
    has(&text, &["cells per pixel: mean 0."]);
    has(&text, &["\nmemory: ", "beside the model's arrays: tables of the grid ", "picture "]);
    assert!(!text.contains("hint"), "{text}");
}

#[test]
fn samples_are_suggested_and_taken_where_cells_are_many() {
    let folder = folder(&Made::history(), &scene("theta", 0.0, 42.0));
    // The whole globe in one pixel.
    let text = folder.render("--size 1x1 -o out.png");
    has(&text, &["sampling  1 ray per pixel; cells", "hint      ", "; samples = "]);
    let plan = folder.prints("plan made.nc --scene scene.toml --size 1x1");
    has(&plan, &["cells per pixel: mean ", "hint: "]);
    let text = folder.render("--size 1x1 -o out.png --samples 8");
    has(&text, &[" rays per pixel, error of their mean "]);
    assert!(!text.contains("hint"), "{text}");
    says(&folder.at("out.png"), &[("step", "2")]);
}

#[test]
fn a_reader_that_goes_away_is_no_error() {
    let folder = Folder::of(&Made::history());
    let mut info = icoray(folder.path());
    let mut child = info.args(["info", "made.nc"]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success() && output.stderr.is_empty(), "{output:?}");
}

#[test]
fn options_give_facts_that_a_file_lacks() {
    let mut made = Made::history();
    made.dimensions.push(("nCategories", 3));
    made.add("ice", &["nCells", "nCategories"], Values::F64((0..126).map(|i| f64::from(i % 3)).collect()));
    made.f32s("theta")[336] = -999.0;
    let folder = folder(&made, "");
    let options = "--at nCategories=2 --heights 0..-300 --radius 1e6 --missing -999";
    let text = folder.prints(&format!("made.nc --field ice {options} --save-scene ice.toml --size 64x48 -o ice.png"));
    has(&text, &["field     ice at cells, 2D", "range     2 to 2"]);
    let scene = folder.text("ice.toml");
    has(&scene, &["--at nCategories=2 --heights 0..-300 --radius 1000000 --missing -9.99e2 --scene ice.toml"]);
    let text = folder.prints(&format!("info made.nc --ranges {options}"));
    has(&text, &["radius     1000000 m", "4 on heights (heights): from 0.0 m to -300.0 m", "to 2041.38 (1 missing)"]);
    folder.fails("made.nc --field ice", 1, &["no heights for the 3 layers of ice", "`heights` says"]);
    folder.fails("made.nc --at nCategories=3", 1, &["at nCategories=3: nCategories has 3 entries"]);
    folder.fails("made.nc --at nCategories", 2, &["--at", "expected"]);
    folder.fails("made.nc --heights 5..5", 2, &["--heights", "expected"]);
}

#[test]
fn info_lists_the_variables_of_a_file_without_a_mesh() {
    let mut made = Made::of([("time", 0), ("n_node", 162)], []);
    made.add("sst", &["time", "n_node"], Values::F32(vec![0.0; 162]));
    made.last().attributes = vec![("long_name", "sea surface temperature".into()), ("units", "C".into())];
    let folder = folder(&made, "");
    let text = folder.prints("info made.nc");
    has(&text, &["file       made.nc", "sst(time = 1, n_node = 162) of float  sea surface temperature  [C]"]);
    has(&text, &["mesh       bad grid: made.nc: no mesh is known of sst(time = 1, n_node = 162) of float"]);
    Made::mesh(true).write_to(&folder.at("mesh.nc"), Options::_64BIT_OFFSET);
    let parts = ["no variable lies on the mesh of", "42 cells (nCells) or 80 vertices (nVertices)", "sst(time = 1,"];
    folder.fails("render made.nc --mesh mesh.nc", 1, &parts);
}
