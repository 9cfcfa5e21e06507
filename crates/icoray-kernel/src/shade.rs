//! Lighting: Blinn and Phong's model with the field's gradient as the normal (§3.5 of the paper).
//!
//! A piece has one shade, [`RayShading::mean`], taken at its mean normal ([`NormalTurn`]); the turn about that mean
//! corrects it and bounds the remaining error.
//!
//! **Body**, `ambient + diffuse |n·l|`. Where `n·l` keeps its sign its mean is that of n, times l: no error but that of
//! the mean normal. Where it changes its sign, |n·l| has a kink: over a linear `n·l` of mean a and half-range r the mean
//! is `|a| + (r - |a|)²/2r`, and light that rises along the piece weighs the part behind the kink. Colour that changes
//! together with n·l adds the covariance of the two, `Δc Δ(n·l)/12`, less the square of the centre.
//!
//! **Highlight**, `specular |n·h|^s`. To second order about the mean p of n·h, of variance V, it is
//! `p^s (1 + s(s-1)V/2p²)`. With `x = √s θ` and t the angle from the highlight's middle times √s, the remainder is at
//! most `x⁴ e^(-t²/2) |t⁴/1920 - t²/720| <= x⁴/1900`; more where light is uneven (`0.023 centre x³`), where its centre
//! is not sure (the slope, at most `0.61 x`), and where the mean normal is not. At `y = s (1 - |n·h|) = t²/2` the
//! polynomial times `e^-y` is no more than `(1.3 - y/12)⁴` of its largest value, and less than 1/1700 of that beyond y
//! = 14. Powers below 2 have a kink where n is across h, like the body; powers below 6 are not small there.

use super::light::INDEPENDENT;
use super::number::Number;
use super::piece::Radiance;
use super::turn::{NormalTurn, direction, dot};
use glam::DVec3;
use icoray_grid::array::MapInline;
use icoray_grid::gradient::Gradients;
use icoray_grid::real::Real;

/// Reflectance of surfaces, and the direction of the light (Blinn and Phong's model).
#[derive(Debug, Clone, Copy)]
pub struct Shading {
    /// Ambient factor of the colour.
    pub ambient: f64,
    /// Diffuse factor of the colour.
    pub diffuse: f64,
    /// Strength of the white highlight.
    pub specular: f64,
    /// Exponent of the highlight.
    pub shininess: f64,
    /// Unit vector towards the light; `None` is a headlight, at the eye.
    pub towards_light: Option<DVec3>,
    /// Whether the gradients are packed ([`Gradients::Packed`]), which turns the normals slightly.
    pub is_packed: bool,
}

/// [`Shading`] for one ray.
#[derive(Debug, Clone, Copy)]
pub struct RayShading<T> {
    /// Ambient factor of the colour.
    pub ambient: T,
    /// Diffuse factor of the colour.
    pub diffuse: T,
    /// Strength of the white highlight.
    pub specular: T,
    /// Exponent of the highlight, at least 1.
    pub shininess: T,
    /// Unit vector towards the light.
    pub light: [T; 3],
    /// Unit vector half-way between the light and the eye.
    pub halfway: [T; 3],
    /// The larger of 4 and the exponent: squared ratio of the change of a shade to the turn of its normal.
    pub sharpness: T,
    /// Standard deviation of a shade due to its own rounding, and to that of the gradients from which its normal is
    /// mixed ([`Shading::deviations`]).
    pub deviations: [T; 2],
}

/// Factor for the surface's own colour, and the white highlight.
#[derive(Debug, Clone, Copy)]
pub struct Shade<T> {
    /// Factor for the surface's own colour.
    pub body: T,
    /// The white highlight, added to each channel.
    pub highlight: T,
}

/// The shade of a piece, for light whose colour changes along it.
#[derive(Debug, Clone, Copy)]
pub struct MeanShade<T> {
    /// The mean shade.
    pub shade: Shade<T>,
    /// Factor for the change of the colour from the piece's start to its end, added per absorbed light.
    pub tilt: T,
    /// Error of a channel per absorbed light, without rounding.
    pub off: T,
    /// The part of rounding, which is alike in neighbouring pieces.
    pub rounding: T,
    /// Size of the gradients where most of the light is.
    pub size: T,
}

