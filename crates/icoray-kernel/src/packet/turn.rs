//! The turn of the normal along a piece of each lane: [`NormalTurn`](crate::turn::NormalTurn) in vectors.

use super::medium::Medium;
use super::part::{Part, all};
use crate::lit::LightSpread;
use crate::turn::Cosine;
use fearless_simd::prelude::*;
use icoray_simd::{Floats, Machine, Mask};

/// A vector of space in each lane.
pub(super) type Vectors<V> = [Floats<V>; 3];

/// The distribution of the light of a piece with known extinction at the ends, as [`LightSpread::of`].
#[inline(always)]
pub(super) fn spread_of<V: Machine>(
    simd: V,
    part: &Part<V>,
    medium: &Medium<V>,
    [from, to]: [Floats<V>; 2],
) -> LightSpread<Floats<V>> {
    let sum = from + to + f32::MIN_POSITIVE;
    let inverse = all(simd, 1.0) / sum;
    let depth = part.length * sum * 0.5;
    let rise = (to - from) * inverse;
    let forward = depth.min(3.0) * (rise * rise).mul_add(-1.0 / 60.0, 5.0 / 60.0);
    let bent = (medium.slope * part.kappa).abs() * inverse;
    let error_bound = (depth * depth * 0.02 + bent * 0.2).min(0.5);
    let (second, extent) = (all(simd, 1.0 / 12.0), all(simd, 1.0) / depth.max(1.0));
    LightSpread { centre: rise * (1.0 / 6.0) - forward, second, error_bound, extent }
}

/// The normal along a piece of each lane.
pub(super) struct Turns<V: Machine> {
    mean: Vectors<V>,
    rise: Vectors<V>,
    bend: Vectors<V>,
    /// The largest component of the gradients where most of the light is.
    pub size: Floats<V>,
    pub angle: Floats<V>,
    pub angle2: Floats<V>,
    pub bend_length: Floats<V>,
    pub across: Floats<V>,
    pub along: Floats<V>,
    pub spread: LightSpread<Floats<V>>,
    pub is_wild: Mask<V>,
}

/// A unit vector, its length before normalisation, and whether it exists.
struct Normal<V: Machine> {
    unit: Vectors<V>,
    length2: Floats<V>,
    is_there: Mask<V>,
}

impl<V: Machine> Normal<V> {
    /// The normal of a scaled gradient.
    #[inline(always)]
    fn of(simd: V, gradient: &Vectors<V>) -> Self {
        let (zero, one) = (all(simd, 0.0), all(simd, 1.0));
        let length2 = dot::<V>(gradient, gradient);
        let is_there = length2.simd_gt(1e-30);
        let factor = is_there.select(one / length2.sqrt(), zero);
        let [x, y, z] = *gradient;
        Normal { unit: [x * factor, y * factor, z * factor], length2, is_there }
    }
}

