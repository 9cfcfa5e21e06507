//! Transfer functions that are hard to integrate, on the multi-scale field and a coarse grid.

use super::multi_scale;
use icoray::{Result, Scene};
use std::fmt::Write as _;

/// Writes the knots of a transfer function.
pub(crate) type Knots = fn() -> String;

/// Name and knots of each transfer function; extinctions are per planet radius.
pub(crate) const TRANSFERS: [(&str, Knots); 4] = [("deep", deep), ("step", step), ("spikes", spikes), ("knots", knots)];

fn knot(text: &mut String, value: f64, color: [u32; 3], extinction: f64) {
    let [r, g, b] = color;
    let _ = writeln!(text, "  {{ value = {value:.9}, color = \"rgb({r} {g} {b})\", extinction = {extinction} }},");
}

/// Clear below zero, then rising to an optical depth of about a million in a cell, colours changing all the way.
fn deep() -> String {
    let mut text = String::new();
    knot(&mut text, -1.0, [40, 60, 200], 0.0);
    knot(&mut text, 0.0, [40, 200, 220], 0.0);
    for (value, color) in [(0.2, [250, 220, 60]), (0.4, [240, 90, 40]), (1.0, [120, 0, 90])] {
        knot(&mut text, value, color, 1.3e8);
    }
    text
}

/// Five bands with coincident knots between: colour and extinction jump.
fn step() -> String {
    let bands = [
        ([30, 60, 160], 2.0),
        ([90, 180, 230], 0.0),
        ([240, 240, 200], 40.0),
        ([240, 150, 40], 0.5),
        ([190, 20, 30], 400.0),
    ];
    let edges = [-1.0, -0.5, -0.1, 0.15, 0.4, 1.0];
    let mut text = String::new();
    for (i, (color, extinction)) in bands.into_iter().enumerate() {
        knot(&mut text, edges[i], color, extinction);
        knot(&mut text, edges[i + 1], color, extinction);
    }
    text
}

/// Triangles a millionth of the range wide: isosurfaces in all but name.
fn spikes() -> String {
    const HALF_WIDTH: f64 = 1e-6;
    let mut text = String::new();
    for (value, color) in [
        (-0.6, [40, 80, 230]),
        (-0.2, [60, 200, 220]),
        (0.1, [240, 240, 120]),
        (0.3, [250, 150, 30]),
        (0.6, [220, 30, 60]),
    ] {
        knot(&mut text, value - HALF_WIDTH, color, 0.0);
        knot(&mut text, value, color, 3e6);
        knot(&mut text, value + HALF_WIDTH, color, 0.0);
    }
    text
}

/// 1024 knots, each with its own colour and extinction, every third clear.
fn knots() -> String {
    let mut text = String::new();
    let mut state = 1u32;
    let mut draw = |range: u32| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 16) % range
    };
    for i in 0..1024 {
        let color = [draw(256), draw(256), draw(256)];
        let extinction = if i % 3 == 0 { 0.0 } else { f64::from(draw(100)) };
        knot(&mut text, -1.0 + 2.0 * f64::from(i) / 1023.0, color, extinction);
    }
    text
}

pub(crate) fn scene(size: u32, knots: Knots) -> Result<Scene> {
    multi_scale::globe("multi-scale", size, "", &format!("unit_length = 1\nknots = [\n{}]", knots()))
}
