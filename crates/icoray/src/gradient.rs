//! Gradients at the vertices: the mean over the frusta around each (§3.5 of the paper).
//!
//! At vertex A of a frustum the interpolant's gradient G is fixed by three slopes: along A, the change to the next layer;
//! along B - A and C - A, the changes to the neighbours on the same layer. With the dual basis e of these three vectors,
//! `G = s·eA + ((gB - gA)·eB + (gC - gA)·eC)/R`. The frusta above and below share the triangle, so the mean over 12 frusta
//! (10 at a pentagon, half of that on the innermost and outermost layer) is the mean over the triangles with the mean of
//! the two radial slopes. Frusta with a missing value are left out of the mean, and beside a hole there are fewer of them.

use crate::array::MapInline;
use crate::grid::Grid;
use crate::kernel::leap::Visible;
use crate::kernel::sample::{Sample, Samples};
use glam::DVec3;
use rayon::prelude::*;
use std::ops::Range;

mod kept;
pub(crate) mod native;
pub(crate) use kept::Gradients;
use kept::Kept;

/// One triangle around a cell: where its two other cells stand in the ring, and the dual basis at the cell.
struct Fan {
    others: [usize; 2],
    radial: DVec3,
    along: [DVec3; 2],
}

/// A cell's neighbours and the triangles that it makes with them.
#[derive(Default)]
struct Ring {
    neighbours: Vec<u32>,
    /// What one unit of difference to each neighbour adds to the mean gradient at radius 1, all triangles counting.
    weight: Vec<DVec3>,
    /// The same for the radial slope.
    radial: DVec3,
    fans: Vec<Fan>,
}

impl Ring {
    fn read(&mut self, grid: &Grid, cell: u32) {
        self.neighbours.clear();
        self.fans.clear();
        let a = grid.direction(cell);
        for triangle in grid.corners_of(cell).filter(|&corner| grid.is_triangle(corner)) {
            let cells = grid.triangle(triangle);
            let k = cells
                .iter()
                .position(|&c| c == cell)
                .expect("the grid's check found the cell at its corners");
            let others = [cells[(k + 1) % 3], cells[(k + 2) % 3]];
            let [b, c] = others.map_inline(|o| grid.direction(o) - a);
            let volume = a.dot(b.cross(c));
            let others = others.map_inline(|o| {
                self.neighbours.iter().position(|&n| n == o).unwrap_or_else(|| {
                    self.neighbours.push(o);
                    self.neighbours.len() - 1
                })
            });
            let along = [c.cross(a) / volume, a.cross(b) / volume];
            self.fans.push(Fan { others, radial: b.cross(c) / volume, along });
        }
        let share = 1.0 / self.fans.len() as f64;
        self.weight.clear();
        self.weight.resize(self.neighbours.len(), DVec3::ZERO);
        self.radial = DVec3::ZERO;
        for fan in &self.fans {
            self.radial += share * fan.radial;
            for k in 0..2 {
                self.weight[fan.others[k]] += share * fan.along[k];
            }
        }
    }
}

/// Which gradients are wanted, and how they are kept.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Wanted<'w> {
    /// Those that rays can see; all where it is `None`.
    pub visible: Option<&'w Visible>,
    pub packed: bool,
}

/// Gradients of the normalised field at the vertices over `cells`, per planet radius, level-fastest; zero where nothing is
/// known. In `memory`, which keeps whatever it holds where nothing is wanted.
pub(crate) fn gradients<S: Sample>(
    grid: &Grid,
    radius: &[f64],
    samples: &Samples<S>,
    cells: Range<usize>,
    wanted: Wanted,
    memory: Gradients,
) -> Gradients {
    let around = Around { grid, radius, samples, first: cells.start, visible: wanted.visible };
    let mut gradients = memory.with_room(cells.len() * radius.len(), wanted.packed);
    match &mut gradients {
        Gradients::Whole(all) => around.fill(all),
        Gradients::Packed(all) => around.fill(all),
    }
    gradients
}

/// What gradients are made of.
struct Around<'a, S> {
    grid: &'a Grid<'a>,
    radius: &'a [f64],
    samples: &'a Samples<'a, S>,
    first: usize,
    visible: Option<&'a Visible>,
}

