//! Rays through a scene: side by side in packets, which pass rare cases to single rays, or one at a time. A picture
//! traces them whole, or as fragments of a part of the cells.

use crate::budget::Budget;
use crate::column::Flow;
use crate::counts::Counts;
use crate::fragment::{Fragment, FragmentBuilder, FragmentRules};
use crate::general::{KernelScene, RayState};
use crate::owned_region::OwnedRegion;
use crate::packet::{self, PacketScene};
use crate::piece::Radiance;
use crate::shade::Shading;
use crate::signature::BoundarySignature;
use crate::walk::Walk;
use fearless_simd::Level;
use icoray_scene::Method;
pub use queue::PrimaryRay;
use queue::{Clip, Queue};

pub(crate) mod queue;

/// Receives the number of a ray, its premultiplied light (`None` if the ray misses the shell), and the surfaces that it
/// meets.
pub type Report<'r> = dyn FnMut(usize, Option<Radiance<f64>>, BoundarySignature) + 'r;

/// Receives the number of a ray and its fragments, in order along the ray.
pub type FragmentReport<'r> = dyn FnMut(usize, &[Fragment]) + 'r;

/// The requested result of rays, and its receiver.
pub enum Target<'t, 'r> {
    /// The light of each ray.
    Light(&'t mut Report<'r>),
    /// The fragments of each ray inside a region.
    Fragments(&'t OwnedRegion, &'t mut FragmentReport<'r>),
}

/// Traces rays, and finds the fragments of rays inside a part of the cells.
pub trait Tracer: Sync {
    /// Radius of the visible space, in planet radii.
    fn outer(&self) -> f64;
    /// Division of the tolerance along a ray.
    fn budget(&self) -> &Budget;
    /// Traces rays, in any order, and reports the light of each. The signature is empty for rays
    /// through one volume alone.
    fn trace(&self, rays: &mut dyn Iterator<Item = PrimaryRay>, counts: &mut Counts, report: &mut Report);
    /// Traces rays inside `own`, in any order, and reports the fragments of each that has any. The rays themselves are
    /// not counted, since several ranks trace them.
    ///
    /// A fragment that shows nothing is left out, unless the core may be met in it: then it marks that the mesh has
    /// data there.
    fn fragments(
        &self,
        own: &OwnedRegion,
        rays: &mut dyn Iterator<Item = PrimaryRay>,
        counts: &mut Counts,
        report: &mut FragmentReport,
    );
}

/// A scene, and the settings for tracing its rays.
pub struct SceneTracer<'w, 'f> {
    /// The scene's volumes, surfaces and cuts.
    pub scene: &'w KernelScene<'f>,
    /// Lighting; `None` shows the transfer functions' own colours.
    pub shading: Option<Shading>,
    /// Division of the tolerance along a ray.
    pub budget: Budget,
    /// The rule of integration of a single volume.
    pub method: Method,
    /// When set, pieces of a single volume are not cut where the gradient turns.
    pub is_coarse: bool,
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
        self.packets.is_some_and(|packets| packet::trace(packets, self, rays, counts, &mut target))
    }
}

impl Tracer for SceneTracer<'_, '_> {
    fn outer(&self) -> f64 {
        self.scene.outer
    }

    fn budget(&self) -> &Budget {
        &self.budget
    }

    fn trace(&self, rays: &mut dyn Iterator<Item = PrimaryRay>, counts: &mut Counts, report: &mut Report) {
        if self.trace_packets(rays, counts, Target::Light(report)) {
            return;
        }
        let KernelScene { grid, outer, .. } = *self.scene;
        let has_voids = grid.void_triangles() > 0;
        let mut queue = Queue::new(grid, Clip { outer, region: None }, rays);
        while let Some((start, line, walk)) = queue.next(|number| report(number, None, BoundarySignature::default())) {
            let mut ray = RayState::new(self, line, &start);
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
        let KernelScene { grid, outer, core_radius, core, .. } = *self.scene;
        let clip = Clip { outer, region: Some((own, core_radius[0])) };
        let (mut queue, mut found) = (Queue::new(grid, clip, rays), Vec::new());
        while let Some((start, line, walk)) = queue.next(|_| ()) {
            let rules = FragmentRules::new(own, &line, core_radius, core.is_some(), self.budget.brightest);
            let mut ray = RayState::new(self, line, &start);
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