/// Brightness of a piece, and the change of its colour along it.
#[derive(Debug, Clone, Copy)]
pub struct ColorChange<T> {
    /// Its brightest channel.
    pub brightest: T,
    /// The largest change of a channel along it.
    pub change: T,
    /// The part of that change that is a bend, equal at both ends.
    pub bend: T,
    /// Relative change of height along the piece, which makes the bend uneven.
    pub eps: T,
}

impl Shading {
    /// The smallest error per absorbed light to which a piece can be cut whose channels are no brighter than
    /// `brightest`: twice the rounding error of a mean shade ([`RayShading::mean`]), which short pieces have too, and
    /// at least the rounding of the sum of a thousand of them.
    #[inline]
    pub fn least_error<T: Real>(&self, brightest: f64) -> f64 {
        let of_shade = 2.0 * (4.0 * brightest + 3.0 * self.shininess.max(4.0) * self.specular);
        T::ROUNDING * of_shade.max(64.0)
    }

    /// Standard deviations of a shade: that due to rounding of the shade, which is larger for sharper highlights, and
    /// that due to rounding of gradients, which are stored in single precision or packed. A normal that turns by a
    /// small angle changes the body by at most `diffuse` times that angle, the highlight by `0.61 √shininess specular`
    /// times it, but hardly ever both.
    #[inline]
    pub fn deviations<T: Real>(&self) -> [f64; 2] {
        let rounded = 0.5 * T::ROUNDING * self.shininess.max(4.0);
        let steepest = self.diffuse.hypot(0.61 * self.shininess.sqrt() * self.specular);
        let stored = if self.is_packed { Gradients::PACKED_TURN } else { 0.25 * f64::from(f32::EPSILON) };
        [rounded, stored.hypot(T::ROUNDING) * steepest]
    }

    /// The lighting of rays along `dir`.
    #[inline]
    pub fn along<T: Real>(&self, dir: DVec3) -> RayShading<T> {
        let light = self.towards_light.unwrap_or(-dir);
        // Light from straight behind has no half-way direction; a zero vector then gives no highlight.
        let halfway = (light - dir).try_normalize().unwrap_or(DVec3::ZERO);
        RayShading {
            ambient: T::of(self.ambient),
            diffuse: T::of(self.diffuse),
            specular: T::of(self.specular),
            shininess: T::of(self.shininess),
            light: light.to_array().map_inline(T::of),
            halfway: halfway.to_array().map_inline(T::of),
            sharpness: T::of(self.shininess.max(4.0)),
            deviations: self.deviations::<T>().map_inline(T::of),
        }
    }
}

impl<T> ColorChange<T> {
    /// This in other numbers.
    #[inline(always)]
    pub fn map<U>(self, number: impl Fn(T) -> U) -> ColorChange<U> {
        let ColorChange { brightest, change, bend, eps } = self;
        ColorChange { brightest: number(brightest), change: number(change), bend: number(bend), eps: number(eps) }
    }
}

impl<T: Number> RayShading<T> {
    /// The mean shade along a piece of a ray.
    #[inline(always)]
    pub fn mean(&self, turn: &NormalTurn<T>, color: &ColorChange<T>) -> MeanShade<T> {
        let number = |value: f64| self.ambient.like(value);
        let (body, tilt, dim) = self.mean_body(turn, color);
        let (highlight, faint) = self.mean_highlight(turn);
        let most = color.brightest * self.diffuse + self.specular;
        // A mean cosine has an error of two last digits, and its power that times the exponent.
        let rounded = (color.brightest * body).mul_add(number(4.0), highlight * self.sharpness * number(3.0));
        let off = most.where_else(turn.is_wild, dim + faint);
        let rounding = rounded * number(T::ROUNDING);
        MeanShade { shade: Shade { body, highlight }, tilt, off, rounding, size: turn.size }
    }

