//! The integral of a piece of a ray in which several volumes overlap: the values of all monotone between knots.
//!
//! There extinctions and colours are smooth. As in [`Piece`](super::Piece), panels of little optical depth have 8 Gauss
//! nodes each, and under light they are halved until halves agree with the whole.

use super::direction_of;
use super::gauss::{Gauss, NODES};
use super::interpolant::FrustumInterpolant;
use super::panel::{LEVELS, LIT_TOLERANCE, MIN_TRANSMITTANCE, Radiance, SMOOTH, STEEP};
use super::spans::Span;
use crate::shading::RayLighting;
use glam::DVec3;

/// A field along a frustum: its value is `base + f`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Course {
    pub base: f64,
    pub f: FrustumInterpolant,
}

/// One volume in a piece.
#[derive(Debug)]
pub(super) struct Part<'s> {
    pub color: (Course, &'s Span),
    pub extinction: (Course, &'s Span),
    /// Components of the gradient of the field that gives the extinction, in a lit scene.
    pub normal: Option<[FrustumInterpolant; 3]>,
}

/// The volumes of a piece, over places u, 0 to 1, of a frustum of the given length in planet radii.
#[derive(Debug)]
pub(super) struct Blend<'s> {
    pub gauss: &'s Gauss,
    pub parts: Vec<Part<'s>>,
    pub length: f64,
    /// Relative change of the value's denominator along the frustum.
    pub eps: f64,
    pub lighting: Option<&'s RayLighting>,
    /// Most optical depth of a panel.
    pub limit: f64,
}

impl Part<'_> {
    fn extinction(&self, u: f64) -> f64 {
        let (course, span) = &self.extinction;
        span.extinction(course.base, course.f.at(u))
    }

    /// Factor and highlight.
    fn shade(&self, lighting: Option<&RayLighting>, u: f64) -> (f64, f64) {
        let (Some(lighting), Some([x, y, z])) = (lighting, &self.normal) else { return (1.0, 0.0) };
        lighting.shade(direction_of(DVec3::new(x.at(u), y.at(u), z.at(u))))
    }
}

impl Blend<'_> {
    /// Adds the light from `from` to `to` behind `radiance`.
    pub fn add(&self, [from, to]: [f64; 2], radiance: &mut Radiance) {
        let density = |u: f64| self.parts.iter().map(|part| self.length * part.extinction(u)).collect::<Vec<f64>>();
        let height = |u: f64| 1.0 + self.eps * u;
        let fits = |u: f64, h: f64| {
            let deepest: f64 = density(u).iter().zip(density(u + h)).map(|(a, b)| a.max(b)).sum();
            deepest * h <= self.limit && self.eps.abs() * h <= STEEP * height(u).min(height(u + h))
        };
        let (mut u, mut width) = (from, to - from);
        while u < to && radiance.transmittance > MIN_TRANSMITTANCE {
            let rest = to - u;
            let mut h = f64::min(width, rest);
            while h > 1e-300 && !fits(u, h) {
                h *= 0.5;
            }
            let (whole, roughness) = self.panel(u, h);
            let is_smooth = self.lighting.is_none() || roughness < SMOOTH;
            let (color, transmittance) =
                if is_smooth { whole } else { self.refined([u, h], whole, radiance.transmittance, LEVELS) };
            radiance.color += radiance.transmittance * color;
            radiance.transmittance *= transmittance;
            if h >= rest || u + h == u {
                return;
            }
            (u, width) = (u + h, 4.0 * h);
        }
    }

    /// Light and transmittance of the panel from `u` on, `h` wide, and how rough the shades are in it.
    fn panel(&self, u: f64, h: f64) -> ((DVec3, f64), f64) {
        let (mut density, mut glow) = ([0.0; NODES], [DVec3::ZERO; NODES]);
        let mut roughness: f64 = 0.0;
        for part in &self.parts {
            let (mut bodies, mut highlights) = ([0.0; NODES], [0.0; NODES]);
            for (j, node) in self.gauss.node.iter().enumerate() {
                let at = u + h * node;
                let own = h * self.length * part.extinction(at);
                let (course, span) = &part.color;
                (bodies[j], highlights[j]) = part.shade(self.lighting, at);
                density[j] += own;
                glow[j] += own * (span.color(course.base, course.f.at(at)) * bodies[j] + highlights[j]);
            }
            let rough = |values| self.gauss.roughness(values);
            roughness = roughness.max(rough(&bodies)).max(rough(&highlights));
        }
        let (mut color, mut whole) = (DVec3::ZERO, 0.0);
        for i in 0..NODES {
            let before: f64 = (0..NODES).map(|j| density[j] * self.gauss.until[j][i]).sum();
            color += self.gauss.weight[i] * (-before).exp() * glow[i];
            whole += self.gauss.weight[i] * density[i];
        }
        ((color, (-whole).exp()), roughness)
    }

    /// A panel's light and transmittance, halved until halves agree with the whole.
    fn refined(&self, [u, h]: [f64; 2], whole: (DVec3, f64), weight: f64, levels: u32) -> (DVec3, f64) {
        let half = 0.5 * h;
        let [front, back] = [u, u + half].map(|u| self.panel(u, half).0);
        let sum = front.0 + front.1 * back.0;
        if levels == 0 || weight * (sum - whole.0).abs().max_element() <= LIT_TOLERANCE {
            return (sum, front.1 * back.1);
        }
        let first = self.refined([u, half], front, weight, levels - 1);
        let second = self.refined([u + half, half], back, weight * first.1, levels - 1);
        (first.0 + first.1 * second.0, first.1 * second.1)
    }
}
