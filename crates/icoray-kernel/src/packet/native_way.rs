//! Values along the lanes' frusta between layers at separate heights over each cell.

use super::layers::Way;
use super::read::{Course, Vertices};
use fearless_simd::prelude::*;
use icoray_simd::{Floats, Machine};

/// The points at which each ray enters and leaves its frustum: `(1 - x) N + x N'` is the value (`native.rs`), with N
/// and N' linear along the column. With Q = N' - N the bend of [`Segment`](crate::segment::Segment) is
/// `κ = (xb - xa)(ε Qa + Qa - Qb)`.
#[derive(Clone, Copy)]
pub(super) struct NativeWay<V: Machine> {
    /// Weights in N and in N' of the second and the third vertex, at the column's entry and exit.
    pub weights: [[[Floats<V>; 2]; 2]; 2],
    /// ψ of the upper layer at the frustum's ends.
    pub above: [Floats<V>; 2],
    /// The ends as fractions of the column's length.
    pub u: [Floats<V>; 2],
    /// x at the ends; exactly 0 and 1 on layers.
    pub place: [Floats<V>; 2],
    pub eps: Floats<V>,
}

impl<V: Machine> Way<V> for NativeWay<V> {
    #[inline(always)]
    fn interpolate(&self, vertices: &Vertices<V>) -> Course<V> {
        let Vertices { low: [a, b, c], high: [d, e, f] } = *vertices;
        let (ab, ac, ad) = (b - a, c - a, d - a);
        let (de, df) = (e - d, f - d);
        let [below, above] = self.weights;
        let [low, low_exit] = [along::<V>(below[0], ab, ac), along::<V>(below[1], ab, ac)];
        let [high, high_exit] = [along::<V>(above[0], de, df), along::<V>(above[1], de, df)];
        let (low_rise, high_rise) = (low_exit - low, high_exit - high);
        let start = self.at(0, [low, low_rise], [high, high_rise], ad);
        let end = self.at(1, [low, low_rise], [high, high_rise], ad);
        let kappa = (self.place[1] - self.place[0]) * self.eps.mul_add(start.1, start.1 - end.1);
        [start.0, end.0, kappa]
    }
}

/// A number over two vertices with these weights.
#[inline(always)]
fn along<V: Machine>([b, c]: [Floats<V>; 2], second: Floats<V>, third: Floats<V>) -> Floats<V> {
    c.mul_add(third, b * second)
}

impl<V: Machine> NativeWay<V> {
    /// The value at an end of the frusta, and N' - N there, from N and N' at the column's entry and their rises.
    #[inline(always)]
    fn at(
        &self,
        end: usize,
        [low, low_rise]: [Floats<V>; 2],
        [high, high_rise]: [Floats<V>; 2],
        ad: Floats<V>,
    ) -> (Floats<V>, Floats<V>) {
        let (u, place) = (self.u[end], self.place[end]);
        let below = u.mul_add(low_rise, low);
        let above = self.above[end].mul_add(ad, u.mul_add(high_rise, high));
        let rise = above - below;
        (place.simd_eq(1.0).select(above, place.mul_add(rise, below)), rise)
    }
}
