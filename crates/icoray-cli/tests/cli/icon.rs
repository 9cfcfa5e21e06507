//! Small ICON files, with a grid file and without.

use crate::files::folder;
use crate::made::Made;
use crate::made_icon::{Angles, LAYERS};
use crate::run::{Folder, difference, has, row, scene, shows_something};
use netcdf::Options;

#[test]
fn pictures_with_tables_are_those_without() {
    let ta = scene("ta", 0.0, 80.0).replace("\"headlight\"", "\"none\"");
    for angles in [Angles::Radians, Angles::Degrees, Angles::Degrees32] {
        let folder = folder(&Made::icon_data(angles), &ta);
        Made::icon_grid().write_to(&folder.at("grid.nc"), Options::NETCDF4);
        let text = folder.render("-o alone.png");
        let bytes = 42 * 4 * LAYERS;
        has(&text, &[&format!("note      ta is at corners: averaged to cell centres (derived, {bytes} bytes)")]);
        folder.render("-o with.png --mesh grid.nc");
        // Positions differ in their last digits.
        let apart = difference(&folder.at("alone.png"), &folder.at("with.png"));
        assert!(apart.max <= 2, "{apart:?}");
        shows_something(&folder.at("alone.png"), 96, 96);
    }
}

#[test]
fn info_prints_layers_and_units() {
    let folder = Folder::of_netcdf4(&Made::icon_data(Angles::Radians));
    let text = folder.prints("info made.nc");
    let parts = [
        "mesh       ICON: 42 cells, 80 corners, 120 edges; corners are the triangles of the file, cells its points",
        "radius     6371229 m",
        "passes the check",
        "0: 1979-01-31_18:00:00, 1: 1979-02-01_00:00:00",
        "layers     3 on heights (lev, standard atmosphere): from 110.9 m to 5579.3 m",
    ];
    has(&text, &parts);
    assert_eq!(row(&text, "ta"), ["ta", "corners", "3", "f32", "K", "Temperature"]);
    folder.write("scene.toml", scene("ta", 0.0, 80.0));
    has(&folder.prints("plan made.nc --scene scene.toml --layers 0..2"), &["left out"]);
}
