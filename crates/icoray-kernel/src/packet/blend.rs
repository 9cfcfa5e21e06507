//! Several volumes on one piece of each lane's ray: the rules of [`general::blend`](crate::general) in vectors.
//!
//! Extinctions add up, colours mix by extinction; Simpson's rule over the start, the middle and the end of a piece gives
//! the mean colour of the light that is absorbed. Where that is not near enough, the lane takes half of the piece.

use super::integral::{Light, absorbed_by, bend_factor};
use super::lanes::Lanes;
use super::light::{Change, GradientCourse, Lit, Shade};
use super::medium::Medium;
use super::part::{Part, all};
use super::turn::Spread;
use crate::lit::ADVANCE;
use crate::piece::THIN;
use crate::shade::RayShading;
use fearless_simd::prelude::*;
use icoray_grid::array::MapInline;
use icoray_simd::{Floats, Machine, Mask};

/// A volume on the pieces of all lanes: parts and media of the fields of its extinction and of its colour.
pub(super) struct VolumePiece<'p, V: Machine> {
    pub extinction: (&'p Part<V>, &'p Medium<V>),
    pub color: (&'p Part<V>, &'p Medium<V>),
    /// Lanes in which no value of the two is missing and there is extinction.
    pub is_seen: Mask<V>,
}

/// A volume at the start, in the middle and at the end of the pieces.
pub(super) struct VolumeNodes<V: Machine> {
    /// The number of the volume.
    number: usize,
    extinction: [Floats<V>; 3],
    color: [[Floats<V>; 3]; 3],
    /// Optical depth of the whole piece, and of its first half.
    depth: [Floats<V>; 2],
    /// Largest error that rounding gives to the colour of the light and to the optical depth.
    rounding: [Floats<V>; 2],
    change: Change<V>,
}

impl<V: Machine> VolumeNodes<V> {
    #[inline(always)]
    pub fn new(simd: V, number: usize, piece: &VolumePiece<'_, V>) -> Self {
        let ((part, medium), (color_part, color)) = (piece.extinction, piece.color);
        let (zero, half) = (all(simd, 0.0), all(simd, 0.5));
        let middle = part.value(simd, half);
        let shown = |x: Floats<V>| piece.is_seen.select(x, zero);
        let extinction = [
            shown(medium.extinction(simd, part.f0)),
            shown(medium.extinction(simd, middle)),
            shown(medium.extinction(simd, part.f1)),
        ];
        let first = part.between((zero, part.f0), (half, middle));
        let whole = depth(simd, part, medium, [extinction[0], extinction[2]]);
        let front = depth(simd, &first, medium, [extinction[0], extinction[1]]);
        let at = color_part.value(simd, half);
        let color_at =
            [colors(simd, color, color_part.f0), colors(simd, color, at), colors(simd, color, color_part.f1)];
        let thickened = part.length * medium.slope.abs() * part.reach();
        VolumeNodes {
            number,
            extinction,
            color: color_at,
            depth: [shown(whole), shown(front)],
            rounding: [shown(color.steepest * color_part.reach()), shown(thickened)],
            change: changes(simd, &color_at, color.brightest, part.eps),
        }
    }

    /// Puts the colours under the mean shade of the volume. `through` is the transmittance at the places. Returns the
    /// light that the volume absorbs, and the error of the shade.
    #[inline(always)]
    fn shade(
        &mut self,
        simd: V,
        through: &[Floats<V>; 2],
        (lit, shading): (&Lit<V>, &RayShading<f32>),
        (course, range): (&GradientCourse<V>, [Floats<V>; 2]),
    ) -> [Floats<V>; 2] {
        let [a, m, b] = self.extinction;
        let (m, b) = (m * through[0], b * through[1]);
        let absorbed = (m.mul_add(4.0, a) + b) * (1.0 / 6.0);
        let mean = absorbed + f32::MIN_POSITIVE;
        let bent = (a - m - m + b).abs() / mean;
        let spread = Spread { centre: (b - a) / (mean * 12.0), error_bound: (bent * 0.2).min(0.5) };
        let Shade { body, tilt, highlight, off } =
            lit.shade_of(simd, shading, (course, range, lit.eps), spread, &self.change);
        for k in 0..3 {
            let added = (self.color[2][k] - self.color[0][k]).mul_add(tilt, highlight);
            for place in 0..3 {
                self.color[place][k] = self.color[place][k].mul_add(body, added);
            }
        }
        [absorbed, off]
    }
}

