//! Pre-integration: a table of a segment's light over the values at its two ends (Röttger, Kraus and Ertl 2000,
//! doi:10.1109/VISUAL.2000.885683; Engel, Kraus and Ertl 2001, doi:10.1145/383507.383515).
//!
//! The value is taken to be linear between the ends of a step, and the table is read by bilinear interpolation; its
//! entries are exact for the table's own step. A step of another length l (the last of a ray) has its opacity scaled,
//! `1 - (1 - a)^(l/h)`, and its colour with it: the usual approximation. So is that values beyond the first and last
//! knot are drawn in to them, and that a step with an end in a void adds nothing. Second order with attenuation inside
//! a segment, first order without (Etiene et al. 2014, doi:10.1109/TVCG.2013.90).

use super::march::{Accumulated, FrustumWindow, Interpolant, StepRule};
use crate::job::PreparedJob;
use crate::oracle::{Blend, FieldInSpan, FrustumInterpolant, Gauss, PANEL, Radiance, Spans, VolumePiece};
use crate::shading::RayLighting;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Premultiplied colour and absorbed part of segments of one length, by the normalised values at front and back.
pub(crate) struct Table {
    side: usize,
    step: f64,
    /// Row by row of the front value.
    entries: Vec<[f32; 4]>,
}

/// Where a table of that side has its node `i`: one node lies beyond each end of the transfer function's range.
fn node(i: usize, side: usize) -> f64 {
    (i as f64 - 1.0) / (side - 3) as f64
}

impl Table {
    /// A table of `side` × `side` entries for segments `step` planet radii long. Without `attenuated`, light is not
    /// absorbed by the segment that it comes from.
    ///
    /// # Panics
    /// When `side` is less than 4.
    pub fn new(prepared: &PreparedJob, step: f64, side: usize, attenuated: bool) -> Self {
        assert!(side >= 4, "a table of {side} values, expected at least 4");
        let spans = Spans::new(&prepared.scene.volumes[0].transfer, prepared.thickness());
        let gauss = Gauss::new();
        let [low, high] = prepared.scene.volumes[0].transfer.range();
        let width = if high > low { high - low } else { 1.0 };
        let row = |front: usize| {
            let entry = move |back: usize| [front, back].map(|i| low + width * node(i, side));
            let (spans, gauss) = (&spans, &gauss);
            (0..side).map(move |back| segment(spans, gauss, entry(back), step, attenuated))
        };
        let rows: Vec<Vec<[f32; 4]>> = (0..side).into_par_iter().map(|i| row(i).collect()).collect();
        Table { side, step, entries: rows.into_iter().flatten().collect() }
    }

    /// The entry between front and back value, both normalised.
    #[inline]
    fn at(&self, values: [f32; 2]) -> [f32; 4] {
        let last = (self.side - 1) as f32;
        let place = values.map(|v| (v * (self.side - 3) as f32 + 1.0).clamp(0.0, last));
        let cell = place.map(|p| (p as usize).min(self.side - 2));
        let [u, v] = [0, 1].map(|i| place[i] - cell[i] as f32);
        let corner = cell[0] * self.side + cell[1];
        let (front, back) = (&self.entries[corner..corner + 2], &self.entries[corner + self.side..][..2]);
        std::array::from_fn(|k| {
            let near = front[0][k] + v * (front[1][k] - front[0][k]);
            near + u * (back[0][k] + v * (back[1][k] - back[0][k]) - near)
        })
    }
}

/// A segment over which the value runs linearly from `f[0]` to `f[1]`.
fn segment(spans: &Spans, gauss: &Gauss, f: [f64; 2], length: f64, attenuated: bool) -> [f32; 4] {
    let mut radiance = Radiance::NONE;
    let mut emission = DVec3::ZERO;
    let field = FrustumInterpolant::linear(f);
    let knots = spans.knots_between(f[0].min(f[1]), f[0].max(f[1])).iter().map(|knot| (knot - f[0]) / (f[1] - f[0]));
    let mut cuts: Vec<f64> = knots.filter(|u| 0.0 < *u && *u < 1.0).chain([0.0, 1.0]).collect();
    cuts.sort_by(f64::total_cmp);
    for pair in cuts.windows(2) {
        let span = spans.at(field.value(0.5 * (pair[0] + pair[1])));
        if pair[0] < pair[1] && !span.is_clear {
            let part = FieldInSpan::new(&field, [pair[0], pair[1]], span);
            let parts = vec![VolumePiece { color: part, extinction: part, normal: None }];
            let length = length * (pair[1] - pair[0]);
            let blend = Blend { gauss, parts, length, lighting: None, limit: PANEL };
            blend.add(&mut radiance);
            emission += blend.emission();
        }
    }
    let color = (if attenuated { radiance.color } else { emission }).as_vec3();
    [color.x, color.y, color.z, (1.0 - radiance.transmittance) as f32]
}

impl<I: Interpolant> StepRule<I> for Table {
    type State = Option<f32>;

    fn enter(&self, front: &mut Option<f32>, window: &mut FrustumWindow<'_, I>, t: f64) {
        *front = window.value(t);
    }

    #[inline]
    fn step(
        &self,
        front: &mut Option<f32>,
        window: &mut FrustumWindow<'_, I>,
        [from, to]: [f64; 2],
        _: Option<&RayLighting>,
        radiance: &mut Accumulated,
    ) {
        radiance.samples += 1;
        let back = window.value(to);
        let ends = (*front, back);
        *front = back;
        let (Some(first), Some(last)) = ends else { return };
        let [r, g, b, alpha] = self.at([first, last]);
        let (color, part) = (Vec3::new(r, g, b), ((to - from) / self.step) as f32);
        if part > 1.0 - 1e-5 {
            radiance.add(color, alpha);
        } else {
            let scaled = -(part * (-alpha).ln_1p()).exp_m1();
            let scale = if alpha > 0.0 { scaled / alpha } else { part };
            radiance.add(color * scale, scaled);
        }
    }
}
