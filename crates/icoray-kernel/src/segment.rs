//! The scalar along a ray inside one frustum.
//!
//! Eq. 3 of the paper is a quadratic over a linear function of the ray's parameter. Written from its ends, with u
//! running from 0 to 1 over the segment, it is
//!
//! `f(u) = f0 + (f1 - f0) u + κ u (1 - u) / (1 + ε u)`
//!
//! where ε is the relative change of height and κ the bend that comes from crossing the triangle while changing layers
//! (`column.rs` has its value). No coefficient cancels, thin layers included: the paper's b1..b5 lose all digits of
//! f32 for 100 m layers. f has **at most one** extremum inside (the paper says several), and meets a value at most
//! twice.

use icoray_grid::real::Real;

/// The scalar along the part of a ray inside one frustum.
#[derive(Debug, Clone, Copy)]
pub struct Segment<T> {
    /// Normalised value at the entry.
    pub f0: T,
    /// Normalised value at the exit.
    pub f1: T,
    /// κ, the bend.
    pub kappa: T,
    /// ε > -1, the relative change of height.
    pub eps: T,
    /// Length along the ray, in planet radii.
    pub length: T,
}

impl<T: Real> Segment<T> {
    /// Value at `u`.
    #[inline]
    pub fn value(&self, u: T) -> T {
        let one = T::one();
        self.f0 + (self.f1 - self.f0) * u + self.kappa * u * (one - u) / (one + self.eps * u)
    }

    /// Slope at `u`.
    #[inline]
    pub fn slope(&self, u: T) -> T {
        let one = T::one();
        let r = one + self.eps * u;
        self.f1 - self.f0 + self.kappa * (one - u - u * r) / (r * r)
    }

    /// Whether a value is missing, which makes it void.
    #[inline(always)]
    pub fn is_void(&self) -> bool {
        !(self.f0 + self.f1 + self.kappa).is_finite()
    }

    /// Whether its value is constant.
    #[inline(always)]
    pub fn is_constant(&self) -> bool {
        self.f0 == self.f1 && self.kappa == T::zero()
    }

    /// Error of the values at its ends due to rounding, which are computed from values of up to `size` at the frustum's
    /// vertices.
    #[inline(always)]
    pub fn reach(&self, size: T) -> T {
        T::of(T::ROUNDING) * (size + self.f0.abs() + self.f1.abs())
    }

    /// A range that contains all values if `ε > -3/4`: the bend then moves them by less than half of κ.
    #[inline(always)]
    pub fn within(&self) -> [T; 2] {
        let swing = T::of(0.5) * self.kappa.abs();
        [self.f0.min(self.f1) - swing, self.f0.max(self.f1) + swing]
    }

    /// The extremum of f inside the segment, if there is one: u and the value there.
    ///
    /// f' has opposite signs at the ends exactly when `(d + κ)((1 + ε)d - κ) < 0`; then κ and `κ - dε` have one sign
    /// and the root below is real and lies in (0, 1).
    #[inline]
    pub fn extremum(&self) -> Option<(T, T)> {
        let one = T::one();
        let d = self.f1 - self.f0;
        let rise_in = d + self.kappa;
        let rise_out = (one + self.eps) * d - self.kappa;
        if rise_in * rise_out >= T::zero() {
            return None;
        }
        let m = self.kappa - d * self.eps;
        let root = (self.kappa * (one + self.eps) / m).max(T::zero()).sqrt();
        let u = (rise_in / m / (one + root)).max(T::zero()).min(one);
        let bend = self.kappa * u * (one - u) / (one + self.eps * u);
        Some((u, self.f0 + d * u + bend))
    }

