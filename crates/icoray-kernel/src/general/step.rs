//! Single steps of a ray in a packet: the frusta, surfaces and cuts that packets pass to this kernel.

use super::wedge::{Facet, FacetSide, Wedge};
use super::{RaySettings, RayState};
use crate::column::Flow;
use crate::counts::Counts;
use crate::ground::SurfaceHit;
use crate::piece::Radiance;
use crate::plane::RayLine;
use crate::signature::{BoundarySignature, EyeDistance};
use crate::walk::Column;
use glam::DVec3;

/// The light and surfaces of a ray in a packet so far.
#[derive(Clone, Copy)]
pub(crate) struct Met {
    pub light: Radiance<f64>,
    pub surfaces: BoundarySignature,
    /// Whether the ray is in space that is cut away.
    pub is_cut: bool,
}

impl<'r, 'f> RayState<'r, 'f> {
    /// Starts a ray, in the memory of one that has ended.
    #[inline]
    pub(crate) fn begin(
        tracer: &RaySettings<'r, 'f>,
        line: RayLine,
        (dir, from_eye): (DVec3, EyeDistance),
        ended: Option<Self>,
    ) -> Self {
        let scratch = ended.map(|ray| ray.scratch).unwrap_or_default();
        RayState { scratch, ..RayState::from_eye(tracer, line, dir, from_eye) }
    }

    /// The light and surfaces of the ray so far.
    #[inline]
    pub(crate) fn met_so_far(&self) -> Met {
        Met { light: self.light, surfaces: self.surfaces, is_cut: self.is_cut }
    }

    /// Continues with light and surfaces from elsewhere, to the transmittance at which the ray ends.
    #[inline]
    pub(crate) fn go_on(&mut self, met: Met, min_transmittance: f64) {
        self.min_transmittance = min_transmittance;
        Met { light: self.light, surfaces: self.surfaces, is_cut: self.is_cut } = met;
        self.pass_void();
    }

    /// The counts since the last call.
    #[inline]
    pub(crate) fn take_counts(&mut self) -> Counts {
        std::mem::take(&mut self.counts)
    }

    /// Passes a gap of a column between two fractions of the column, each with the layer at that place.
    pub(crate) fn pass_gap(
        &mut self,
        column: &Column,
        triangle: u32,
        (gap, ends): (usize, [(f64, FacetSide); 2]),
    ) -> Flow {
        let wedge = Wedge::new(column, triangle);
        let levels = &self.scene.levels;
        let [lower, upper] = [gap - 1, gap].map(|layer| Facet::new(&wedge, levels, layer));
        self.scratch.forget();
        self.gap(&wedge, [&lower, &upper], ends)
    }

    /// Passes a layer with surfaces at the fraction `u` of a column.
    pub(crate) fn pass_layer(&mut self, column: &Column, triangle: u32, layer: usize, u: f64) -> Flow {
        let wedge = Wedge::new(column, triangle);
        let facet = Facet::new(&wedge, &self.scene.levels, layer);
        self.layer(&wedge, &facet, u)
    }

    /// Meets the core at the fraction `u` of a column.
    pub(crate) fn meet_core(&mut self, column: &Column, triangle: u32, u: f64) {
        let wedge = Wedge::new(column, triangle);
        let lowest = Facet::new(&wedge, &self.scene.levels, 0);
        self.core(&wedge, &lowest, u);
    }

    /// Meets the round core below a void triangle, at distance `t`.
    pub(crate) fn meet_round_core(&mut self, t: f64) {
        self.ground(t, &SurfaceHit::round(self.line.position(t)), None);
    }

    /// The bits of the cuts that contain the ray behind distance `t`, regardless of layers, and the distance up to
    /// which it stays in them.
    pub(crate) fn cuts_behind(&self, t: f64) -> (u32, f64) {
        self.clips.behind(t)
    }
}
