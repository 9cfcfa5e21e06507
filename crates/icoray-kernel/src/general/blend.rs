//! Several media along one piece of a ray: extinctions add up, colours mix by extinction.
//!
//! On a piece each field stays in one span of each of its transfer functions, so the optical depth from the piece's
//! start is a sum of closed forms (`piece.rs`). The remaining integral is the mean colour of the absorbed light
//! (`mean_color.rs`). If its error exceeds the tolerance, under light the ray's budget, the panel is halved, front half
//! first, until the ray ends.
//! With lighting, each medium has one shade in a panel, that of its mean normal, as one volume has it
//! ([`RayShading::mean`]); the centre of its light follows from its absorption at the three places.
//!
//! The work is bounded by [`may_halve`], and rounding errors of values are not halved. The error of the remaining
//! panels is reported.

use super::mean_color::{MeanColor, Nodes, Panel};
use super::source::TransferMap;
use crate::light::{COLOR_PART, INDEPENDENT};
use crate::lit::{LightSpread, is_affordable, may_halve};
use crate::piece::{Radiance, bend_factor};
use crate::segment::Segment;
use crate::shade::{ColorChange, MeanShade, RayShading};
use crate::transfer::Span;
use crate::turn::NormalTurn;
use icoray_grid::array::MapInline;

/// A volume: colour by one field, extinction by the same or another one.
#[derive(Debug)]
pub struct Medium {
    /// Colour of the first field's values.
    pub color: TransferMap,
    /// Extinction of the second field's values.
    pub extinction: TransferMap,
    has_own_color: bool,
}

impl Medium {
    /// A volume of these maps.
    pub fn new(color: TransferMap, extinction: TransferMap) -> Self {
        // Compared once instead of for each ray.
        let has_own_color = color.source == extinction.source && color.knots() == extinction.knots();
        Medium { color, extinction, has_own_color }
    }

    /// Whether both are the same transfer function of the same field.
    #[inline]
    pub fn has_own_color(&self) -> bool {
        self.has_own_color
    }
}

/// A medium on one piece.
#[derive(Debug, Clone, Copy)]
pub(super) struct MediumPiece<'w> {
    medium: &'w Medium,
    spans: [&'w Span<f64>; 2],
    /// Interpolants of the colour's and of the extinction's field over the whole frustum.
    segments: [Segment<f64>; 2],
    /// Slot of the gradients of the extinction's field.
    pub slot: usize,
    /// The largest component of these at the frustum's vertices; 0 without light.
    pub gradient_size: f64,
    /// Effect of the rounding of values on the colour, and on the extinction.
    rounding: [f64; 2],
}

impl<'w> MediumPiece<'w> {
    /// The medium between two places of a frustum; values near their middle determine the spans. `None` if it is clear
    /// there.
    #[inline]
    pub fn new(medium: &'w Medium, segments: [Segment<f64>; 2], middle: f64, slot: usize) -> Option<Self> {
        let extinction = medium.extinction.span(segments[1].value(middle));
        if extinction.is_clear {
            return None;
        }
        let color = medium.color.span(segments[0].value(middle));
        let reach = segments.map_inline(|segment| 0.5 * f64::EPSILON * segment.f0.abs().max(segment.f1.abs()));
        let rounding = [
            color.steepest * medium.color.scale() * reach[0],
            extinction.extinction_slope.abs() * medium.extinction.scale() * reach[1],
        ];
        Some(MediumPiece { medium, spans: [color, extinction], segments, slot, gradient_size: 0.0, rounding })
    }

