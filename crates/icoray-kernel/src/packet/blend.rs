//! Several volumes on one piece of each lane's ray: the rules of [`general::blend`](crate::general) in vectors.
//!
//! Extinctions add up, colours mix by extinction; the start, the middle and the end of a piece give the mean colour of
//! the absorbed light, by the rule of `general/mean_color.rs`. If its error is too large, the lane takes half of the
//! piece.

use super::integral::{Light, absorbed_by, bend_factor};
use super::lanes::Lanes;
use super::light::{GradientCourse, Lit, Shade, is_dear};
use super::medium::Medium;
use super::part::{Part, all};
use super::several::LEAST_PART;
use crate::light::{COLOR_PART, INDEPENDENT, Radiance};
use crate::lit::LightSpread;
use crate::piece::THIN;
use crate::shade::{ColorChange, RayShading};
use fearless_simd::prelude::*;
use icoray_grid::array::MapInline;
use icoray_simd::{Floats, Machine, Mask};

/// A volume on the pieces of all lanes: parts and media of the fields of its extinction and of its colour.
pub(super) struct VolumePiece<'p, V: Machine> {
    pub extinction: (&'p Part<V>, &'p Medium<V>),
    pub color: (&'p Part<V>, &'p Medium<V>),
    /// The largest magnitude of values of the two fields at the vertices.
    pub sizes: [Floats<V>; 2],
    /// Lanes in which no value of the two is missing and extinction is not zero.
    pub is_seen: Mask<V>,
}

/// A volume at the start, in the middle and at the end of the pieces.
pub(super) struct VolumeNodes<V: Machine> {
    /// The number of the volume.
    number: usize,
    extinction: [Floats<V>; 3],
    color: [[Floats<V>; 3]; 3],
    /// Slopes of the extinction and of the colour along the piece, at its start and end.
    thickening: [Floats<V>; 2],
    tint: [[Floats<V>; 3]; 2],
    /// Length of the piece, and relative change of height along it.
    length: Floats<V>,
    eps: Floats<V>,
    /// Optical depth of the whole piece, and of its first half.
    depth: [Floats<V>; 2],
    /// Largest error of the colour of the light and of the optical depth due to rounding.
    rounding: [Floats<V>; 2],
    change: ColorChange<Floats<V>>,
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
        let thickened = part.length * medium.slope.abs() * part.reach(piece.sizes[0]);
        let tints = color_part.end_slopes();
        VolumeNodes {
            number,
            extinction,
            color: color_at,
            thickening: part.end_slopes().map_inline(|slope| shown(medium.slope * slope)),
            tint: tints.map_inline(|slope| color.color_slope.map_inline(|c| shown(c * slope))),
            length: shown(part.length),
            eps: shown(part.eps),
            depth: [shown(whole), shown(front)],
            rounding: [shown(color.steepest * color_part.reach(piece.sizes[1])), shown(thickened)],
            change: changes(simd, &color_at, color.brightest, part.eps),
        }
    }

    /// Lights the colours with the mean shade of the volume on pieces with this [growth](growth); `unseen` is the
    /// relative error of the absorption of all volumes. Returns the light that the volume absorbs, the
    /// shade's error, that by rounding, and the standard deviation by rounding of the gradients.
    #[inline(always)]
    fn shade(
        &mut self,
        simd: V,
        fading: &Fading<V>,
        (growth, unseen): ([Floats<V>; 3], Floats<V>),
        (lit, shading): (&Lit<V>, &RayShading<f32>),
        (course, range): (&GradientCourse<V>, [Floats<V>; 2]),
    ) -> (Floats<V>, [Floats<V>; 3]) {
        let absorbs = fading.nodes(self.extinction, self.thickening);
        let spread = absorbs.spread(simd, growth, unseen);
        // The three places may miss dense media entirely.
        let share = simpson::<V>(absorbs.values) + f32::MIN_POSITIVE;
        let Shade { body, tilt, highlight, off, rounding, deviation } =
            lit.shade_of(simd, shading, (course, range, lit.eps), spread, &self.change);
        for k in 0..3 {
            let added = (self.color[2][k] - self.color[0][k]).mul_add(tilt, highlight);
            for place in 0..3 {
                self.color[place][k] = self.color[place][k].mul_add(body, added);
            }
            for end in 0..2 {
                self.tint[end][k] *= body;
            }
        }
        (share, [off, rounding, deviation])
    }
}

