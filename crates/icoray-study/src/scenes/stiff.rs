//! Transfer functions that are hard to integrate, on the multi-scale field and a coarse grid.

use super::multi_scale;
use icoray::{Result, Scene};

/// Writes the knots of a transfer function.
pub(crate) type Knots = fn() -> String;

/// Name and knots of each transfer function; extinctions are per planet radius.
pub(crate) const TRANSFERS: [(&str, Knots); 4] = [("deep", deep), ("step", step), ("spikes", spikes), ("knots", knots)];

fn knot((value, color, extinction): (f64, [u32; 3], f64)) -> String {
    let [r, g, b] = color;
    format!("  {{ value = {value:.9}, color = \"rgb({r} {g} {b})\", extinction = {extinction} }},\n")
}

/// Clear below zero, then rising to an optical depth of about a million in a cell, colours changing all the way.
fn deep() -> String {
    let knots = [
        (-1.0, [40, 60, 200], 0.0),
        (0.0, [40, 200, 220], 0.0),
        (0.2, [250, 220, 60], 1.3e8),
        (0.4, [240, 90, 40], 1.3e8),
        (1.0, [120, 0, 90], 1.3e8),
    ];
    knots.map(knot).concat()
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
    let ends = edges.windows(2).zip(bands);
    ends.flat_map(|(ends, (color, extinction))| [ends[0], ends[1]].map(|value| knot((value, color, extinction))))
        .collect()
}

/// Triangles a millionth of the range wide: isosurfaces in all but name.
fn spikes() -> String {
    const HALF_WIDTH: f64 = 1e-6;
    let middles = [
        (-0.6, [40, 80, 230]),
        (-0.2, [60, 200, 220]),
        (0.1, [240, 240, 120]),
        (0.3, [250, 150, 30]),
        (0.6, [220, 30, 60]),
    ];
    let spike = |(value, color)| {
        [(value - HALF_WIDTH, color, 0.0), (value, color, 3e6), (value + HALF_WIDTH, color, 0.0)].map(knot)
    };
    middles.into_iter().flat_map(spike).collect()
}

/// 1024 knots, each with its own colour and extinction, every third clear.
fn knots() -> String {
    let mut state = 1u32;
    let mut draw = |range: u32| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 16) % range
    };
    let knot_at = |i: u32| {
        let color = [draw(256), draw(256), draw(256)];
        let extinction = if i.is_multiple_of(3) { 0.0 } else { f64::from(draw(100)) };
        knot((-1.0 + 2.0 * f64::from(i) / 1023.0, color, extinction))
    };
    (0..1024).map(knot_at).collect()
}

pub(crate) fn scene(size: u32, knots: Knots) -> Result<Scene> {
    multi_scale::globe("multi-scale", size, "", &format!("unit_length = 1\nknots = [\n{}]", knots()))
}
