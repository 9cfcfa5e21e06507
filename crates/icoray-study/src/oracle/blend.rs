//! The integral of a piece of a ray in which several volumes overlap: the values of all monotone between knots.
//!
//! There extinctions and colours are smooth. As in [`Piece`](super::Piece), panels of little optical depth have 8 Gauss
//! nodes each. Under light they are halved until halves agree with the whole and normals hardly turn from node to node:
//! where a gradient passes close to zero its normal turns over in a moment, which all nodes may miss.

use super::gauss::{Gauss, NODES};
use super::interpolant::FrustumInterpolant;
use super::panel::{MIN_TRANSMITTANCE, Radiance, STEEP};
use super::spans::Span;
use super::{component, direction_of, zeros};
use crate::shading::RayLighting;
use glam::DVec3;

/// Most halvings of a panel under light.
const LEVELS: u32 = 24;

/// Change of a pixel by which a panel under light may differ from its halves.
const LIT_TOLERANCE: f64 = 1e-11;

/// Roughness of the shade below which a panel needs no halves: coefficients fall as powers, so that those of degree 16,
/// the first that count, are some 1e-12.
const SMOOTH: f64 = 1e-6;

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

    /// The unit normal, or zero for none.
    fn normal(&self, u: f64) -> DVec3 {
        self.normal.map_or(DVec3::ZERO, |[x, y, z]| direction_of(DVec3::new(x.at(u), y.at(u), z.at(u))))
    }
}

/// Light and transmittance of a panel, and whether its halves may differ.
struct Panel {
    color: DVec3,
    transmittance: f64,
    is_rough: bool,
    /// Whether a normal turns so far between nodes that halves may agree by accident.
    turns: bool,
}

impl Blend<'_> {
    /// Adds the light from `from` to `to` behind `radiance`.
    pub fn add(&self, [from, to]: [f64; 2], radiance: &mut Radiance) {
        let normals = self.parts.iter().filter_map(|part| part.normal.as_ref());
        let lights = self.lighting.into_iter().flat_map(|lighting| [lighting.towards, lighting.halfway]);
        let mut cuts: Vec<f64> = normals
            .flat_map(|normal| lights.clone().flat_map(|v| zeros(&component(normal, v))))
            .flatten()
            .filter(|u| from < *u && *u < to)
            .chain([from, to])
            .collect();
        cuts.sort_by(f64::total_cmp);
        cuts.windows(2).for_each(|pair| self.panels([pair[0], pair[1]], radiance));
    }

    /// The same where no shade has a kink.
    fn panels(&self, [from, to]: [f64; 2], radiance: &mut Radiance) {
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
            let panel = self.refined([u, h], self.panel(u, h), radiance.transmittance, LEVELS);
            radiance.color += radiance.transmittance * panel.color;
            radiance.transmittance *= panel.transmittance;
            if h >= rest || u + h == u {
                return;
            }
            (u, width) = (u + h, 4.0 * h);
        }
    }

    /// The panel from `u` on, `h` wide.
    fn panel(&self, u: f64, h: f64) -> Panel {
        let (mut density, mut glow) = ([0.0; NODES], [DVec3::ZERO; NODES]);
        let (mut is_rough, mut turns) = (false, false);
        for part in &self.parts {
            let (mut bodies, mut highlights) = ([1.0; NODES], [0.0; NODES]);
            if let Some(lighting) = self.lighting {
                let normals = self.gauss.node.map(|node| part.normal(u + h * node));
                (bodies, highlights) = (normals.map(|n| lighting.shade(n).0), normals.map(|n| lighting.shade(n).1));
                let all = [&[part.normal(u)], &normals[..], &[part.normal(u + h)]].concat();
                turns |= all.windows(2).any(|pair| pair[0].distance(pair[1]) > lighting.sharpness());
                is_rough |= self.gauss.roughness(&bodies).max(self.gauss.roughness(&highlights)) >= SMOOTH;
            }
            for (j, node) in self.gauss.node.iter().enumerate() {
                let own = h * self.length * part.extinction(u + h * node);
                let (course, span) = &part.color;
                density[j] += own;
                glow[j] += own * (span.color(course.base, course.f.at(u + h * node)) * bodies[j] + highlights[j]);
            }
        }
        let (mut color, mut whole) = (DVec3::ZERO, 0.0);
        for i in 0..NODES {
            let before: f64 = (0..NODES).map(|j| density[j] * self.gauss.until[j][i]).sum();
            color += self.gauss.weight[i] * (-before).exp() * glow[i];
            whole += self.gauss.weight[i] * density[i];
        }
        Panel { color, transmittance: (-whole).exp(), is_rough: is_rough || turns, turns }
    }

    /// A panel, halved where it is rough until halves agree with the whole.
    fn refined(&self, [u, h]: [f64; 2], whole: Panel, weight: f64, levels: u32) -> Panel {
        if !whole.is_rough || levels == 0 {
            return whole;
        }
        let half = 0.5 * h;
        let [front, back] = [u, u + half].map(|u| self.panel(u, half));
        let sum = front.color + front.transmittance * back.color;
        let agree = weight * (sum - whole.color).abs().max_element() <= LIT_TOLERANCE;
        if agree && !(front.turns || back.turns) {
            return Panel { color: sum, transmittance: front.transmittance * back.transmittance, ..whole };
        }
        let first = self.refined([u, half], front, weight, levels - 1);
        let second = self.refined([u + half, half], back, weight * first.transmittance, levels - 1);
        let color = first.color + first.transmittance * second.color;
        Panel { color, transmittance: first.transmittance * second.transmittance, ..whole }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::oracle::{PANEL, Spans};
    use icoray::Scene;

    /// The gradient passes zero at the distance `close`: the mean of `|x|/sqrt(x² + close²)` over -1 to 1.
    #[test]
    fn a_normal_that_turns_over_between_nodes_is_seen() {
        let scene = Scene::parse(
            "field = 'f'\nlight = { ambient = 0, diffuse = 1, specular = 0 }\n\
             transfer = { unit_length = 1, knots = [{ value = 0, color = 'white', extinction = 1e-9 }] }",
        )
        .unwrap();
        let (gauss, spans) = (Gauss::new(), Spans::new(&scene.volumes[0].transfer, 1.0));
        let lighting = RayLighting::new(&scene, DVec3::NEG_X);
        let along = |f: [f64; 2]| FrustumInterpolant { f, bend: 0.0, eps: 0.0 };
        for close in [1e-2f64, 1e-3, 1e-4, 1e-6] {
            let course = (Course { base: 0.0, f: along([0.5, 0.5]) }, spans.at(0.5));
            let normal = Some([along([-1.0, 1.0]), along([close, close]), along([0.0, 0.0])]);
            let parts = vec![Part { color: course, extinction: course, normal }];
            let blend =
                Blend { gauss: &gauss, parts, length: 1.0, eps: 0.0, lighting: lighting.as_ref(), limit: PANEL };
            let mut radiance = Radiance { color: DVec3::ZERO, transmittance: 1.0 };
            blend.add([0.0, 1.0], &mut radiance);
            let expected = 1e-9 * ((1.0 + close * close).sqrt() - close);
            assert!((radiance.color.x - expected).abs() < 1e-17, "{close}: {:e} {expected:e}", radiance.color.x);
        }
    }
}
