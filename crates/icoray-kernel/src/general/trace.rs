//! The general kernel's implementation of [`Tracer`].

use super::{MultiVolumeTracer, RayState};
use crate::budget::Budget;
use crate::plane::RayLine;
use crate::signature::EyeDistance;
use crate::trace::{self, Extent, Kernel, Tracer};
use glam::DVec3;

impl<'w> MultiVolumeTracer<'w, '_> {
    /// The kernel as a trait object.
    // Not inlined, so that crates that use the kernel do not compile it again.
    #[inline(never)]
    pub fn boxed(self) -> Box<dyn Tracer + 'w> {
        trace::boxed(self)
    }
}

impl Kernel for MultiVolumeTracer<'_, '_> {
    type Ray<'r>
        = RayState<'r, 'r>
    where
        Self: 'r;

    fn extent(&self) -> Extent<'_> {
        let scene = self.scene;
        let (outer, is_solid) = (scene.outer, scene.core.is_some());
        Extent { grid: scene.grid, outer, top: outer, core_radius: scene.core_radius, is_solid }
    }

    fn budget(&self) -> &Budget {
        &self.budget
    }

    fn ray(&self, line: RayLine, eye: DVec3, dir: DVec3) -> RayState<'_, '_> {
        RayState::new(self, line, dir, EyeDistance::new(eye, dir))
    }
}
