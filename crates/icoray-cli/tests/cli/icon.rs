//! Small ICON files, with a grid file and without.

use crate::files::{folder, render};
use crate::made::Made;
use crate::made_icon::{Angles, LAYERS};
use crate::run::{has, icoray, prints, scene, shows_something};
use netcdf::Options;
use std::fs;

#[test]
fn pictures_with_tables_are_those_without() {
    let ta = scene("ta", 0.0, 80.0).replace("\"headlight\"", "\"none\"");
    for angles in [Angles::Radians, Angles::Degrees, Angles::Degrees32] {
        let folder = folder(&Made::icon_data(angles), &ta);
        Made::icon_grid().write_to(&folder.path().join("grid.nc"), Options::NETCDF4);
        let text = render(folder.path(), &["-o", "alone.png"]);
        let bytes = 42 * 4 * LAYERS;
        has(&text, &[&format!("note      ta is at corners: averaged to cell centres (derived, {bytes} bytes)")]);
        render(folder.path(), &["-o", "with.png", "--mesh", "grid.nc"]);
        let read = |name: &str| image::open(folder.path().join(name)).unwrap().to_rgba8();
        // Positions differ in their last digits.
        let apart = read("alone.png").iter().zip(read("with.png").iter()).map(|(a, b)| a.abs_diff(*b)).max();
        assert!(apart <= Some(2), "{apart:?}");
        shows_something(&folder.path().join("alone.png"), 96, 96);
    }
}

#[test]
fn info_says_what_is_known_of_layers_and_units() {
    let (folder, path) = Made::icon_data(Angles::Radians).write(Options::NETCDF4);
    let text = prints(icoray(folder.path()).arg("info").arg(&path));
    has(
        &text,
        &[
            "mesh       ICON: 42 cells, 80 corners, 120 edges; corners are the triangles of the file, cells its points",
            "radius     6371229 m",
            "passes the check",
            "0: 1979-01-31_18:00:00, 1: 1979-02-01_00:00:00",
            "layers     3 on heights (lev, standard atmosphere): from 110.9 m to 5579.3 m",
        ],
    );
    let line = text.lines().find(|line| line.starts_with("ta ")).unwrap();
    assert_eq!(line.split_whitespace().collect::<Vec<_>>(), ["ta", "corners", "3", "f32", "K", "Temperature"]);
    fs::write(folder.path().join("scene.toml"), scene("ta", 0.0, 80.0)).unwrap();
    let mut plan = icoray(folder.path());
    has(&prints(plan.arg("plan").arg(path).args(["--scene", "scene.toml", "--layers", "0..2"])), &["left out"]);
}