/// Values at three places, weighted by the transmittances from the start to them.
#[inline(always)]
fn weighted<V: Machine>([a, m, b]: [Floats<V>; 3], through: &[Floats<V>; 2]) -> [Floats<V>; 3] {
    [a, m * through[0], b * through[1]]
}

/// The light that passes.
struct Fading<V: Machine> {
    /// Transmittance from the start to the middle and to the end.
    through: [Floats<V>; 2],
    /// Extinction of all volumes at the start and end, times the length of the piece.
    rates: [Floats<V>; 2],
}

impl<V: Machine> Fading<V> {
    /// A function with these values at the three places and slopes at the ends, weighted by the transmittance.
    #[inline(always)]
    fn nodes(&self, values: [Floats<V>; 3], slopes: [Floats<V>; 2]) -> Nodes<V> {
        let [from, to] = [0, 1].map_inline(|end: usize| slopes[end] - self.rates[end] * values[2 * end]);
        Nodes { values: weighted::<V>(values, &self.through), slopes: [from, to * self.through[1]] }
    }
}

/// Factors by which coefficients two to four degrees higher come, as `Panel::growth`.
#[inline(always)]
fn growth<V: Machine>([s0, s1, s2]: [Floats<V>; 3], [length, depth]: [Floats<V>; 2], eps: Floats<V>) -> [Floats<V>; 3] {
    let tilt = length * 0.25 * (s1 - s0).abs().max((s2 - s1).abs());
    let uneven = eps / (eps * -0.5 + 1.0);
    let bent = length * (s0 - s1 - s1 + s2).abs() * (1.0 / 12.0);
    let e2 = (depth * depth).mul_add(0.05, tilt) + uneven * uneven * 0.75;
    [e2, e2.mul_add(e2.sqrt(), bent), e2.mul_add(e2, bent * depth.mul_add(0.25, uneven))]
}

/// Simpson's mean.
#[inline(always)]
fn simpson<V: Machine>([a, m, b]: [Floats<V>; 3]) -> Floats<V> {
    (m.mul_add(4.0, a) + b) * (1.0 / 6.0)
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

/// The change of colours over three places.
#[inline(always)]
fn changes<V: Machine>(
    simd: V,
    colors: &[[Floats<V>; 3]; 3],
    brightest: Floats<V>,
    eps: Floats<V>,
) -> ColorChange<Floats<V>> {
    let [start, middle, end] = colors;
    let (mut bend, mut change) = (all(simd, 0.0), all(simd, 0.0));
    for k in 0..3 {
        bend = bend.max((start[k] - middle[k] - middle[k] + end[k]).abs());
        change = change.max((end[k] - start[k]).abs());
    }
    let bend = bend + bend;
    ColorChange { brightest, change: change + bend, bend, eps }
}

/// The light of all volumes on the pieces.
pub(super) struct Blend<V: Machine> {
    pub light: Light<V>,
    /// Errors of the colour per absorbed light: that which adds up along a ray, and that which is independent.
    off: [Floats<V>; 2],
    /// Lanes in which these are no more than its rounding error.
    is_rounding: Mask<V>,
    /// Lanes in which anything is absorbed.
    pub absorbs: Mask<V>,
}

/// The smallest difference of colours that rounding in single precision leaves.
const LEAST_TOLERANCE: f32 = 4.0 * f32::EPSILON;

/// Light on the volumes: the ray's, the frame's, the gradients of each volume, and the range of the frustum.
pub(super) type Lighting<'l, V> = (&'l Lit<V>, &'l RayShading<f32>, &'l [GradientCourse<V>], [Floats<V>; 2]);

