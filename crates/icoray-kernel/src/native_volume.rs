//! Rays through a single volume between layers at heights of their own over each cell.

use crate::budget::Budget;
use crate::counts::Counts;
use crate::owned_region::OwnedRegion;
use crate::packet;
use crate::packet::NativeLayers;
use crate::single_volume::SingleVolumeTracer;
use crate::trace::{FragmentReport, PrimaryRay, Report, Tracer};

/// The kernel for one field on native heights: packets of rays, in single precision. Fragments, and rays over grids that
/// are too large for packets, are traced by the general kernel.
pub struct NativeVolumeTracer<'f> {
    /// What is the same for all rays; its `method` is [`Method::Exact`](icoray_scene::Method::Exact), and its `level` is
    /// the one that packets are traced at. The radii of its shell are means.
    pub volume: SingleVolumeTracer<'f, f32>,
    /// Where the layers lie.
    pub layers: NativeLayers<'f>,
    /// The general kernel for the same scene.
    pub general: Box<dyn Tracer + 'f>,
}

impl<'f> NativeVolumeTracer<'f> {
    /// The kernel as a trait object.
    // Not inlined, so that crates that use the kernel do not compile it again.
    #[inline(never)]
    pub fn boxed(self) -> Box<dyn Tracer + 'f> {
        Box::new(self)
    }
}

impl Tracer for NativeVolumeTracer<'_> {
    fn outer(&self) -> f64 {
        self.volume.outer
    }

    fn budget(&self) -> &Budget {
        &self.volume.budget
    }

    fn trace(&self, rays: &mut dyn Iterator<Item = PrimaryRay>, counts: &mut Counts, report: &mut Report) {
        let NativeVolumeTracer { volume, layers, general } = self;
        let is_traced = volume.level.is_some_and(|level| match volume.shading {
            Some(_) => packet::trace_native::<4>(level, volume, layers, rays, counts, report),
            None => packet::trace_native::<1>(level, volume, layers, rays, counts, report),
        });
        if !is_traced {
            general.trace(rays, counts, report);
        }
    }

    fn fragments(
        &self,
        own: &OwnedRegion,
        rays: &mut dyn Iterator<Item = PrimaryRay>,
        counts: &mut Counts,
        report: &mut FragmentReport,
    ) {
        self.general.fragments(own, rays, counts, report);
    }
}