impl<S: Sample> Around<'_, S> {
    fn fill<V: Kept>(&self, gradients: &mut [V]) {
        let layers = self.radius.len();
        let rows = gradients.par_chunks_exact_mut(layers).with_min_len(64).enumerate();
        rows.for_each_init(
            || (Ring::default(), Columns::new(self.radius)),
            |(ring, columns), (cell, row)| {
                let cell = (self.first + cell) as u32;
                let wanted =
                    self.visible.map_or(0..layers, |visible| visible.layers_over(self.grid, cell, layers));
                if wanted.is_empty() {
                    return;
                }
                ring.read(self.grid, cell);
                columns.read(self.samples, cell, &ring.neighbours, &wanted);
                columns.means(ring, &wanted);
                for layer in wanted {
                    let mean = if columns.is_whole(layer) {
                        columns.mean(layer)
                    } else {
                        columns.known(ring, layer)
                    };
                    row[layer] = V::of(narrowed(mean));
                }
            },
        );
    }
}

/// In single precision. Light asks for directions alone, so one that is too long is shortened: with infinite ones between
/// vertices nothing tells how light changes, and rays would be cut as fine as they can be. None where even doubles overflow.
fn narrowed(mean: DVec3) -> [f32; 3] {
    /// Sums of a few of these are no more than a float holds.
    const MOST: f64 = 1e30;
    let largest = mean.abs().max_element();
    if !mean.is_finite() {
        return [0.0; 3];
    }
    (mean * (MOST / largest).min(1.0)).as_vec3().to_array()
}

/// The values over a cell and its neighbours, and the gradients there; reused from cell to cell.
struct Columns<'r> {
    radius: &'r [f64],
    inverse_radius: Vec<f64>,
    inverse_gap: Vec<f64>,
    own: Vec<f64>,
    /// A column of values per neighbour.
    around: Vec<f64>,
    /// The sum of all values on each layer: NaN where one is missing.
    total: Vec<f64>,
    /// x, y and z of the mean over all frusta, which means something where no value is missing.
    mean: [Vec<f64>; 3],
}

impl<'r> Columns<'r> {
    fn new(radius: &'r [f64]) -> Self {
        let zeros = || vec![0.0; radius.len()];
        Columns {
            radius,
            inverse_radius: radius.iter().map(|r| 1.0 / r).collect(),
            inverse_gap: radius.windows(2).map(|w| 1.0 / (w[1] - w[0])).collect(),
            own: zeros(),
            around: Vec::new(),
            total: zeros(),
            mean: [zeros(), zeros(), zeros()],
        }
    }

    /// Reads what the gradients on layers `wanted` ask for: the layers below and above too.
    fn read<S: Sample>(
        &mut self,
        samples: &Samples<S>,
        cell: u32,
        neighbours: &[u32],
        wanted: &Range<usize>,
    ) {
        let layers = self.radius.len();
        let read = wanted.start.saturating_sub(1)..(wanted.end + 1).min(layers);
        let fill = |column: &mut [f64], cell: u32| {
            let base = samples.base(cell);
            for (layer, value) in read.clone().zip(&mut column[read.clone()]) {
                *value = samples.get(base, layer);
            }
        };
        fill(&mut self.own, cell);
        self.around.resize(neighbours.len() * layers, 0.0);
        self.total[read.clone()].copy_from_slice(&self.own[read.clone()]);
        for (column, &neighbour) in self.around.chunks_exact_mut(layers).zip(neighbours) {
            fill(column, neighbour);
            let sums = self.total[read.clone()].iter_mut().zip(&column[read.clone()]);
            sums.for_each(|(total, value)| *total += value);
        }
    }

    /// The mean over all incident frusta, as if no value were missing.
    fn means(&mut self, ring: &Ring, wanted: &Range<usize>) {
        let layers = self.radius.len();
        let [x, y, z] = self.mean.each_mut().map_inline(|mean| &mut mean[wanted.clone()]);
        for (i, layer) in wanted.clone().enumerate() {
            let slope = |gap: usize| (self.own[gap + 1] - self.own[gap]) * self.inverse_gap[gap];
            let slope = match layer {
                0 => slope(0),
                l if l + 1 == layers => slope(l - 1),
                l => 0.5 * (slope(l - 1) + slope(l)),
            };
            (x[i], y[i], z[i]) = (slope * ring.radial.x, slope * ring.radial.y, slope * ring.radial.z);
        }
        let (own, inverse) = (&self.own[wanted.clone()], &self.inverse_radius[wanted.clone()]);
        for (column, weight) in self.around.chunks_exact(layers).zip(&ring.weight) {
            let rows = column[wanted.clone()].iter().zip(own).zip(inverse);
            let sums = x.iter_mut().zip(y.iter_mut()).zip(z.iter_mut());
            for (((value, own), inverse), ((x, y), z)) in rows.zip(sums) {
                let difference = (value - own) * inverse;
                *x += weight.x * difference;
                *y += weight.y * difference;
                *z += weight.z * difference;
            }
        }
    }