/// Optical depth of a part with these extinctions at its ends.
#[inline(always)]
fn depth<V: Machine>(simd: V, part: &Part<V>, medium: &Medium<V>, [from, to]: [Floats<V>; 2]) -> Floats<V> {
    let bend = part.kappa * bend_factor(simd, part.eps);
    (part.length * (medium.slope * bend).mul_add(1.0 / 6.0, (from + to) * 0.5)).max(all(simd, 0.0))
}

/// The colours of values, none below black.
#[inline(always)]
fn colors<V: Machine>(simd: V, medium: &Medium<V>, f: Floats<V>) -> [Floats<V>; 3] {
    let (x, zero) = (f - medium.anchor, all(simd, 0.0));
    let [r, g, b] = [0, 1, 2].map_inline(|k: usize| medium.color_slope[k].mul_add(x, medium.color[k]));
    [r.max(zero), g.max(zero), b.max(zero)]
}

/// How colours at three places change.
#[inline(always)]
fn changes<V: Machine>(simd: V, colors: &[[Floats<V>; 3]; 3], brightest: Floats<V>, eps: Floats<V>) -> Change<V> {
    let [start, middle, end] = colors;
    let (mut bend, mut change) = (all(simd, 0.0), all(simd, 0.0));
    for k in 0..3 {
        bend = bend.max((start[k] - middle[k] - middle[k] + end[k]).abs());
        change = change.max((end[k] - start[k]).abs());
    }
    let bend = bend + bend;
    Change { brightest, change: change + bend, bend, eps }
}

/// The light of all volumes on the pieces.
pub(super) struct Blend<V: Machine> {
    pub light: Light<V>,
    /// Error of the colour per absorbed light.
    off: Floats<V>,
    /// Lanes in which anything is absorbed.
    pub absorbs: Mask<V>,
}

/// Rounding in single precision leaves no smaller differences of colours.
const LEAST_TOLERANCE: f32 = 4.0 * f32::EPSILON;

/// Light on the volumes: the ray's, the frame's, the gradients of each volume, and the range of the frustum.
pub(super) type Lighting<'l, V> = (&'l Lit<V>, &'l RayShading<f32>, &'l [GradientCourse<V>], [Floats<V>; 2]);

