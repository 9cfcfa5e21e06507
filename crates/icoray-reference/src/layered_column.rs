//! A ray's path through layers of any heights in double-double, from its column of a triangle.
//!
//! With the coordinates α of a point in the unit vectors of a triangle's cells, the facet of a layer with the radii R
//! is `ψ = Σ α/R = 1`, and the value between two facets, linear along the radius, is
//! `((1 - ψ') Σ αg/R + (ψ - 1) Σ αg'/R') / (ψ - ψ')`: a sum of the six vertices' values with weights that add up to 1.

use crate::columns::Column;
use crate::double_double::Dd;

/// A triangle's column along a ray, and the radii of its layers.
pub(crate) struct LayeredColumn<'c, R> {
    pub column: &'c Column,
    pub layers: usize,
    /// Radius of a layer at a cell.
    pub radius: R,
}

/// A place where a ray crosses a layer, or an end of its column.
pub(crate) struct Crossing {
    pub t: Dd,
    pub layer: Option<usize>,
}

/// A part of a ray between two layers.
pub(crate) struct FrustumWeights {
    /// Weights of the lower and upper vertices at the start, in the middle and at the end.
    pub weight: [[Dd; 6]; 3],
    /// `ψ - ψ'` at the start and at the end, which is proportional to the height.
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

    /// The column's ends and the crossings between them, in order.
    pub fn crossings(&self) -> Vec<Crossing> {
        let [start, end] = self.column.t;
        let mut crossings = vec![Crossing { t: start, layer: None }, Crossing { t: end, layer: None }];
        for layer in 0..self.layers {
            let ends = [self.psi(layer, start), self.psi(layer, end)];
            if (ends[0] >= Dd::ONE) != (ends[1] >= Dd::ONE) {
                let t = start + (end - start) * ((Dd::ONE - ends[0]) / (ends[1] - ends[0]));
                crossings.push(Crossing { t: t.max(start).min(end), layer: Some(layer) });
            }
        }
        crossings[1..].sort_by(|a, b| a.t.partial_cmp(&b.t).expect("distances are numbers"));
        crossings
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
    pub fn frustum(&self, layer: usize, [from, to]: [Dd; 2]) -> FrustumWeights {
        let mut height = [Dd::ZERO; 3];
        let mut weight = [[Dd::ZERO; 6]; 3];
        for (i, t) in [from, (from + to) / 2.0, to].into_iter().enumerate() {
            let (low, high) = (self.terms(layer, t), self.terms(layer + 1, t));
            let [below, above] = [low, high].map(|[a, b, c]| a + b + c);
            height[i] = below - above;
            let [down, up] = [(Dd::ONE - above) / height[i], (below - Dd::ONE) / height[i]];
            weight[i] = [0, 1, 2, 3, 4, 5].map(|k| if k < 3 { down * low[k] } else { up * high[k - 3] });
        }
        FrustumWeights { weight, height: [height[0], height[2]] }
    }
}
