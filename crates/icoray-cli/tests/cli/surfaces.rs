//! 2D fields, which are drawn as surfaces, and scenes with few keys.

use crate::files::folder;
use crate::made::Made;
use crate::run::{Folder, has, row, says, scene, shows_something};
use std::fs;

/// A history whose only field is surface pressure.
fn flat() -> Made {
    let mut made = Made::history();
    made.variables.retain(|v| !["theta", "w", "vorticity", "rho", "zgrid", "levels"].contains(&v.name));
    made
}

#[test]
fn a_file_of_2d_fields_is_drawn_alone() {
    let folder = Folder::of(&flat());
    let text = folder.render_alone("--save-scene s.toml");
    let parts = [
        "scene     suggested for surface_pressure, the first 2D field, as none has layers; saved as s.toml\n",
        "picture   surface_pressure_2013-10-27_00.00.00_000002.png (96 x 72)",
        "field     surface_pressure at cells, 2D, time 2",
        "range     2000 to 2041, 0 missing",
    ];
    has(&text, &parts);
    let picture = folder.at("surface_pressure_2013-10-27_00.00.00_000002.png");
    shows_something(&picture, 96, 72);
    says(&picture, &[("field", "surface_pressure")]);
    let drawn = fs::read(&picture).unwrap();
    folder.render_alone("--scene s.toml --time 2");
    assert!(fs::read(&picture).unwrap() == drawn, "the saved scene draws another picture");
    let text = folder.prints("info made.nc --ranges");
    has(&text, &["layers     1: a 2D field, shown as a surface on the sphere", "2000 to 2041"]);
    assert_eq!(row(&text, "surface_pressure")[..4], ["surface_pressure", "cells", "1", "f32"]);
}

#[test]
fn a_2d_field_is_chosen_by_name() {
    let folder = Folder::of(&Made::history());
    let text = folder.render_alone("--field surface_pressure --surface top --time 0");
    has(&text, &["suggested for surface_pressure\n", "surface_pressure at cells, 2D, time 0"]);
    let parts = ["read: surface_pressure at cells, 1 layers (168 bytes each time)"];
    has(&folder.prints("plan made.nc --field surface_pressure"), &parts);
}

#[test]
fn a_2d_field_lies_under_a_volume_or_an_isosurface() {
    let on_ground = "[[surfaces]]\nfield = \"surface_pressure\"\n";
    let volume = scene("theta", 0.0, 42.0).replace("0.9]]", "0.2]]").replace("\"headlight\"", "\"none\"");
    let folder = folder(&Made::history(), &volume);
    let draw = |text: &str, more: &str| {
        folder.write("scene.toml", text);
        (folder.render(&format!("-o a.exr {more}")), folder.bytes("a.exr"))
    };
    let (_, without) = draw(&volume, "");
    let (said, with) = draw(&format!("{volume}{on_ground}"), "");
    has(&said, &["theta at cells, 4 layers", "surface_pressure at cells, 2D"]);
    assert!(without != with, "the surface is not seen");
    // The layers are those of the field that has some, whichever is named first.
    let isosurface = "[[isosurfaces]]\nfield = \"theta\"\nvalue = 20\ncolor = \"red\"\n";
    let (said, _) = draw(&format!("{on_ground}{isosurface}"), "--layers 1..4");
    has(&said, &["theta at cells, 3 layers", "surface_pressure at cells, 2D"]);
    // On interfaces as well.
    draw(&format!("[[surfaces]]\nlayer = \"top\"\nfield = \"w\"\n{on_ground}{isosurface}"), "");
}

#[test]
fn scenes_with_few_keys_show_the_first_field() {
    let folder = folder(&Made::history(), "image = { width = 96, height = 72 }\n");
    has(&folder.render(""), &["picture   theta_000002.png (96 x 72)", "theta at cells, 4 layers"]);
    shows_something(&folder.at("theta_000002.png"), 96, 72);
    let views = "image.width = 96\n[[views]]\nname = \"a\"\n[[views]]\nname = \"b\"\nfield = \"w\"\n";
    folder.write("scene.toml", views);
    has(&folder.render("-o ."), &["picture   ./a_theta_000002.png", "picture   ./b_w_000002.png"]);
}

#[test]
fn scenes_with_few_keys_show_2d_fields_as_surfaces() {
    let size = "[image]\nwidth = 96\nheight = 72\n";
    let folder = folder(&flat(), size);
    let draw = |text: &str| {
        folder.write("scene.toml", format!("{text}{size}"));
        folder.render("-o out.exr");
        folder.bytes("out.exr")
    };
    let surface = draw("field = \"surface_pressure\"\n[[surfaces]]\n[labels]\n");
    assert!(
        draw("[transfer]\nmap = \"viridis\"\nscale = \"linear\"\n") == surface,
        "a colour map draws another picture"
    );
    assert!(draw("") == draw("field = \"surface_pressure\"\n"), "the first field is another one");
    assert!(draw("[transfer]\nopacity = [[0, 0], [1, 0.5]]\n") != surface, "an opacity makes a film of it");
}

#[test]
fn a_scene_of_comments_draws_nothing() {
    let folder = folder(&Made::history(), "# nothing today\n");
    for command in ["render", "plan"] {
        let text = folder.prints(&format!("{command} made.nc --scene scene.toml"));
        assert_eq!(text, "note      nothing is drawn: scene.toml has no keys\n");
    }
    assert_eq!(folder.count(), 2, "no picture");
}

#[test]
fn hexagons_with_bounds_are_drawn() {
    let folder = Folder::of_netcdf4(&Made::dynamico(crate::made_icon::Angles::Degrees));
    has(&folder.render_alone(""), &["suggested for ta", "--field also takes ps"]);
    let parts = ["mesh       polygons: 162 cells, 320 corners, 480 edges", "passes the check"];
    has(&folder.prints("info made.nc"), &parts);
}
