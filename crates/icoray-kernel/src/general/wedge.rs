//! A column between layers of any shape: layer facets are the planes through `R·V` of a triangle's three vertices V,
//! each with a radius R of its own.
//!
//! A point of the column is `Σ α·V`, with α linear along the ray. The facet of a layer is where `ψ = Σ α/R` is 1:
//! linear too, so that a ray crosses each facet of a column once at most, and below it ψ < 1. Radii rise with the
//! layers, so ψ falls with them, and the layers of a column are crossed in one order for any shape. On a facet a value
//! is barycentric, `Σ (α/R)·g/ψ`; between two of them it is linear along the radius, at the fraction
//! `w = ψ'(ψ - 1)/(ψ - ψ')` of the way from the lower (ψ) to the upper (ψ'). Both depend, on a side between two
//! columns, on the vertices of that side alone: values are continuous everywhere. Along the ray the value is
//! `((1 - ψ')·N + (ψ - 1)·N')/(ψ - ψ')` with N linear: a quadratic over a linear function, as in Eq. 3 of the paper,
//! which is the case of equal radii.

use super::levels::Levels;
use crate::walk::Column;
use icoray_grid::array::MapInline;
use icoray_grid::real::lerp;

/// A ray's path over one triangle.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Wedge {
    pub triangle: u32,
    pub cells: [u32; 3],
    /// Distances along the ray at the column's ends.
    pub t: [f64; 2],
    /// α at the column's ends.
    alpha: [[f64; 3]; 2],
}

impl Wedge {
    #[inline]
    pub fn new(column: &Column, triangle: u32) -> Self {
        let Column { cells, entry, exit, .. } = column;
        let alpha = [entry, exit].map_inline(|end| {
            let [b, c] = end.weight;
            [end.rho * (1.0 - b - c).max(0.0), end.rho * b, end.rho * c]
        });
        Wedge { triangle, cells: *cells, t: [entry.t, exit.t], alpha }
    }

    /// The distance at the fraction `u` of the column.
    #[inline]
    pub fn distance(&self, u: f64) -> f64 {
        lerp(self.t[0], self.t[1], u)
    }

    /// The fraction of the column at a distance.
    #[inline]
    pub fn fraction(&self, t: f64) -> f64 {
        let length = self.t[1] - self.t[0];
        if length > 0.0 { ((t - self.t[0]) / length).clamp(0.0, 1.0) } else { 0.0 }
    }

    /// α at the fraction `u` of the column.
    #[inline]
    pub fn alpha(&self, u: f64) -> [f64; 3] {
        let [a, b] = &self.alpha;
        [lerp(a[0], b[0], u), lerp(a[1], b[1], u), lerp(a[2], b[2], u)]
    }

    /// The vertex whose direction is nearest to that of the place at `u`: its Voronoi cell contains the place.
    #[inline]
    pub fn nearest(&self, u: f64, direction: impl Fn(u32) -> glam::DVec3) -> usize {
        let alpha = self.alpha(u);
        let vertices = self.cells.map_inline(direction);
        let at = alpha[0] * vertices[0] + alpha[1] * vertices[1] + alpha[2] * vertices[2];
        let near = |k: usize| at.dot(vertices[k]);
        (0..3).max_by(|&a, &b| near(a).total_cmp(&near(b))).unwrap_or(0)
    }
}

/// A layer in one column.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Facet {
    /// The layer, counted from the innermost.
    pub layer: usize,
    /// 1 / R at the vertices.
    inverse: [f64; 3],
    /// ψ at the column's ends.
    psi: [f64; 2],
}

impl Facet {
    #[inline]
    pub fn new(wedge: &Wedge, levels: &Levels, layer: usize) -> Self {
        Self::of_radii(wedge, layer, levels.inverse(wedge.cells, layer))
    }

    /// A facet with 1 / R at the vertices.
    #[inline]
    pub fn of_radii(wedge: &Wedge, layer: usize, inverse: [f64; 3]) -> Self {
        let psi = wedge.alpha.map_inline(|alpha| dot(&alpha, &inverse));
        Facet { layer, inverse, psi }
    }

