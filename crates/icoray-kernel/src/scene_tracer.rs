//! Rays through any scene in single precision: packets, which pass rare cases to the general kernel.

use crate::budget::Budget;
use crate::counts::Counts;
use crate::general::{MultiVolumeTracer, RayState};
use crate::packet::{self, PacketScene};
use crate::plane::RayLine;
use crate::single_volume::SingleVolumeTracer;
use crate::trace::{self, Extent, Kernel, PrimaryRay, Target, Tracer};
use fearless_simd::Level;
use glam::DVec3;

/// The kernel for scenes of several volumes, surfaces and cuts, and for native heights, in single precision. Rays over
/// grids that are too large for packets are traced by the general kernel.
pub struct SceneTracer<'w, 'f> {
    /// The general kernel for the scene.
    pub general: MultiVolumeTracer<'w, 'f>,
    /// The scene for packets.
    pub packets: &'w PacketScene<'f>,
    /// The machine's vector instructions.
    pub level: Level,
    /// Whether frusta are integrated; false where the walk and the interpolation alone are measured.
    pub integrates: bool,
}

impl<'w> SceneTracer<'w, '_> {
    /// The kernel as a trait object.
    // Not inlined, so that crates that use the kernel do not compile it again.
    #[inline(never)]
    pub fn boxed(self) -> Box<dyn Tracer + 'w> {
        trace::boxed(self)
    }
}

impl Kernel for SceneTracer<'_, '_> {
    type Ray<'r>
        = RayState<'r, 'r>
    where
        Self: 'r;

    fn extent(&self) -> Extent<'_> {
        self.general.extent()
    }

    fn budget(&self) -> &Budget {
        &self.general.budget
    }

    fn ray(&self, line: RayLine, eye: DVec3, dir: DVec3) -> RayState<'_, '_> {
        self.general.ray(line, eye, dir)
    }

    fn trace_packets(
        &self,
        rays: &mut dyn Iterator<Item = PrimaryRay>,
        counts: &mut Counts,
        target: &mut Target,
    ) -> bool {
        let SceneTracer { general, packets, level, integrates } = self;
        let MultiVolumeTracer { scene, shading, budget, is_coarse, .. } = *general;
        let source = scene.media.first().map_or(0, |medium| medium.extinction.source);
        let volume = SingleVolumeTracer {
            grid: scene.grid,
            shell: &packets.shell,
            spans: &packets.spans,
            samples: packets.samples,
            needs_sizes: packets.spans.needs_sizes(scene.sources[source].value_range()),
            visible: packets.visible(scene),
            outer: scene.outer,
            gradients: scene.sources[source].gradients().values(),
            budget,
            shading: shading.filter(|_| !scene.media.is_empty()),
            is_coarse,
            level: *level,
            integrates: *integrates,
            core: scene.core,
        };
        match volume.shading {
            Some(_) => packet::trace_scene::<4>(*level, &volume, (general, packets), rays, counts, target),
            None => packet::trace_scene::<1>(*level, &volume, (general, packets), rays, counts, target),
        }
    }
}
