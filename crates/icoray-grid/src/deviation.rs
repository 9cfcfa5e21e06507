//! The most by which the values of a grid differ from those of a coarser one ([`CoarseGrid`](crate::CoarseGrid)).
//!
//! Over a triangle T of the finer grid both fields are interpolated between vertices: `f = Σ wᵢ fᵢ` with the weights of
//! T, and the coarse field of a triangle A is `g = Σ wᵢ hᵢ gᵢ / Σ wᵢ hᵢ`, where gᵢ continues g to the vertices of T and
//! hᵢ is the height of these over the plane of A. So `|f - g| <= max |fᵢ - gᵢ| + (max h / min h - 1) (max gᵢ - min
//! gᵢ)`, for all vertices of all T that overlap A. Vertically both are linear between layers, so that the largest
//! difference lies at a layer.
//!
//! Facets lie up to `1 - q` of their radius below the sphere, q the least height of a grid's planes over the centre. The
//! layers of the coarser grid are raised by the factor [`GridPair::lift`], so that they are as far above those of the
//! finer grid at vertices as below them in between. One place is then up to `r s` higher in one grid than in the other,
//! s about half of the depth of the coarser facets, and its value changes by at most that times the steepest vertical
//! slope there. Where one grid has a layer above the outermost or below the innermost one of the other, nothing is said.

use crate::array::MapInline;
use crate::field::Field;
use crate::grid::{CellsOver, Grid};
use fearless_simd::{Level, Simd, dispatch, f64x8, prelude::*};
use glam::DVec3;
use std::ops::Range;

/// The values of a coarser grid in a gap between layers over a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GapRange {
    /// The least value.
    pub low: f64,
    /// The greatest value; less than the least if both grids have only missing values.
    pub high: f64,
    /// The most by which the finer grid's values differ from these; infinite if some values are missing.
    pub deviation: f64,
}

impl GapRange {
    /// That of missing values.
    const NONE: Self = GapRange { low: f64::INFINITY, high: f64::NEG_INFINITY, deviation: 0.0 };
    /// That of values of which some are missing.
    const UNKNOWN: Self = GapRange { low: f64::NEG_INFINITY, high: f64::INFINITY, deviation: f64::INFINITY };
}

/// A field on a grid, and a coarser grid over some of its cells.
#[derive(Clone, Copy)]
pub struct GridPair<'g> {
    /// The finer grid.
    pub fine: &'g Grid<'g>,
    /// The values over its cells; the first layer is the innermost.
    pub field: Field<'g>,
    /// Radii of the layers.
    pub radius: &'g [f64],
    /// The coarser grid.
    pub coarse: &'g Grid<'g>,
    /// The number of each of its cells in the finer grid.
    pub cells: &'g [u32],
    /// The cells over its triangles.
    pub over: &'g CellsOver,
}

impl GridPair<'_> {
    /// The factor by which radii of the coarser grid's layers are larger.
    pub fn lift(&self) -> f64 {
        0.5 * (1.0 + 1.0 / self.coarse.lowest_facet())
    }

    /// The least and the greatest height of facets of the finer and of the coarser grid, relative to the radius of their
    /// layer in the finer one.
    pub fn facets(&self) -> [[f64; 2]; 2] {
        let lift = self.lift();
        [[self.fine.lowest_facet(), 1.0], [lift * self.coarse.lowest_facet(), lift]]
    }

    /// How much higher a place may be in one grid than in the other, relative to the radius.
    fn shift(&self) -> f64 {
        let [fine, coarse] = self.facets();
        (fine[1] / coarse[0]).max(coarse[1] / fine[0]) - 1.0
    }

    /// The gaps that facets of the innermost and of the outermost layer of either grid may reach.
    pub fn ends(&self) -> [Range<usize>; 2] {
        let (radius, [fine, coarse]) = (self.radius, self.facets());
        let (low, high) = (fine[0].min(coarse[0]), fine[1].max(coarse[1]));
        let [first, last] = [radius[0], radius[radius.len() - 1]];
        [touched(radius, [first, first * high / low]), touched(radius, [last * low / high, last])]
    }
}

/// Values in a vector.
const LANES: usize = 8;

/// Finds the values in the gaps over one triangle after another.
pub struct GapFinder<'g> {
    pair: GridPair<'g>,
    gaps: Vec<Gap>,
    /// Inverse thickness of the gap above each layer, with zeros up to a whole vector.
    inverse: Vec<f64>,
    /// The values at the vertices of the triangle and at the cells over it, each column as long as `inverse`.
    columns: Vec<f64>,
    /// The weights of the vertices at each cell.
    weights: Vec<[f64; 3]>,
    layers: Vec<LayerRange>,
}

/// A gap over any triangle.
struct Gap {
    /// How much higher a place may be in one grid than in the other.
    shift: f64,
    /// The gaps in which the place may be there.
    touched: Range<usize>,
}

/// The values at a layer over a triangle.
struct LayerRange {
    /// Least of the coarser grid.
    low: f64,
    /// Greatest of the coarser grid.
    high: f64,
    /// The most by which the finer grid's values differ from these.
    deviation: f64,
    /// Number of missing values.
    missing: f64,
    /// The steepest slope from here to the next layer.
    slope: f64,
}