    /// Extinction and colour, each with its slope.
    #[inline]
    fn at(&self, u: f64) -> MediumNode {
        let Medium { color, extinction, .. } = self.medium;
        let [of_color, of_extinction] = &self.segments;
        let (value, slope) = (of_extinction.value(u), of_extinction.slope(u));
        let (other, other_slope) = match color.source == extinction.source {
            true => (value, slope),
            false => (of_color.value(u), of_color.slope(u)),
        };
        let [in_color, in_extinction] = self.spans;
        // Rounding at a knot may reach slightly beyond the colours of the span.
        let tone = in_color.color(color.normal(other)).map_inline(|c| c.max(0.0));
        MediumNode {
            extinction: in_extinction.extinction(extinction.normal(value)),
            thickening: in_extinction.extinction_slope * extinction.scale() * slope,
            color: tone,
            tint: in_color.color_slope.map_inline(|c| c * color.scale() * other_slope),
        }
    }

    #[inline]
    fn extinction(&self, u: f64) -> f64 {
        self.spans[1].extinction(self.medium.extinction.normal(self.segments[1].value(u)))
    }

    /// Optical depth from `from` to `to`.
    #[inline]
    fn depth(&self, from: f64, to: f64) -> f64 {
        let whole = &self.segments[1];
        let part = whole.part((from, whole.value(from)), (to, whole.value(to)));
        let ends = self.extinction(from) + self.extinction(to);
        let slope = self.spans[1].extinction_slope * self.medium.extinction.scale();
        (part.length * (0.5 * ends + slope * part.kappa * bend_factor(part.eps) / 6.0)).max(0.0)
    }
}

/// A medium at a place: extinction and colour, and their slopes along the frustum.
#[derive(Debug, Clone, Copy)]
struct MediumNode {
    extinction: f64,
    thickening: f64,
    color: [f64; 3],
    tint: [f64; 3],
}

/// All media at a place.
#[derive(Debug, Clone, Copy)]
struct Node {
    u: f64,
    mixture: Mixture,
    /// Optical depth from the piece's start.
    depth: f64,
    /// Index of the place's first [`LitNode`] in [`BlendBuffers`], under light.
    lit: usize,
}

/// A medium at a place, with its gradient.
#[derive(Debug, Clone, Copy)]
struct LitNode {
    medium: MediumNode,
    gradient: [f64; 3],
}

/// The media at a place.
#[derive(Debug, Clone, Copy, Default)]
struct Mixture {
    /// Extinction per planet radius, and its slope along the frustum, from 0 to 1.
    rate: [f64; 2],
    /// Colour times extinction, and its slope.
    color: [[f64; 3]; 2],
}

impl Mixture {
    /// Adds a medium with this colour and its slope.
    #[inline]
    fn add(&mut self, medium: &MediumNode, [color, tint]: [[f64; 3]; 2]) {
        let MediumNode { extinction, thickening, .. } = *medium;
        self.rate = [self.rate[0] + extinction, self.rate[1] + thickening];
        self.color = [
            [0, 1, 2].map_inline(|k| self.color[0][k] + extinction * color[k]),
            [0, 1, 2].map_inline(|k| self.color[1][k] + thickening * color[k] + extinction * tint[k]),
        ];
    }
}

/// Buffers that are reused for the next piece.
#[derive(Debug, Default)]
pub(super) struct BlendBuffers {
    /// Starts and ends of pending panels, the next one last.
    panels: Vec<[Node; 2]>,
    /// The media of each place.
    lit: Vec<LitNode>,
}

/// Errors of the shades of a panel, per absorbed light.
#[derive(Debug, Default)]
struct ShadeError {
    /// Of the shades, without rounding.
    off: f64,
    /// Of their rounding.
    rounding: f64,
    /// Standard deviation by rounding of the gradients at the vertices.
    deviation: f64,
}

/// A piece of a ray in several media.
pub(super) struct Blend<'p, 'w, G> {
    pub parts: &'p [MediumPiece<'w>],
    /// Returns the gradient of a field, by its slot, at a place of the frustum.
    pub gradient: G,
    pub shading: Option<&'p RayShading<f64>>,
    /// Allowed error of the colour per absorbed light.
    pub color_tolerance: f64,
    /// Transmittance at which the ray may end.
    pub min_transmittance: f64,
}