impl<V: Machine> Blend<V> {
    /// The light of these volumes; with `lighting`, each with its mean shade.
    #[inline(always)]
    pub fn of(simd: V, volumes: &mut [VolumeNodes<V>], lighting: Option<Lighting<'_, V>>, is_coarse: bool) -> Self {
        let (zero, one) = (all(simd, 0.0), all(simd, 1.0));
        let (mut depth, mut front, mut length, mut eps) = (zero, zero, zero, zero);
        let (mut rates, mut thickening) = ([zero; 3], [zero; 2]);
        for volume in &*volumes {
            (depth, front) = (depth + volume.depth[0], front + volume.depth[1]);
            // These are equal for all visible volumes.
            length = length.max(volume.length);
            eps = eps.max(volume.eps.abs());
            rates = [0, 1, 2].map_inline(|i: usize| rates[i] + volume.extinction[i]);
            thickening = [0, 1].map_inline(|i: usize| thickening[i] + volume.thickening[i]);
        }
        let absorbed = absorbed_by(simd, depth);
        let fading = Fading {
            through: [one - absorbed_by(simd, front), one - absorbed],
            rates: [rates[0] * length, rates[2] * length],
        };
        let growth = growth::<V>(rates, [length, depth], eps);
        let mut of_shades = [zero; 3];
        if let Some((lit, shading, courses, range)) = lighting {
            let seen: Floats<V> = length * fading.nodes(rates, thickening).mean();
            let unseen = (seen / absorbed.max(f32::MIN_POSITIVE) - 1.0).abs();
            let mut sum = zero;
            for volume in volumes.iter_mut() {
                let course = &courses[volume.number];
                let (share, of_shade) = volume.shade(simd, &fading, (growth, unseen), (lit, shading), (course, range));
                sum += share;
                of_shades = [0, 1, 2].map_inline(|k: usize| share.mul_add(of_shade[k], of_shades[k]));
            }
            of_shades = of_shades.map_inline(|error| error / sum);
        }
        let mut mixture = Mixture::none(simd);
        let (mut rounded, mut thickened) = (zero, zero);
        for volume in &*volumes {
            mixture.add(volume);
            rounded = rounded.max(volume.rounding[0]);
            thickened += volume.rounding[1];
        }
        let MeanColor { color, off, spread } = mixture.mean(simd, &fading, growth, [length, absorbed]);
        // Errors of extinctions change the mixture of colours.
        let rounded = spread.mul_add((thickened / depth.max(f32::MIN_POSITIVE)).min(one), rounded);
        let [shade_off, shade_rounding, shade_deviation] = of_shades;
        // In dense pieces the centre of the light is less certain.
        let shade_off = shade_off * depth.simd_le(THIN as f32).select(one, all(simd, 3.0));
        // Estimates of different pieces are added as independent ones.
        let of_color = off * COLOR_PART[usize::from(lighting.is_some())] as f32;
        let own = of_color.mul_add(of_color, shade_off * shade_off).sqrt();
        let off_by = thickened.mul_add(fading.through[1], absorbed * (rounded + 0.5 * f32::EPSILON)).min(one);
        let deviation = absorbed * own * INDEPENDENT as f32;
        // All parts of a frustum share the rounding of the gradients at its vertices.
        let extent = lighting.map_or(one, |(.., [from, to])| (to - from).max(LEAST_PART));
        let turned = absorbed * shade_deviation;
        let light = Radiance {
            color: color.map_inline(|c| c * absorbed),
            alpha: absorbed,
            error: absorbed * shade_rounding,
            variance: off_by.mul_add(off_by, turned * turned / extent),
            shade_variance: deviation * deviation,
        };
        let own = if is_coarse { of_color } else { own };
        // A NaN depth absorbs nothing, and shorter pieces do not reduce rounding errors.
        let is_rounding = (shade_rounding + own).simd_le(rounded);
        Blend { light, off: [shade_rounding, own], is_rounding, absorbs: depth.simd_gt(0.0) }
    }

    /// Lanes whose pieces are to be halved: those whose rays cannot afford the error of lit ones, and unlit ones that
    /// exceed the tolerance themselves, since a halving divides their error by about 64.
    #[inline(always)]
    pub fn is_far(&self, simd: V, lanes: &Lanes<V>, color_tolerance: f32, is_lit: bool) -> Mask<V> {
        let color_tolerance = color_tolerance.max(LEAST_TOLERANCE);
        let is_dear = if is_lit {
            is_dear(simd, &lanes.light, self.light.alpha, self.off, color_tolerance)
        } else {
            self.off[1].simd_gt(COLOR_PART[0] as f32 * color_tolerance)
        };
        is_dear & !self.is_rounding & self.absorbs
    }
}