    /// Factor for the colour, factor for the colour's change, and the error of both.
    #[inline(always)]
    fn mean_body(&self, turn: &NormalTurn<T>, color: &ColorChange<T>) -> (T, T, T) {
        let number = |value: f64| self.ambient.like(value);
        let [zero, half, one] = [0.0, 0.5, 1.0].map_inline(number);
        let cosine = turn.cosine(&self.light);
        let is_behind = zero.exceeds(cosine.mean);
        let turned = |x: T| (zero - x).where_else(is_behind, x);
        let (level, centre) = (cosine.mean.abs(), turn.spread.centre);
        let (rise, bend, swing) = (turned(cosine.rise), cosine.bend.abs(), cosine.swing());
        let unsure = turn.spread.error_bound;
        let may_cross = swing * half + turn.angle2 * number(0.02) + turn.across - level;
        let crosses = may_cross.exceeds(zero);
        let mut body = level;
        let mut tilt = rise * turn.variance() * self.diffuse;
        let (mut at_kink, mut apart) = (zero, zero);
        // The kink's position, and the part beyond it, as if n·l were linear.
        let reach = rise.abs() * half;
        let beyond = (reach - turned(cosine.even)).max(zero);
        if T::is_any(crosses | beyond.exceeds(zero)) {
            let part = beyond / (reach + reach + zero.least());
            let forward = (zero - centre).where_else(zero.exceeds(rise), centre);
            body = body + beyond * part * (one - forward * (number(6.0) - part * number(4.0)));
            tilt = zero.where_else(crosses, tilt);
            let bent = (bend + turn.across) * number(0.25)
                + (unsure + centre * centre * number(0.3)) * swing
                + turn.angle2 * number(0.05);
            at_kink = (may_cross * half).min(bent).where_else(crosses, zero);
            apart = number(0.1).where_else(crosses, zero);
        }
        // Rules beyond their validity must not leave the range of what they approximate.
        let body = self.ambient + self.diffuse * body.max(zero).min(one);
        let even = unsure * swing + turn.across + turn.along + at_kink;
        let skewed = color.bend * (color.eps.abs() * number(0.015) + centre.abs() * number(0.1)) * swing;
        let change = color.change * (bend * number(0.12) + (unsure + apart) * swing + turn.across) + skewed;
        (body, tilt, (color.brightest * even + change).min(color.brightest) * self.diffuse)
    }

    /// The highlight and its error.
    #[inline(always)]
    fn mean_highlight(&self, turn: &NormalTurn<T>) -> (T, T) {
        let number = |value: f64| self.ambient.like(value);
        let [zero, half, one] = [0.0, 0.5, 1.0].map_inline(number);
        let (s, cosine) = (self.shininess, turn.cosine(&self.halfway));
        let level = cosine.mean.abs().min(one);
        let (reach, swing) = (cosine.reach(), cosine.swing());
        let variance = cosine.rise * cosine.rise * turn.variance() + cosine.bend * cosine.bend * number(1.0 / 45.0);
        let inverse = one / (level * level).max(reach * reach).max(zero.least());
        let bent = variance * inverse * (half * s * (s - one)) + one;
        let power = level.power(s);
        let highlight = (power * bent).max(zero).min(one);
        // Angles in widths of the highlight.
        let (x2, root) = (turn.angle2 * s, s.sqrt());
        let x = turn.angle * root;
        let nearest = (one - cosine.largest()).max(zero);
        let y = (nearest * ((s - number(2.0)).max(zero) * number(0.85)) - x2 * number(0.1)).max(zero);
        let near = (number(1.3) - y * number(1.0 / 12.0)).max(zero).min(one);
        let near2 = near * near;
        let near = near2 * near2;
        let unsure = turn.spread.error_bound;
        let centre = turn.spread.centre.abs() * x * number(0.03) + turn.bend_length * (root * number(0.008));
        let turned = x2 * (x2 * number(1.0 / 700.0) + centre) + turn.along * s;
        // The highlight's slope along the piece: at its mean normal and to second order, or the steepest.
        let local = (power * swing / level.max(zero.least())).mul_add(s, unsure * x2 * half);
        let slope = unsure * local.min(x * number(0.61)) + turn.across * (root * number(0.61));
        let mut off = near * (turned + slope + unsure * x2 * number(0.25));
        let is_blunt = number(6.0).exceeds(s);
        if T::is_any(is_blunt) {
            let across = (reach + turn.angle2 * number(0.02) + turn.across - level).max(zero);
            let beside = reach * reach * reach * inverse * number(0.01);
            let blunt = (across * half + beside).where_else(number(2.0).exceeds(s), across * reach);
            off = off + blunt.where_else(is_blunt, zero);
        }
        (highlight * self.specular, off.min(one) * self.specular)
    }

