//! Gradients of linear fields, on whole meshes and beside missing values.

use super::*;
use crate::field::{Field, Location};
use crate::grid::icosahedral_grid;
use std::borrow::Cow;

#[test]
fn gradients_too_long_for_a_float_keep_their_direction() {
    for (mean, expected) in [
        (DVec3::new(1.5, -2.0, 0.0), [1.5, -2.0, 0.0]),
        (DVec3::new(1e40, 0.0, 1e300), [0.0, 0.0, 1e30]),
        (DVec3::new(1e300, -5e299, 0.0), [1e30, -5e29, 0.0]),
        (DVec3::new(f64::INFINITY, 1.0, 0.0), [0.0; 3]),
        (DVec3::new(1.0, f64::NAN, f64::NAN), [0.0; 3]),
    ] {
        assert_eq!(narrowed(mean), expected, "{mean}");
    }
}
fn radii() -> Vec<f64> {
    vec![1.0, 1.03, 1.1, 1.2]
}

fn field_of(grid: &Grid, f: impl Fn(DVec3) -> f64) -> Vec<f64> {
    let cells = 0..grid.cells() as u32;
    cells.flat_map(|c| radii().into_iter().map(move |r| (c, r))).map(|(c, r)| f(grid.direction(c) * r)).collect()
}

fn gradients_of(grid: &Grid, values: &[f64]) -> Vec<[f32; 3]> {
    gradients_in(grid, values, [0.0, 1.0])
}

/// The gradients of values that are normalised to `range`.
fn gradients_in(grid: &Grid, values: &[f64], range: [f64; 2]) -> Vec<[f32; 3]> {
    let field = Field::level_fastest(values, 4, Location::Center).unwrap();
    gradients(
        grid,
        &radii(),
        &Samples::new(values, &field, false, range),
        0..grid.cells(),
        GradientOptions::default(),
        Gradients::none(),
    )
    .unwrap()
    .whole()
    .to_vec()
}

/// A linear field is linear on every facet and along every radius: each frustum's gradient is the field's, so the
/// mean is exact, at pentagons and on the outer and inner layers too.
#[test]
fn a_linear_field_has_its_own_gradient_everywhere() {
    let grid = icosahedral_grid(3);
    let slope = DVec3::new(0.3, -2.0, 0.7);
    let values = field_of(&grid, |p| p.dot(slope) + 5.0);
    for gradient in gradients_of(&grid, &values) {
        assert!(DVec3::from_array(gradient.map(f64::from)).distance(slope) < 1e-6, "{gradient:?}");
    }
}

/// The direction across values that differ in their last digits is theirs, not that of rounding by normalisation; also
/// beside missing values.
#[test]
fn a_range_scales_gradients_of_last_digits() {
    let grid = icosahedral_grid(2);
    let range = [8.093, 19.843];
    for missing in [None, Some(4 * 40 + 2)] {
        let mut digits = field_of(&grid, |p| (40.0 * p.x * p.y + 9.0 * p.z).round());
        if let Some(missing) = missing {
            digits[missing] = f64::NAN;
        }
        let values: Vec<f64> = digits.iter().map(|digit| 14.25 + digit * 8.0 * f64::EPSILON).collect();
        let scale = 8.0 * f64::EPSILON / (range[1] - range[0]);
        for (found, digits) in gradients_in(&grid, &values, range).iter().zip(gradients_of(&grid, &digits)) {
            let [found, expected] = [found.map(|g| f64::from(g) / scale), digits.map(f64::from)].map(DVec3::from_array);
            assert!(found.distance(expected) < 1e-6 * (1.0 + expected.length()), "{found} {expected}");
        }
    }
}