    /// Whether the ray enters the column on or above it.
    #[inline]
    pub fn is_below_entry(&self) -> bool {
        self.psi[0] >= 1.0
    }

    /// The place at which the ray crosses it upwards.
    #[inline]
    pub fn up(&self) -> Option<f64> {
        (self.psi[0] < 1.0 && self.psi[1] >= 1.0).then(|| self.root())
    }

    /// The place at which the ray crosses it downwards.
    #[inline]
    pub fn down(&self) -> Option<f64> {
        (self.psi[0] >= 1.0 && self.psi[1] < 1.0).then(|| self.root())
    }

    #[inline]
    fn root(&self) -> f64 {
        ((1.0 - self.psi[0]) / (self.psi[1] - self.psi[0])).clamp(0.0, 1.0)
    }

    /// The weights of the second and third vertex at `u`, on the facet.
    #[inline]
    pub fn weights(&self, wedge: &Wedge, u: f64) -> [f64; 2] {
        let alpha = wedge.alpha(u);
        let [_, b, c] = [0, 1, 2].map_inline(|k| alpha[k] * self.inverse[k]);
        let psi = dot(&alpha, &self.inverse);
        [b / psi, c / psi]
    }
}

#[inline]
fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// A place between two facets, with the weights of values at their six vertices.
#[derive(Debug, Clone, Copy)]
pub(super) struct FrustumPoint {
    /// Weights of the second and third vertex on the lower and upper facet.
    on: [[f64; 2]; 2],
    /// Fraction of the way from the lower to the upper facet.
    w: f64,
    /// ψ - ψ', to which the value's denominator is proportional.
    pub depth: f64,
}

/// Whether a place lies on a facet, independent of rounding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FacetSide {
    Lower,
    Upper,
    Between,
}

impl FrustumPoint {
    #[inline]
    pub fn new(wedge: &Wedge, [lower, upper]: [&Facet; 2], u: f64, on: FacetSide) -> Self {
        let alpha = wedge.alpha(u);
        let psi = [lower, upper].map_inline(|facet| dot(&alpha, &facet.inverse));
        let depth = psi[0] - psi[1];
        let w = match on {
            FacetSide::Lower => 0.0,
            FacetSide::Upper => 1.0,
            // Facets that meet have no space in between.
            FacetSide::Between if depth <= 0.0 => 0.5,
            FacetSide::Between => (psi[1] * (psi[0] - 1.0) / depth).clamp(0.0, 1.0),
        };
        let weights = |facet: &Facet, psi: f64| [1, 2].map_inline(|k| alpha[k] * facet.inverse[k] / psi);
        FrustumPoint { on: [weights(lower, psi[0]), weights(upper, psi[1])], w, depth }
    }

