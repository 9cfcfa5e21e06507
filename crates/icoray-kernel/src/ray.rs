//! One ray, whole: Algorithm 1 of the paper.

use crate::counts::Counts;
use crate::packet;
use crate::plane::RayLine;
use crate::trace::{self, Extent, Kernel, Target};
use fearless_simd::Level;
use glam::DVec3;
use icoray_grid::real::Real;
use scalar::Ray;

mod frustum;
pub(crate) mod scalar;
pub use crate::budget::{Budget, FAINTEST};
pub use crate::fragment::Fragment;
pub use crate::packet::{PacketScene, beyond_gathers, packets};
pub use crate::scene_tracer::SceneTracer;
pub use crate::single_volume::SingleVolumeTracer;
pub use crate::trace::{FragmentReport, PrimaryRay, Report, Tracer};

/// A precision for which the kernel is compiled: `f32` or `f64`.
pub trait KernelReal: Real {
    /// Whether rays of this precision are traced in packets, which use the grid's half-edges.
    const HAS_PACKETS: bool;

    /// The kernel as a trait object.
    fn boxed<'f>(tracer: SingleVolumeTracer<'f, Self>) -> Box<dyn Tracer + 'f>;

    /// Traces all rays in packets and returns true, or traces none if this precision or the grid has no packets.
    fn trace_packets<const N: usize>(
        level: Level,
        tracer: &SingleVolumeTracer<'_, Self>,
        rays: &mut dyn Iterator<Item = PrimaryRay>,
        counts: &mut Counts,
        target: &mut Target,
    ) -> bool;
}

// Not inlined, so that crates that use the kernel do not compile it again.
impl KernelReal for f32 {
    const HAS_PACKETS: bool = true;

    #[inline(never)]
    fn boxed<'f>(tracer: SingleVolumeTracer<'f, Self>) -> Box<dyn Tracer + 'f> {
        boxed(tracer)
    }

    #[inline]
    fn trace_packets<const N: usize>(
        level: Level,
        tracer: &SingleVolumeTracer<'_, Self>,
        rays: &mut dyn Iterator<Item = PrimaryRay>,
        counts: &mut Counts,
        target: &mut Target,
    ) -> bool {
        packet::trace::<N>(level, tracer, rays, counts, target)
    }
}

impl KernelReal for f64 {
    /// Packets of f64 were a tenth faster.
    const HAS_PACKETS: bool = false;

    #[inline(never)]
    fn boxed<'f>(tracer: SingleVolumeTracer<'f, Self>) -> Box<dyn Tracer + 'f> {
        boxed(tracer)
    }

    #[inline]
    fn trace_packets<const N: usize>(
        _: Level,
        _: &SingleVolumeTracer<'_, Self>,
        _: &mut dyn Iterator<Item = PrimaryRay>,
        _: &mut Counts,
        _: &mut Target,
    ) -> bool {
        false
    }
}

#[inline]
fn boxed<'f, T: KernelReal>(tracer: SingleVolumeTracer<'f, T>) -> Box<dyn Tracer + 'f> {
    match tracer.shading {
        Some(_) => trace::boxed(Interpolating::<T, 4>(tracer)),
        None => trace::boxed(Interpolating::<T, 1>(tracer)),
    }
}

/// A kernel whose rays interpolate `N` values.
struct Interpolating<'f, T, const N: usize>(SingleVolumeTracer<'f, T>);

impl<T: KernelReal, const N: usize> Kernel for Interpolating<'_, T, N> {
    type Ray<'r>
        = Ray<'r, 'r, T, N>
    where
        Self: 'r;

    #[inline]
    fn extent(&self) -> Extent<'_> {
        let SingleVolumeTracer { grid, shell, outer, core, .. } = self.0;
        let core_radius = [shell.inner(); 2];
        Extent { grid, outer, top: shell.outer(), core_radius, is_solid: core.is_some() }
    }

    #[inline]
    fn budget(&self) -> &Budget {
        &self.0.budget
    }

    #[inline]
    fn ray(&self, line: RayLine, _: DVec3, dir: DVec3) -> Ray<'_, '_, T, N> {
        Ray::new(&self.0, line, dir)
    }

    #[inline]
    fn trace_packets(
        &self,
        rays: &mut dyn Iterator<Item = PrimaryRay>,
        counts: &mut Counts,
        target: &mut Target,
    ) -> bool {
        self.0.level.is_some_and(|level| T::trace_packets::<N>(level, &self.0, rays, counts, target))
    }
}
