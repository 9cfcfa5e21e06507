//! The integral of a piece in each lane: the rules of `piece.rs` in vectors.
//!
//! [`Integral::thin`] is [`ThinPiece`](crate::piece::ThinPiece), with a bend factor that is valid for `|ε| < 0.4`;
//! [`Integral::gauss`] is the rule of the same name for denser pieces. Bounds are those of `piece.rs`. Scalar code
//! integrates the lanes for which neither is accurate enough.

use super::medium::Medium;
use super::part::{Part, all};
use crate::light::Radiance;
use crate::piece::THIN;
use fearless_simd::prelude::*;
use icoray_simd::{Floats, Machine, Mask, exp2};

/// The largest |ε| for which the series of the bend factor is exact to f32's last digit.
pub(super) const LARGEST_EPS: f32 = 0.4;

/// Optical depth beyond which scalar code integrates a piece.
pub(super) const LARGEST_DEPTH: f32 = 80.0;

/// Half a unit of the last digit of 1.
const ROUNDING: f32 = 0.5 * f32::EPSILON;

/// Colour and absorption of a piece in each lane.
pub(super) type Light<V> = Radiance<Floats<V>>;

/// The terms that all rules share, as `Terms` of `piece.rs`.
pub(super) struct Integral<'p, V: Machine> {
    simd: V,
    part: &'p Part<V>,
    medium: &'p Medium<V>,
    pub ends: [Floats<V>; 2],
    rise: Floats<V>,
    bend: Floats<V>,
    steep: Floats<V>,
    /// Maximum of |T''|.
    curve: Floats<V>,
    pub depth: Floats<V>,
}

/// The outcome of a rule: the absorbed part, W, the bound of the colour's error, and the lanes in which it is small
/// enough.
pub(super) struct Outcome<V: Machine> {
    pub absorbed: Floats<V>,
    weight: Floats<V>,
    error: Floats<V>,
    pub is_near: Mask<V>,
}

impl<V: Machine> Outcome<V> {
    /// `self` in the lanes of `mask`, `other` in the rest.
    #[inline(always)]
    pub fn over(self, mask: Mask<V>, other: Self) -> Self {
        Outcome {
            absorbed: mask.select(self.absorbed, other.absorbed),
            weight: mask.select(self.weight, other.weight),
            error: mask.select(self.error, other.error),
            is_near: mask.select(self.is_near, other.is_near),
        }
    }
}

impl<'p, V: Machine> Integral<'p, V> {
    #[inline(always)]
    pub fn new(simd: V, part: &'p Part<V>, medium: &'p Medium<V>) -> Self {
        let ends = [medium.extinction(simd, part.f0), medium.extinction(simd, part.f1)];
        let rise = part.f1 - part.f0;
        let bend = part.kappa * bend_factor(simd, part.eps);
        let steep = rise.abs() + bend.abs();
        let mean = (medium.slope * bend).mul_add(1.0 / 6.0, (ends[0] + ends[1]) * 0.5);
        let depth = (part.length * mean).max(all(simd, 0.0));
        let curve = part.length * medium.slope.abs() * steep;
        Integral { simd, part, medium, ends, rise, bend, steep, curve, depth }
    }

    /// The rule for thin pieces, which needs no exponential.
    #[inline(always)]
    pub fn thin(&self, color_tolerance: f32) -> Outcome<V> {
        let (x, b) = (self.depth, self.curve);
        let absorbed = absorbed_by_thin(self.simd, x);
        let y = b.mul_add(0.5, x);
        let cubed = y * y * y * (1.0 / 24.0);
        let own = self.steep * b.mul_add(x.mul_add(0.02, b * (1.0 / 240.0)), cubed);
        let error = self.medium.steepest * (own + self.skew(absorbed));
        let is_near = x.simd_lt(THIN as f32) & error.simd_le(absorbed * color_tolerance);
        let (bend, third) = (self.bend, 1.0 / 3.0);
        let p = self.rise + bend;
        let level = self.ends[0] * bend.mul_add(-2.0 / 3.0, p * 0.5);
        let ramp = p.mul_add(bend.mul_add(-third, p * (1.0 / 6.0)), bend * bend * (2.0 / 15.0));
        let thinned = x.mul_add(-third, all(self.simd, 1.0));
        let weight = self.part.length * self.medium.slope.mul_add(ramp, level) * thinned;
        let weight = (bend * x * x).mul_add(1.0 / 36.0, weight);
        Outcome { absorbed, weight, error, is_near }
    }

    /// Gauss's 2-point rule with the known quartic term; if it is not accurate enough but the colours of the piece
    /// hardly differ, W is replaced by half of the change.
    #[inline(always)]
    pub fn gauss(&self, color_tolerance: f32) -> Outcome<V> {
        let simd = self.simd;
        let absorbed = absorbed_by(simd, self.depth);
        let (length, slope, bend) = (self.part.length, self.medium.slope, self.bend);
        let offset = 0.288_675_13;
        let weight = (self.weighted(0.5 - offset) + self.weighted(0.5 + offset)) * 0.5
            + length * slope * bend * bend * (1.0 / 270.0);
        let error = self.medium.steepest * (self.gauss_error() + self.skew(absorbed));
        let allowed = absorbed * color_tolerance;
        let is_exact = error.simd_le(allowed);
        let half_change = self.medium.steepest * self.steep * 0.5;
        let is_uniform = half_change.simd_le(color_tolerance);
        let is_small = self.depth.simd_lt(LARGEST_DEPTH);
        Outcome {
            absorbed,
            weight: is_exact.select(weight, self.rise * absorbed * 0.5),
            error: is_exact.select(error, half_change * absorbed),
            is_near: (is_exact | is_uniform) & is_small,
        }
    }

