//! Frusta of a pass as structs of rows: each member has a row, with an element for each frustum.

use crate::column::{Chord, Values};
use crate::lit::FrustumInterpolant;
use crate::piece::Radiance;
use crate::segment::Segment;
use crate::walk::packet::{LANES, Lanes};
use icoray_grid::array::MapInline;
use icoray_grid::real::Real;

/// Where and at which weights a ray crosses a frustum of its column.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FrustumCrossing<X> {
    /// Weights of the second and third vertex at the column's entry and at its exit.
    pub weight: [[X; 2]; 2],
    /// Where the ray enters and leaves the frustum between the column's edge points, 0 to 1.
    pub tau: [X; 2],
    /// Where it enters and leaves the frustum between the layer behind and the layer ahead, 0 to 1.
    pub place: [X; 2],
    /// Relative change of height.
    pub eps: X,
    /// Length, in planet radii.
    pub length: X,
}

impl<X> FrustumCrossing<X> {
    #[inline(always)]
    pub fn splat(value: X) -> Self
    where
        X: Copy,
    {
        FrustumCrossing { weight: [[value; 2]; 2], tau: [value; 2], place: [value; 2], eps: value, length: value }
    }

    /// All members.
    #[inline(always)]
    pub fn all(self) -> [X; 10] {
        let FrustumCrossing { weight: [[w0, w1], [w2, w3]], tau: [t0, t1], place: [p0, p1], eps, length } = self;
        [w0, w1, w2, w3, t0, t1, p0, p1, eps, length]
    }

    #[inline(always)]
    pub fn map<'a, Y>(&'a self, of: impl Fn(&'a X) -> Y) -> FrustumCrossing<Y> {
        let FrustumCrossing { weight: [[w0, w1], [w2, w3]], tau: [t0, t1], place: [p0, p1], eps, length } = self;
        FrustumCrossing {
            weight: [[of(w0), of(w1)], [of(w2), of(w3)]],
            tau: [of(t0), of(t1)],
            place: [of(p0), of(p1)],
            eps: of(eps),
            length: of(length),
        }
    }

    /// All members, in the order of [`Self::all`].
    #[inline(always)]
    pub fn all_mut(&mut self) -> [&mut X; 10] {
        let FrustumCrossing { weight: [[w0, w1], [w2, w3]], tau: [t0, t1], place: [p0, p1], eps, length } = self;
        [w0, w1, w2, w3, t0, t1, p0, p1, eps, length]
    }
}

impl<T: Real> FrustumCrossing<T> {
    /// The interpolant of these values at the three vertices on the layer behind and on the layer ahead.
    #[inline(always)]
    pub fn interpolant<const N: usize>(
        &self,
        behind: [Values<T, N>; 3],
        ahead: [Values<T, N>; 3],
    ) -> FrustumInterpolant<T, N> {
        let (first, second) = (Chord::over(behind, &self.weight), Chord::over(ahead, &self.weight));
        let (at_a, at_b) = (first.mix(second, self.place[0]), first.mix(second, self.place[1]));
        at_a.interpolant(&at_b, self.tau, self.eps)
    }
}

/// A struct whose members are rows, of which `Self::One` is that of one frustum.
pub(super) trait Rows {
    type One;

    fn at(&self, i: usize) -> Self::One;

    fn set(&mut self, i: usize, one: &Self::One);
}

impl<T: Real> Rows for Segment<Lanes<T>> {
    type One = Segment<T>;

    #[inline(always)]
    fn at(&self, i: usize) -> Segment<T> {
        let Segment { f0, f1, kappa, eps, length } = self;
        Segment { f0: f0[i], f1: f1[i], kappa: kappa[i], eps: eps[i], length: length[i] }
    }

    #[inline(always)]
    fn set(&mut self, i: usize, one: &Segment<T>) {
        (self.f0[i], self.f1[i], self.kappa[i]) = (one.f0, one.f1, one.kappa);
        (self.eps[i], self.length[i]) = (one.eps, one.length);
    }
}

impl<T: Real> Rows for Radiance<Lanes<T>> {
    type One = Radiance<T>;

    #[inline(always)]
    fn at(&self, i: usize) -> Radiance<T> {
        let Radiance { color, alpha: absorbed, error, variance } = self;
        let color = color.each_ref().map_inline(|row| row[i]);
        Radiance { color, alpha: absorbed[i], error: error[i], variance: variance[i] }
    }

    #[inline(always)]
    fn set(&mut self, i: usize, one: &Radiance<T>) {
        put(&mut self.color, i, &one.color);
        (self.alpha[i], self.error[i], self.variance[i]) = (one.alpha, one.error, one.variance);
    }
}

impl<T: Real> Rows for FrustumInterpolant<Lanes<T>, 3> {
    type One = FrustumInterpolant<T, 3>;

    #[inline(always)]
    fn at(&self, i: usize) -> FrustumInterpolant<T, 3> {
        let FrustumInterpolant { from, to, kappa, eps } = self;
        let [from, to, kappa] = [from, to, kappa].map_inline(|rows| rows.each_ref().map_inline(|row| row[i]));
        FrustumInterpolant { from, to, kappa, eps: eps[i] }
    }

    #[inline(always)]
    fn set(&mut self, i: usize, one: &FrustumInterpolant<T, 3>) {
        put(&mut self.from, i, &one.from);
        put(&mut self.to, i, &one.to);
        put(&mut self.kappa, i, &one.kappa);
        self.eps[i] = one.eps;
    }
}

#[inline(always)]
fn put<T: Real>(rows: &mut [Lanes<T>; 3], i: usize, [x, y, z]: &[T; 3]) {
    (rows[0][i], rows[1][i], rows[2][i]) = (*x, *y, *z);
}

#[inline(always)]
pub(super) fn no_segments<T: Real>() -> Segment<Lanes<T>> {
    let zero = [T::zero(); LANES];
    Segment { f0: zero, f1: zero, kappa: zero, eps: zero, length: zero }
}

#[inline(always)]
pub(super) fn no_lights<T: Real>() -> Radiance<Lanes<T>> {
    let zero = [T::zero(); LANES];
    Radiance { color: [zero; 3], alpha: zero, error: zero, variance: zero }
}

#[inline(always)]
pub(super) fn no_interpolants<T: Real>() -> FrustumInterpolant<Lanes<T>, 3> {
    let zero = [[T::zero(); LANES]; 3];
    FrustumInterpolant { from: zero, to: zero, kappa: zero, eps: zero[0] }
}
