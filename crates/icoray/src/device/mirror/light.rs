//! Functions of `kernel/shade.rs`, `kernel/turn.rs` and `kernel/lit.rs`.
//!
//! An interpolant is the gradient's ends and bends and ε.

use super::{Span, segment};
use glam::DVec3;
use icoray_kernel::lit;
use icoray_kernel::piece::{ErrorBudget, Radiance};
use icoray_kernel::shade::{self, RayShading};
use icoray_scene::Method;

/// Blinn and Phong's model along one ray; its members are those of the kernel's `RayShading`.
#[allow(missing_docs)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AlongRay {
    pub ambient: f32,
    pub diffuse: f32,
    pub specular: f32,
    pub shininess: f32,
    pub light: [f32; 3],
    pub halfway: [f32; 3],
    pub sharpness: f32,
    pub deviations: [f32; 2],
}

/// Body and highlight.
pub type Shade = [f32; 2];

/// A mean shade: body, highlight, tilt and error.
pub type MeanShade = [f32; 4];

impl AlongRay {
    /// `Shading::along` of ambient, diffuse, specular and shininess.
    pub fn new(
        [ambient, diffuse, specular, shininess]: [f64; 4],
        towards_light: Option<[f64; 3]>,
        dir: [f64; 3],
    ) -> Self {
        let towards_light = towards_light.map(DVec3::from_array);
        let shading = shade::Shading { ambient, diffuse, specular, shininess, towards_light, is_packed: false };
        let RayShading { ambient, diffuse, specular, shininess, light, halfway, sharpness, deviations } =
            shading.along(DVec3::from_array(dir));
        AlongRay { ambient, diffuse, specular, shininess, light, halfway, sharpness, deviations }
    }

    fn kernel(&self) -> RayShading<f32> {
        let AlongRay { ambient, diffuse, specular, shininess, light, halfway, sharpness, deviations } = *self;
        RayShading { ambient, diffuse, specular, shininess, light, halfway, sharpness, deviations }
    }

    /// `RayShading::shade`.
    pub fn shade(&self, gradient: [f32; 3]) -> Shade {
        let shade::Shade { body, highlight } = self.kernel().shade(gradient);
        [body, highlight]
    }

    /// `mean_shade` of a piece with these gradients at its start, middle and end.
    pub fn mean(&self, piece: [f32; 5], span: &Span, gradients: &[[f32; 3]; 3]) -> MeanShade {
        let shade::MeanShade { shade, tilt, off, .. } =
            lit::mean_shade(&self.kernel(), &segment(piece), span, gradients);
        [shade.body, shade.highlight, tilt, off]
    }

    /// `RayShading::apply`, across gradients that do not cancel, to red, green, blue, absorbed, error, variance of a piece whose colour changes by `change`.
    pub fn apply(&self, light: [f32; 6], mean: MeanShade, change: [f32; 3]) -> [f32; 6] {
        let [r, g, b, absorbed, error, variance] = light;
        let light = Radiance { color: [r, g, b], alpha: absorbed, error, variance };
        let [body, highlight, tilt, off] = mean;
        let mean = shade::MeanShade { shade: shade::Shade { body, highlight }, tilt, off, size: 1.0 };
        let shading = self.kernel();
        let deviation = shading.deviation_of(0.0, 1.0);
        let Radiance { color: [r, g, b], alpha: absorbed, error, variance } =
            shading.apply(light, &mean, change, deviation);
        [r, g, b, absorbed, error, variance]
    }

    /// `RayShading::deviation_of`.
    pub fn deviation_of(&self, mixed_of: f32, size: f32) -> f32 {
        self.kernel().deviation_of(mixed_of, size)
    }

    /// `RayShading::solid`.
    pub fn solid(&self, normal: [f64; 3]) -> f32 {
        self.kernel().solid(DVec3::from_array(normal))
    }

    /// `Lit::light` of a piece that is the interpolant from `range[0]` to `range[1]`; allowance as of
    /// [`integrate`](super::integrate), and the error that the ray may spend beyond.
    #[allow(clippy::too_many_arguments)]
    pub fn lit(
        &self,
        method: Method,
        piece: [f32; 5],
        span: &Span,
        [share, rest, through, reach, spare]: [f32; 5],
        interpolant: [f32; 10],
        range: [f32; 2],
        is_coarse: bool,
    ) -> [f32; 6] {
        let allowance = ErrorBudget { color_tolerance: share, min_transmittance: rest, transmittance: through, reach };
        let (shading, interpolant) = (self.kernel(), kernel_interpolant(interpolant));
        let lit = lit::Lit::<f32, 4> {
            method,
            allowance: &allowance,
            shading: &shading,
            span,
            interpolant: &interpolant,
            gradient_size: 0.0,
        };
        let cuts = if is_coarse { 0 } else { lit::Lit::<f32, 4>::MAX_CUTS };
        let Radiance { color: [r, g, b], alpha: absorbed, error, variance } =
            lit.light(&segment(piece), range, cuts, spare);
        [r, g, b, absorbed, error, variance]
    }
}

/// `turn::direction`.
pub fn direction(gradient: [f32; 3]) -> [f32; 3] {
    icoray_kernel::turn::direction(&gradient)
}

/// `FrustumInterpolant::gradient`.
pub fn gradient(interpolant: [f32; 10], u: f32) -> [f32; 3] {
    kernel_interpolant(interpolant).gradient(u)
}

/// `LightSpread::of`: centre and error bound.
pub fn spread(piece: [f32; 5], span: &Span) -> (f32, f32) {
    let spread = lit::LightSpread::of(&segment(piece), span);
    (spread.centre, spread.error_bound)
}

fn kernel_interpolant([ax, ay, az, bx, by, bz, kx, ky, kz, eps]: [f32; 10]) -> lit::FrustumInterpolant<f32, 4> {
    lit::FrustumInterpolant { from: [0.0, ax, ay, az], to: [0.0, bx, by, bz], kappa: [0.0, kx, ky, kz], eps }
}
