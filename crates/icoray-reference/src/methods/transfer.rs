//! The transfer function in f32, of values normalised to its range.

use crate::oracle::{Span, Spans};
use glam::Vec3;
use icoray::Scene;

/// Extinction and colour, looked up by value; and the map from field values to normalised ones.
pub(crate) struct Transfer {
    knots: Vec<f32>,
    spans: Vec<Line>,
    low: f64,
    scale: f64,
}

/// A span: extinction and colour linear in the value.
#[derive(Debug, Clone, Copy)]
struct Line {
    anchor: f32,
    extinction: [f32; 2],
    color: [Vec3; 2],
}

impl Transfer {
    /// For a shell of the given thickness in planet radii.
    pub fn new(scene: &Scene, thickness: f64) -> Self {
        let [low, high] = scene.volumes[0].transfer.range();
        let scale = if high > low { 1.0 / (high - low) } else { 1.0 };
        let narrow = |v: f64| ((v - low) * scale) as f32;
        let knots = scene.volumes[0].transfer.knots.iter().map(|k| narrow(k.value)).collect();
        let line = |span: &Span| {
            let anchor = if span.low.is_finite() { span.low } else { span.high };
            Line {
                anchor: narrow(anchor),
                extinction: [span.extinction(0.0, anchor) as f32, (span.extinction_slope / scale) as f32],
                color: [span.color(0.0, anchor).as_vec3(), (span.color_slope / scale).as_vec3()],
            }
        };
        let spans = Spans::new(&scene.volumes[0].transfer, thickness).spans.iter().map(line).collect();
        Transfer { knots, spans, low, scale }
    }

    /// A field value, 0 at the first knot and 1 at the last.
    #[inline]
    pub fn normalised(&self, value: f64) -> f32 {
        ((value - self.low) * self.scale) as f32
    }

    /// Linear RGB and extinction per planet radius at a normalised value.
    #[inline]
    pub fn at(&self, value: f32) -> (Vec3, f32) {
        let line = &self.spans[self.knots.partition_point(|k| *k <= value)];
        let x = value - line.anchor;
        (line.color[0] + line.color[1] * x, (line.extinction[0] + line.extinction[1] * x).max(0.0))
    }
}
