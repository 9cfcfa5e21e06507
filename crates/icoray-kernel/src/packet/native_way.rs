//! Values along the lanes' frusta between layers at separate heights over each cell.

use super::layers::Way;
use super::read::{Course, Vertices};
use crate::column::Values;
use crate::lit::FrustumInterpolant;
use fearless_simd::prelude::*;
use icoray_grid::array::MapInline;
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

/// [`NativeWay`] of one lane.
pub(super) struct LaneWay {
    weights: [[[f32; 2]; 2]; 2],
    above: [f32; 2],
    u: [f32; 2],
    place: [f32; 2],
    eps: f32,
}

impl LaneWay {
    #[inline]
    pub fn of<V: Machine>(way: &NativeWay<V>, lane: usize) -> Self {
        LaneWay {
            weights: way.weights.map_inline(|layer| layer.map_inline(|end| end.map_inline(|row| row[lane]))),
            above: way.above.map_inline(|row| row[lane]),
            u: way.u.map_inline(|row| row[lane]),
            place: way.place.map_inline(|row| row[lane]),
            eps: way.eps[lane],
        }
    }

    /// Value, and gradient where `N` is 4, from those at the vertices below and above.
    pub fn interpolant<const N: usize>(&self, [low, high]: &[[Values<f32, N>; 3]; 2]) -> FrustumInterpolant<f32, N> {
        let zero = [0.0; N];
        let mut interpolant = FrustumInterpolant { from: zero, to: zero, kappa: zero, eps: self.eps };
        for k in 0..N {
            let at = |vertices: &[Values<f32, N>; 3]| vertices.map(|values| values[k]);
            let [from, to, kappa] = self.interpolate(at(low), at(high));
            (interpolant.from[k], interpolant.to[k], interpolant.kappa[k]) = (from, to, kappa);
        }
        interpolant
    }

    fn interpolate(&self, [a, b, c]: [f32; 3], [d, e, f]: [f32; 3]) -> [f32; 3] {
        let [below, above] = self.weights;
        let low = below.map(|[second, third]| second * (b - a) + third * (c - a));
        let high = above.map(|[second, third]| second * (e - d) + third * (f - d));
        let [start, end] = [0, 1].map(|k: usize| {
            let n = low[0] + self.u[k] * (low[1] - low[0]);
            let above = high[0] + self.u[k] * (high[1] - high[0]) + self.above[k] * (d - a);
            let rise = above - n;
            (if self.place[k] == 1.0 { above } else { n + self.place[k] * rise }, rise)
        });
        let kappa = (self.place[1] - self.place[0]) * (self.eps * start.1 + (start.1 - end.1));
        [a + start.0, a + end.0, kappa]
    }
}