    /// Whether all frusta at `layer` have all their values.
    fn is_whole(&self, layer: usize) -> bool {
        let last = (layer + 1).min(self.radius.len() - 1);
        !self.total[layer.saturating_sub(1)..=last].iter().any(|t| t.is_nan())
    }

    fn mean(&self, layer: usize) -> DVec3 {
        DVec3::new(self.mean[0][layer], self.mean[1][layer], self.mean[2][layer])
    }

    /// The mean over those frusta at `layer` that miss no value.
    fn known(&self, ring: &Ring, layer: usize) -> DVec3 {
        let layers = self.radius.len();
        let value = |neighbour: usize, layer: usize| self.around[neighbour * layers + layer];
        let next = [layer.checked_sub(1), (layer + 1 < layers).then_some(layer + 1)];
        let (mut sum, mut count) = (DVec3::ZERO, 0.0);
        for fan in &ring.fans {
            let [b, c] = fan.others.map_inline(|o| value(o, layer) - self.own[layer]);
            let flat = (b * fan.along[0] + c * fan.along[1]) * self.inverse_radius[layer];
            for beyond in next.into_iter().flatten() {
                let slope = (self.own[beyond] - self.own[layer]) / (self.radius[beyond] - self.radius[layer]);
                let gradient = flat + slope * fan.radial;
                let is_whole = fan.others.iter().all(|&o| !value(o, beyond).is_nan());
                if is_whole && gradient.is_finite() {
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
    use crate::field::{Field, Location};
    use crate::grid::IcosahedralMesh;
    use crate::shape::Shape;

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
        gradients(
            grid,
            &radii(),
            &Samples::new(values, &field, false, [0.0, 1.0]),
            0..grid.cells(),
            Wanted { visible: None, packed: false },
            Gradients::none(),
        )
        .whole()
        .to_vec()
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

    /// Where nothing can be seen memory stays as it was, and where something can the bits are those of all gradients.
    #[test]
    fn gradients_are_those_that_can_be_seen() {
        let mesh = IcosahedralMesh::new(3).unwrap();
        let grid = Grid::new(mesh.tables()).unwrap();
        let values = field_of(&grid, |p| (3.0 * p.x).sin() * (5.0 * p.y).cos() + p.z * p.z);
        let field = Field::new(
            values.as_slice().into(),
            Shape::level_fastest(grid.cells(), 4),
            Location::Center,
            None,
        )
        .unwrap();
        let samples = Samples::new(&values, &field, false, [0.0, 1.0]);
        let all = gradients_of(&grid, &values);
        // Blocks of one gap: each third triangle has the lowest, each seventh the uppermost.
        let blocks =
            (0..grid.triangles()).map(|t| u32::from(t % 3 == 0) | u32::from(t % 7 == 0) << 2).collect();
        let visible = Visible { blocks, ..Visible::default() };
        let unknown = Gradients::Whole(vec![[9.0; 3]; values.len()]);
        let wanted = Wanted { visible: Some(&visible), packed: false };
        let found = gradients(&grid, &radii(), &samples, 0..grid.cells(), wanted, unknown);
        let mut left_out = 0;
        for (i, gradient) in found.whole().iter().enumerate() {
            let around =
                grid.corners_of((i / 4) as u32).fold(0, |all, triangle| all | visible.over(triangle));
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

    /// Any field with holes: each vertex has the mean over those incident frusta that miss none of their six values, and
    /// a frustum's gradient solves its three slopes.
    #[test]
    fn the_mean_is_over_the_whole_incident_frusta() {
        let mesh = IcosahedralMesh::new(2).unwrap();
        let grid = Grid::new(mesh.tables()).unwrap();
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
}