    /// Standard deviation of the shade across a gradient of this size, mixed from gradients of size `mixed_of`: their
    /// rounding turns a smaller mixed gradient more.
    #[inline(always)]
    pub fn deviation_of(&self, mixed_of: T, size: T) -> T {
        let [rounded, turned] = self.deviations;
        let turned = turned * (mixed_of / size.max(size.least())).max(size.like(1.0));
        (rounded + turned).min(self.diffuse + self.specular)
    }
}

impl<T: Real> RayShading<T> {
    /// Light on a surface across `gradient`, on either side of it; only ambient light without a gradient.
    #[inline(always)]
    pub fn shade(&self, gradient: [T; 3]) -> Shade<T> {
        let normal = direction(&gradient);
        let body = self.ambient + self.diffuse * dot(&normal, &self.light).abs();
        let gleam = dot(&normal, &self.halfway).abs().min(T::one());
        Shade { body, highlight: self.specular * gleam.power(self.shininess) }
    }

    /// `light` with the shade `mean`; its colour changes by `change` from start to end. The shade's own deviation
    /// ([`RayShading::deviation_of`]) and its error are added to the variances of the light.
    #[inline(always)]
    pub fn apply(&self, mut light: Radiance<T>, mean: &MeanShade<T>, change: [T; 3], deviation: T) -> Radiance<T> {
        let Shade { body, highlight } = mean.shade;
        for (channel, change) in light.color.iter_mut().zip(change) {
            *channel = *channel * body + light.alpha * (highlight + mean.tilt * change);
        }
        light.error = light.error * body + light.alpha * mean.rounding;
        let [deviation, off] = [deviation, mean.off * T::of(INDEPENDENT)].map_inline(|own| light.alpha * own);
        let scale = body.max(T::one());
        light.variance = light.variance * scale * scale + deviation * deviation;
        light.shade_variance = light.shade_variance + off * off;
        light
    }

    /// Light on an opaque surface with the outward normal `normal`, on its outer side only.
    #[inline]
    pub fn solid(&self, normal: DVec3) -> T {
        let facing = normal.to_array().map_inline(T::of);
        let cosine = (0..3).fold(T::zero(), |sum, k| sum + facing[k] * self.light[k]);
        self.ambient + self.diffuse * cosine.max(T::zero())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHADING: Shading =
        Shading { ambient: 0.2, diffuse: 0.7, specular: 0.5, shininess: 8.0, towards_light: None, is_packed: false };

    #[test]
    fn a_headlight_shines_fully_on_both_sides_of_a_surface() {
        let ray = SHADING.along::<f32>(DVec3::NEG_X);
        for gradient in [[3.0, 0.0, 0.0], [-1e30, 0.0, 0.0], [1e-30, 0.0, 0.0]] {
            let s = ray.shade(gradient);
            assert!((s.body - 0.9).abs() < 1e-6 && (s.highlight - 0.5).abs() < 1e-6, "{gradient:?}: {s:?}");
        }
        let across = ray.shade([0.0, 1.0, 0.0]);
        assert!(across.body == 0.2 && across.highlight < 1e-30, "{across:?}");
        assert_eq!(ray.shade([0.0; 3]).body, 0.2);
    }

    #[test]
    fn the_sun_leaves_the_far_side_of_the_ground_dark() {
        let sun = Shading { towards_light: Some(DVec3::Z), ..SHADING };
        let ray = sun.along::<f64>(DVec3::NEG_X);
        assert!((ray.solid(DVec3::Z) - 0.9).abs() < 1e-12);
        assert!((ray.solid(DVec3::NEG_Z) - 0.2).abs() < 1e-12);
    }
}
