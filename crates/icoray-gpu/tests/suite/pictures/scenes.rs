//! Scenes that show more than a volume and a core.

use super::common::*;

/// Cuts of all kinds, one by one and together.
pub const CLIPS: [(&str, &str); 9] = [
    ("box", "[[clip]]\nlon = [10, 70]\nlat = [-20, 45]"),
    ("wide box", "[[clip]]\nlon = [-100, 150]\nlat = [-90, 30]\ncut = \"outside\""),
    ("half a turn", "[[clip]]\nlon = [20, 200]"),
    ("shell", "[[clip]]\nheight_m = [4000, 11000]"),
    ("outside a shell", "[[clip]]\nheight_m = [4000, 11000]\ncut = \"outside\""),
    ("layers", "[[clip]]\nlon = [0, 60]\nlayers = [2, 4]"),
    ("half-space", "[[clip]]\nhalf_space = { towards = [40, 20], distance = 0.7 }"),
    ("cap", "[[clip]]\nlat = [40, 90]\nlon = [30, 390]"),
    (
        "several",
        "[[clip]]\nlon = [10, 50]\n[[clip]]\nlat = [20, 50]\nheight_m = [2000, 9000]\n[[clip]]\n\
         half_space = { towards = [300, 0], distance = 0.2 }\n[[clip]]\nlon = [-60, 120]\ncut = \"outside\"",
    ),
];

#[test]
fn cut_volumes() {
    let Some(_) = gpu() else { return };
    let both = sphere(4, &THICK_M);
    for (k, (clip, text)) in CLIPS.into_iter().enumerate() {
        for (transfer, colors) in [TRANSFERS[k % 5], TRANSFERS[(k + 2) % 5]] {
            for (camera, where_) in [("far", FAR), ("inside", INSIDE)] {
                let scene = scene(where_, &format!("{colors}\n{text}"), CORES[k % 2]);
                both.compare(&format!("{clip}, {transfer}, {camera}"), &scene, 0);
            }
        }
        both.compare_edges(clip, &scene(FAR, &format!("{DENSE}\n{text}"), CORES[0]));
        for (light, lamp) in [("headlight", LIT), ("shiny", SHINY)] {
            let scene = scene(FAR, &format!("{SMOOTH}\n{lamp}\n{text}"), CORES[0]);
            both.compare(&format!("{clip}, {light}"), &scene, 0);
        }
    }
}

/// Names of views with their cameras and lights.
pub const VIEWS: [(&str, &str, &str); 4] =
    [("far", FAR, ""), ("inside", INSIDE, ""), ("headlight", FAR, LIT), ("shiny", FAR, SHINY)];

/// Draws all that is `shown` in these views, and its edges; up to `stray` pixels of the number of what is shown may be
/// beyond their errors.
fn compare_all(shown: &[(&str, &str)], stray: impl Fn(usize) -> usize) {
    let Some(_) = gpu() else { return };
    let both = sphere(4, &THICK_M);
    for (k, (surface, text)) in shown.iter().enumerate() {
        for (view, where_, lamp) in VIEWS {
            let scene = scene(where_, &format!("{}\n{lamp}\n{text}", TRANSFERS[k % 2].1), CORES[k % 2]);
            both.compare(&format!("{surface}, {view}"), &scene, stray(k));
        }
        let scene = scene(FAR, &format!("{RAMP}\n{text}"), CORES[k % 2]);
        both.compare_edges(&format!("{surface}, edges"), &scene);
    }
}

