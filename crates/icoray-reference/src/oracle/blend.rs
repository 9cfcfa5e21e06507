//! The integral of a piece of a ray in which several volumes may overlap: the values of all monotone between knots.
//!
//! There extinctions and colours are smooth. A piece is cut into panels of little optical depth; in each, 8 Gauss nodes
//! give the depth up to every node by collocation and the light by quadrature, both of order 16. Under light panels are
//! halved until halves agree with the whole and normals hardly turn from node to node: where a gradient passes close to
//! zero its normal turns over in a moment, which all nodes may miss.

use super::gauss::{Gauss, NODES};
use super::interpolant::FrustumInterpolant;
use super::spans::Span;
use crate::shading::{RayLighting, direction_of};
use glam::DVec3;

pub(crate) const MIN_TRANSMITTANCE: f64 = 1e-17;

/// Panels are short enough that heights change by no more than this part.
const STEEP: f64 = 0.25;

/// Largest number of halvings of a panel under light.
const LEVELS: u32 = 24;

/// Change of a pixel by which a panel under light may differ from its halves.
const LIT_TOLERANCE: f64 = 1e-11;

/// Roughness of the shade below which a panel needs no halves: coefficients fall as powers, so that those of degree 16,
/// the first that count, are some 1e-12.
const SMOOTH: f64 = 1e-6;

/// Accumulated premultiplied linear RGB and transmittance.
pub(crate) struct Radiance {
    pub color: DVec3,
    pub transmittance: f64,
}

impl Radiance {
    pub const NONE: Self = Radiance { color: DVec3::ZERO, transmittance: 1.0 };
}

/// A field along a piece, and the span of the transfer function that all its values lie in.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FieldInSpan<'s> {
    pub field: FrustumInterpolant,
    pub span: &'s Span,
}

impl<'s> FieldInSpan<'s> {
    /// The part of a field from `from` to `to`: an end on a knot to rounding has the knot's value.
    pub fn new(field: &FrustumInterpolant, range: [f64; 2], span: &'s Span) -> Self {
        let rounding = 4.0 * f64::EPSILON * (field.f[0].abs() + field.f[1].abs() + field.bend.abs());
        let ends = range.map(|u| {
            let f = field.at(u);
            let knots = [span.low - field.base, span.high - field.base];
            knots.into_iter().find(|knot| (knot - f).abs() <= rounding).unwrap_or(f)
        });
        FieldInSpan { field: field.part(range, field.base, ends), span }
    }
}

/// One volume in a piece.
pub(crate) struct VolumePiece<'s> {
    pub color: FieldInSpan<'s>,
    pub extinction: FieldInSpan<'s>,
    /// Components of the gradient of the field that gives the extinction, in a lit scene.
    pub normal: Option<[FrustumInterpolant; 3]>,
}

/// The volumes of a piece, over places u, 0 to 1, of the given length in planet radii.
pub(crate) struct Blend<'s> {
    pub gauss: &'s Gauss,
    pub parts: Vec<VolumePiece<'s>>,
    pub length: f64,
    pub lighting: Option<&'s RayLighting>,
    /// Largest optical depth of a panel.
    pub limit: f64,
}