/// All volumes at the start, in the middle and at the end of the pieces, with slopes along these at the ends.
struct Mixture<V: Machine> {
    /// Extinction.
    rates: [Floats<V>; 3],
    thickening: [Floats<V>; 2],
    /// Colour times extinction.
    colors: [[Floats<V>; 3]; 3],
    tints: [[Floats<V>; 3]; 2],
}

/// The mean colour of the absorbed light, its error, and the difference of the colours.
struct MeanColor<V: Machine> {
    color: [Floats<V>; 3],
    off: Floats<V>,
    spread: Floats<V>,
}

impl<V: Machine> Mixture<V> {
    #[inline(always)]
    fn none(simd: V) -> Self {
        let zero = all(simd, 0.0);
        Mixture { rates: [zero; 3], thickening: [zero; 2], colors: [[zero; 3]; 3], tints: [[zero; 3]; 2] }
    }

    #[inline(always)]
    fn add(&mut self, volume: &VolumeNodes<V>) {
        for place in 0..3 {
            let rate = volume.extinction[place];
            self.rates[place] += rate;
            for (channel, color) in self.colors[place].iter_mut().zip(volume.color[place]) {
                *channel = rate.mul_add(color, *channel);
            }
        }
        for (end, place) in [0, 2].into_iter().enumerate() {
            let (rate, thickening) = (volume.extinction[place], volume.thickening[end]);
            self.thickening[end] += thickening;
            for k in 0..3 {
                let (color, tint) = (volume.color[place][k], volume.tint[end][k]);
                self.tints[end][k] += thickening.mul_add(color, rate * tint);
            }
        }
    }

    /// The mean colour of pieces with this [growth](growth), length and absorbed part.
    #[inline(always)]
    fn mean(
        &self,
        simd: V,
        fading: &Fading<V>,
        [e2, e3, e4]: [Floats<V>; 3],
        [length, absorbed]: [Floats<V>; 2],
    ) -> MeanColor<V> {
        let zero = all(simd, 0.0);
        let rates = fading.nodes(self.rates, self.thickening);
        let whole = rates.mean();
        let inverse = all(simd, 1.0) / whole;
        let (mut color, mut sizes) = ([zero; 3], [zero; 4]);
        for k in 0..3 {
            let channel = fading.nodes(self.colors.map_inline(|color| color[k]), self.tints.map_inline(|tint| tint[k]));
            color[k] = channel.mean() * inverse;
            let found = channel.less(color[k], &rates).coefficients();
            sizes = [0, 1, 2, 3].map_inline(|i: usize| sizes[i].max(found[i]));
        }
        let [a1, a2, a3, a4] = sizes;
        let missed = e2 * a1.mul_add(e3, a4) + a3 * e3 + a2 * e4;
        let (spread, first) = self.spread(simd);
        let longer = length / absorbed.max(f32::MIN_POSITIVE);
        let off = missed * longer * (24.0 / 105.0) + spread * (longer * whole - 1.0).abs();
        let is_near = whole.simd_gt(zero) & off.simd_le(spread);
        if !is_near.all_true() {
            // Simpson's rule: a mean of the colours at the places. The light absorbed at the start may leave none in
            // the middle and at the end.
            let mean = |values: [Floats<V>; 3]| simpson::<V>(weighted::<V>(values, &fading.through));
            let whole = mean(self.rates);
            let inverse = all(simd, 1.0) / whole;
            for (k, channel) in color.iter_mut().enumerate() {
                let simpson = mean(self.colors.map_inline(|color| color[k])) * inverse;
                let simpson = whole.simd_gt(f32::MIN_POSITIVE).select(simpson, first[k]);
                *channel = is_near.select(*channel, simpson);
            }
        }
        MeanColor { color, off: is_near.select(off, spread), spread }
    }