/// Surfaces of all kinds, one by one and together.
pub const SURFACES: [(&str, &str); 10] = [
    ("plain", "[[surfaces]]\nlayer = 2\ncolor = \"orange\"\nopacity = 0.5"),
    ("top", "[[surfaces]]\nlayer = \"top\"\ncolor = \"#80ff40\"\nopacity = 0.25"),
    ("interpolated", "[[surfaces]]\nlayer = 3\nfield = \"g\"\ntransfer = { map = \"plasma\", range = [-0.7, 0.9] }"),
    (
        "cells",
        "[[surfaces]]\nlayer = 1\nfield = \"g\"\ntransfer = { map = \"plasma\", range = [-0.7, 0.9] }\n\
         shading = \"cells\"\nopacity = 0.7",
    ),
    (
        "own field",
        "[[surfaces]]\nlayer = \"bottom\"\nfield = \"f\"\ntransfer = { map = \"turbo\", range = [-0.5, 0.5] }",
    ),
    (
        "several, cut",
        "[[surfaces]]\nlayer = 2\ncolor = \"blue\"\nopacity = 0.25\n[[surfaces]]\nlayer = 2\nfield = \"g\"\n\
         transfer = { map = \"plasma\", range = [-0.7, 0.9] }\nopacity = 0.5\n[[surfaces]]\nlayer = 4\n\
         field = \"f\"\ntransfer = { map = \"turbo\", range = [-0.5, 0.5] }\nopacity = 0.5\n\
         [[clip]]\nlon = [10, 60]\nlat = [-30, 45]\n[[clip]]\nlon = [-40, 0]\nlayers = [2, 4]",
    ),
    // At heights between layers.
    ("plain, between", "[[surfaces]]\nheight_m = 8000\ncolor = \"orange\"\nopacity = 0.5"),
    (
        "own field, between",
        "[[surfaces]]\nheight_m = 4100\nfield = \"f\"\ntransfer = { map = \"turbo\", range = [-0.5, 0.5] }\nopacity = 0.6",
    ),
    (
        "other field, between",
        "[[surfaces]]\nheight_m = 15000\nfield = \"g\"\ntransfer = { map = \"plasma\", range = [-0.7, 0.9] }\n\
         shading = \"cells\"\nopacity = 0.7",
    ),
    (
        "several, cut, between",
        "[[surfaces]]\nheight_m = 8000\ncolor = \"blue\"\nopacity = 0.25\n[[surfaces]]\nheight_m = 8000\n\
         field = \"g\"\ntransfer = { map = \"plasma\", range = [-0.7, 0.9] }\nopacity = 0.5\n[[surfaces]]\n\
         height_m = 9000\ncolor = \"red\"\nopacity = 0.3\n[[surfaces]]\nlayer = 2\ncolor = \"white\"\nopacity = 0.2\n\
         [[isosurfaces]]\nfield = \"f\"\nvalue = 0.2\ncolor = \"orange\"\nopacity = 0.5\n\
         [[clip]]\nlon = [10, 60]\nlat = [-30, 45]",
    ),
];

#[test]
fn surfaces_on_and_between_layers() {
    compare_all(&SURFACES, |k| if k == 9 { GRAZING } else { 0 });
}

/// Isosurfaces of the volume's field and of another one.
pub const ISOSURFACES: [(&str, &str); 6] = [
    ("own field", "[[isosurfaces]]\nfield = \"f\"\nvalue = 0.2\ncolor = \"orange\"\nopacity = 0.5"),
    ("opaque", "[[isosurfaces]]\nfield = \"f\"\nvalue = -0.15\ncolor = \"#80ff40\""),
    ("other field", "[[isosurfaces]]\nfield = \"g\"\nvalue = 0.1\ncolor = \"red\"\nopacity = 0.6"),
    (
        "colours of another field",
        "[[isosurfaces]]\nfield = \"f\"\nvalue = 0.3\ncolor_by = \"g\"\n\
         transfer = { map = \"plasma\", range = [-0.7, 0.9] }\nopacity = 0.8",
    ),
    (
        "colours of the volume's field",
        "[[isosurfaces]]\nfield = \"g\"\nvalue = -0.1\ncolor_by = \"f\"\n\
         transfer = { map = \"turbo\", range = [-0.5, 0.5] }\nopacity = 0.5",
    ),
    (
        "several, cut",
        "[[isosurfaces]]\nfield = \"f\"\nvalues = [-0.3, 0, 0.3]\ncolors = [\"blue\", \"white\", \"red\"]\n\
         opacity = 0.4\n[[isosurfaces]]\nfield = \"g\"\nvalue = 0.2\ncolor = \"green\"\nopacity = 0.3\n\
         [[clip]]\nlon = [10, 60]\nlat = [-30, 45]\n[[surfaces]]\nlayer = 2\ncolor = \"blue\"\nopacity = 0.25",
    ),
];

/// Pixels at which rounding decides whether a ray grazes an isosurface, or the CPU's error, an estimate, is too
/// small: in "several, cut, inside" one is off by 1.8e-4, reported as 4e-5, and the device's by 9e-6.
const GRAZING: usize = 2;

#[test]
fn isosurfaces_of_fields() {
    compare_all(&ISOSURFACES, |_| GRAZING);
}

/// Isosurfaces alone, far from 0, where single precision has no digits of the values themselves, and where none of the
/// field's layers shows a volume.
#[test]
fn isosurfaces_without_a_volume() {
    let Some(_) = gpu() else { return };
    let sphere = sphere(4, &THICK_M);
    let both = (&sphere.grid, &sphere.layers);
    let far: Vec<f64> = sphere.values[0].iter().map(|x| 1e6 + f64::from(*x)).collect();
    let far = at_centers(&far, THICK_M.len());
    for lamp in ["", LIT] {
        let tables =
            format!("[[isosurfaces]]\nfield = \"f\"\nvalue = 1000000.25\ncolor = \"orange\"\nopacity = 0.5\n{lamp}");
        let scene = scene_of(FAR, &tables, CORES[0]);
        compare("alone, far from 0", &scene, both, &far, GRAZING);
        compare_edges("alone, far from 0", &scene, both, &far);
    }
    // Volumes are clear in most layers.
    let rising = |cell: usize, layer: usize| layer as f32 + 0.3 * sphere.values[0][cell * THICK_M.len() + layer];
    let rising = over_columns(sphere.grid.cells(), THICK_M.len(), rising);
    let knots = "knots = [ { value = 2.9, color = \"red\", extinction = 0 }, { value = 3.5, color = \"red\", extinction = 4 } ]";
    let scene =
        scene(FAR, &format!("{knots}\n[[isosurfaces]]\nfield = \"f\"\nvalue = 0.6\ncolor = \"blue\""), CORES[0]);
    compare("in clear layers", &scene, both, &at_centers(&rising, THICK_M.len()), GRAZING);
}

