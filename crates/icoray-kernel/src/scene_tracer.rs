//! Rays through a scene: side by side in packets, which pass rare cases to single rays, or one at a time.

use crate::budget::Budget;
use crate::column::Flow;
use crate::counts::Counts;
use crate::fragment::{Fragment, FragmentBuilder, FragmentRules};
use crate::general::{KernelScene, Passage, RaySettings, RayState};
use crate::owned_region::OwnedRegion;
use crate::packet::{self, PacketFrame, PacketScene};
use crate::signature::BoundarySignature;
use crate::trace::queue::{Clip, Queue};
use crate::trace::{FragmentReport, PrimaryRay, Report, Target, Tracer};
use crate::walk::Walk;
use fearless_simd::Level;
use glam::DVec3;

/// Rays through a scene.
pub struct SceneTracer<'w, 'f> {
    /// The scene and the settings of its rays.
    pub rays: RaySettings<'w, 'f>,
    /// The machine's vector instructions, and the scene for packets of rays in single precision; `None` traces rays one
    /// at a time in double precision, as do grids that are too large for packets.
    pub packets: Option<(Level, &'w PacketScene<'f>)>,
    /// Whether packets integrate frusta; false where the walk and the interpolation alone are measured.
    pub integrates: bool,
}

impl<'w> SceneTracer<'w, '_> {
    /// The kernel as a trait object.
    // Not inlined, so that crates that use the kernel do not compile it again.
    #[inline(never)]
    pub fn boxed(self) -> Box<dyn Tracer + 'w> {
        Box::new(self)
    }

    /// Traces all rays in packets and returns true, or traces none if there are no packets.
    fn trace_packets(
        &self,
        rays: &mut dyn Iterator<Item = PrimaryRay>,
        counts: &mut Counts,
        mut target: Target,
    ) -> bool {
        self.packets.is_some_and(|(level, packets)| {
            let frame = PacketFrame::new(&self.rays, packets, self.integrates);
            let traced = match frame.shading {
                Some(_) => packet::trace::<4>(level, &frame, rays, counts, &mut target),
                None => packet::trace::<1>(level, &frame, rays, counts, &mut target),
            };
            traced.is_some()
        })
    }
}

impl Tracer for SceneTracer<'_, '_> {
    fn outer(&self) -> f64 {
        self.rays.scene.outer
    }

    fn budget(&self) -> &Budget {
        &self.rays.budget
    }

    fn trace(&self, rays: &mut dyn Iterator<Item = PrimaryRay>, counts: &mut Counts, report: &mut Report) {
        if self.trace_packets(rays, counts, Target::Light(report)) {
            return;
        }
        let KernelScene { grid, outer, .. } = *self.rays.scene;
        let has_voids = grid.void_triangles() > 0;
        let mut queue = Queue::new(grid, Clip { outer, region: None }, rays);
        while let Some((start, line, walk)) = queue.next(|number| report(number, None, BoundarySignature::default())) {
            let mut ray = RayState::new(&self.rays, line, &start);
            pass(&mut ray, has_voids, walk);
            *counts += *ray.counts();
            let (light, surfaces) = ray.met();
            report(start.number, Some(*light), surfaces);
        }
    }

    fn fragments(
        &self,
        own: &OwnedRegion,
        rays: &mut dyn Iterator<Item = PrimaryRay>,
        counts: &mut Counts,
        report: &mut FragmentReport,
    ) {
        if self.trace_packets(rays, counts, Target::Fragments(own, report)) {
            return;
        }
        let KernelScene { grid, outer, core_radius, core, .. } = *self.rays.scene;
        let clip = Clip { outer, region: Some((own, core_radius[0])) };
        let (mut queue, mut found) = (Queue::new(grid, clip, rays), Vec::new());
        while let Some((start, line, walk)) = queue.next(|_| ()) {
            let rules = FragmentRules::new(own, &line, core_radius, core.is_some(), self.rays.budget.brightest);
            let mut ray = RayState::new(&self.rays, line, &start);
            ray.counts().rays = 0;
            FragmentBuilder::new(rules, &mut found).trace(&mut ray, own, walk);
            *counts += *ray.counts();
            if !found.is_empty() {
                report(start.number, &found);
                found.clear();
            }
        }
    }
}

/// The places that the ray from `eye` along the unit vector `dir` passes, in order: in the columns of `own`, whose
/// fragments are returned too, or in all.
pub fn passages(
    rays: &RaySettings,
    own: Option<&OwnedRegion>,
    eye: DVec3,
    dir: DVec3,
) -> (Vec<Passage>, Vec<Fragment>) {
    let KernelScene { grid, outer, core_radius, core, .. } = *rays.scene;
    let mut start = std::iter::once(PrimaryRay { number: 0, eye, dir, begins_row: true });
    let clip = Clip { outer, region: own.map(|own| (own, core_radius[0])) };
    let mut fragments = Vec::new();
    let Some((start, line, walk)) = Queue::new(grid, clip, &mut start).next(|_| ()) else {
        return (Vec::new(), fragments);
    };
    let mut ray = RayState::new(rays, line, &start).recorded();
    match own {
        Some(own) => {
            let rules = FragmentRules::new(own, &line, core_radius, core.is_some(), rays.budget.brightest);
            FragmentBuilder::new(rules, &mut fragments).trace(&mut ray, own, walk);
        }
        None => pass(&mut ray, grid.void_triangles() > 0, walk),
    }
    (ray.into_passages(), fragments)
}

/// Passes all columns of a walk until the ray ends.
#[inline]
fn pass(ray: &mut RayState, has_voids: bool, mut walk: Walk) {
    loop {
        // `has_voids` saves meshes without holes the look-up. Blocks are read before the next step of the walk, so that
        // both wait for memory at the same time.
        let is_void = has_voids && walk.is_void();
        let triangle = walk.triangle();
        let blocks = ray.blocks(triangle);
        let Some(column) = walk.next_column() else { return };
        let flow = if is_void { ray.void_column(&column) } else { ray.column(&column, triangle, blocks) };
        if flow == Flow::Stop {
            return;
        }
    }
}