    /// The difference of the colours on the pieces, from those at the places and from their slopes, and the first of
    /// them.
    #[inline(always)]
    fn spread(&self, simd: V) -> (Floats<V>, [Floats<V>; 3]) {
        let (zero, one) = (all(simd, 0.0), all(simd, 1.0));
        let most = all(simd, f32::MAX);
        let has = self.rates.map_inline(|rate| rate.simd_gt(zero));
        let inverse = self.rates.map_inline(|rate| one / rate);
        // Without absorption the colour is that of the volume that begins to absorb there.
        let begins = self.thickening.map_inline(|thickening| one / thickening);
        let [enters, leaves] = self.thickening.map_inline(|thickening| !thickening.simd_eq(zero));
        let is_there = [has[0] | enters, has[1], has[2] | leaves];
        let (mut spread, mut steepest, mut first) = (zero, zero, [zero; 3]);
        for (k, first) in first.iter_mut().enumerate() {
            let (mut low, mut high) = (most, zero - most);
            let mut here = [0, 1, 2].map_inline(|place: usize| self.colors[place][k] * inverse[place]);
            for (end, place) in [0, 2].into_iter().enumerate() {
                let slope = (self.tints[end][k] - here[place] * self.thickening[end]) * inverse[place];
                steepest = has[place].select(steepest.max(slope.abs()), steepest);
                here[place] = has[place].select(here[place], self.tints[end][k] * begins[end]);
            }
            for place in 0..3 {
                low = is_there[place].select(low.min(here[place]), low);
                high = is_there[place].select(high.max(here[place]), high);
            }
            spread = spread.max(high - low);
            *first = is_there[0].select(here[0], is_there[1].select(here[1], here[2]));
        }
        (steepest.mul_add(0.25, spread), first)
    }
}

/// A function at the three places, and its slopes at the ends, for the rule of `general/mean_color.rs`.
#[derive(Clone, Copy)]
struct Nodes<V: Machine> {
    values: [Floats<V>; 3],
    slopes: [Floats<V>; 2],
}

impl<V: Machine> Nodes<V> {
    /// Its mean, exact to the fifth degree.
    #[inline(always)]
    fn mean(&self) -> Floats<V> {
        let [a, m, b] = self.values;
        let ends = (a + b).mul_add(7.0 / 30.0, m * (16.0 / 30.0));
        (self.slopes[0] - self.slopes[1]).mul_add(1.0 / 60.0, ends)
    }

    /// The distribution of light that is absorbed like this, as `Nodes::spread` of `general/mean_color.rs`.
    #[inline(always)]
    fn spread(&self, simd: V, [e2, e3, e4]: [Floats<V>; 3], unseen: Floats<V>) -> LightSpread<Floats<V>> {
        let ([a, m, b], [from, to]) = (self.values, self.slopes);
        let inverse = all(simd, 1.0) / self.mean().max(f32::MIN_POSITIVE);
        let first = (b - a).mul_add(0.1, (from + to) * (-1.0 / 120.0));
        let second = m.mul_add(2.0 / 105.0, (a + b) * (9.0 / 280.0)) + (from - to) * (1.0 / 560.0);
        let [a1, a2, a3, a4] = self.coefficients();
        let missed = e2 * m.mul_add(e3, a4 + a3) + a2 * e3 + a1 * e4;
        let bent = (a - m - m + b).abs();
        let error_bound = missed.mul_add(12.0 / 105.0, bent * 0.02).mul_add(inverse, unseen * 0.5);
        LightSpread {
            centre: (first * inverse).max(-0.5).min(0.5),
            second: (second * inverse).max(0.0).min(0.25),
            error_bound: error_bound.min(0.5),
            extent: all(simd, 1.0),
        }
    }

    #[inline(always)]
    fn less(&self, factor: Floats<V>, other: &Self) -> Self {
        Nodes {
            values: [0, 1, 2].map_inline(|i: usize| self.values[i] - factor * other.values[i]),
            slopes: [0, 1].map_inline(|i: usize| self.slopes[i] - factor * other.slopes[i]),
        }
    }

    /// The sizes of its coefficients of x, x², x³ and x⁴, for x from -1 to 1.
    #[inline(always)]
    fn coefficients(&self) -> [Floats<V>; 4] {
        let ([a, m, b], [from, to]) = (self.values, self.slopes);
        let (rise, bend) = (b - a, a - m - m + b);
        let cubic = ((from + to) * -0.5 + rise) * 0.25;
        let quartic = ((from - to) * 0.25 + bend) * 0.5;
        [(rise * 0.5).abs(), (bend * 0.5).abs(), cubic.abs(), quartic.abs()]
    }
}