pub const COASTS: &str = "[[lines]]\npattern = \"coast\"\non = 2\ncolor = \"black\"\nopacity = 0.9\nwidth = 1.5\n";
const GRATICULE: &str = "[[lines]]\non = \"top\"\ncolor = \"yellow\"\nopacity = 0.6\nspacing = 15\n";
pub const CELLS: &str = "[[lines]]\npattern = \"cells\"\non = 3\ncolor = \"red\"\nopacity = 0.8\nregion = { lon = [-20, 90] }\n\
    [[lines]]\npattern = \"triangles\"\non = 1\nopacity = 0.5\n";
const HIGH_LINES: &str = "[[lines]]\nheight_m = 8000\ncolor = \"#40ff40\"\nopacity = 0.7\nspacing = 20\n";
pub const EARTH: &str = "[ground]\nland = \"#708050\"\nocean = \"#203060\"\n";
pub const ON_CORE: &str =
    "[[lines]]\npattern = \"coast\"\ncolor = \"white\"\n[[lines]]\npattern = \"cells\"\ncolor = \"orange\"\n";

#[test]
fn lines_and_grounds() {
    let Some(_) = gpu() else { return };
    let both = sphere(4, &THICK_M);
    for (what, where_, transfer, text) in [
        ("on a sphere and layers", FAR, STEPS, format!("{HIGH_LINES}{GRATICULE}{CELLS}")),
        ("over surfaces, lit", FAR, SMOOTH, format!("{COASTS}{CELLS}{}\n{LIT}", SURFACES[5].1)),
        ("ground, lit", POLE, RAMP, format!("{EARTH}{ON_CORE}{SHINY}")),
    ] {
        both.compare(what, &scene(where_, &format!("{transfer}\n{text}"), CORES[0]), 0);
    }
}

/// Heights of layers that follow mountains, some of which have no thickness; some columns have no heights.
pub fn heights(sphere: &Model) -> Vec<f64> {
    over_columns(sphere.grid.cells(), THICK_M.len(), |cell, layer| {
        let p = sphere.grid.direction(cell as u32);
        let ground = 2e3 + 2e3 * (5.0 * p.x).sin() * (4.0 * p.y + 1.0).cos() + 500.0 * (20.0 * p.z).sin();
        let flat = cell.is_multiple_of(7) && layer == 2;
        let up = THICK_M[if flat { 1 } else { layer }] / THICK_M[THICK_M.len() - 1];
        if cell % 113 == 5 { f64::NAN } else { ground + up * (20e3 - ground) }
    })
}

pub const NATIVE: &str = "heights = \"native\"\nexaggeration = 60";
const HIGH: &str = "[[surfaces]]\nheight_m = 9000\nfield = \"g\"\nopacity = 0.4\n\
    transfer = { map = \"magma\", range = [-0.9, 0.9] }\n";
pub const LINES: &str =
    "[ground]\nland = \"#708050\"\nocean = \"#203060\"\n[[lines]]\non = 2\nopacity = 0.7\nspacing = 15\n";

#[test]
fn layers_at_native_heights() {
    let Some(_) = gpu() else { return };
    let sphere = sphere(4, &THICK_M);
    let heights = heights(&sphere);
    let fields = sphere.fields().with_heights(at_centers(&heights, THICK_M.len()));
    let both = (&sphere.grid, &sphere.layers);
    let hollow = format!("{NATIVE}\ncore = \"transparent\"");
    for (what, where_, text, rest) in [
        ("surfaces, cut", POLE, format!("{STEPS}\n{}", SURFACES[5].1), NATIVE),
        ("cells and spheres, lit", FAR, format!("{RAMP}\n{}\n{HIGH}\n{LIT}", SURFACES[3].1), NATIVE),
        ("isosurfaces, cut, lit", INSIDE, format!("{RAMP}\n{}\n{LIT}", ISOSURFACES[5].1), &hollow),
    ] {
        let scene = scene(where_, &text, rest);
        // A ray grazes an isosurface.
        compare(what, &scene, both, fields.clone(), usize::from(what.starts_with("isosurfaces")));
        if what == "surfaces, cut" {
            compare_edges(what, &scene, both, fields.clone());
        }
    }
    compare("two volumes", &scene_of(FAR, &super::volumes::contents("two"), NATIVE), both, fields, 0);
}