impl<V: Machine> Turns<V> {
    /// The turn between the gradients at start, middle and end of a piece with this relative change of height.
    #[inline(always)]
    pub fn of(simd: V, gradients: &[Vectors<V>; 3], eps: Floats<V>, spread: LightSpread<Floats<V>>) -> Self {
        let ([a, m, b], largest) = scaled(simd, gradients);
        let (start, middle, end) = (Normal::of(simd, &a), Normal::of(simd, &m), Normal::of(simd, &b));
        let nm = middle.unit;
        let (mut na, mut nb) = (start.unit, end.unit);
        let none = <Mask<V> as SimdMask<V>>::splat(simd, false);
        let (mut is_at_end, mut has_gap) = (none, none);
        let mut least = start.length2.min(middle.length2).min(end.length2);
        if !(start.is_there & middle.is_there & end.is_there).all_true() {
            let [has_a, has_m, has_b] = [start.is_there, middle.is_there, end.is_there];
            let (at_start, at_end) = (!has_a & has_m & has_b, has_a & has_m & !has_b);
            for k in 0..3 {
                na[k] = at_start.select(nm[k] + nm[k] - end.unit[k], na[k]);
                nb[k] = at_end.select(nm[k] + nm[k] - start.unit[k], nb[k]);
            }
            let most = all(simd, f32::MAX);
            let present = [
                has_a.select(start.length2, most),
                has_m.select(middle.length2, most),
                has_b.select(end.length2, most),
            ];
            least = present[0].min(present[1]).min(present[2]);
            is_at_end = at_start | at_end;
            has_gap = (has_a | has_m | has_b) & !(has_a & has_m & has_b);
        }
        let rise = [nb[0] - na[0], nb[1] - na[1], nb[2] - na[2]];
        let bend =
            [second::<V>(na[0], nm[0], nb[0]), second::<V>(na[1], nm[1], nb[1]), second::<V>(na[2], nm[2], nb[2])];
        let twice = spread.second * 2.0;
        let mean = [bend[0].mul_add(twice, nm[0]), bend[1].mul_add(twice, nm[1]), bend[2].mul_add(twice, nm[2])];
        let (rise2, bend2) = (dot::<V>(&rise, &rise), dot::<V>(&bend, &bend));
        let angle2 = rise2 + bend2 + dot::<V>(&rise, &bend).abs() * 2.0;
        let (angle, bend_length) = (angle2.sqrt(), bend2.sqrt());
        let bulged = [second::<V>(a[0], m[0], b[0]), second::<V>(a[1], m[1], b[1]), second::<V>(a[2], m[2], b[2])];
        // NaN becomes a large value.
        let bulge = (dot::<V>(&bulged, &bulged) / least).sqrt().min_precise(4.0);
        let part = bend2 / (rise2 + bend2 + f32::MIN_POSITIVE);
        let uneven = (eps * eps).mul_add(0.03, (part.mul_add(4.0, 0.5) * part).min(0.6));
        let lost = is_at_end.select(angle * 0.2, all(simd, 0.0));
        let centre = spread.centre.abs();
        let bulging = (angle * 0.2).mul_add(centre + bulge, bulge * bulge * 0.6);
        let along = angle2.mul_add(1.0 / 400.0, (centre * angle).mul_add(1.0 / 30.0, bulge * 0.03));
        Turns {
            mean,
            rise,
            bend,
            size: a[0].abs().max(a[1].abs()).max(a[2].abs()).max(spread.extent) * largest,
            angle,
            angle2,
            bend_length,
            across: uneven.mul_add(bend_length, bulge.mul_add(bulging, lost)),
            along: angle2 * along,
            spread,
            is_wild: angle2.simd_gt(3.0) | (has_gap & !is_at_end),
        }
    }

    /// Its components along `direction`.
    #[inline(always)]
    pub fn cosine(&self, direction: &Vectors<V>) -> Cosine<Floats<V>> {
        let (even, rise) = (dot::<V>(&self.mean, direction), dot::<V>(&self.rise, direction));
        Cosine { even, mean: self.spread.centre.mul_add(rise, even), rise, bend: dot::<V>(&self.bend, direction) }
    }

    /// The ratio of the variance over the piece's light to the square of a difference between the ends.
    #[inline(always)]
    pub fn variance(&self) -> Floats<V> {
        (self.spread.second - self.spread.centre * self.spread.centre).max(0.0)
    }
}

/// [`Cosine::largest`] in vectors.
#[inline(always)]
pub(super) fn largest_cosine<V: Machine>(cosine: &Cosine<Floats<V>>) -> Floats<V> {
    let middle = cosine.even - cosine.bend * (1.0 / 6.0);
    let end = (cosine.even + cosine.bend * (1.0 / 3.0)).abs() + cosine.rise.abs() * 0.5;
    end.max(middle.abs())
}

/// [`Cosine::swing`] in vectors.
#[inline(always)]
pub(super) fn swing<V: Machine>(cosine: &Cosine<Floats<V>>) -> Floats<V> {
    cosine.rise.abs() + cosine.bend.abs()
}

#[inline(always)]
fn second<V: Machine>(a: Floats<V>, m: Floats<V>, b: Floats<V>) -> Floats<V> {
    (a - m) + (b - m)
}

#[inline(always)]
fn dot<V: Machine>(a: &Vectors<V>, b: &Vectors<V>) -> Floats<V> {
    a[0].mul_add(b[0], a[1].mul_add(b[1], a[2] * b[2]))
}

/// Gradients divided by the largest component of all, and that; zero if it is infinite.
#[inline(always)]
fn scaled<V: Machine>(simd: V, gradients: &[Vectors<V>; 3]) -> ([Vectors<V>; 3], Floats<V>) {
    let mut largest = all(simd, f32::MIN_POSITIVE);
    for [x, y, z] in gradients {
        largest = largest.max(x.abs()).max(y.abs()).max(z.abs());
    }
    // An infinite one makes all zero.
    let scale = all(simd, 1.0) / largest;
    let [a, m, b] = gradients;
    ([times::<V>(a, scale), times::<V>(m, scale), times::<V>(b, scale)], largest)
}

#[inline(always)]
fn times<V: Machine>([x, y, z]: &Vectors<V>, scale: Floats<V>) -> Vectors<V> {
    [*x * scale, *y * scale, *z * scale]
}
