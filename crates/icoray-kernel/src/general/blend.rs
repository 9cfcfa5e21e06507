//! Several media along one piece of a ray: extinctions add up, colours mix by extinction.
//!
//! On a piece each field is monotone and stays in one span of each of its transfer functions, so that the optical depth
//! from the piece's start is a sum of closed forms (`piece.rs`). The remaining integral is the mean colour of the
//! absorbed light, `∫ Σσc e^-T / ∫ Σσ e^-T`: a ratio, so that a constant colour is exact. Both integrals are taken by
//! Simpson's rule. In a thin panel the difference from the rule of the ends alone is the error; where the panel is not
//! thin or the error too large, the panel is halved, front half first, until the ray ends. With lighting, each medium
//! has one shade in a panel, that of its mean normal, as in the kernel of one field ([`RayShading::mean`]); where its
//! light is centred is known from what it absorbs at the three places. The error is an estimate, not a bound: three
//! places may miss how the colours of several fields mix.

use super::source::TransferMap;
use crate::lit::LightSpread;
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
}

/// A medium on one piece.
#[derive(Debug, Clone, Copy)]
pub(super) struct MediumPiece<'w> {
    medium: &'w Medium,
    spans: [&'w Span<f64>; 2],
    /// Interpolants of the colour's and of the extinction's field over the whole frustum.
    segments: [Segment<f64>; 2],
    /// Where the gradients of the extinction's field are.
    pub slot: usize,
}

impl<'w> MediumPiece<'w> {
    /// The medium between two places of a frustum, near the middle of which values tell the spans; `None` where it is
    /// clear there.
    #[inline]
    pub fn new(medium: &'w Medium, segments: [Segment<f64>; 2], middle: f64, slot: usize) -> Option<Self> {
        let extinction = medium.extinction.span(segments[1].value(middle));
        if extinction.is_clear {
            return None;
        }
        let color = medium.color.span(segments[0].value(middle));
        Some(MediumPiece { medium, spans: [color, extinction], segments, slot })
    }

    /// Extinction and colour.
    #[inline]
    fn at(&self, u: f64) -> (f64, [f64; 3]) {
        let Medium { color, extinction } = self.medium;
        let value = self.segments[1].value(u);
        let other = if color.source == extinction.source { value } else { self.segments[0].value(u) };
        // Rounding at a knot may reach a little beyond the colours of the span.
        let color = self.spans[0].color(color.normal(other)).map_inline(|c| c.max(0.0));
        (self.spans[1].extinction(extinction.normal(value)), color)
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
        let slope = self.spans[1].extinction_slope() * self.medium.extinction.scale();
        (part.length * (0.5 * ends + slope * part.kappa * bend_factor(part.eps) / 6.0)).max(0.0)
    }
}

/// The media at a node of the quadrature.
#[derive(Debug, Clone, Copy)]
struct Node {
    u: f64,
    /// Extinction, and colour times extinction.
    rate: f64,
    color: [f64; 3],
    /// Optical depth from the piece's start.
    depth: f64,
    /// Index of the node's first [`LitPart`] in [`BlendBuffers`], under light.
    lit: usize,
}

impl Node {
    /// Its colour, black where nothing absorbs.
    #[inline]
    fn mean(&self) -> [f64; 3] {
        if self.rate > 0.0 { self.color.map_inline(|c| c / self.rate) } else { [0.0; 3] }
    }
}

/// A part at a node.
#[derive(Debug, Clone, Copy)]
struct LitPart {
    extinction: f64,
    color: [f64; 3],
    gradient: [f64; 3],
}

/// A part of a piece between two places, and how often the piece was halved for it.
#[derive(Debug, Clone, Copy)]
struct Panel {
    first: Node,
    last: Node,
    halves: u32,
}

/// Buffers that are reused for the next piece.
#[derive(Debug, Default)]
pub(super) struct BlendBuffers {
    panels: Vec<Panel>,
    /// The parts of each node.
    lit: Vec<LitPart>,
}

