//! Lines on layers, and cores with land, sea and lines, whose light the host adds to fragments of rays.

use super::common::*;
use super::scenes::{SHINY, SURFACES, TwoFields, compare};
use icoray::Fields;

const COASTS: &str = "[[lines]]\npattern = \"coast\"\non = 2\ncolor = \"black\"\nopacity = 0.9\nwidth = 1.5\n";
const GRATICULE: &str = "[[lines]]\non = \"top\"\ncolor = \"yellow\"\nopacity = 0.6\nspacing = 15\n";
pub const CELLS: &str = "[[lines]]\npattern = \"cells\"\non = 3\ncolor = \"red\"\nopacity = 0.8\nregion = { lon = [-20, 90] }\n\
    [[lines]]\npattern = \"triangles\"\non = 1\nopacity = 0.5\n";
const HIGH: &str = "[[lines]]\nheight_m = 8000\ncolor = \"#40ff40\"\nopacity = 0.7\nspacing = 20\n";
const EARTH: &str = "[ground]\nland = \"#708050\"\nocean = \"#203060\"\n";
pub const ON_CORE: &str =
    "[[lines]]\npattern = \"coast\"\ncolor = \"white\"\n[[lines]]\npattern = \"cells\"\ncolor = \"orange\"\n";

#[test]
fn lines_and_grounds() {
    let Some(_) = gpu() else { return };
    let both = TwoFields::new(4, &THICK_M);
    for (what, where_, transfer, text) in [
        ("on a sphere and layers", FAR, STEPS, format!("{HIGH}{GRATICULE}{CELLS}")),
        ("over surfaces, lit", FAR, SMOOTH, format!("{COASTS}{CELLS}{}\n{LIT}", SURFACES[5].1)),
        ("ground, lit", POLE, RAMP, format!("{EARTH}{ON_CORE}{SHINY}")),
    ] {
        both.compare(what, &scene(where_, &format!("{transfer}\n{text}"), CORES[0]), 0);
    }
    each_mesh_with_holes(|hole, grid, layers, field| {
        let scene = scene(FAR, &format!("{SMOOTH}\n{EARTH}{ON_CORE}{COASTS}"), CORES[0]);
        compare(hole, &scene, (grid, layers), || Fields::new([("f", *field)]), 0);
    });
}