    /// The integrand of W at `u`.
    #[inline(always)]
    fn weighted(&self, u: f32) -> Floats<V> {
        let risen = (self.rise * 0.5 + self.bend * (0.5 - u * (1.0 / 3.0))) * (u * u);
        let depth = self.part.length * (self.ends[0] * u + self.medium.slope * risen);
        let absorbed = absorbed_by(self.simd, depth.max(all(self.simd, 0.0)));
        (self.rise + self.bend * (1.0 - 2.0 * u)) * absorbed
    }

    #[inline(always)]
    fn gauss_error(&self) -> Floats<V> {
        let (bend, length) = (self.bend.abs(), self.part.length);
        let swing = self.medium.slope.abs() * bend;
        let a = length * (self.ends[0].max(self.ends[1]) + swing * 0.25);
        let (b, j) = (self.curve, length * swing * 2.0);
        let a2 = a * a;
        let even = a2 * (a2 + b * 6.0) + b * b * 3.0 + a * j * 4.0;
        let odd = bend * 8.0 * (a * (a2 + b * 3.0) + j * a.min(all(self.simd, 1.0)));
        (self.steep * even + odd) * (1.0 / 4320.0)
    }

    /// Error of W from taking the bend as constant.
    #[inline(always)]
    fn skew(&self, absorbed: Floats<V>) -> Floats<V> {
        let zero = all(self.simd, 0.0);
        let eps = self.part.eps;
        // 1 / (1 + ε) is convex: the chord from 0 to -0.4 lies above it.
        let wide = (zero - eps).max(zero).mul_add(1.0 / 0.6, 1.0);
        wide * self.bend.abs() * eps.abs() * absorbed.mul_add(0.05, self.curve * (1.0 / 60.0))
    }

    /// The light of an outcome, whose values have errors of up to `reach`.
    #[inline(always)]
    pub fn light(&self, outcome: &Outcome<V>, reach: Floats<V>) -> Light<V> {
        let (part, medium) = (self.part, self.medium);
        let (absorbed, one) = (outcome.absorbed, all(self.simd, 1.0));
        let x = part.f1 - medium.anchor;
        let mut color = [absorbed; 3];
        for (k, channel) in color.iter_mut().enumerate() {
            let slope = medium.color_slope[k];
            *channel = slope.mul_add(x, medium.color[k]).mul_sub(absorbed, slope * outcome.weight);
        }
        let thickened = part.length * medium.slope.abs() * (one - absorbed);
        let change = medium.steepest.mul_add(absorbed, thickened);
        let off = reach.mul_add(change, absorbed * ROUNDING).min(one);
        let shade_variance = all(self.simd, 0.0);
        Radiance { color, alpha: absorbed, error: outcome.error, variance: off * off, shade_variance }
    }
}

/// `1 - e^-x` for `0 <= x <= 1/2`, as [`Real::absorbed_by`](icoray_grid::real::Real::absorbed_by).
#[inline(always)]
fn absorbed_by_thin<V: Machine>(simd: V, x: Floats<V>) -> Floats<V> {
    const C: [f32; 8] =
        [1.0, -1.0 / 2.0, 1.0 / 6.0, -1.0 / 24.0, 1.0 / 120.0, -1.0 / 720.0, 1.0 / 5040.0, -1.0 / 40320.0];
    let mut series = all(simd, C[7]);
    for k in (0..7).rev() {
        series = series.mul_add(x, all(simd, C[k]));
    }
    x * series
}

/// `1 - e^-x` for `x >= 0`.
#[inline(always)]
pub(super) fn absorbed_by<V: Machine>(simd: V, x: Floats<V>) -> Floats<V> {
    let one = all(simd, 1.0);
    let dense = one - exp2(simd, x * -std::f32::consts::LOG2_E);
    x.simd_le(0.5).select(absorbed_by_thin(simd, x), dense)
}

/// 6 ∫ x(1-x)/(1+εx) dx. With `δ = ε/(2 + ε)` it is `2/(2 + ε) Σ 3 δ^2m / ((2m+1)(2m+3))`.
#[inline(always)]
pub(super) fn bend_factor<V: Machine>(simd: V, eps: Floats<V>) -> Floats<V> {
    let inverse = all(simd, 1.0) / (eps + 2.0);
    let delta = eps * inverse;
    let d2 = delta * delta;
    let series = d2.mul_add(1.0 / 33.0, 1.0 / 21.0).mul_add(d2, 3.0 / 35.0).mul_add(d2, 0.2).mul_add(d2, 1.0);
    inverse * 2.0 * series
}
