//! One ray, whole: Algorithm 1 of the paper.

use crate::counts::Counts;
use crate::plane::RayLine;
use crate::trace::{self, Extent, Kernel, Report};
use glam::DVec3;
use icoray_grid::real::Real;
use scalar::Ray;

#[allow(clippy::needless_range_loop, reason = "rows side by side are indexed alike")]
mod batch;
mod frustum;
#[allow(clippy::needless_range_loop, reason = "rows side by side are indexed alike")]
mod packet;
mod scalar;
pub use crate::budget::Budget;
pub use crate::fragment::Fragment;
pub use crate::single_volume::SingleVolumeTracer;
pub use crate::trace::{PrimaryRay, Tracer};
pub use packet::packets;

/// A precision for which the kernel is compiled: `f32` or `f64`.
pub trait KernelReal: Real {
    /// The kernel as a trait object.
    fn boxed<'f>(tracer: SingleVolumeTracer<'f, Self>) -> Box<dyn Tracer + 'f>;
}

// Not inlined, so that crates that use the kernel do not compile it again.
impl KernelReal for f32 {
    #[inline(never)]
    fn boxed<'f>(tracer: SingleVolumeTracer<'f, Self>) -> Box<dyn Tracer + 'f> {
        boxed(tracer)
    }
}

impl KernelReal for f64 {
    #[inline(never)]
    fn boxed<'f>(tracer: SingleVolumeTracer<'f, Self>) -> Box<dyn Tracer + 'f> {
        boxed(tracer)
    }
}

#[inline]
fn boxed<'f, T: Real>(tracer: SingleVolumeTracer<'f, T>) -> Box<dyn Tracer + 'f> {
    match tracer.shading {
        Some(_) => trace::boxed(Interpolating::<T, 4>(tracer)),
        None => trace::boxed(Interpolating::<T, 1>(tracer)),
    }
}

/// A kernel whose rays interpolate `N` values.
struct Interpolating<'f, T, const N: usize>(SingleVolumeTracer<'f, T>);

impl<T: Real, const N: usize> Kernel for Interpolating<'_, T, N> {
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
        tell: &mut Report,
    ) -> bool {
        if T::HAS_PACKETS
            && let Some(level) = self.0.level
        {
            self.0.trace_packets::<N>(level, rays, counts, tell);
            return true;
        }
        false
    }
}
