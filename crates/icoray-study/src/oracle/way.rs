//! A ray's way through layers of any heights, by intersection with the cone of every triangle in double-double: no
//! traversal, and no code of the renderer's.
//!
//! With the coordinates α of a point in the unit vectors of a triangle's cells, the facet of a layer with the radii R
//! is `ψ = Σ α/R = 1`, and the value between two facets, linear along the radius, is
//! `((1 - ψ') Σ αg/R + (ψ - 1) Σ αg'/R') / (ψ - ψ')`: a sum of the six vertices' values with weights that add up to 1.

use super::blend::Course;
use super::interpolant::FrustumInterpolant;
use crate::stability::dd::Dd;
use crate::stability::path::Column;

/// A triangle's column along a ray, and where its layers are.
pub(crate) struct LayeredColumn<'c, R> {
    pub column: &'c Column,
    pub layers: usize,
    /// Radius of a layer at a cell.
    pub radius: R,
}

/// A part of a ray between two layers.
pub(crate) struct Frustum {
    /// Weights of the lower and upper vertices at the start, in the middle and at the end.
    pub weight: [[Dd; 6]; 3],
    /// `ψ - ψ'` at the start and at the end, which is as the height.
    pub height: [Dd; 2],
}

impl<R: Fn(u32, usize) -> f64> LayeredColumn<'_, R> {
    /// The terms of ψ at `t`.
    fn terms(&self, layer: usize, t: Dd) -> [Dd; 3] {
        let alpha = self.column.coordinates(t);
        [0, 1, 2].map(|k| alpha[k] / Dd::from((self.radius)(self.column.cells[k], layer)))
    }

    fn psi(&self, layer: usize, t: Dd) -> Dd {
        let [a, b, c] = self.terms(layer, t);
        a + b + c
    }

    /// The number of layers at or below the point at `t`.
    pub fn layers_below(&self, t: Dd) -> usize {
        (0..self.layers).take_while(|layer| self.psi(*layer, t) >= Dd::ONE).count()
    }

    /// The column's ends and the places between them where the ray crosses a layer, in order, with its number.
    pub fn crossings(&self) -> Vec<(Dd, Option<usize>)> {
        let [start, end] = self.column.t;
        let mut found = vec![(start, None), (end, None)];
        for layer in 0..self.layers {
            let ends = [self.psi(layer, start), self.psi(layer, end)];
            if (ends[0] >= Dd::ONE) != (ends[1] >= Dd::ONE) {
                let t = start + (end - start) * ((Dd::ONE - ends[0]) / (ends[1] - ends[0]));
                found.push((t.max(start).min(end), Some(layer)));
            }
        }
        found[1..].sort_by(|a, b| a.0.partial_cmp(&b.0).expect("places are numbers"));
        found
    }

    /// Where the ray meets the facet whose vertices all have this radius.
    pub fn meets(&self, radius: f64) -> Option<Dd> {
        let [start, end] = self.column.t;
        let t = self.column.reaches(radius)?;
        (start <= t && t < end).then_some(t)
    }

    /// Weights of the vertices of a layer's facet at `t`.
    pub fn on_layer(&self, layer: usize, t: Dd) -> [f64; 3] {
        let psi = self.psi(layer, t);
        self.terms(layer, t).map(|term| (term / psi).to_f64())
    }

    /// The part from `from` to `to`, above `layer`.
    pub fn frustum(&self, layer: usize, [from, to]: [Dd; 2]) -> Frustum {
        let places = [from, (from + to) / 2.0, to].map(|t| {
            let (low, high) = (self.terms(layer, t), self.terms(layer + 1, t));
            let [below, above] = [low, high].map(|[a, b, c]| a + b + c);
            let depth = below - above;
            let [down, up] = [(Dd::ONE - above) / depth, (below - Dd::ONE) / depth];
            let weight = |k: usize| if k < 3 { down * low[k] } else { up * high[k - 3] };
            ([0, 1, 2, 3, 4, 5].map(weight), depth)
        });
        Frustum { weight: places.map(|(weight, _)| weight), height: [places[0].1, places[2].1] }
    }
}

impl Frustum {
    /// The course of a quantity with these values at the lower and upper vertices; `None` where one is missing.
    pub fn course(&self, values: [f64; 6]) -> Option<Course> {
        if values.iter().any(|value| value.is_nan()) {
            return None;
        }
        let base = values[0];
        let at = |weight: [Dd; 6]| (1..6).map(|k| weight[k].to_f64() * (values[k] - base)).sum::<f64>();
        let [start, middle, end] = self.weight.map(at);
        let eps = (self.height[1] / self.height[0] - Dd::ONE).to_f64();
        let bend = (middle - 0.5 * (start + end)) * 4.0 * (1.0 + 0.5 * eps);
        Some(Course { base, f: FrustumInterpolant { f: [start, end], bend, eps } })
    }
}
