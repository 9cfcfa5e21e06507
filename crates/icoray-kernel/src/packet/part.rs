//! [`Segment`](crate::segment::Segment) in vectors: the scalar along a part of a frustum, a lane per ray.

use crate::segment::Segment;
use fearless_simd::prelude::*;
use icoray_simd::{Floats, Machine, Mask};

/// The scalar along a part of each lane's frustum, as in [`Segment`](crate::segment::Segment).
#[derive(Debug, Clone, Copy)]
pub(super) struct Part<V: Machine> {
    pub f0: Floats<V>,
    pub f1: Floats<V>,
    pub kappa: Floats<V>,
    pub eps: Floats<V>,
    pub length: Floats<V>,
}

/// A place of each lane's part: the parameter, and the value there.
pub(super) type Place<V> = (Floats<V>, Floats<V>);

/// The extremum of the scalar.
pub(super) struct Extremum<V: Machine> {
    /// Lanes in which it lies inside the part.
    pub exists: Mask<V>,
    pub place: Place<V>,
}

impl<V: Machine> Part<V> {
    /// A part of no length.
    #[inline(always)]
    pub fn none(simd: V) -> Self {
        let zero = all(simd, 0.0);
        Part { f0: zero, f1: zero, kappa: zero, eps: zero, length: zero }
    }

    /// The part of a lane.
    pub fn segment(&self, lane: usize) -> Segment<f32> {
        Segment {
            f0: self.f0[lane],
            f1: self.f1[lane],
            kappa: self.kappa[lane],
            eps: self.eps[lane],
            length: self.length[lane],
        }
    }

    /// `self` in the lanes of `mask`, `other` in the rest.
    #[inline(always)]
    pub fn over(self, mask: Mask<V>, other: Self) -> Self {
        Part {
            f0: mask.select(self.f0, other.f0),
            f1: mask.select(self.f1, other.f1),
            kappa: mask.select(self.kappa, other.kappa),
            eps: mask.select(self.eps, other.eps),
            length: mask.select(self.length, other.length),
        }
    }

    /// Value at `u`.
    #[inline(always)]
    pub fn value(&self, simd: V, u: Floats<V>) -> Floats<V> {
        let one = all(simd, 1.0);
        let bend = self.kappa * u * (one - u) / self.eps.mul_add(u, one);
        (self.f1 - self.f0).mul_add(u, self.f0 + bend)
    }

    /// A range that contains all values if `ε > -3/4`.
    #[inline(always)]
    pub fn within(&self) -> [Floats<V>; 2] {
        let swing = self.kappa.abs() * 0.5;
        [self.f0.min(self.f1) - swing, self.f0.max(self.f1) + swing]
    }

    /// Error of the values at its ends due to rounding, which are computed from values of up to `size` at the frustum's
    /// vertices.
    #[inline(always)]
    pub fn reach(&self, size: Floats<V>) -> Floats<V> {
        (self.f0.abs() + self.f1.abs() + size) * (0.5 * f32::EPSILON)
    }

    /// The extremum of the scalar inside the part, as [`Segment::extremum`](crate::segment::Segment::extremum).
    #[inline(always)]
    pub fn extremum(&self, simd: V) -> Extremum<V> {
        let (zero, one) = (all(simd, 0.0), all(simd, 1.0));
        let d = self.f1 - self.f0;
        let rise_in = d + self.kappa;
        let rise_out = (self.eps + 1.0) * d - self.kappa;
        let exists = (rise_in * rise_out).simd_lt(zero);
        let m = self.kappa - d * self.eps;
        let root = (self.kappa * (self.eps + 1.0) / m).max(zero).sqrt();
        let u = (rise_in / m / (root + 1.0)).max(zero).min(one);
        Extremum { exists, place: (u, self.value(simd, u)) }
    }

    /// Slopes at the start and the end, over the part.
    #[inline(always)]
    pub fn end_slopes(&self) -> [Floats<V>; 2] {
        let rise = self.f1 - self.f0;
        [rise + self.kappa, rise - self.kappa / (self.eps + 1.0)]
    }

    /// The place at which the scalar, which is monotone, takes the value `v`, as
    /// [`Segment::solve`](crate::segment::Segment::solve).
    #[inline(always)]
    pub fn solve(&self, simd: V, v: Floats<V>) -> Floats<V> {
        let (zero, one) = (all(simd, 0.0), all(simd, 1.0));
        let (c0, above) = (self.f0 - v, self.f1 - v);
        let whole = self.eps + 1.0;
        let c2 = whole * above;
        let c1 = (whole.mul_add(c0, self.kappa + above)) * 0.5;
        let root = c1.mul_sub(c1, c0 * c2).max(zero).sqrt();
        let q = c1.simd_lt(zero).select(root - c1, zero - (c1 + root));
        let [numerator, other] = {
            let same = c0.simd_lt(zero).simd_eq(q.simd_lt(zero));
            [same.select(c0, q), same.select(q, c2)]
        };
        let u = (numerator / (numerator + other)).max(zero).min(one);
        let u = c2.simd_eq(zero).select(one, u);
        c0.simd_eq(zero).select(zero, u)
    }

    /// The part between two places.
    #[inline(always)]
    pub fn between(&self, (u0, f0): Place<V>, (u1, f1): Place<V>) -> Self {
        let (r0, r1) = (self.eps.mul_add(u0, 1.0), self.eps.mul_add(u1, 1.0));
        let du = u1 - u0;
        let inverse = du / r0;
        Part {
            f0,
            f1,
            kappa: self.kappa * inverse * inverse * (self.eps + 1.0) / r1,
            eps: self.eps * inverse,
            length: self.length * du,
        }
    }
}

/// The same number in all lanes.
#[inline(always)]
pub(super) fn all<V: Machine>(simd: V, value: f32) -> Floats<V> {
    <Floats<V> as SimdBase<V>>::splat(simd, value)
}