/// A piece of a ray in several media.
pub(super) struct Blend<'p, 'w, G> {
    pub parts: &'p [MediumPiece<'w>],
    /// Gives the gradient of a field, by its slot, at a place of the frustum.
    pub gradient: G,
    pub shading: Option<&'p RayShading<f64>>,
    /// Error of the colour that is allowed per absorbed light.
    pub color_tolerance: f64,
    /// Transmittance at which the ray may end.
    pub min_transmittance: f64,
}

/// A panel is halved no more often: a part in 10¹² of its length.
const MAX_HALVINGS: u32 = 40;
/// Optical depth up to which the rules' difference estimates the error.
const THIN: f64 = 1.5;

impl<G: Fn(usize, f64) -> [f64; 3]> Blend<'_, '_, G> {
    /// Adds the light of the piece from `from` to `to`.
    #[inline]
    pub fn add(&self, light: &mut Radiance<f64>, from: f64, to: f64, memory: &mut BlendBuffers) {
        let BlendBuffers { panels, lit } = memory;
        panels.clear();
        lit.clear();
        let (first, last) = (self.node(from, from, lit), self.node(from, to, lit));
        panels.push(Panel { first, last, halves: 0 });
        while let Some(Panel { first, last, halves }) = panels.pop() {
            let middle = self.node(from, 0.5 * (first.u + last.u), lit);
            let depth = last.depth - first.depth;
            // A NaN depth would never converge.
            if depth.is_nan() || depth <= 0.0 {
                continue;
            }
            let mut nodes = [first, middle, last];
            let shade_off = self.shade(lit, &mut nodes);
            let (color, [rule, spread]) = mean(nodes.each_ref());
            // Between their places colours may be farther apart than at these, by what a chord misses: 81/32 of what
            // the rule does, and half a kink.
            let off = if depth <= THIN { rule + shade_off } else { spread + 3.0 * shade_off };
            let absorbed = -(-depth).exp_m1();
            // What the pieces before have left of theirs.
            let earned = if self.shading.is_some() { self.color_tolerance * light.alpha - light.error } else { 0.0 };
            let spare = earned.max(0.0) / light.transmittance().max(f64::MIN_POSITIVE);
            if (off - self.color_tolerance) * absorbed <= spare || halves == MAX_HALVINGS {
                light.over(&Radiance { error: absorbed * off, ..Radiance::plain(color, absorbed) });
                if light.transmittance() <= self.min_transmittance {
                    return;
                }
            } else {
                panels.push(Panel { first: middle, last, halves: halves + 1 });
                panels.push(Panel { first, last: middle, halves: halves + 1 });
            }
        }
    }

    #[inline]
    fn node(&self, from: f64, u: f64, lit: &mut Vec<LitPart>) -> Node {
        let mut node = Node { u, rate: 0.0, color: [0.0; 3], depth: 0.0, lit: lit.len() };
        for part in self.parts {
            let (rate, color) = part.at(u);
            if self.shading.is_some() {
                lit.push(LitPart { extinction: rate, color, gradient: (self.gradient)(part.slot, u) });
            }
            node.rate += rate;
            node.color = [0, 1, 2].map_inline(|k| node.color[k] + rate * color[k]);
            node.depth += if u > from { part.depth(from, u) } else { 0.0 };
        }
        node
    }