/// Optical depth up to which panels are thin.
const THIN: f64 = 1.5;

impl<G: Fn(usize, f64) -> [f64; 3]> Blend<'_, '_, G> {
    /// Adds the light of the piece from `from` to `to`.
    #[inline]
    pub fn add(&self, light: &mut Radiance<f64>, from: f64, to: f64, memory: &mut BlendBuffers) {
        let BlendBuffers { panels, lit } = memory;
        panels.clear();
        lit.clear();
        panels.push([self.node(from, from, lit), self.node(from, to, lit)]);
        let mut halvings = 0;
        // Gradients and values at the vertices, whose rounding moves all panels alike.
        let mut moved = 0.0;
        while let Some([first, last]) = panels.pop() {
            let middle = self.node(from, 0.5 * (first.u + last.u), lit);
            let depth = last.depth - first.depth;
            // A NaN depth would never converge.
            if depth.is_nan() || depth <= 0.0 {
                continue;
            }
            let absorbed = -(-depth).exp_m1();
            let mut nodes = [first, middle, last];
            let ShadeError { off: shade_off, rounding, deviation } = self.shade(lit, &mut nodes, absorbed);
            let mean = MeanColor::of(&self.panel(&nodes), absorbed);
            let rounded = self.rounding(&nodes, mean.spread);
            // In dense panels the centre of the light is less certain.
            let shade_off = if depth <= THIN { shade_off } else { 3.0 * shade_off };
            // Estimates of different panels are added as independent ones. Unlit panels have no budget in common: a
            // halving divides their error by about 64.
            let own = shade_off.hypot(COLOR_PART[usize::from(self.shading.is_some())] * mean.off);
            let is_near = match self.shading {
                Some(_) => is_affordable(light, absorbed, [rounding, own], self.color_tolerance),
                None => mean.off <= self.color_tolerance,
            };
            if is_near || rounding + own <= rounded || !may_halve(halvings, (last.u - from) / (to - from)) {
                moved += light.transmittance() * absorbed * rounded.hypot(deviation);
                let shade_variance = (absorbed * own * INDEPENDENT).powi(2);
                let plain = Radiance::plain(mean.color, absorbed);
                light.over(&Radiance { error: absorbed * rounding, shade_variance, ..plain });
                if light.transmittance() <= self.min_transmittance {
                    break;
                }
            } else {
                panels.push([middle, last]);
                panels.push([first, middle]);
                halvings += 1;
            }
        }
        light.variance += moved * moved;
    }

    #[inline]
    fn node(&self, from: f64, u: f64, lit: &mut Vec<LitNode>) -> Node {
        let mut node = Node { u, mixture: Mixture::default(), depth: 0.0, lit: lit.len() };
        for part in self.parts {
            let medium = part.at(u);
            if self.shading.is_some() {
                lit.push(LitNode { medium, gradient: (self.gradient)(part.slot, u) });
            }
            node.mixture.add(&medium, [medium.color, medium.tint]);
            node.depth += if u > from { part.depth(from, u) } else { 0.0 };
        }
        node
    }

    /// The panel between these places.
    #[inline]
    fn panel(&self, nodes: &[Node; 3]) -> Panel<f64> {
        let [first, middle, last] = nodes;
        let width = last.u - first.u;
        // All fields have the path's length and change of height.
        let Segment { eps, length, .. } = self.parts[0].segments[1];
        let at = nodes.each_ref().map_inline(|node| &node.mixture);
        Panel {
            rate: over(width, at.map_inline(|place| place.rate)),
            color: [0, 1, 2].map_inline(|k| over(width, at.map_inline(|place| place.color.map_inline(|of| of[k])))),
            depth: last.depth - first.depth,
            through: [middle, last].map_inline(|node| (first.depth - node.depth).exp()),
            length: length * width,
            eps: eps * width / (1.0 + eps * first.u),
        }
    }