impl VolumePiece<'_> {
    fn extinction(&self, u: f64) -> f64 {
        let FieldInSpan { field, span } = &self.extinction;
        (span.extinction(field.base, field.f[0]) + span.extinction_slope * field.since_start(u)).max(0.0)
    }

    fn color(&self, u: f64) -> DVec3 {
        let FieldInSpan { field, span } = &self.color;
        span.color(field.base, field.f[0]) + span.color_slope * field.since_start(u)
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
    /// Adds the light of the piece behind `radiance`.
    pub fn add(&self, radiance: &mut Radiance) {
        let normals = self.parts.iter().filter_map(|part| part.normal.as_ref());
        let lights = self.lighting.into_iter().flat_map(|lighting| [lighting.towards, lighting.halfway]);
        let mut cuts: Vec<f64> = normals
            .flat_map(|normal| lights.clone().flat_map(|v| zeros(&component(normal, v))))
            .flatten()
            .filter(|u| 0.0 < *u && *u < 1.0)
            .chain([0.0, 1.0])
            .collect();
        cuts.sort_by(f64::total_cmp);
        cuts.windows(2).for_each(|pair| self.panels([pair[0], pair[1]], radiance));
    }

    /// The unlit light of the piece without absorption.
    pub fn emission(&self) -> DVec3 {
        let node = |j: usize| {
            let glow = |part: &VolumePiece| part.extinction(self.gauss.node[j]) * part.color(self.gauss.node[j]);
            self.gauss.weight[j] * self.length * self.parts.iter().map(glow).sum::<DVec3>()
        };
        (0..NODES).map(node).sum()
    }

    /// The same where no shade has a kink.
    fn panels(&self, [from, to]: [f64; 2], radiance: &mut Radiance) {
        let eps = self.parts.first().map_or(0.0, |part| part.extinction.field.eps);
        let height = |u: f64| 1.0 + eps * u;
        let fits = |u: f64, h: f64| {
            let deepest: f64 = self.parts.iter().map(|part| part.extinction(u).max(part.extinction(u + h))).sum();
            self.length * deepest * h <= self.limit && eps.abs() * h <= STEEP * height(u).min(height(u + h))
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
                let shades = normals.map(|n| lighting.shade(n));
                (bodies, highlights) = (shades.map(|shade| shade.body), shades.map(|shade| shade.highlight));
                let all = [&[part.normal(u)], &normals[..], &[part.normal(u + h)]].concat();
                turns |= all.windows(2).any(|pair| pair[0].distance(pair[1]) > lighting.sharpness());
                is_rough |= self.gauss.roughness(&bodies).max(self.gauss.roughness(&highlights)) >= SMOOTH;
            }
            for (j, node) in self.gauss.node.iter().enumerate() {
                let own = h * self.length * part.extinction(u + h * node);
                density[j] += own;
                glow[j] += own * (part.color(u + h * node) * bodies[j] + highlights[j]);
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

/// The component along `v` of a vector whose components run along the same stretch.
fn component(of: &[FrustumInterpolant; 3], v: DVec3) -> FrustumInterpolant {
    let dot = |get: &dyn Fn(&FrustumInterpolant) -> f64| v.dot(DVec3::new(get(&of[0]), get(&of[1]), get(&of[2])));
    FrustumInterpolant { base: 0.0, f: [dot(&|c| c.f[0]), dot(&|c| c.f[1])], bend: dot(&|c| c.bend), eps: of[0].eps }
}

/// Where a quantity is zero, at most twice.
fn zeros(interpolant: &FrustumInterpolant) -> [Option<f64>; 2] {
    let turn = interpolant.extremum();
    let parts = match turn {
        None => [Some([0.0, 1.0]), None],
        Some(u) => [Some([0.0, u]), Some([u, 1.0])],
    };
    parts.map(|part| {
        let [a, b] = part?;
        (interpolant.at(a) * interpolant.at(b) < 0.0).then(|| interpolant.meets(0.0, a, b))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::oracle::spans::Spans;
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
        let along = FrustumInterpolant::linear;
        for close in [1e-2f64, 1e-3, 1e-4, 1e-6] {
            let field = FieldInSpan { field: along([0.5, 0.5]), span: spans.at(0.5) };
            let normal = Some([along([-1.0, 1.0]), along([close, close]), along([0.0, 0.0])]);
            let parts = vec![VolumePiece { color: field, extinction: field, normal }];
            let blend = Blend { gauss: &gauss, parts, length: 1.0, lighting: lighting.as_ref(), limit: 0.25 };
            let mut radiance = Radiance::NONE;
            blend.add(&mut radiance);
            let expected = 1e-9 * ((1.0 + close * close).sqrt() - close);
            assert!((radiance.color.x - expected).abs() < 1e-17, "{close}: {:e} {expected:e}", radiance.color.x);
        }
    }
}