/// In invisible blocks memory is unchanged, and in visible ones the bits are those of all gradients.
#[test]
fn gradients_are_those_that_can_be_seen() {
    let grid = icosahedral_grid(3);
    let values = field_of(&grid, |p| (3.0 * p.x).sin() * (5.0 * p.y).cos() + p.z * p.z);
    let field = Field::level_fastest(&values, 4, Location::Center).unwrap();
    let samples = Samples::new(&values, &field, false, [0.0, 1.0]);
    let all = gradients_of(&grid, &values);
    // Blocks of one gap: each third triangle has the lowest, each seventh the uppermost.
    let blocks = (0..grid.triangles()).map(|t| u32::from(t % 3 == 0) | u32::from(t % 7 == 0) << 2).collect();
    let visible = OccupancyMask { blocks: Cow::Owned(blocks), ..OccupancyMask::default() };
    let unknown = Gradients::Whole(vec![[9.0; 3]; values.len()].into());
    let wanted = GradientOptions { visible: Some(&visible), ..GradientOptions::default() };
    let found = gradients(&grid, &radii(), &samples, 0..grid.cells(), wanted, unknown).unwrap();
    let mut left_out = 0;
    for (i, gradient) in found.whole().iter().enumerate() {
        let around = grid.corners_of((i / 4) as u32).fold(0, |all, triangle| all | visible.blocks_over(triangle));
        // Between the blocks of a cell nothing is left out.
        let is_seen = match i % 4 {
            0 => around & 1 != 0,
            1 => around & 1 != 0,
            2 => around & 4 != 0,
            _ => around & 4 != 0,
        };
        let is_known = *gradient != [9.0; 3];
        assert!(is_known || !is_seen, "{i}");
        assert!(!is_known || *gradient == all[i], "{i}: {gradient:?} {:?}", all[i]);
        left_out += u32::from(!is_known);
    }
    assert!(left_out > 100, "{left_out}");
}

/// Any field with holes: each vertex has the mean over those incident frusta that miss none of their six values, and
/// a frustum's gradient solves its three slopes.
#[test]
fn the_mean_is_over_the_whole_incident_frusta() {
    let grid = icosahedral_grid(2);
    let mut values = field_of(&grid, |p| (3.0 * p.x).sin() * (5.0 * p.y).cos() + p.z * p.z);
    for cell in (0..grid.cells()).step_by(7) {
        values[4 * cell + cell % 4] = f64::NAN;
        values[4 * cell + (cell + 1) % 4] = f64::NAN;
    }
    let (radius, value) = (radii(), |cell: u32, layer: usize| values[4 * cell as usize + layer]);
    let frustum = |cell: u32, layer: usize, triangle: u32, gap: usize| {
        let cells = grid.triangle(triangle);
        let whole = cells.iter().all(|&c| !value(c, gap).is_nan() && !value(c, gap + 1).is_nan());
        let others: Vec<u32> = cells.into_iter().filter(|&c| c != cell).collect();
        let side = |o: u32| (grid.direction(o) - grid.direction(cell)) * radius[layer];
        let slopes = DVec3::new(
            (value(cell, gap + 1) - value(cell, gap)) / (radius[gap + 1] - radius[gap]),
            value(others[0], layer) - value(cell, layer),
            value(others[1], layer) - value(cell, layer),
        );
        let basis = glam::DMat3::from_cols(grid.direction(cell), side(others[0]), side(others[1]));
        whole.then(|| basis.transpose().inverse() * slopes)
    };
    let found = gradients_of(&grid, &values);
    let mut partial = 0;
    for (i, gradient) in found.iter().enumerate() {
        let (cell, layer) = ((i / 4) as u32, i % 4);
        let gaps = [layer.checked_sub(1), (layer < 3).then_some(layer)].into_iter().flatten();
        let around: Vec<_> = gaps
            .flat_map(|gap| grid.corners_of(cell).map(move |t| (t, gap)))
            .map(|(t, gap)| frustum(cell, layer, t, gap))
            .collect();
        let known: Vec<DVec3> = around.iter().copied().flatten().collect();
        partial += usize::from(!known.is_empty() && known.len() < around.len());
        let mean = known.iter().sum::<DVec3>() / known.len().max(1) as f64;
        assert!(
            DVec3::from_array(gradient.map(f64::from)).distance(mean) < 1e-5,
            "{cell} {layer}: {gradient:?} {mean}"
        );
    }
    assert!(partial > 100, "{partial} vertices beside voids");
}