impl<'g> GapFinder<'g> {
    /// Finds the values of `pair`.
    pub fn new(pair: GridPair<'g>) -> Self {
        let (radius, shift) = (pair.radius, pair.shift());
        let gap = |ends: &[f64]| {
            let shift = shift * ends[1];
            Gap { shift, touched: touched(radius, [ends[0] - shift, ends[1] + shift]) }
        };
        let gaps = radius.windows(2).map(gap).collect();
        let mut inverse: Vec<f64> = radius.windows(2).map(|ends| 1.0 / (ends[1] - ends[0])).collect();
        inverse.resize(radius.len().next_multiple_of(LANES), 0.0);
        GapFinder { pair, gaps, inverse, columns: Vec::new(), weights: Vec::new(), layers: Vec::new() }
    }

    /// The values of each gap over a triangle, from the innermost.
    pub fn gaps(&mut self, triangle: u32) -> impl Iterator<Item = GapRange> {
        let cells = self.pair.over.of(triangle);
        dispatch!(Level::new(), simd => self.read(simd, triangle, cells));
        let gaps = self.gaps.iter().zip(self.layers.windows(2));
        gaps.map(|(gap, ends)| gap.range(ends, &self.layers, cells.len() as f64))
    }

    /// Finds the values at each layer over a triangle, over which these cells are.
    #[inline(always)]
    fn read<V: Simd>(&mut self, simd: V, triangle: u32, over: &[u32]) {
        let GridPair { fine, field, radius, coarse, cells, .. } = self.pair;
        let vertices = coarse.triangle(triangle);
        let at = vertices.map_inline(|cell| coarse.direction(cell));
        let normal = [0, 1, 2].map_inline(|k: usize| at[(k + 1) % 3].cross(at[(k + 2) % 3]));
        let plane: DVec3 = normal.into_iter().sum();
        let [mut lowest, mut highest] = [f64::INFINITY, f64::NEG_INFINITY];
        self.weights.clear();
        self.weights.extend(over.iter().map(|cell| {
            let direction = fine.direction(*cell);
            let height = plane.dot(direction);
            (lowest, highest) = (lowest.min(height), highest.max(height));
            normal.map_inline(|normal| normal.dot(direction) / height)
        }));
        let spread = highest / lowest - 1.0;
        let length = self.inverse.len();
        // One more, as the layers above those of a vector are read too.
        self.columns.resize((3 + over.len()) * length + 1, 0.0);
        let all = vertices.map_inline(|vertex| &cells[vertex as usize]).into_iter().chain(over);
        for (cell, column) in all.zip(self.columns.chunks_exact_mut(length)) {
            field.read_column(*cell as usize, &mut column[..radius.len()]);
        }
        let vector = |of: &[f64], start: usize| f64x8::from_slice(simd, &of[start..start + LANES]);
        let [zero, one] = [0.0, 1.0].map_inline(|value| f64x8::splat(simd, value));
        self.layers.clear();
        for first in (0..length).step_by(LANES) {
            let [a, b, c] = [0, 1, 2].map_inline(|vertex| vector(&self.columns, vertex * length + first));
            let [mut low, mut high] = [f64::INFINITY, f64::NEG_INFINITY].map_inline(|value| f64x8::splat(simd, value));
            let [mut deviation, mut missing, mut step] = [zero; 3];
            for (start, [u, v, w]) in (3 * length + first..).step_by(length).zip(&self.weights) {
                let [value, above] = [start, start + 1].map_inline(|start| vector(&self.columns, start));
                let continued = a * *u + b * *v + c * *w;
                (low, high) = (low.min(continued), high.max(continued));
                deviation = deviation.max((value - continued).abs());
                missing += value.simd_eq(value).select(zero, one);
                step = step.max((above - value).abs());
            }
            deviation += (high - low) * spread;
            let slope = step * vector(&self.inverse, first);
            let (low, high) = (a.min(b).min(c), a.max(b).max(c));
            self.layers.extend((0..LANES).map(|k| LayerRange {
                low: low[k],
                high: high[k],
                deviation: deviation[k],
                missing: missing[k],
                slope: slope[k],
            }));
        }
        self.layers.truncate(radius.len());
    }
}

impl Gap {
    /// The values between the two layers at its ends, out of all layers over a triangle and this number of cells.
    #[inline]
    fn range(&self, ends: &[LayerRange], layers: &[LayerRange], cells: f64) -> GapRange {
        if ends.iter().any(|layer| layer.missing == cells) {
            return GapRange::NONE;
        }
        let Range { start, end } = self.touched;
        if layers[start..=end].iter().any(|layer| layer.missing > 0.0) {
            return GapRange::UNKNOWN;
        }
        let slope = layers[start..end].iter().fold(0.0, |most: f64, layer| most.max(layer.slope));
        let deviation = ends[0].deviation.max(ends[1].deviation) + slope * self.shift;
        GapRange { low: ends[0].low.min(ends[1].low), high: ends[0].high.max(ends[1].high), deviation }
    }
}

/// The gaps that a range of radii touches.
fn touched(radius: &[f64], [low, high]: [f64; 2]) -> Range<usize> {
    let last = radius.len() - 1;
    let first = radius.partition_point(|r| *r <= low).saturating_sub(1).min(last - 1);
    first..radius.partition_point(|r| *r < high).clamp(first + 1, last)
}

#[cfg(test)]
mod tests;
