//! The intersections of a packet's rays with the opaque core.

use super::lanes::lanes_of;
use super::layers::{CoreHit, Layers};
use super::{Packet, mask};
use icoray_simd::Machine;

impl<V: Machine, L: Layers, const N: usize> Packet<'_, '_, V, L, N> {
    /// Takes the lanes of `entered` over void triangles, under which only the core, a sphere there, can be met, to
    /// their columns' exits.
    #[cold]
    #[inline(never)]
    pub(super) fn pass_voids(&mut self, entered: u32) {
        for lane in lanes_of(entered) {
            if !self.frame.scene.grid.is_void(self.lanes.triangles[lane]) {
                continue;
            }
            let ends = [0, 1].map(|k: usize| self.lanes.t[k].get(lane));
            let line = self.starts[lane].as_ref().map(|start| start.line);
            let met = line.and_then(|line| line.first_inside(self.frame.scene.core_radius[0], ends));
            match met.filter(|_| self.frame.scene.core.is_some()) {
                Some(t) => self.meet_core(lane, &CoreHit { t, u: None }),
                None => {
                    let height = self.lanes.rho[1].get(lane);
                    self.layers.locate(&mut self.lanes, lane, height);
                    self.leave(1 << lane);
                }
            }
        }
    }

    /// Ends the ray in a lane at the opaque core.
    #[inline(never)]
    pub(super) fn meet_core(&mut self, lane: usize, hit: &CoreHit) {
        if self.tables.deviations.is_some() {
            self.settle_color(mask::<V>(self.simd, 1 << lane));
        }
        if L::HAS_SCENE {
            self.scene_core(lane, hit);
        } else if let (Some(mut ray), Some(core), Some(start)) =
            (self.ray(lane), self.frame.scene.core, &self.starts[lane])
        {
            let over = hit.u.map(|_| (self.frame.scene.grid, self.lanes.triangles[lane]));
            ray.light.over(&core.round_light(start.line.position(hit.t), over, ray.shading.as_ref()));
            self.lanes.put_light(lane, &ray.light);
        }
        self.ended |= 1 << lane;
    }
}
