//! Gradients at the vertices: the mean over the frusta around each (§3.5 of the paper).
//!
//! At vertex A of a frustum the interpolant's gradient G is fixed by three slopes: along A, the change to the next layer;
//! along B - A and C - A, the changes to the neighbours on the same layer. With the dual basis e of these three vectors,
//! `G = s·eA + ((gB - gA)·eB + (gC - gA)·eC)/R`. The frusta above and below share the triangle, so the mean over 12 frusta
//! (10 at a pentagon, half of that on the innermost and outermost layer) is the mean over the triangles with the mean of
//! the two radial slopes. Frusta with a missing value are left out of the mean.

use crate::grid::Grid;
use crate::kernel::sample::{Sample, Samples};
use glam::DVec3;
use rayon::prelude::*;

/// One triangle around a cell: its two other cells and the dual basis at the cell.
struct Fan {
    cells: [u32; 2],
    radial: DVec3,
    along: [DVec3; 2],
}

fn fans(grid: &Grid, cell: u32) -> Vec<Fan> {
    let a = grid.direction(cell);
    let fan = |triangle| {
        let cells = grid.triangle(triangle);
        let k = cells.iter().position(|&c| c == cell)?;
        let others = [cells[(k + 1) % 3], cells[(k + 2) % 3]];
        let [b, c] = others.map(|o| grid.direction(o) - a);
        let volume = a.dot(b.cross(c));
        Some(Fan {
            cells: others,
            radial: b.cross(c) / volume,
            along: [c.cross(a) / volume, a.cross(b) / volume],
        })
    };
    grid.corners_of(cell).filter_map(fan).collect()
}

/// Gradients of the normalised field at every vertex, per planet radius, level-fastest; zero where nothing is known.
pub(crate) fn gradients<S: Sample>(grid: &Grid, radius: &[f64], samples: &Samples<S>) -> Vec<[f32; 3]> {
    let layers = radius.len();
    let mut gradients = vec![[0.0f32; 3]; grid.cells() * layers];
    let rows = gradients.par_chunks_exact_mut(layers).with_min_len(64).enumerate();
    rows.for_each_init(Columns::default, |columns, (cell, row)| {
        let fans = fans(grid, cell as u32);
        columns.read(samples, cell as u32, &fans, layers);
        for (layer, gradient) in row.iter_mut().enumerate() {
            *gradient = columns.gradient(&fans, radius, layer).as_vec3().to_array();
        }
    });
    gradients
}

/// The values over a cell and over the corners of its fans, reused from cell to cell.
#[derive(Default)]
struct Columns {
    own: Vec<f64>,
    others: Vec<[f64; 2]>,
}

impl Columns {
    fn read<S: Sample>(&mut self, samples: &Samples<S>, cell: u32, fans: &[Fan], layers: usize) {
        self.own.clear();
        let base = samples.base(cell);
        self.own.extend((0..layers).map(|l| samples.get::<f64>(base, l)));
        self.others.clear();
        for fan in fans {
            let base = fan.cells.map(|c| samples.base(c));
            self.others.extend((0..layers).map(|l| base.map(|b| samples.get::<f64>(b, l))));
        }
    }

    fn gradient(&self, fans: &[Fan], radius: &[f64], layer: usize) -> DVec3 {
        let layers = radius.len();
        let here = self.own[layer];
        if here.is_nan() {
            return DVec3::ZERO;
        }
        let next = [layer.checked_sub(1), (layer + 1 < layers).then_some(layer + 1)];
        let mut sum = DVec3::ZERO;
        let mut count = 0.0;
        for (fan, values) in fans.iter().zip(self.others.chunks_exact(layers)) {
            let [b, c] = values[layer].map(|v| v - here);
            let flat = (b * fan.along[0] + c * fan.along[1]) / radius[layer];
            for beyond in next.into_iter().flatten() {
                let slope = (self.own[beyond] - here) / (radius[beyond] - radius[layer]);
                let gradient = flat + slope * fan.radial;
                let whole =
                    !values[beyond][0].is_nan() && !values[beyond][1].is_nan() && gradient.is_finite();
                if whole {
                    sum += gradient;
                    count += 1.0;
                }
            }
        }
        if count > 0.0 { sum / count } else { DVec3::ZERO }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{Field, Location, Shape};
    use crate::grid::IcosahedralMesh;

    fn radii() -> Vec<f64> {
        vec![1.0, 1.03, 1.1, 1.2]
    }

    fn field_of(grid: &Grid, f: impl Fn(DVec3) -> f64) -> Vec<f64> {
        let cells = 0..grid.cells() as u32;
        cells
            .flat_map(|c| radii().into_iter().map(move |r| (c, r)))
            .map(|(c, r)| f(grid.direction(c) * r))
            .collect()
    }

    fn gradients_of(grid: &Grid, values: &[f64]) -> Vec<[f32; 3]> {
        let field =
            Field::new(values.into(), Shape::level_fastest(grid.cells(), 4), Location::Center, None).unwrap();
        gradients(grid, &radii(), &Samples::new(values, &field, false, [0.0, 1.0]))
    }

    /// A linear field is linear on every facet and along every radius: each frustum's gradient is the field's, so the
    /// mean is exact, at pentagons and on the outer and inner layers too.
    #[test]
    fn a_linear_field_has_its_own_gradient_everywhere() {
        let mesh = IcosahedralMesh::new(3).unwrap();
        let grid = Grid::new(mesh.tables()).unwrap();
        let slope = DVec3::new(0.3, -2.0, 0.7);
        let values = field_of(&grid, |p| p.dot(slope) + 5.0);
        for gradient in gradients_of(&grid, &values) {
            assert!(DVec3::from_array(gradient.map(f64::from)).distance(slope) < 1e-6, "{gradient:?}");
        }
    }

    #[test]
    fn frusta_with_missing_values_are_left_out_of_the_mean() {
        let mesh = IcosahedralMesh::new(2).unwrap();
        let grid = Grid::new(mesh.tables()).unwrap();
        let slope = DVec3::new(0.3, -2.0, 0.7);
        let mut values = field_of(&grid, |p| p.dot(slope));
        values[4 * 40 + 2] = f64::NAN;
        let gradients = gradients_of(&grid, &values);
        for (i, gradient) in gradients.iter().enumerate() {
            // The vertex above has frusta below it only, and all of those hold the missing value.
            let unknown = i == 4 * 40 + 2 || i == 4 * 40 + 3;
            let expected = if unknown { DVec3::ZERO } else { slope };
            assert!(
                DVec3::from_array(gradient.map(f64::from)).distance(expected) < 1e-6,
                "{i}: {gradient:?}"
            );
        }
    }
}
