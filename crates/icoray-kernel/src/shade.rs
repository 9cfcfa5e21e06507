//! Lighting: Blinn and Phong's model with the field's gradient as the normal (§3.5 of the paper).

use super::piece::Radiance;
use glam::DVec3;
use icoray_grid::array::MapInline;
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
    /// Exponent of the highlight.
    pub shininess: T,
    /// Unit vector towards the light.
    pub light: [T; 3],
    /// Unit vector half-way between the light and the eye.
    pub halfway: [T; 3],
    /// The larger of 4 and the exponent: squared ratio of the change of a shade to the turn of its normal.
    pub sharpness: T,
    /// Highlights below this value are left out.
    pub blind: T,
    /// Cosine between normal and half-way direction below which a highlight is left out.
    pub dull: T,
}

/// Factor for the surface's own colour, and the white highlight.
#[derive(Debug, Clone, Copy)]
pub struct Shade<T> {
    /// Factor for the surface's own colour.
    pub body: T,
    /// The white highlight, added to each channel.
    pub highlight: T,
    /// The surface's unit normal; zero where there is no gradient.
    pub normal: [T; 3],
}

impl Shading {
    /// The lighting of rays along `dir`, with highlights exact to a twentieth of `color_tolerance`; with 0 none is left
    /// out.
    #[inline]
    pub fn along<T: Real>(&self, dir: DVec3, color_tolerance: f64) -> RayShading<T> {
        let light = self.towards_light.unwrap_or(-dir);
        // The light straight behind leaves no half-way direction; none then gives no highlight.
        let halfway = (light - dir).try_normalize().unwrap_or(DVec3::ZERO);
        let blind = (0.05 * color_tolerance).max(f64::MIN_POSITIVE);
        RayShading {
            ambient: T::of(self.ambient),
            diffuse: T::of(self.diffuse),
            specular: T::of(self.specular),
            shininess: T::of(self.shininess),
            light: light.to_array().map_inline(T::of),
            halfway: halfway.to_array().map_inline(T::of),
            sharpness: T::of(self.shininess.max(4.0)),
            blind: T::of(blind),
            dull: T::of(self.dull(blind)),
        }
    }

    /// The cosine between normal and half-way direction at which a highlight is as weak as `blind`. A call, so that it
    /// is not worked out for scenes without light too: compilers take powers for harmless.
    #[inline(never)]
    fn dull(&self, blind: f64) -> f64 {
        (blind / self.specular.max(blind)).powf(1.0 / self.shininess)
    }
}

impl<T: Real> RayShading<T> {
    /// Light on a surface across `gradient`, on either side of it; only ambient light where there is no gradient.
    /// Simple enough that the compiler takes several at a time.
    #[inline(always)]
    pub fn shade(&self, gradient: [T; 3]) -> Shade<T> {
        let (zero, one) = (T::zero(), T::one());
        // Scaled first: a gradient of 1e30 squared is no f32.
        let [x, y, z] = gradient;
        let largest = zero.max(x.abs()).max(y.abs()).max(z.abs());
        let is_there = (largest > zero) & (largest < T::infinity());
        let scale = if is_there { largest } else { one };
        let n = [x / scale, y / scale, z / scale];
        let length = dot(&n, &n).sqrt();
        let unit = |x: T| if is_there { x / length } else { zero };
        let normal = [unit(n[0]), unit(n[1]), unit(n[2])];
        let body = self.ambient + self.diffuse * dot(&normal, &self.light).abs();
        let gleam = dot(&normal, &self.halfway).abs();
        let is_dull = (gleam < self.dull) | !is_there;
        let highlight = if is_dull { zero } else { self.specular * gleam.power(self.shininess) };
        Shade { body, highlight, normal }
    }

    /// The mean shade of a part of a ray with shades `a` and `b` at its ends and `m` in the middle, when the part's
    /// light comes from `centre` of the part behind its middle.
    #[inline(always)]
    pub fn mean(a: &Shade<T>, m: &Shade<T>, b: &Shade<T>, centre: T) -> (T, T) {
        let simpson = |a: T, m: T, b: T| (a + T::of(4.0) * m + b) * T::of(1.0 / 6.0) + centre * (b - a);
        (simpson(a.body, m.body, b.body), simpson(a.highlight, m.highlight, b.highlight))
    }

    /// Estimated error of [`Self::mean`], in the factor of the colour and in the highlight, when `centre` has an error
    /// of up to `skew`. `None` where the normal turns too far between the three for an estimate.
    #[inline(always)]
    pub fn error_bound(&self, a: &Shade<T>, m: &Shade<T>, b: &Shade<T>, skew: T) -> Option<(T, T)> {
        // Simpson's rule is right for a bend under even light; a fifth of it stands for kinks.
        let off = |a: T, m: T, b: T| {
            let bend = (a - m - m + b).abs();
            skew * ((b - a).abs() + bend) + T::of(0.2) * bend
        };
        let (body, highlight) = (off(a.body, m.body, b.body), off(a.highlight, m.highlight, b.highlight));
        let turned = self.turned(a, m, b)?;
        Some((body + turned.0, highlight + turned.1 + self.blind))
    }

