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

/// The values over a triangle.
struct LayerRanges {
    /// Those at each layer.
    at: Vec<LayerRange>,
    /// Range of heights of the finer grid's cells over the plane of the triangle.
    heights: [f64; 2],
}

/// The values at a layer over a triangle.
#[derive(Debug, Clone, Copy)]
struct LayerRange {
    /// Least and greatest of the coarser grid.
    own: [f64; 2],
    /// Least and greatest of the coarser grid, continued to the cells of the finer one.
    continued: [f64; 2],
    deviation: f64,
    /// Number of missing values.
    missing: f64,
    /// The steepest slope from here to the next layer.
    slope: f64,
}

impl GridPair<'_> {
    /// The values of each gap over a triangle, from the innermost.
    pub fn gaps(&self, triangle: u32) -> Vec<GapRange> {
        let layers = self.layers(triangle);
        let (cells, shift) = (self.over.of(triangle).len() as f64, self.shift());
        (0..self.radius.len().saturating_sub(1)).map(|gap| self.gap(&layers, gap, cells, shift)).collect()
    }

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

    /// The values at each layer over a triangle.
    fn layers(&self, triangle: u32) -> LayerRanges {
        let cells = self.coarse.counterclockwise(triangle).0;
        let at = cells.map_inline(|cell| self.coarse.direction(cell));
        let normal = [0, 1, 2].map_inline(|k: usize| at[(k + 1) % 3].cross(at[(k + 2) % 3]));
        let plane: DVec3 = normal.into_iter().sum();
        let count = self.radius.len();
        let inverse: Vec<f64> = self.radius.windows(2).map(|pair| 1.0 / (pair[1] - pair[0])).collect();
        let [a, b, c] = cells.map(|cell| {
            let mut column = vec![0.0; count];
            self.field.read_column(self.cells[cell as usize] as usize, &mut column);
            column
        });
        let own = |layer: usize| [a[layer], b[layer], c[layer]].into_iter().fold(NOTHING, widened);
        let none = LayerRange { own: NOTHING, continued: NOTHING, deviation: 0.0, missing: 0.0, slope: 0.0 };
        let at = (0..count).map(|layer| LayerRange { own: own(layer), ..none }).collect();
        let mut found = LayerRanges { at, heights: NOTHING };
        let mut column = vec![0.0; count];
        for &cell in self.over.of(triangle) {
            self.field.read_column(cell as usize, &mut column);
            let direction = self.fine.direction(cell);
            let height = plane.dot(direction);
            found.heights = widened(found.heights, height);
            let [u, v, w] = normal.map_inline(|normal| normal.dot(direction) / height);
            let coarse = a.iter().zip(&b).zip(&c).map(|((a, b), c)| u * a + v * b + w * c);
            for ((value, coarse), found) in column.iter().zip(coarse).zip(&mut found.at) {
                let [low, high] = &mut found.continued;
                (*low, *high) = (lesser(*low, coarse), greater(*high, coarse));
                found.deviation = greater(found.deviation, (value - coarse).abs());
                found.missing += f64::from(u8::from(value.is_nan()));
            }
            for ((pair, inverse), found) in column.windows(2).zip(&inverse).zip(&mut found.at) {
                found.slope = greater(found.slope, (pair[1] - pair[0]).abs() * inverse);
            }
        }
        found
    }

    /// The values of the gap above a layer over this number of cells; `shift` is that of the module's head.
    fn gap(&self, layers: &LayerRanges, gap: usize, cells: f64, shift: f64) -> GapRange {
        let ends = &layers.at[gap..gap + 2];
        if ends.iter().any(|layer| layer.missing == cells) {
            return GapRange::NONE;
        }
        let [low, high] = ends.iter().flat_map(|layer| layer.own).fold(NOTHING, widened);
        let (radius, shift) = (self.radius, self.radius[gap + 1] * shift);
        let touched = touched(radius, [radius[gap] - shift, radius[gap + 1] + shift]);
        if layers.at[touched.start..touched.end + 1].iter().any(|layer| layer.missing > 0.0) {
            return GapRange { low, high, deviation: f64::INFINITY };
        }
        let spread = layers.heights[1] / layers.heights[0] - 1.0;
        let slope = layers.at[touched].iter().map(|layer| layer.slope).fold(0.0, f64::max);
        let horizontal = ends.iter().map(|layer| {
            let [low, high] = layer.continued;
            layer.deviation + spread * (high - low)
        });
        GapRange { low, high, deviation: horizontal.fold(0.0, f64::max) + slope * shift }
    }
}

const NOTHING: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];

/// The lesser of two numbers; the first if the second is missing.
fn lesser(a: f64, b: f64) -> f64 {
    if b < a { b } else { a }
}

/// The greater of two numbers; the first if the second is missing.
fn greater(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

/// The range with a value, unless that is missing.
fn widened([low, high]: [f64; 2], value: f64) -> [f64; 2] {
    [lesser(low, value), greater(high, value)]
}

/// The gaps that a range of radii touches.
fn touched(radius: &[f64], [low, high]: [f64; 2]) -> Range<usize> {
    let last = radius.len() - 1;
    let first = radius.partition_point(|r| *r <= low).saturating_sub(1).min(last - 1);
    first..radius.partition_point(|r| *r < high).clamp(first + 1, last)
}

#[cfg(test)]
mod tests;