    /// The place at which f takes the value `v`, for a segment on which f is monotone and `v` lies between its ends.
    ///
    /// The quadratic in Bernstein form; the root is taken by the branch that does not cancel.
    #[inline]
    pub fn solve(&self, v: T) -> T {
        let (zero, one) = (T::zero(), T::one());
        let (below, above) = (self.f0 - v, self.f1 - v);
        let c0 = below;
        let c2 = (one + self.eps) * above;
        if c0 == zero || c2 == zero {
            return if c0 == zero { zero } else { one };
        }
        let c1 = T::of(0.5) * (self.kappa + above + (one + self.eps) * below);
        let root = (c1 * c1 - c0 * c2).max(zero).sqrt();
        let q = if c1 < zero { root - c1 } else { -(c1 + root) };
        // The roots are at u/(1-u) = q/c2 and c0/q; c0 and c2 differ in sign, so exactly one of them is positive.
        let u = if (c0 < zero) == (q < zero) { c0 / (c0 + q) } else { q / (q + c2) };
        u.max(zero).min(one)
    }

    /// The part from `u0` to `u1`, given the values there.
    #[inline]
    pub fn part(&self, (u0, f0): (T, T), (u1, f1): (T, T)) -> Self {
        let one = T::one();
        let (r0, r1) = (one + self.eps * u0, one + self.eps * u1);
        let du = u1 - u0;
        Segment {
            f0,
            f1,
            kappa: self.kappa * du * du * (one + self.eps) / (r0 * r0 * r1),
            eps: self.eps * du / r0,
            length: self.length * du,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cases() -> Vec<Segment<f64>> {
        let mut cases = Vec::new();
        for f1 in [0.0, 0.3, 1.0, -2.0] {
            for kappa in [0.0, 1e-12, 0.2, 3.0, -3.0, -0.4] {
                for eps in [0.0, 1e-3, -0.3, 0.8, -0.9, 1e-9] {
                    cases.push(Segment { f0: 0.1, f1, kappa, eps, length: 1.0 });
                }
            }
        }
        cases
    }

    #[test]
    fn extremum_is_where_a_fine_scan_finds_it() {
        for s in cases() {
            let scan: Vec<f64> = (0..=20_000).map(|i| s.value(f64::from(i) / 20_000.0)).collect();
            let (low, high) = scan.iter().fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
            let (end_low, end_high) = (s.f0.min(s.f1), s.f0.max(s.f1));
            match s.extremum() {
                None => assert!(low >= end_low - 1e-12 && high <= end_high + 1e-12, "{s:?}"),
                Some((u, f)) => {
                    assert!((0.0..=1.0).contains(&u));
                    assert!((s.value(u) - f).abs() < 1e-14);
                    let nearer = (high - f).abs().min((low - f).abs());
                    assert!(nearer < 1e-8, "{s:?}: {f} against {low} and {high}");
                    assert!(f <= end_low + 1e-12 || f >= end_high - 1e-12, "{s:?}: {f} is no extremum");
                }
            }
        }
    }

    #[test]
    fn solve_meets_the_value_on_monotone_parts() {
        for s in cases() {
            let ends = match s.extremum() {
                None => vec![((0.0, s.f0), (1.0, s.f1))],
                Some(top) => vec![((0.0, s.f0), top), (top, (1.0, s.f1))],
            };
            for (a, b) in ends {
                let part = s.part(a, b);
                for w in [0.0, 1e-9, 0.25, 0.5, 0.99, 1.0] {
                    let v = (a.1 + w * (b.1 - a.1)).clamp(a.1.min(b.1), a.1.max(b.1));
                    let u = part.solve(v);
                    assert!((part.value(u) - v).abs() < 1e-13, "{part:?} at {v}: u = {u}");
                }
            }
        }
    }

    #[test]
    fn slopes_are_those_of_the_values() {
        for s in cases() {
            for u in [0.0, 0.3, 1.0] {
                let rise = (s.value(u + 1e-6) - s.value(u - 1e-6)) / 2e-6;
                assert!((s.slope(u) - rise).abs() < 1e-7 * (1.0 + rise.abs()), "{s:?} at {u}");
            }
        }
    }

    #[test]
    fn a_part_has_the_values_of_the_whole() {
        for s in cases() {
            let (u0, u1) = (0.2, 0.7);
            let part = s.part((u0, s.value(u0)), (u1, s.value(u1)));
            for w in [0.0, 0.3, 0.5, 1.0] {
                assert!((part.value(w) - s.value(u0 + w * (u1 - u0))).abs() < 1e-13, "{s:?}");
            }
        }
    }
}
