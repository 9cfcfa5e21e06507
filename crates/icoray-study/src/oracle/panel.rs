//! The integral of one piece of a ray: inside one frustum, one span of the transfer function, the value monotone.
//!
//! There extinction and colour are smooth. A piece is cut into panels of little optical depth; in each, 8 Gauss nodes
//! give the depth up to every node by collocation and the light by quadrature, both of order 16.

use super::gauss::{Gauss, NODES};
use super::interpolant::FrustumInterpolant;
use super::spans::Span;
use glam::DVec3;

/// Transmittance at which rays end.
pub(crate) const MIN_TRANSMITTANCE: f64 = 1e-17;

/// Panels are short enough that heights change by no more than this part.
pub(super) const STEEP: f64 = 0.25;

/// Accumulated premultiplied linear RGB and transmittance.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Radiance {
    pub color: DVec3,
    pub transmittance: f64,
}

/// A piece: value `base + course`, over `length` planet radii.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Piece<'s> {
    pub interpolant: FrustumInterpolant,
    pub base: f64,
    pub span: &'s Span,
    pub length: f64,
}

/// A panel at its nodes.
struct Panel {
    /// Change of the value since the piece's start.
    change: [f64; NODES],
    /// Weight of the node's colour in the panel's light.
    emission: [f64; NODES],
    depth: f64,
}

/// e^-x for 0 <= x <= 0.25, by Taylor's series: to rounding.
#[inline(always)]
fn exp_neg(x: f64) -> f64 {
    let mut sum = 1.0;
    for n in (1..=11u32).rev() {
        sum = 1.0 - x * sum * (1.0 / f64::from(n));
    }
    sum
}

impl Piece<'_> {
    /// Extinction times the piece's length at `s`, 0 to 1, where it is `start` at 0.
    #[inline(always)]
    fn density(&self, start: f64, s: f64) -> f64 {
        (start + self.span.extinction_slope * self.length * self.interpolant.since_start(s)).max(0.0)
    }

    /// Calls `panel` with start and width of panels of a depth up to `limit` (at most 0.25), until it says false.
    pub fn panels(&self, limit: f64, mut panel: impl FnMut(f64, f64) -> bool) {
        let start = self.length * self.span.extinction(self.base, self.interpolant.f[0]);
        let height = |s: f64| 1.0 + self.interpolant.eps * s;
        let fits = |s: f64, h: f64| {
            let deepest = self.density(start, s).max(self.density(start, s + h));
            deepest * h <= limit && self.interpolant.eps.abs() * h <= STEEP * height(s).min(height(s + h))
        };
        let (mut s, mut width) = (0.0, 1.0);
        loop {
            let rest = 1.0 - s;
            let mut h = f64::min(width, rest);
            while h > 1e-300 && !fits(s, h) {
                h *= 0.5;
            }
            if !panel(s, h) || h >= rest || s + h == s {
                return;
            }
            s += h;
            width = 4.0 * h;
        }
    }

    /// The panel from `s` on, `h` wide.
    #[inline(always)]
    fn panel(&self, gauss: &Gauss, s: f64, h: f64) -> Panel {
        let start = self.length * self.span.extinction(self.base, self.interpolant.f[0]);
        let mut panel = Panel { change: [0.0; NODES], emission: [0.0; NODES], depth: 0.0 };
        let (mut density, mut depth) = ([0.0; NODES], [0.0; NODES]);
        for (j, node) in gauss.node.iter().enumerate() {
            panel.change[j] = self.interpolant.since_start(s + h * node);
            density[j] = h * (start + self.span.extinction_slope * self.length * panel.change[j]).max(0.0);
        }
        for (density, row) in density.iter().zip(&gauss.until) {
            for (sum, part) in depth.iter_mut().zip(row) {
                *sum += density * part;
            }
        }
        for j in 0..NODES {
            let part = gauss.weight[j] * density[j];
            panel.depth += part;
            panel.emission[j] = part * exp_neg(depth[j]);
        }
        panel
    }

    /// The piece's light, unlit, behind `light`.
    pub fn plain(&self, gauss: &Gauss, limit: f64, radiance: &mut Radiance) {
        let color = self.span.color(self.base, self.interpolant.f[0]);
        self.panels(limit, |s, h| {
            let panel = self.panel(gauss, s, h);
            let (mut sum, mut bent) = (0.0, 0.0);
            for j in 0..NODES {
                sum += panel.emission[j];
                bent += panel.emission[j] * panel.change[j];
            }
            radiance.color += radiance.transmittance * (color * sum + self.span.color_slope * bent);
            radiance.transmittance *= (-panel.depth).exp();
            radiance.transmittance > MIN_TRANSMITTANCE
        });
    }

    /// The emission of the piece without absorption.
    pub fn emission(&self, gauss: &Gauss) -> DVec3 {
        let start = self.length * self.span.extinction(self.base, self.interpolant.f[0]);
        let node = |j: usize| {
            let f = self.interpolant.at(gauss.node[j]);
            gauss.weight[j] * self.density(start, gauss.node[j]) * self.span.color(self.base, f)
        };
        (0..NODES).map(node).sum()
    }
}
