//! `icoray render` on several ranks of MPI: one picture, which one rank writes, byte by byte that of a process alone.

use crate::files::folder;
use crate::heights::{hills, native, two};
use crate::made::Made;
use crate::run::{has, scene};
use icoray_test_support::{Need, has_tool};
use std::path::Path;
use std::process::Output;

/// Runs `icoray render` on so many ranks. If there is no mpirun, skips the test.
fn on_ranks(ranks: usize, folder: &Path, more: &[&str]) -> Option<Output> {
    if !has_tool(Need::Mpi, "mpirun") {
        return None;
    }
    let mut run = icoray_test_support::on_ranks("mpirun", ranks, folder);
    run.env("HDF5_USE_FILE_LOCKING", "FALSE");
    run.arg(env!("CARGO_BIN_EXE_icoray")).args(["render", "made.nc", "--scene", "scene.toml", "-v"]).args(more);
    Some(run.output().unwrap())
}

/// What ranks print that draw as they should. If there is no mpirun, skips the test.
fn draw_on(ranks: usize, folder: &Path, more: &[&str]) -> Option<String> {
    let output = on_ranks(ranks, folder, more)?;
    let [said, complaint] = [output.stdout, output.stderr].map(|said| String::from_utf8(said).unwrap());
    assert!(output.status.success(), "{said}{complaint}");
    Some(said)
}

#[test]
fn ranks_draw_each_picture_of_a_series_together() {
    let folder = folder(&Made::history(), &scene("vorticity", 0.0, 2080.0));
    folder.render("--time all -o alone --threads 1");
    for ranks in [1, 2, 3] {
        let to = format!("of {ranks}");
        let more = ["--time", "all", "-o", &to, "--threads", "1"];
        let Some(said) = draw_on(ranks, folder.path(), &more) else { return };
        assert_eq!(said.matches("picture ").count(), 3, "{said}");
        assert_eq!(said.matches("note ").count(), 1, "{said}");
        if ranks > 1 {
            has(&said, &[&format!("({ranks} ranks of 1 threads)")]);
        }
        for time in 0..3 {
            let bytes = |of: &str| folder.bytes(&format!("{of}/vorticity_{time:06}.png"));
            assert!(bytes(&to) == bytes("alone"), "{ranks} ranks, time {time}");
        }
    }
}

/// All ranks find the same views due, each by what it has read itself.
#[test]
fn ranks_draw_the_views_that_are_due_together() {
    let views = "[output]\ncinema = \"v.cdb\"\n[[views]]\nname = \"mean\"\nwhen = \"mean(theta) > 1020\"\n\
                 [[views]]\nname = \"other\"\nfield = \"w\"\nat_steps = [0]\ncamera.lat = 0\n";
    let folder = folder(&Made::history(), &(scene("theta", 0.0, 2080.0) + views));
    folder.render("--time all -o alone --threads 1");
    let Some(said) = draw_on(2, folder.path(), &["--time", "all", "-o", "of 2", "--threads", "1"]) else {
        return;
    };
    let at = |of: &str, name: &str| folder.bytes(&format!("{of}/v.cdb/{name}"));
    assert_eq!(said.matches("picture ").count(), 3, "{said}");
    for name in ["mean_theta_000001.png", "mean_theta_000002.png", "other_w_000000.png", "data.csv"] {
        assert!(at("of 2", name) == at("alone", name), "{name}");
    }
    let data = folder.text("alone/v.cdb/data.csv");
    assert_eq!(data.lines().count(), 4, "{data}");
}

#[test]
fn ranks_draw_native_heights_and_several_fields_together() {
    let folder = folder(&hills(), &native(&two("w", "theta")));
    folder.render("--time 0..2 -o alone --size 64x64 --threads 1");
    let more = ["--time", "0..2", "-o", "of 2", "--size", "64x64", "--threads", "1"];
    let Some(said) = draw_on(2, folder.path(), &more) else { return };
    has(&said, &["heights   zgrid of each column\n", "(2 ranks of 1 threads)"]);
    for time in 0..2 {
        let bytes = |of: &str| folder.bytes(&format!("{of}/w_{time:06}.png"));
        assert!(bytes("of 2") == bytes("alone"), "time {time}");
    }
}

#[test]
fn an_error_on_any_rank_stops_all_and_is_printed_once() {
    let folder = folder(&Made::history(), &scene("theta", 0.0, 42.0));
    folder.write("taken", "");
    for (more, part) in [
        (&["--time", "7"][..], "--time 7: expected -3 to 2"),
        (&["--time", "all", "-o", "one.png"], "expected a directory"),
        (&["-o", "taken/one.png"], "taken/one.png"),
    ] {
        let Some(output) = on_ranks(3, folder.path(), more) else { return };
        let complaint = String::from_utf8(output.stderr).unwrap();
        assert!(!output.status.success());
        let lines: Vec<&str> = complaint.lines().filter(|line| line.starts_with("icoray: error: ")).collect();
        assert!(lines.len() == 1 && lines[0].contains(part), "{complaint}");
    }
}
