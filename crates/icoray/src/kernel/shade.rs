//! Lighting: Blinn and Phong's model with the field's gradient as the normal (§3.5 of the paper).

use super::real::Real;
use glam::DVec3;

/// How strongly a surface answers to light, and from where it comes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shading {
    pub ambient: f64,
    pub diffuse: f64,
    pub specular: f64,
    pub shininess: f64,
    /// Unit vector towards the light; `None` is a headlight, at the eye.
    pub towards_light: Option<DVec3>,
}

/// The same for one ray.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RayShading<T> {
    ambient: T,
    diffuse: T,
    specular: T,
    shininess: T,
    light: [T; 3],
    halfway: [T; 3],
}

/// Factor for the surface's own colour, and the white highlight.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shade<T> {
    pub body: T,
    pub highlight: T,
}

impl Shading {
    /// For rays along `dir`.
    pub fn along<T: Real>(&self, dir: DVec3) -> RayShading<T> {
        let light = self.towards_light.unwrap_or(-dir);
        // The light straight behind leaves no half-way direction; none then gives no highlight.
        let halfway = (light - dir).try_normalize().unwrap_or(DVec3::ZERO);
        RayShading {
            ambient: T::of(self.ambient),
            diffuse: T::of(self.diffuse),
            specular: T::of(self.specular),
            shininess: T::of(self.shininess),
            light: light.to_array().map(T::of),
            halfway: halfway.to_array().map(T::of),
        }
    }
}

impl<T: Real> RayShading<T> {
    /// Light on a surface across `gradient`, on either side of it; only ambient light where there is no gradient.
    #[inline]
    pub fn shade(&self, gradient: [T; 3]) -> Shade<T> {
        // Scaled first: a gradient of 1e30 squared is no f32.
        let largest = gradient.iter().fold(T::zero(), |m, g| m.max(g.abs()));
        if !(largest > T::zero() && largest.is_finite()) {
            return Shade { body: self.ambient, highlight: T::zero() };
        }
        let n = gradient.map(|g| g / largest);
        let dot = |a: &[T; 3], b: &[T; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let length = dot(&n, &n).sqrt();
        let body = self.ambient + self.diffuse * (dot(&n, &self.light) / length).abs();
        let gleam = (dot(&n, &self.halfway) / length).abs();
        Shade { body, highlight: self.specular * gleam.powf(self.shininess) }
    }

    /// Into how many parts a piece is cut whose gradient turns from `from` over `middle` to `to`: about one per 3° of
    /// turn, at most 32.
    ///
    /// Shading by the gradient at a part's middle errs with the square of the turn; at 3° and an exponent of 32 the
    /// highlight is right to about 1e-3.
    #[inline]
    pub fn parts(&self, from: &[T; 3], middle: &[T; 3], to: &[T; 3]) -> usize {
        let turn2 = turn2(from, middle).max(turn2(middle, to));
        let parts = (turn2 * T::of(1600.0)).max(T::one()).sqrt().ceil();
        parts.min(T::of(32.0)).wide() as usize
    }

    /// Light on an opaque surface with the outward normal `normal`, on its outer side only.
    pub fn solid(&self, normal: DVec3) -> T {
        let facing = normal.to_array().map(T::of);
        let cosine = (0..3).fold(T::zero(), |sum, k| sum + facing[k] * self.light[k]);
        self.ambient + self.diffuse * cosine.max(T::zero())
    }
}

/// About the square of the angle between two vectors; 0 where one has no direction.
#[inline]
fn turn2<T: Real>(a: &[T; 3], b: &[T; 3]) -> T {
    let dot = |a: &[T; 3], b: &[T; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let size = dot(a, a) * dot(b, b);
    if !(size > T::zero() && size.is_finite()) {
        return T::zero();
    }
    T::of(2.0) * (T::one() - dot(a, b) / size.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHADING: Shading =
        Shading { ambient: 0.2, diffuse: 0.7, specular: 0.5, shininess: 8.0, towards_light: None };

    #[test]
    fn a_headlight_shines_fully_on_what_faces_it_from_either_side() {
        let ray = SHADING.along::<f32>(DVec3::NEG_X);
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
        let ray = sun.along::<f64>(DVec3::NEG_X);
        assert!((ray.solid(DVec3::Z) - 0.9).abs() < 1e-12);
        assert!((ray.solid(DVec3::NEG_Z) - 0.2).abs() < 1e-12);
    }
}
