//! Single steps of a ray that is in a packet: the frusta, surfaces and cuts that packets leave to this kernel.

use super::wedge::{Facet, FacetSide, Wedge};
use super::{MultiVolumeTracer, RayState};
use crate::column::Flow;
use crate::counts::Counts;
use crate::ground::SurfaceHit;
use crate::piece::Radiance;
use crate::plane::RayLine;
use crate::signature::{BoundarySignature, EyeDistance};
use crate::walk::Column;
use glam::DVec3;

/// What a ray in a packet has met so far.
#[derive(Clone, Copy)]
pub(crate) struct Met {
    pub light: Radiance<f64>,
    pub surfaces: BoundarySignature,
    /// Whether the ray is in what is cut away.
    pub is_cut: bool,
}

/// A ray's way through one gap: the gap, and the fractions of the column at which the ray enters and leaves it, each
/// with the layer that lies there.
#[derive(Clone, Copy)]
pub(crate) struct GapWay {
    pub gap: usize,
    pub ends: [(f64, FacetSide); 2],
}

impl<'r, 'f> RayState<'r, 'f> {
    /// The ray at its start, in the memory of one that has ended.
    #[inline]
    pub(crate) fn begin(
        tracer: &MultiVolumeTracer<'r, 'f>,
        line: RayLine,
        (dir, from_eye): (DVec3, EyeDistance),
        ended: Option<Self>,
    ) -> Self {
        let scratch = ended.map(|ray| ray.scratch).unwrap_or_default();
        RayState { scratch, ..RayState::new(tracer, line, dir, from_eye) }
    }

    /// What the ray has met.
    #[inline]
    pub(crate) fn met_so_far(&self) -> Met {
        Met { light: self.light, surfaces: self.surfaces, is_cut: self.is_cut }
    }

    /// Goes on with what the ray has met elsewhere, to the transmittance at which it ends.
    #[inline]
    pub(crate) fn go_on(&mut self, met: Met, min_transmittance: f64) {
        self.min_transmittance = min_transmittance;
        Met { light: self.light, surfaces: self.surfaces, is_cut: self.is_cut } = met;
    }

    /// What was counted since it was asked for last.
    #[inline]
    pub(crate) fn take_counts(&mut self) -> Counts {
        std::mem::take(&mut self.counts)
    }

    /// Passes a gap of a column.
    pub(crate) fn pass_gap(&mut self, column: &Column, triangle: u32, way: &GapWay) -> Flow {
        let wedge = Wedge::new(column, triangle);
        let levels = &self.scene.levels;
        let [lower, upper] = [way.gap - 1, way.gap].map(|layer| Facet::new(&wedge, levels.inverse(wedge.cells, layer)));
        self.scratch.forget();
        self.gap(&wedge, (way.gap, [&lower, &upper]), way.ends)
    }

    /// Passes a layer with surfaces at the fraction `u` of a column.
    pub(crate) fn pass_layer(&mut self, column: &Column, triangle: u32, layer: usize, u: f64) -> Flow {
        let wedge = Wedge::new(column, triangle);
        let facet = Facet::new(&wedge, self.scene.levels.inverse(wedge.cells, layer));
        self.layer(&wedge, (layer, &facet), u)
    }

    /// Meets the core at the fraction `u` of a column.
    pub(crate) fn meet_core(&mut self, column: &Column, triangle: u32, u: f64) {
        let wedge = Wedge::new(column, triangle);
        let lowest = Facet::new(&wedge, self.scene.levels.inverse(wedge.cells, 0));
        self.core(&wedge, Some(&lowest), u);
    }

    /// Meets the round core below a void triangle, at distance `t`.
    pub(crate) fn meet_round_core(&mut self, t: f64) {
        self.ground(t, &SurfaceHit::round(self.line.position(t)), None);
    }

    /// The bits of the cuts that the ray is in behind distance `t`, layers apart, and the distance up to where it stays
    /// in them.
    pub(crate) fn cuts_behind(&self, t: f64) -> (u32, f64) {
        self.clips.behind(t)
    }
}
