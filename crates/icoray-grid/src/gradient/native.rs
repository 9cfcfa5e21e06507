//! Gradients if each column's layers have separate heights.
//!
//! As for concentric layers, the three slopes at vertex A of a frustum determine its gradient: along A the change to
//! the next layer, along `R·B - R·A` and `R·C - R·A`, now with a radius at each vertex, the changes to the neighbours
//! on the same layer.

use super::{Gradients, narrowed};
use crate::array::MapInline;
use crate::error::Result;
use crate::grid::Grid;
use crate::heights::Heights;
use crate::sample::Sample;
use crate::samples::Samples;
use glam::DVec3;
use rayon::prelude::*;
use std::ops::Range;

/// Gradients of the normalised field at the vertices over `cells`, per planet radius, level-fastest; zero if unknown.
/// Reuses `memory`.
///
/// # Errors
/// [`ErrorKind::Memory`](crate::error::ErrorKind::Memory) if they do not fit.
pub fn gradients<S: Sample>(
    grid: &Grid,
    heights: &Heights,
    samples: &Samples<S>,
    cells: Range<usize>,
    memory: Gradients<'static>,
) -> Result<Gradients<'static>> {
    let layers = heights.layers();
    let mut gradients = memory.with_room(cells.len() * layers, false)?;
    let rows = gradients.whole_mut().par_chunks_exact_mut(layers).with_min_len(64).enumerate();
    rows.for_each_init(Vec::new, |around_cell: &mut Vec<[u32; 2]>, (i, row)| {
        let cell = (cells.start + i) as u32;
        let around = NeighborColumns { grid, heights, samples, cell };
        around_cell.clear();
        around_cell.extend(grid.fans(cell));
        for (layer, gradient) in row.iter_mut().enumerate() {
            *gradient = narrowed(around.mean(around_cell, layer));
        }
    });
    Ok(gradients)
}

/// The direction across a layer at each of `cells`, outwards: the mean of the facets around it, weighted by area. Reuses
/// `memory`.
pub fn normals(
    grid: &Grid,
    heights: &Heights,
    layer: usize,
    cells: Range<usize>,
    mut memory: Vec<[f32; 3]>,
) -> Vec<[f32; 3]> {
    let place = |cell: u32| heights.radius(cell, layer) * grid.direction(cell);
    let normal = |cell: u32| {
        let (up, own) = (grid.direction(cell), place(cell));
        let across = grid.fans(cell).map(|others| {
            let [b, c] = others.map_inline(|other| place(other) - own);
            let across = b.cross(c);
            if across.dot(up) < 0.0 { -across } else { across }
        });
        across.sum::<DVec3>().try_normalize().unwrap_or(up).as_vec3().to_array()
    };
    (cells.start as u32..cells.end as u32).into_par_iter().with_min_len(256).map(normal).collect_into_vec(&mut memory);
    memory
}

/// A cell's column and those around it.
struct NeighborColumns<'a, S> {
    grid: &'a Grid<'a>,
    heights: &'a Heights<'a>,
    samples: &'a Samples<'a, S>,
    cell: u32,
}

impl<S: Sample> NeighborColumns<'_, S> {
    /// The value as the model has it.
    fn value(&self, cell: u32, layer: usize) -> f64 {
        self.samples.unscaled(self.samples.base(cell), layer)
    }

    /// The mean of the slopes to the layers above and below, as far as these exist.
    fn radial(&self, layer: usize) -> Option<f64> {
        let slope = |low: usize, high: usize| {
            let thickness = self.heights.radius(self.cell, high) - self.heights.radius(self.cell, low);
            (self.value(self.cell, high) - self.value(self.cell, low)) * self.samples.mapping.scale / thickness
        };
        let below = layer.checked_sub(1).map(|below| slope(below, layer));
        let above = (layer + 1 < self.heights.layers()).then(|| slope(layer, layer + 1));
        let known = below.into_iter().chain(above).filter(|slope| slope.is_finite());
        let (sum, count) = known.fold((0.0, 0), |(sum, count), slope| (sum + slope, count + 1));
        (count > 0).then(|| sum / f64::from(count))
    }

    fn mean(&self, fans: &[[u32; 2]], layer: usize) -> DVec3 {
        let Some(radial) = self.radial(layer) else { return DVec3::ZERO };
        let place = |cell: u32| self.heights.radius(cell, layer) * self.grid.direction(cell);
        let (a, value) = (self.grid.direction(self.cell), self.value(self.cell, layer));
        let own = place(self.cell);
        let (mut sum, mut count) = (DVec3::ZERO, 0);
        for others in fans {
            let [b, c] = others.map_inline(|other| place(other) - own);
            let [to_b, to_c] =
                others.map_inline(|other| (self.value(other, layer) - value) * self.samples.mapping.scale);
            let volume = a.dot(b.cross(c));
            let gradient = (radial * b.cross(c) + to_b * c.cross(a) + to_c * a.cross(b)) / volume;
            if gradient.is_finite() {
                sum += gradient;
                count += 1;
            }
        }
        if count > 0 { sum / f64::from(count) } else { DVec3::ZERO }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{Field, Location};
    use crate::grid::icosahedral_grid;
    use crate::layers::Layers;

    /// Between flat facets a field that is linear in space is exact at every vertex, for any heights of layers.
    #[test]
    fn a_linear_field_has_its_slope_everywhere() {
        const LAYERS: usize = 4;
        let grid = icosahedral_grid(3);
        let height = |cell: usize, layer: usize| 0.1 * layer as f64 + 0.03 * ((7 * cell) % 11) as f64 / 11.0;
        let all = || (0..grid.cells()).flat_map(|cell| (0..LAYERS).map(move |layer| (cell, layer)));
        let heights: Vec<f64> = all().map(|(cell, layer)| height(cell, layer)).collect();
        let slope = DVec3::new(0.3, -1.1, 0.7);
        let place = |cell: usize, layer: usize| (1.0 + height(cell, layer)) * grid.direction(cell as u32);
        let values: Vec<f64> = all().map(|(cell, layer)| slope.dot(place(cell, layer))).collect();
        let [heights, field] =
            [&heights, &values].map(|data| Field::level_fastest(data, LAYERS, Location::Center).unwrap());
        let layers = Layers::from_heights(&[0.0, 0.1, 0.2, 0.3], 1.0).unwrap();
        let heights = Heights::new(&heights, &layers, &grid, LAYERS, 1.0).unwrap();
        let samples = Samples::new(&values, &field, false, [0.0, 1.0]);
        let found = gradients(&grid, &heights, &samples, 0..grid.cells(), Gradients::none()).unwrap();
        for i in 0..grid.cells() * LAYERS {
            let error = DVec3::from_array(found.at(i).map(f64::from)) - slope;
            assert!(error.length() < 1e-5, "{i}: {error}");
        }
    }
}
