//! Layers at other heights over each cell.

use super::common::*;
use super::scenes::{ISOSURFACES, SURFACES, TwoFields, compare, compare_edges};
use super::volumes;

/// Heights of layers that follow mountains, some of which have no thickness; some columns have no heights.
pub fn heights(sphere: &Sphere) -> Vec<f64> {
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
    let data = TwoFields::new(4, &THICK_M);
    let heights = heights(&data.sphere);
    let fields = || data.fields().with_heights(at_centers(&heights, THICK_M.len()));
    let both = (&data.sphere.grid, &data.sphere.layers);
    let hollow = format!("{NATIVE}\ncore = \"transparent\"");
    for (what, where_, text, rest) in [
        ("surfaces, cut", POLE, format!("{STEPS}\n{}", SURFACES[5].1), NATIVE),
        ("cells and spheres, lit", FAR, format!("{RAMP}\n{}\n{HIGH}\n{LIT}", SURFACES[3].1), NATIVE),
        ("isosurfaces, cut, lit", INSIDE, format!("{RAMP}\n{}\n{LIT}", ISOSURFACES[5].1), &hollow),
    ] {
        let scene = scene(where_, &text, rest);
        // A ray grazes an isosurface.
        compare(what, &scene, both, fields, usize::from(what.starts_with("isosurfaces")));
        if what == "surfaces, cut" {
            compare_edges(what, &scene, both, fields);
        }
    }
    let scene = volumes::scene_of(FAR, &[&volumes::contents("two")], NATIVE, "");
    compare("two volumes", &scene, both, fields, 0);
}
