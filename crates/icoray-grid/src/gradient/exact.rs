//! Gradients in double precision, for any cell: beside holes, and at missing values.

use crate::array::MapInline;
use crate::grid::Grid;
use crate::sample::Sample;
use crate::samples::Samples;
use glam::DVec3;
use std::ops::Range;

/// One triangle around a cell: indices of its two other cells in the ring, and the dual basis at the cell.
struct IncidentTriangle {
    others: [usize; 2],
    radial: DVec3,
    along: [DVec3; 2],
}

/// A cell's neighbours and the triangles that it makes with them.
#[derive(Default)]
pub(super) struct Ring {
    pub neighbours: Vec<u32>,
    /// The mean gradient at radius 1 per unit of difference to each neighbour, when all triangles count.
    pub weight: Vec<DVec3>,
    /// The mean gradient per unit of the radial slope.
    pub radial: DVec3,
    fans: Vec<IncidentTriangle>,
}

impl Ring {
    pub fn read(&mut self, grid: &Grid, cell: u32) {
        self.neighbours.clear();
        self.fans.clear();
        let a = grid.direction(cell);
        for others in grid.fans(cell) {
            let [b, c] = others.map_inline(|o| grid.direction(o) - a);
            let volume = a.dot(b.cross(c));
            let others = others.map_inline(|o| {
                self.neighbours.iter().position(|&n| n == o).unwrap_or_else(|| {
                    self.neighbours.push(o);
                    self.neighbours.len() - 1
                })
            });
            let along = [c.cross(a) / volume, a.cross(b) / volume];
            self.fans.push(IncidentTriangle { others, radial: b.cross(c) / volume, along });
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

/// The values over a cell and its neighbours, and the gradients there; reused from cell to cell.
pub(super) struct NeighborColumns<'r> {
    radius: &'r [f64],
    /// The factor of normalisation over each layer's radius, and over each gap's thickness.
    inverse_radius: Vec<f64>,
    inverse_gap: Vec<f64>,
    own: Vec<f64>,
    /// A column of values per neighbour.
    around: Vec<f64>,
    /// The sum of all values on each layer: NaN where one is missing.
    total: Vec<f64>,
    /// x, y and z of the mean over all frusta, which is valid if no value is missing.
    mean: [Vec<f64>; 3],
}

impl<'r> NeighborColumns<'r> {
    /// For layers with these radii, and values that `scale` normalises.
    pub fn new(radius: &'r [f64], scale: f64) -> Self {
        let zeros = || vec![0.0; radius.len()];
        NeighborColumns {
            radius,
            inverse_radius: radius.iter().map(|r| scale / r).collect(),
            inverse_gap: radius.windows(2).map(|w| scale / (w[1] - w[0])).collect(),
            own: zeros(),
            around: Vec::new(),
            total: zeros(),
            mean: [zeros(), zeros(), zeros()],
        }
    }

    /// Reads the values that the gradients on layers `wanted` need: those of the layers below and above too.
    pub fn read<S: Sample>(&mut self, samples: &Samples<S>, cell: u32, neighbours: &[u32], wanted: &Range<usize>) {
        let layers = self.radius.len();
        let read = wanted.start.saturating_sub(1)..(wanted.end + 1).min(layers);
        let fill = |column: &mut [f64], cell: u32| {
            let base = samples.base(cell);
            for (layer, value) in read.clone().zip(&mut column[read.clone()]) {
                *value = samples.unscaled(base, layer);
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

    /// Computes the mean over all incident frusta, as if no value were missing.
    pub fn means(&mut self, ring: &Ring, wanted: &Range<usize>) {
        let layers = self.radius.len();
        let [x, y, z] = self.mean.each_mut().map_inline(|mean| &mut mean[wanted.clone()]);
        for (i, layer) in wanted.clone().enumerate() {
            let slope = |gap: usize| (self.own[gap + 1] - self.own[gap]) * self.inverse_gap[gap];
            let slope = match layer {
                0 => slope(0),
                l if l + 1 == layers => slope(l - 1),
                l => 0.5 * (slope(l - 1) + slope(l)),
            };
            x[i] = slope * ring.radial.x;
            y[i] = slope * ring.radial.y;
            z[i] = slope * ring.radial.z;
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
    pub fn is_whole(&self, layer: usize) -> bool {
        let last = (layer + 1).min(self.radius.len() - 1);
        !self.total[layer.saturating_sub(1)..=last].iter().any(|t| t.is_nan())
    }

    pub fn mean(&self, layer: usize) -> DVec3 {
        DVec3::new(self.mean[0][layer], self.mean[1][layer], self.mean[2][layer])
    }

    /// The mean over those frusta at `layer` that miss no value.
    pub fn mean_of_complete(&self, ring: &Ring, layer: usize) -> DVec3 {
        let layers = self.radius.len();
        let value = |neighbour: usize, layer: usize| self.around[neighbour * layers + layer];
        let gaps = [layer.checked_sub(1), (layer + 1 < layers).then_some(layer)];
        let (mut sum, mut count) = (DVec3::ZERO, 0.0);
        for fan in &ring.fans {
            let [b, c] = fan.others.map_inline(|o| value(o, layer) - self.own[layer]);
            let flat = (b * fan.along[0] + c * fan.along[1]) * self.inverse_radius[layer];
            for gap in gaps.into_iter().flatten() {
                let beyond = if gap < layer { gap } else { gap + 1 };
                let slope = (self.own[gap + 1] - self.own[gap]) * self.inverse_gap[gap];
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