    /// Puts the colours at the start, middle and end of a panel under light, each medium under its mean shade there.
    /// Gives the error of the shades per absorbed light.
    #[inline]
    fn shade(&self, lit: &[LitPart], nodes: &mut [Node; 3]) -> f64 {
        let Some(shading) = self.shading else { return 0.0 };
        let through = nodes.each_ref().map_inline(|node| (nodes[0].depth - node.depth).exp());
        let (mut off, mut sum) = (0.0, 0.0);
        for node in nodes.iter_mut() {
            node.color = [0.0; 3];
        }
        for (k, part) in self.parts.iter().enumerate() {
            let parts = nodes.each_ref().map_inline(|node| &lit[node.lit + k]);
            let absorbs = [0, 1, 2].map_inline(|i| through[i] * parts[i].extinction);
            let MeanShade { shade, tilt, off: part_off } = part.mean_shade(shading, parts, absorbs);
            let rise = [0, 1, 2].map_inline(|k| parts[2].color[k] - parts[0].color[k]);
            for (node, part) in nodes.iter_mut().zip(parts) {
                let lit = |k: usize| part.color[k] * shade.body + shade.highlight + tilt * rise[k];
                node.color = [0, 1, 2].map_inline(|k| node.color[k] + part.extinction * lit(k));
            }
            let absorbed = simpson(absorbs);
            off += absorbed * part_off;
            sum += absorbed;
        }
        if sum > 0.0 { off / sum } else { 0.0 }
    }
}

impl MediumPiece<'_> {
    /// The shade of the medium between three places, in which it absorbs so much of the light.
    #[inline]
    fn mean_shade(&self, shading: &RayShading<f64>, parts: [&LitPart; 3], absorbs: [f64; 3]) -> MeanShade<f64> {
        let [a, m, b] = absorbs;
        let mean = simpson(absorbs) + f64::MIN_POSITIVE;
        let bent = (a - m - m + b).abs() / mean;
        let spread = LightSpread { centre: (b - a) / (12.0 * mean), error_bound: (0.2 * bent).min(0.5) };
        let eps = self.segments[1].eps;
        let turn = NormalTurn::of(&parts.map_inline(|part| part.gradient), eps, spread);
        let [start, middle, end] = parts.map_inline(|part| &part.color);
        let most = |of: &dyn Fn(usize) -> f64| of(0).abs().max(of(1).abs()).max(of(2).abs());
        let bend = 2.0 * most(&|k| start[k] - 2.0 * middle[k] + end[k]);
        let change = most(&|k| end[k] - start[k]) + bend;
        shading.mean(&turn, &ColorChange { brightest: self.spans[0].brightest(), change, bend, eps })
    }
}

/// Simpson's mean.
#[inline]
fn simpson([a, m, b]: [f64; 3]) -> f64 {
    (a + 4.0 * m + b) / 6.0
}

/// The mean colour of the light that is absorbed between places of these weights.
#[inline]
fn weighed(nodes: &[&Node], weights: &[f64]) -> Option<[f64; 3]> {
    let (mut sum, mut color) = (0.0, [0.0; 3]);
    for (node, weight) in nodes.iter().zip(weights) {
        let weight = weight * (nodes[0].depth - node.depth).exp();
        sum += weight * node.rate;
        color = [0, 1, 2].map_inline(|k| color[k] + weight * node.color[k]);
    }
    (sum > 0.0).then(|| color.map_inline(|c| c / sum))
}

/// The largest difference of two colours' channels.
#[inline]
fn color_difference(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    let [r, g, b] = [0, 1, 2].map_inline(|k| (a[k] - b[k]).abs());
    r.max(g).max(b)
}

/// The mean colour of a panel, how far it is from that of its ends alone, and how far colours are apart.
#[inline]
fn mean(nodes: [&Node; 3]) -> ([f64; 3], [f64; 2]) {
    let (mut low, mut high) = ([f64::MAX; 3], [f64::MIN; 3]);
    for node in nodes {
        if node.rate > 0.0 {
            let color = node.mean();
            low = [0, 1, 2].map_inline(|k| low[k].min(color[k]));
            high = [0, 1, 2].map_inline(|k| high[k].max(color[k]));
        }
    }
    let [r, g, b] = [0, 1, 2].map_inline(|k| high[k] - low[k]);
    let spread = r.max(g).max(b).max(0.0);
    let Some(color) = weighed(&nodes, &[1.0, 4.0, 1.0]) else { return ([0.0; 3], [f64::INFINITY; 2]) };
    let off = weighed(&nodes, &[1.0, 0.0, 1.0]).map_or(spread, |ends| color_difference(&color, &ends));
    (color, [off.min(spread), spread])
}

#[cfg(test)]
mod tests;
