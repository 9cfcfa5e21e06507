//! Several files of a run as one, and differences of two runs.

use crate::made::{Made, RECORDS, Values};
use crate::run::{Folder, has, scene};
use crate::watch::model::records;
use netcdf::Options;
use std::ops::Range;

/// Some of the records of a dataset, with variables that `keeps` takes.
fn part(made: &Made, range: Range<usize>, keeps: impl Fn(&str) -> bool) -> Made {
    let mut part = records(made, range);
    part.variables.retain(|variable| keeps(variable.name));
    part
}

fn is_of_mesh(name: &str) -> bool {
    ["Cell", "Vertex", "Edge", "zgrid"].iter().any(|end| name.ends_with(end))
}

fn write(folder: &Folder, name: &str, made: &Made) {
    made.write_to(&folder.at(name), Options::_64BIT_OFFSET);
}

#[test]
fn files_of_a_run_are_one_series_by_their_dates() {
    let (folder, made) = (Folder::new(), Made::history());
    write(&folder, "whole.nc", &made);
    write(&folder, "grid.nc", &part(&made, 0..0, is_of_mesh));
    write(&folder, "late.nc", &part(&made, 1..3, |name| !is_of_mesh(name) && name != "rho"));
    write(&folder, "early.nc", &part(&made, 0..1, |name| !is_of_mesh(name) && name != "rho"));
    write(&folder, "rho.nc", &part(&made, 0..3, |name| ["rho", "xtime"].contains(&name)));
    let both = scene("both", 0.0, 4000.0) + "[[derive]]\nname = \"both\"\nmagnitude = [\"theta\", \"rho\"]\n";
    folder.write("scene.toml", both);
    let parts = "rho.nc late.nc early.nc grid.nc";
    let draw = |files: &str, to: &str| {
        folder.prints(&format!("render {files} --scene scene.toml --time all --size 32x32 -o {to}"));
        (0..RECORDS).map(|step| folder.bytes(&format!("{to}/both_{step:06}.png"))).collect::<Vec<_>>()
    };
    assert!(draw(parts, "parts") == draw("whole.nc", "whole"), "the pictures differ");
    let text = folder.prints(&format!("info {parts} --ranges"));
    let times = "times      0: 2013-10-25_00:00:00, 1: 2013-10-26_00:00:00, 2: 2013-10-27_00:00:00\n";
    has(&text, &["file       rho.nc\nfile       late.nc\n", times, "2000 to 2041.5"]);
    let film = "animate late.nc early.nc grid.nc --size 32x32 --no-labels -o film.png";
    has(&folder.prints(film), &["animation film.png (32 x 32, 3 pictures, 10 per second"]);
    folder.prints("late.nc grid.nc --size 32x32 --no-labels --save-scene last.toml");
    folder.prints("early.nc grid.nc --size 32x32 --no-labels -o first.png --scene last.toml");
    let pixels = |name: &str| image::open(folder.at(name)).unwrap().into_rgba8();
    assert!(pixels("film.png") == pixels("first.png"), "the film does not begin with the first date");
    // A scene that is saved for one file names the pictures of others.
    let save = "early.nc grid.nc --size 32x32 --save-scene saved.toml";
    has(&folder.prints(save), &["picture   theta_2013-10-25_00.00.00_000000.png"]);
    has(&folder.text("saved.toml"), &["# icoray render early.nc grid.nc --scene saved.toml --time 0\n"]);
    let again = "late.nc grid.nc --scene saved.toml --time 0";
    has(&folder.prints(again), &["picture   theta_2013-10-26_00.00.00_000000.png"]);
    // A variable that is not there at all times.
    write(&folder, "theta.nc", &part(&made, 0..3, |name| ["theta", "xtime"].contains(&name)));
    write(&folder, "w.nc", &part(&made, 1..2, |name| ["w", "xtime"].contains(&name)));
    folder.prints("theta.nc w.nc grid.nc --field w --time 1");
    let parts = ["none of the files has w of time 0 (2013-10-25_00:00:00)"];
    folder.fails("theta.nc w.nc grid.nc --field w --time 0", 1, &parts);
}

#[test]
fn files_without_dates_follow_each_other_by_variable() {
    let (folder, made) = (Folder::new(), Made::history());
    write(&folder, "grid.nc", &part(&made, 0..0, is_of_mesh));
    for (name, field, records) in [("a.nc", "theta", 0..1), ("b.nc", "w", 0..2), ("c.nc", "theta", 1..3)] {
        write(&folder, name, &part(&made, records, |name| name == field));
    }
    let files = "a.nc b.nc c.nc grid.nc --size 32x32 -o x.png";
    let theta = folder.prints(&format!("{files} --field theta --time 2"));
    has(&theta, &["time 2 (no date)", "range     2000 to 2041.38"]);
    has(&folder.prints(&format!("{files} --field w --time 1")), &["range     1000 to "]);
}

#[test]
fn files_that_do_not_fit_each_other_are_named() {
    let (folder, made) = (Folder::new(), Made::history());
    write(&folder, "a.nc", &made);
    let mut other = part(&made, 1..2, |name| name != "xtime");
    write(&folder, "dateless.nc", &part(&made, 0..3, |name| name == "theta"));
    other.variable("theta").dimensions[2] = "nVertLevelsP1";
    let values = vec![0.0; other.dimension("nCells") * other.dimension("nVertLevelsP1")];
    other.variable("theta").values = Values::F64(values);
    write(&folder, "thick.nc", &other);
    let packed = |scale: f64| {
        let mut packed = part(&made, 0..1, |name| name != "theta");
        let values = Values::I32(vec![7; packed.dimension("nCells")]);
        packed.add("counts", &["Time", "nCells"], values).attributes.push(("scale_factor", scale.into()));
        packed
    };
    write(&folder, "packed1.nc", &packed(1.0));
    write(&folder, "packed2.nc", &packed(2.0));
    for (files, part) in [
        ("a.nc thick.nc", "thick.nc: theta(Time = 1, nCells = 42, nVertLevelsP1 = 5) of double, expected the dimen"),
        ("a.nc dateless.nc", "dateless.nc: its times have no dates, expected dates as in the other files"),
        ("packed1.nc packed2.nc", "packed2.nc: scale_factor of counts is another one than in the files before"),
    ] {
        folder.fails(&format!("info {files}"), 1, &[part]);
    }
}

#[test]
fn differences_of_two_runs_are_drawn() {
    let (folder, made) = (Folder::new(), Made::history());
    write(&folder, "a.nc", &made);
    let mut other = made.clone();
    other.f32s("theta").iter_mut().for_each(|value| *value -= 5.0);
    other.f64s("w")[0] = f64::NAN;
    write(&folder, "early.nc", &part(&other, 0..1, |name| name != "rho"));
    write(&folder, "late.nc", &part(&other, 1..3, |name| name != "rho"));
    let text = folder.prints("info a.nc --ranges --minus late.nc early.nc");
    let row = |name: &str| text.lines().find(|line| line.starts_with(name)).unwrap().to_owned();
    has(&row("theta "), &["Potential temperature, less late.nc", "5 to 5"]);
    has(&row("w "), &["0 to 0"]);
    assert!(!text.contains("\nrho "), "{text}");
    let draw = "a.nc --minus early.nc --field w --time 0 --size 32x32";
    has(&folder.prints(draw), &["range     0 to 0", ", 1 missing"]);
    let parts = ["early.nc: theta has no record of time 1 (2013-10-26_00:00:00)"];
    folder.fails("a.nc --minus early.nc --time 1", 1, &parts);
}
