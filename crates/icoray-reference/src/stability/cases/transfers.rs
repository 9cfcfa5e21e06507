//! Cells from clear to opaque, and transfer functions with steps, spikes and many knots.

use super::{BLUE, Case, CaseMesh, RED, knot};
use icoray::{Knot, Result};

const GREEN: [f64; 3] = [0.1, 0.8, 0.2];
const WHITE: [f64; 3] = [1.0, 1.0, 1.0];
/// Thickness of a layer in these cases.
const CELL: f64 = 0.02;

/// Optical depth of a cell from 1e-12 to 1e12: in all of the field, and rising from none.
pub fn depths(mesh: &CaseMesh) -> Result<Vec<Case>> {
    let mut cases = Vec::new();
    for power in [-12, -9, -6, -3, -1, 0, 1, 3, 6, 9, 12] {
        let depth = 10f64.powi(power);
        let name = |what: &str| format!("1e{power} per cell, {what}");
        let even = [knot(-1.0, RED, depth), knot(1.0, BLUE, depth)];
        cases.push(mesh.case("depth", name("even"))?.transfer(CELL, &even));
        let ramp = [knot(-0.5, RED, 0.0), knot(0.1, BLUE, 0.0), knot(0.6, GREEN, depth), knot(1.0, WHITE, 0.0)];
        cases.push(mesh.case("depth", name("from 0"))?.transfer(CELL, &ramp).hollow());
    }
    Ok(cases)
}

/// Steps, spikes, one knot, many knots, knots that the field never reaches.
pub fn transfers(mesh: &CaseMesh) -> Result<Vec<Case>> {
    let make = |name: &str, knots: &[Knot]| Ok(mesh.case("transfer", name)?.transfer(CELL, knots));
    let step = |at: f64, below: f64, above: f64| {
        [knot(-1.0, RED, below), knot(at, RED, below), knot(at, BLUE, above), knot(1.0, GREEN, above)]
    };
    let spike =
        |width: f64, depth: f64| [knot(0.1 - width, RED, 0.0), knot(0.1, BLUE, depth), knot(0.1 + width, WHITE, 0.0)];
    let box_of = |width: f64, depth: f64| {
        let (low, high) = (0.1 - 0.5 * width, 0.1 + 0.5 * width);
        [
            knot(-1.0, RED, 0.0),
            knot(low, RED, 0.0),
            knot(low, BLUE, depth),
            knot(high, GREEN, depth),
            knot(high, GREEN, 0.0),
            knot(1.0, RED, 0.0),
        ]
    };
    let mut cases = vec![
        make("step, clear below", &step(0.2, 0.0, 1.0))?,
        make("step, clear above", &step(0.2, 1.0, 0.0))?,
        make("step, both sides seen", &step(0.2, 0.2, 0.9))?,
        make("step to an opaque body", &step(0.2, 0.05, 1e6))?,
        make("step of colour alone", &step(0.2, 0.5, 0.5))?,
        make("step at the first knot", &[knot(0.0, RED, 0.3), knot(0.0, BLUE, 1.0), knot(1.0, GREEN, 0.0)])?,
        make("step at the last knot", &[knot(-1.0, RED, 0.3), knot(0.3, BLUE, 0.6), knot(0.3, GREEN, 0.0)])?,
        make("step alone", &[knot(0.1, RED, 0.2), knot(0.1, BLUE, 0.8)])?,
        make("spike 1e-6 wide, faint", &spike(5e-7, 1.0))?,
        make("spike 1e-6 wide, seen", &spike(5e-7, 1e6))?,
        make("spike 1e-6 wide, opaque", &spike(5e-7, 1e10))?,
        make("spike 1e-6 wide among wide knots", &box_of(1e-6, 1e6))?,
        make("spike 1e-3 wide", &spike(5e-4, 1e3))?,
        make("box 1e-2 wide", &box_of(1e-2, 10.0))?,
        make("one colour, extinction rising", &[knot(-1.0, GREEN, 0.0), knot(1.0, GREEN, 3.0)])?,
        make("one knot", &[knot(0.3, GREEN, 0.4)])?,
        make("all above the last knot", &[knot(-9.0, RED, 0.0), knot(-8.0, BLUE, 0.3)])?,
        make("all below the first knot", &[knot(8.0, RED, 0.3), knot(9.0, BLUE, 0.0)])?,
    ];
    for (name, depth) in [("1024 knots, smooth", 0.2), ("1024 knots, dense", 20.0)] {
        cases.push(make(name, &many(|i| depth * (1.0 + (f64::from(i) * 0.02).sin())))?);
    }
    cases.push(make("1024 knots, zigzag", &many(|i| if i % 2 == 0 { 0.0 } else { 3.0 }))?);
    Ok(cases)
}

fn many(depth: impl Fn(i32) -> f64) -> Vec<Knot> {
    let of = |i: i32| {
        let x = f64::from(i) / 1023.0;
        let color = [0.5 + 0.5 * (9.0 * x).sin(), x, 0.5 + 0.5 * (31.0 * x).cos()];
        knot(-1.0 + 2.0 * x, color, depth(i))
    };
    (0..1024).map(of).collect()
}