    /// Error of Simpson's mean of three equally spaced shades that comes from turns of the normal between them, even
    /// where the three are alike: in the factor of the colour and in the highlight. `None` where the normal turns
    /// by more than the width of a highlight.
    ///
    /// Simpson's rule errs by at most M/81 where |f''| <= M. With θ the larger turn between neighbours, M is at most
    /// (2θ)² times the second derivative of the shade in the angle: `diffuse`, and shininess times the highlight.
    /// Between three places a highlight may be larger than at these, a twentieth of the largest possible stands for
    /// that. Where the normal is within θ of being across the light, |n·l| may have a kink, whose error is at most
    /// θ/6.
    #[inline(always)]
    pub fn turned(&self, a: &Shade<T>, m: &Shade<T>, b: &Shade<T>) -> Option<(T, T)> {
        let turn2 = turn2(&a.normal, &m.normal).max(turn2(&m.normal, &b.normal)).max(T::zero());
        let bend = T::of(4.0 / 81.0) * turn2;
        let kink = |direction: &[T; 3]| {
            let across = dot(&m.normal, direction);
            if across * across < turn2 { T::of(1.0 / 6.0) * turn2.sqrt() } else { T::zero() }
        };
        let highest = a.highlight.max(m.highlight).max(b.highlight) + T::of(0.05) * self.specular;
        let body = self.diffuse * (bend + kink(&self.light));
        // Powers from the second on have no kink.
        let is_blunt = self.shininess < T::of(2.0);
        let blunt = if is_blunt { self.specular * kink(&self.halfway) } else { T::zero() };
        let turns = turn2 * self.sharpness > T::of(0.5);
        (!turns).then_some((body, bend * self.sharpness * highest + blunt))
    }

    /// `light` under the shade `mean`, which may be `off`. Shades are rounded too, the sharper the more.
    #[inline(always)]
    pub fn apply(&self, mut light: Radiance<T>, (body, highlight): (T, T), off: T) -> Radiance<T> {
        for channel in &mut light.color {
            *channel = *channel * body + light.alpha * highlight;
        }
        light.error = light.error * body + light.alpha * off;
        let rounded = T::of(0.5 * T::ROUNDING) * self.sharpness * light.alpha;
        let scale = body.max(T::one());
        light.variance = light.variance * scale * scale + rounded * rounded;
        light
    }

    /// The most that a body and a highlight can differ from any other.
    #[inline(always)]
    pub fn range(&self) -> (T, T) {
        (self.diffuse, self.specular)
    }

    /// Light on an opaque surface with the outward normal `normal`, on its outer side only.
    #[inline]
    pub fn solid(&self, normal: DVec3) -> T {
        let facing = normal.to_array().map_inline(T::of);
        let cosine = (0..3).fold(T::zero(), |sum, k| sum + facing[k] * self.light[k]);
        self.ambient + self.diffuse * cosine.max(T::zero())
    }
}

#[inline(always)]
fn dot<T: Real>(a: &[T; 3], b: &[T; 3]) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// About the square of the angle between two unit vectors, up to 4. A normal that turns round looks the same at both
/// ends, but swings through all between. Two that are no normals at all are alike.
#[inline(always)]
fn turn2<T: Real>(a: &[T; 3], b: &[T; 3]) -> T {
    let turned = T::of(2.0) * (T::one() - dot(a, b));
    let are_none = dot(a, a) + dot(b, b) == T::zero();
    if are_none { T::zero() } else { turned }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHADING: Shading = Shading { ambient: 0.2, diffuse: 0.7, specular: 0.5, shininess: 8.0, towards_light: None };

    #[test]
    fn a_headlight_shines_fully_on_what_faces_it_from_either_side() {
        let ray = SHADING.along::<f32>(DVec3::NEG_X, 1e-6);
        for gradient in [[3.0, 0.0, 0.0], [-1e30, 0.0, 0.0], [1e-30, 0.0, 0.0]] {
            let s = ray.shade(gradient);
            assert!((s.body - 0.9).abs() < 1e-6 && (s.highlight - 0.5).abs() < 1e-6, "{gradient:?}: {s:?}");
        }
        let across = ray.shade([0.0, 1.0, 0.0]);
        assert_eq!((across.body, across.highlight), (0.2, 0.0));
        assert_eq!(ray.shade([0.0; 3]).body, 0.2);
    }

    #[test]
    fn the_sun_leaves_the_far_side_of_the_ground_dark() {
        let sun = Shading { towards_light: Some(DVec3::Z), ..SHADING };
        let ray = sun.along::<f64>(DVec3::NEG_X, 1e-6);
        assert!((ray.solid(DVec3::Z) - 0.9).abs() < 1e-12);
        assert!((ray.solid(DVec3::NEG_Z) - 0.2).abs() < 1e-12);
    }
}
