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
use crate::general::{MeanColor, Nodes, Panel};
use crate::light::{COLOR_PART, INDEPENDENT, Radiance};
use crate::number::Vector;
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
    change: ColorChange<Vector<V>>,
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

    /// Lights the colours with the mean shade of the volume on pieces with this [growth](Panel::growth); `unseen` is the
    /// relative error of the absorption of all volumes. Returns the light that the volume absorbs, the
    /// shade's error, that by rounding, and the standard deviation by rounding of the gradients.
    #[inline(always)]
    fn shade(
        &mut self,
        simd: V,
        panel: &Panels<V>,
        (growth, unseen): ([Vector<V>; 3], Vector<V>),
        (lit, shading): (&Lit<V>, &RayShading<f32>),
        (course, range): (&GradientCourse<V>, [Floats<V>; 2]),
    ) -> (Floats<V>, [Floats<V>; 3]) {
        let absorbs = panel.faded(&nodes(simd, self.extinction, self.thickening));
        let spread = absorbs.spread(growth, unseen);
        // The three places may miss dense media entirely.
        let share = absorbs.simpson().lanes + f32::MIN_POSITIVE;
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
) -> ColorChange<Vector<V>> {
    let [start, middle, end] = colors;
    let (mut bend, mut change) = (all(simd, 0.0), all(simd, 0.0));
    for k in 0..3 {
        bend = bend.max((start[k] - middle[k] - middle[k] + end[k]).abs());
        change = change.max((end[k] - start[k]).abs());
    }
    let bend = bend + bend;
    ColorChange { brightest, change: change + bend, bend, eps }.map(|lanes| Vector::new(simd, lanes))
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
        let vector = |lanes| Vector::new(simd, lanes);
        let mut panel = Panel {
            rate: nodes(simd, rates, thickening),
            color: [nodes(simd, [zero; 3], [zero; 2]); 3],
            depth: vector(depth),
            through: [one - absorbed_by(simd, front), one - absorbed].map_inline(vector),
            length: vector(length),
            // Of volumes that differ where one is not seen, the least favourable.
            eps: vector(zero - eps),
        };
        let mut of_shades = [zero; 3];
        if let Some((lit, shading, courses, range)) = lighting {
            let growth = panel.growth();
            let seen = length * panel.faded(&panel.rate).mean().lanes;
            let unseen = vector((seen / absorbed.max(f32::MIN_POSITIVE) - 1.0).abs());
            let mut sum = zero;
            for volume in volumes.iter_mut() {
                let course = &courses[volume.number];
                let (share, of_shade) = volume.shade(simd, &panel, (growth, unseen), (lit, shading), (course, range));
                sum += share;
                of_shades = [0, 1, 2].map_inline(|k: usize| share.mul_add(of_shade[k], of_shades[k]));
            }
            of_shades = of_shades.map_inline(|error| error / sum);
        }
        panel.color = mixed(simd, volumes);
        let (mut rounded, mut thickened) = (zero, zero);
        for volume in &*volumes {
            rounded = rounded.max(volume.rounding[0]);
            thickened += volume.rounding[1];
        }
        let mean = MeanColor::of(&panel, vector(absorbed));
        let (color, off, spread) = (mean.color.map_inline(|channel| channel.lanes), mean.off.lanes, mean.spread.lanes);
        // Errors of extinctions change the mixture of colours.
        let rounded = spread.mul_add((thickened / depth.max(f32::MIN_POSITIVE)).min(one), rounded);
        let [shade_off, shade_rounding, shade_deviation] = of_shades;
        // In dense pieces the centre of the light is less certain.
        let shade_off = shade_off * depth.simd_le(THIN as f32).select(one, all(simd, 3.0));
        // Estimates of different pieces are added as independent ones.
        let of_color = off * COLOR_PART[usize::from(lighting.is_some())] as f32;
        let own = of_color.mul_add(of_color, shade_off * shade_off).sqrt();
        let off_by = thickened.mul_add(panel.through[1].lanes, absorbed * (rounded + 0.5 * f32::EPSILON)).min(one);
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

/// Colour times extinction of all volumes.
#[inline(always)]
fn mixed<V: Machine>(simd: V, volumes: &[VolumeNodes<V>]) -> [Nodes<Vector<V>>; 3] {
    let zero = all(simd, 0.0);
    let (mut values, mut slopes) = ([[zero; 3]; 3], [[zero; 2]; 3]);
    for (k, (values, slopes)) in values.iter_mut().zip(&mut slopes).enumerate() {
        for volume in volumes {
            for (place, value) in values.iter_mut().enumerate() {
                *value = volume.extinction[place].mul_add(volume.color[place][k], *value);
            }
            for (end, slope) in slopes.iter_mut().enumerate() {
                let (rate, color) = (volume.extinction[2 * end], volume.color[2 * end][k]);
                *slope += volume.thickening[end].mul_add(color, rate * volume.tint[end][k]);
            }
        }
    }
    [0, 1, 2].map_inline(|k: usize| nodes(simd, values[k], slopes[k]))
}

/// The panel of each lane.
type Panels<V> = Panel<Vector<V>>;

/// A function in each lane, of these values at the three places and slopes over the piece at its ends.
#[inline(always)]
fn nodes<V: Machine>(simd: V, values: [Floats<V>; 3], slopes: [Floats<V>; 2]) -> Nodes<Vector<V>> {
    let vector = |lanes| Vector::new(simd, lanes);
    Nodes { values: values.map_inline(vector), slopes: slopes.map_inline(vector) }
}