impl<V: Machine> Blend<V> {
    /// Of these volumes; with `lighting`, each under its mean shade.
    #[inline(always)]
    pub fn of(simd: V, volumes: &mut [VolumeNodes<V>], lighting: Option<Lighting<'_, V>>, is_coarse: bool) -> Self {
        let (zero, one) = (all(simd, 0.0), all(simd, 1.0));
        let (mut depth, mut front) = (zero, zero);
        for volume in &*volumes {
            (depth, front) = (depth + volume.depth[0], front + volume.depth[1]);
        }
        let absorbed = absorbed_by(simd, depth);
        let through = [one - absorbed_by(simd, front), one - absorbed];
        let (mut shade_off, mut sharpness) = (zero, 0.0);
        if let Some((lit, shading, courses, range)) = lighting {
            let (mut sum, mut off) = (all(simd, f32::MIN_POSITIVE), zero);
            for volume in volumes.iter_mut() {
                let course = &courses[volume.number];
                let [share, shade_off] = volume.shade(simd, &through, (lit, shading), (course, range));
                (sum, off) = (sum + share, share.mul_add(shade_off, off));
            }
            (shade_off, sharpness) = (off / sum, shading.sharpness);
        }
        let mut rates = [zero; 3];
        let mut mixed = [[zero; 3]; 3];
        let (mut rounded, mut thickened) = (zero, zero);
        for volume in &*volumes {
            for place in 0..3 {
                let rate = volume.extinction[place];
                rates[place] += rate;
                for (channel, color) in mixed[place].iter_mut().zip(volume.color[place]) {
                    *channel = rate.mul_add(color, *channel);
                }
            }
            rounded = rounded.max(volume.rounding[0]);
            thickened += volume.rounding[1];
        }
        let Means { color, rule, spread } = Means::of(simd, &rates, &mixed, through);
        let cut_for = if is_coarse { zero } else { shade_off };
        let is_thin = depth.simd_le(THIN as f32);
        let off = is_thin.select(rule + cut_for, spread + cut_for * 3.0);
        let told = is_thin.select(rule + shade_off, spread + shade_off * 3.0);
        let off_by = (rounded + thickened * through[1] + absorbed * (0.5 * f32::EPSILON)).min(one);
        let shaded = absorbed * (0.25 * f32::EPSILON * sharpness);
        let light = Light {
            color: color.map_inline(|c| c * absorbed),
            alpha: absorbed,
            error: absorbed * told,
            variance: off_by.mul_add(off_by, shaded * shaded),
        };
        // No number is no depth.
        Blend { light, off, absorbs: depth.simd_gt(0.0) }
    }

    /// Lanes whose rays cannot afford the error of their pieces, from what pieces before have left of theirs and an
    /// advance.
    #[inline(always)]
    pub fn is_far(&self, simd: V, lanes: &Lanes<V>, color_tolerance: f32) -> Mask<V> {
        let (zero, one) = (all(simd, 0.0), all(simd, 1.0));
        let color_tolerance = color_tolerance.max(LEAST_TOLERANCE);
        let earned = ((lanes.alpha + ADVANCE as f32) * color_tolerance - lanes.error).max(zero);
        let through = (one - lanes.alpha).max(f32::MIN_POSITIVE);
        ((self.off - color_tolerance) * self.light.alpha * through).simd_gt(earned) & self.absorbs
    }
}

/// The mean colour by Simpson's rule, how far that of the ends alone is from it, and how far colours are apart.
struct Means<V: Machine> {
    color: [Floats<V>; 3],
    rule: Floats<V>,
    spread: Floats<V>,
}

impl<V: Machine> Means<V> {
    #[inline(always)]
    fn of(simd: V, rates: &[Floats<V>; 3], mixed: &[[Floats<V>; 3]; 3], [front, through]: [Floats<V>; 2]) -> Self {
        let zero = all(simd, 0.0);
        let (least, most) = (all(simd, f32::MIN_POSITIVE), all(simd, f32::MAX));
        let has = [rates[0].simd_gt(zero), rates[1].simd_gt(zero), rates[2].simd_gt(zero)];
        let inverse = [all(simd, 1.0) / rates[0], all(simd, 1.0) / rates[1], all(simd, 1.0) / rates[2]];
        let weights = [all(simd, 1.0), front * 4.0, through];
        let ends = through.mul_add(rates[2], rates[0]);
        let sum = weights[1].mul_add(rates[1], ends);
        let (of_sum, of_ends) = (all(simd, 1.0) / sum.max(least), all(simd, 1.0) / ends.max(least));
        let (mut color, mut rule, mut spread) = ([zero; 3], zero, zero);
        for k in 0..3 {
            let at_ends = through.mul_add(mixed[2][k], mixed[0][k]);
            color[k] = weights[1].mul_add(mixed[1][k], at_ends) * of_sum;
            rule = rule.max((color[k] - at_ends * of_ends).abs());
            let (mut low, mut high) = (most, zero - most);
            for place in 0..3 {
                let here = mixed[place][k] * inverse[place];
                low = has[place].select(low.min(here), low);
                high = has[place].select(high.max(here), high);
            }
            spread = spread.max(high - low);
        }
        Means { color, rule: ends.simd_gt(zero).select(rule.min(spread), spread), spread }
    }
}