    /// Effect of the rounding of values on the mean colour of a panel whose colours differ by `spread`.
    #[inline]
    fn rounding(&self, nodes: &[Node; 3], spread: f64) -> f64 {
        let (mut tinted, mut thickened) = (0.0f64, 0.0);
        for part in self.parts {
            tinted = tinted.max(part.rounding[0]);
            thickened += part.rounding[1];
        }
        let [a, m, b] = nodes.each_ref().map_inline(|node| node.mixture.rate[0]);
        tinted + spread * (thickened / a.max(m).max(b)).min(1.0)
    }

    /// Lights the colours at the start, middle and end of a panel that absorbs the part `absorbed` of the light, each
    /// medium with its mean shade there.
    #[inline]
    fn shade(&self, lit: &[LitNode], nodes: &mut [Node; 3], absorbed: f64) -> ShadeError {
        let Some(shading) = self.shading else { return ShadeError::default() };
        let panel = self.panel(nodes);
        let growth = panel.growth();
        let seen = panel.length * panel.faded(&panel.rate).mean();
        let unseen = (seen / absorbed - 1.0).abs();
        let (mut of, mut sum) = (ShadeError::default(), 0.0);
        for node in nodes.iter_mut() {
            node.mixture = Mixture::default();
        }
        for (k, part) in self.parts.iter().enumerate() {
            let parts = nodes.each_ref().map_inline(|node| &lit[node.lit + k]);
            let rate = parts.map_inline(|part| [part.medium.extinction, part.medium.thickening]);
            let absorbs = panel.faded(&over(nodes[2].u - nodes[0].u, rate));
            let spread = absorbs.spread(growth, unseen);
            let MeanShade { shade, tilt, off, rounding, size } = part.mean_shade(shading, parts, spread);
            let rise = [0, 1, 2].map_inline(|k| parts[2].medium.color[k] - parts[0].medium.color[k]);
            for (node, LitNode { medium, .. }) in nodes.iter_mut().zip(parts) {
                let lit = |k: usize| medium.color[k] * shade.body + shade.highlight + tilt * rise[k];
                node.mixture.add(medium, [[0, 1, 2].map_inline(lit), medium.tint.map_inline(|c| c * shade.body)]);
            }
            // The three places may miss dense media entirely.
            let share = absorbs.simpson() + f64::MIN_POSITIVE;
            of.off += share * off;
            of.rounding += share * rounding;
            of.deviation += share * shading.deviation_of(part.gradient_size, size);
            sum += share;
        }
        ShadeError { off: of.off / sum, rounding: of.rounding / sum, deviation: of.deviation / sum }
    }
}

impl MediumPiece<'_> {
    /// The shade of the medium between three places, where it absorbs light of this distribution.
    #[inline]
    fn mean_shade(&self, shading: &RayShading<f64>, parts: [&LitNode; 3], spread: LightSpread<f64>) -> MeanShade<f64> {
        let eps = self.segments[1].eps;
        let turn = NormalTurn::of(&parts.map_inline(|part| part.gradient), eps, spread);
        let [start, middle, end] = parts.map_inline(|part| &part.medium.color);
        let most = |of: &dyn Fn(usize) -> f64| of(0).abs().max(of(1).abs()).max(of(2).abs());
        let bend = 2.0 * most(&|k| start[k] - 2.0 * middle[k] + end[k]);
        let change = most(&|k| end[k] - start[k]) + bend;
        shading.mean(&turn, &ColorChange { brightest: self.spans[0].brightest, change, bend, eps })
    }
}

/// A function on a panel that is this part of the frustum, from values and slopes along the frustum at three places.
#[inline]
fn over(width: f64, [start, middle, end]: [[f64; 2]; 3]) -> Nodes<f64> {
    Nodes { values: [start[0], middle[0], end[0]], slopes: [start[1], end[1]].map_inline(|slope| width * slope) }
}

#[cfg(test)]
mod tests;
