//! Fragments of the rays of a packet inside a region: [`FragmentBuilder`](crate::fragment::FragmentBuilder) in lanes.
//!
//! A lane passes columns outside of the region without reading values. When it leaves the region, or its ray ends, its
//! light since entering becomes a fragment, and the lane continues without light.

use super::frame::PacketFrame;
use super::lanes::lanes_of;
use super::layers::Layers;
use super::start::Start;
use super::{MOST, Packet};
use crate::fragment::{Fragment, FragmentRules};
use crate::general::KernelScene;
use crate::owned_region::OwnedRegion;
use crate::piece::Radiance;
use crate::plane::RayLine;
use crate::signature::BoundarySignature;
use crate::trace::FragmentReport;
use crate::trace::queue::Clip;
use fearless_simd::prelude::*;
use icoray_simd::{Machine, Table, Wide};

/// The runs of each lane's ray inside a region.
pub(super) struct Runs<'o, V: Machine> {
    region: &'o OwnedRegion<'o>,
    /// The words of its marks.
    own: Table<'o, u32>,
    /// Lanes inside the region, and the distances at which they entered it.
    open: u32,
    starts: [f64; MOST],
    rules: [FragmentRules; MOST],
    /// [`FragmentRules::core_by`] of each lane.
    core_by: Wide<V>,
    /// The fragments of each lane's ray so far.
    found: [Vec<Fragment>; MOST],
}

impl<'o, V: Machine> Runs<'o, V> {
    /// Lanes without rays; `own` are the words of its marks.
    #[inline(always)]
    pub fn new(simd: V, region: &'o OwnedRegion<'o>, own: Table<'o, u32>) -> Self {
        Runs {
            region,
            own,
            open: 0,
            starts: [0.0; MOST],
            rules: [FragmentRules::default(); MOST],
            core_by: Wide::splat(simd, 0.0),
            found: [const { Vec::new() }; MOST],
        }
    }

    /// Begins a ray in a lane.
    #[inline]
    pub fn begin(&mut self, lane: usize, line: &RayLine, frame: &PacketFrame<'_>) {
        let KernelScene { core_radius, core, .. } = *frame.scene;
        let rules = FragmentRules::new(self.region, line, core_radius, core.is_some(), frame.rays.budget.brightest);
        self.rules[lane % MOST] = rules;
        self.core_by.set(lane, rules.core_by());
    }

    /// Ends a lane's run at the distance `to`.
    fn leave(&mut self, lane: usize, to: f64, met: (&Radiance<f32>, BoundarySignature)) {
        self.found[lane].extend(self.rules[lane].left([self.starts[lane], to], met));
    }

    /// Ends a lane's run in which its ray has ended.
    fn end(&mut self, lane: usize, met: (&Radiance<f32>, BoundarySignature)) {
        let fragment = self.rules[lane].ended(self.starts[lane], met);
        self.found[lane].push(fragment);
    }
}

impl<'p, V: Machine, L: Layers, const N: usize> Packet<'p, '_, V, L, N> {
    /// The part of space in which rays are traced.
    #[inline]
    pub(super) fn clip(&self) -> Clip<'p> {
        let KernelScene { core_radius: [lowest, _], outer, .. } = *self.frame.scene;
        Clip { outer, region: self.runs.as_ref().map(|runs| (runs.region, lowest)) }
    }

    /// Moves the lanes of `entered` outside of the region to their columns' exits. Runs end and begin.
    #[inline(always)]
    pub(super) fn pass_others(&mut self, entered: u32) {
        let Some(runs) = &self.runs else { return };
        let triangles = self.lanes.triangles;
        let words = self.simd.gather_u32(runs.own, triangles >> 5);
        let is_own = ((words >> (triangles & 31)) & 1).simd_ne(0);
        let own = is_own.to_bitmask() as u32 & entered;
        let others = entered & !own;
        let (left, begun) = (others & runs.open, own & !runs.open);
        let hidden = runs.core_by.lt(self.lanes.t[1]).narrow().to_bitmask() as u32 & others;
        if left != 0 {
            self.end_runs(left);
        }
        if begun != 0 {
            self.begin_runs(begun);
        }
        self.leave(others);
        self.ended |= hidden;
    }

    /// Begins runs at the entries of the lanes' columns.
    #[inline(never)]
    fn begin_runs(&mut self, lanes: u32) {
        let Some(runs) = &mut self.runs else { return };
        for lane in lanes_of(lanes) {
            runs.starts[lane] = self.lanes.t[0].get(lane);
            let height = self.lanes.rho[0].get(lane);
            self.layers.locate(&mut self.lanes, lane, height);
        }
        runs.open |= lanes;
    }

    /// Ends runs at the entries of the lanes' columns. Only the light that they transmit reaches the lanes' next runs.
    #[inline(never)]
    fn end_runs(&mut self, lanes: u32) {
        let Some(runs) = &mut self.runs else { return };
        for lane in lanes_of(lanes) {
            let light = self.lanes.light(lane);
            let surfaces = self.starts[lane].as_mut().map(|start| std::mem::take(&mut start.surfaces));
            runs.leave(lane, self.lanes.t[0].get(lane), (&light, surfaces.unwrap_or_default()));
            self.min_transmittance[lane] /= light.transmittance();
            self.lanes.put_light(lane, &Radiance::none());
        }
        if let Some(scene) = &mut self.scene {
            scene.restart(lanes);
        }
        runs.open &= !lanes;
    }

    /// Reports the fragments of a lane's ray, which has ended.
    pub(super) fn finish_runs(&mut self, lane: usize, start: &Start, report: &mut FragmentReport) {
        let Some(runs) = &mut self.runs else { return };
        let bit = 1 << lane;
        if runs.open & bit != 0 {
            let light = self.lanes.light(lane);
            if self.exited & bit != 0 {
                runs.leave(lane, self.lanes.t[1].get(lane), (&light, start.surfaces));
            } else {
                runs.end(lane, (&light, start.surfaces));
            }
            runs.open &= !bit;
        }
        if !runs.found[lane].is_empty() {
            report(start.number, &runs.found[lane]);
            runs.found[lane].clear();
        }
    }
}

#[cfg(test)]
mod tests;