    /// The interpolated value of `[lower, upper]` at the vertices; exact for a constant.
    #[inline]
    pub fn value(&self, [lower, upper]: [&[f64; 3]; 2]) -> f64 {
        let [below, above] = [(lower, self.on[0]), (upper, self.on[1])]
            .map_inline(|(g, [b, c])| g[0] + (b * (g[1] - g[0]) + c * (g[2] - g[0])));
        // On the upper facet it equals the next frustum's value on its lower one, to the bit.
        if self.w == 1.0 { above } else { below + self.w * (above - below) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::segment::Segment;
    use crate::walk::ColumnEnd;
    use glam::DVec3;

    /// A ray's way over a triangle, and the points of it by their definition.
    fn wedge() -> (Wedge, [DVec3; 3]) {
        let vertices = [DVec3::X, DVec3::new(0.96, 0.28, 0.0), DVec3::new(0.96, 0.1, 0.26).normalize()];
        let end = |t, rho, weight| ColumnEnd { t, rho, weight };
        let column = Column { cells: [0, 1, 2], entry: end(0.0, 1.02, [0.3, 0.0]), exit: end(0.4, 1.35, [0.25, 0.6]) };
        (Wedge::new(&column, 0), vertices)
    }

    fn point(wedge: &Wedge, vertices: &[DVec3; 3], u: f64) -> DVec3 {
        let alpha = wedge.alpha(u);
        (0..3).map(|k| alpha[k] * vertices[k]).sum()
    }

    #[test]
    fn facets_are_the_planes_through_their_vertices() {
        let (wedge, vertices) = wedge();
        let radii = [1.1, 1.2, 1.25];
        let facet = Facet::of_radii(&wedge, 0, radii.map(|r| 1.0 / r));
        let u = facet.up().expect("the ray rises from 1.02 to 1.35");
        assert!(facet.down().is_none() && !facet.is_below_entry());
        let [a, b, c] = [0, 1, 2].map(|k| radii[k] * vertices[k]);
        let at = point(&wedge, &vertices, u);
        let normal = (b - a).cross(c - a).normalize();
        assert!(normal.dot(at - a).abs() < 1e-14);
        let [wb, wc] = facet.weights(&wedge, u);
        assert!((a + wb * (b - a) + wc * (c - a) - at).length() < 1e-14);
    }

    #[test]
    fn values_are_linear_along_the_radius_and_rational_along_the_ray() {
        let (wedge, vertices) = wedge();
        let (low, high) = ([1.0, 0.98, 1.01], [1.4, 1.5, 1.36]);
        let facets = [low, high].map(|radii| Facet::of_radii(&wedge, 0, radii.map(|r| 1.0 / r)));
        let (g, h) = ([0.3, -0.8, 1.1], [2.0, 0.4, -0.6]);
        let place = |u| FrustumPoint::new(&wedge, [&facets[0], &facets[1]], u, FacetSide::Between);
        for u in [0.0, 0.21, 0.5, 0.83, 1.0] {
            // The radius through the point meets each facet at x times the point.
            let at = point(&wedge, &vertices, u);
            let meets = |radii: [f64; 3], g: [f64; 3]| {
                let [a, b, c] = [0, 1, 2].map(|k| radii[k] * vertices[k]);
                let normal = (b - a).cross(c - a);
                let x = normal.dot(a) / normal.dot(at);
                let p = x * at;
                let area = |p: DVec3, q: DVec3, r: DVec3| (q - p).cross(r - p).dot(normal);
                let whole = area(a, b, c);
                (x, (area(p, b, c) * g[0] + area(a, p, c) * g[1] + area(a, b, p) * g[2]) / whole)
            };
            let ((x0, g0), (x1, g1)) = (meets(low, g), meets(high, h));
            let w = (1.0 - x0) / (x1 - x0);
            let expected = g0 + w * (g1 - g0);
            assert!((place(u).value([&g, &h]) - expected).abs() < 1e-13, "{u}");
        }
        let [f0, middle, f1] = [0.0, 0.5, 1.0].map(|u| place(u).value([&g, &h]));
        let eps = place(1.0).depth / place(0.0).depth - 1.0;
        let kappa = (middle - 0.5 * (f0 + f1)) * 4.0 * (1.0 + 0.5 * eps);
        let segment = Segment { f0, f1, kappa, eps, length: 1.0 };
        for i in 0..=20 {
            let u = f64::from(i) / 20.0;
            assert!((segment.value(u) - place(u).value([&g, &h])).abs() < 1e-13, "{u}");
        }
    }

    #[test]
    fn a_constant_field_stays_constant() {
        let (wedge, _) = wedge();
        let facets = [[1.0; 3], [1.5, 1.4, 1.6]].map(|radii| Facet::of_radii(&wedge, 0, radii.map(|r: f64| 1.0 / r)));
        for u in [0.0, 0.3, 0.77, 1.0] {
            let place = FrustumPoint::new(&wedge, [&facets[0], &facets[1]], u, FacetSide::Between);
            assert_eq!(place.value([&[0.1; 3], &[0.1; 3]]), 0.1);
        }
    }
}
