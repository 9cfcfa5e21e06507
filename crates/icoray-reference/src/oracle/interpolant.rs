//! The interpolant along a ray inside one frustum.
//!
//! With u from 0 to 1 along the stretch, heights and the vertices' values are linear in u and barycentric weights are
//! linear over linear, which together make `f(u) = f0 + (f1 - f0) u + bend · u (1 - u)/(1 + eps u)`: at most one
//! extremum, and no coefficient that cancels.

use crate::columns::FrustumWeights;
use crate::double_double::Dd;

/// A quantity along a stretch, or along a part of one.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FrustumInterpolant {
    /// All values are relative to this one.
    pub base: f64,
    /// Values at the ends.
    pub f: [f64; 2],
    pub bend: f64,
    pub eps: f64,
}

impl FrustumInterpolant {
    /// The quantity with these values at the lower and upper vertices; `None` where one is missing.
    pub fn new(frustum: &FrustumWeights, values: [f64; 6]) -> Option<Self> {
        if values.iter().any(|value| value.is_nan()) {
            return None;
        }
        let base = values[0];
        let at = |weight: [Dd; 6]| (1..6).map(|k| weight[k].to_f64() * (values[k] - base)).sum::<f64>();
        let [start, middle, end] = frustum.weight.map(at);
        let eps = (frustum.height[1] / frustum.height[0] - Dd::ONE).to_f64();
        let bend = (middle - 0.5 * (start + end)) * 4.0 * (1.0 + 0.5 * eps);
        Some(FrustumInterpolant { base, f: [start, end], bend, eps })
    }

    /// A quantity that is linear along the stretch.
    pub fn linear(f: [f64; 2]) -> Self {
        FrustumInterpolant { base: 0.0, f, bend: 0.0, eps: 0.0 }
    }

    /// The value at `u`, not relative to the base.
    pub fn value(&self, u: f64) -> f64 {
        self.base + self.at(u)
    }

    /// At `u`, 0 to 1.
    #[inline]
    pub fn at(&self, u: f64) -> f64 {
        self.f[0] + self.since_start(u)
    }

    /// The change from the start to `u`.
    #[inline]
    pub fn since_start(&self, u: f64) -> f64 {
        (self.f[1] - self.f[0]) * u + self.bend * (u * (1.0 - u) / (1.0 + self.eps * u))
    }

    #[inline]
    fn slope(&self, u: f64) -> f64 {
        let x = 1.0 + self.eps * u;
        (self.f[1] - self.f[0]) + self.bend * ((1.0 - 2.0 * u - self.eps * u * u) / (x * x))
    }

    /// Where the one extremum inside lies, if there is one.
    pub fn extremum(&self) -> Option<f64> {
        let d = self.f[1] - self.f[0];
        let (first, last) = (d + self.bend, d - self.bend / (1.0 + self.eps));
        if first * last >= 0.0 {
            return None;
        }
        let m = self.bend - d * self.eps;
        let mut u = first / m / (1.0 + (self.bend * (1.0 + self.eps) / m).max(0.0).sqrt());
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..4 {
            // Newton's steps, kept inside; the closed form is close already.
            let slope = self.slope(u);
            if (slope > 0.0) == (first > 0.0) {
                low = u;
            } else {
                high = u;
            }
            let x = 1.0 + self.eps * u;
            let curvature = -2.0 * self.bend * (1.0 + self.eps) / (x * x * x);
            let next = u - slope / curvature;
            if next == u || !(low < next && next < high) {
                break;
            }
            u = next;
        }
        (0.0 < u && u < 1.0).then_some(u)
    }

    /// Where the quantity is `value` in [`from`, `to`], between whose ends it is monotone and passes the value.
    pub fn meets(&self, value: f64, from: f64, to: f64) -> f64 {
        let rising = self.at(to) > self.at(from);
        let (mut low, mut high) = (from, to);
        let mut u = self.root(value, from, to);
        for _ in 0..100 {
            let residual = self.at(u) - value;
            if residual == 0.0 {
                break;
            }
            if (residual < 0.0) == rising {
                low = u;
            } else {
                high = u;
            }
            let newton = u - residual / self.slope(u);
            let next = if low < newton && newton < high { newton } else { 0.5 * (low + high) };
            if (next - u).abs() <= 1e-16 * next.abs() || next <= low || next >= high {
                break;
            }
            u = next;
        }
        u
    }

    /// A first guess for [`Self::meets`]: the quadratic's root.
    fn root(&self, value: f64, from: f64, to: f64) -> f64 {
        let (d, residual) = (self.f[1] - self.f[0], self.f[0] - value);
        let (a, b) = (self.eps * d - self.bend, residual * self.eps + d + self.bend);
        let q = -0.5 * (b + (b * b - 4.0 * a * residual).max(0.0).sqrt().copysign(b));
        let inside = |u: &f64| from < *u && *u < to;
        [residual / q, q / a].into_iter().find(inside).unwrap_or(0.5 * (from + to))
    }

    /// The part from `from` to `to`, where the values are known to be `f`, relative to `base`.
    pub fn part(&self, [from, to]: [f64; 2], base: f64, f: [f64; 2]) -> Self {
        let (h, x, y) = (to - from, 1.0 + self.eps * from, 1.0 + self.eps * to);
        let bend = self.bend * h * h * (1.0 + self.eps) / (x * x * y);
        FrustumInterpolant { base, f, bend, eps: self.eps * h / x }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const INTERPOLANTS: [FrustumInterpolant; 4] = [
        FrustumInterpolant { base: 0.0, f: [0.3, 0.5], bend: 1.7, eps: 0.4 },
        FrustumInterpolant { base: 0.0, f: [0.3, 0.5], bend: -0.9, eps: -0.3 },
        FrustumInterpolant { base: 0.0, f: [1.0, -2.0], bend: 0.4, eps: 1e-9 },
        FrustumInterpolant { base: 0.0, f: [-1.0, -1.0], bend: 1e-8, eps: -1e-3 },
    ];

    #[test]
    fn a_part_is_the_same_function() {
        for interpolant in INTERPOLANTS {
            let range = [0.2, 0.7];
            let part = interpolant.part(range, 0.0, range.map(|u| interpolant.at(u)));
            for i in 0..=10 {
                let s = f64::from(i) / 10.0;
                assert!((part.at(s) - interpolant.at(0.2 + 0.5 * s)).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn extrema_and_crossings_are_where_they_are() {
        for interpolant in INTERPOLANTS {
            let turn = interpolant.extremum();
            let is_monotone =
                (0..1000).map(|i| interpolant.slope(f64::from(i) / 999.0)).is_sorted_by(|a, b| a * b > 0.0);
            assert_eq!(turn.is_none(), is_monotone);
            let ends = [0.0, turn.unwrap_or(0.5), 1.0];
            for pair in ends.windows(2) {
                let value = 0.3 * interpolant.at(pair[0]) + 0.7 * interpolant.at(pair[1]);
                let u = interpolant.meets(value, pair[0], pair[1]);
                assert!(pair[0] < u && u < pair[1]);
                assert!((interpolant.at(u) - value).abs() < 1e-15, "{interpolant:?} {u}");
            }
            if let Some(u) = turn {
                assert!(interpolant.slope(u).abs() < 1e-14 * interpolant.bend.abs().max(1.0));
            }
        }
    }
}
