//! The part of a frame that all rays through a single volume share.

use crate::budget::Budget;
use crate::column::{Shell, Values};
use crate::counts::Counts;
use crate::ground::Core;
use crate::owned_region::OwnedRegion;
use crate::packet;
use crate::shade::Shading;
use crate::trace::{FragmentReport, PrimaryRay, Report, Target, Tracer};
use crate::transfer::Spans;
use crate::volume_ray::VolumeRules;
use fearless_simd::Level;
use icoray_grid::Grid;
use icoray_grid::gradient::Gradients;
use icoray_grid::occupancy::OccupancyMask;
use icoray_grid::samples::AnySamples;
use icoray_scene::Method;

/// The kernel for one field: all data that the rays of a frame share.
///
/// Rays interpolate `N` values: the field's value (`N = 1`), or value and gradient (`N = 4`) where there is lighting.
pub struct SingleVolumeTracer<'f> {
    /// Tables and directions of the grid.
    pub grid: &'f Grid<'f>,
    /// Radii of the layers, in planet radii.
    pub shell: &'f Shell<f32>,
    /// The transfer function.
    pub spans: &'f Spans<f32>,
    /// The field, normalised to the range of `spans`.
    pub samples: AnySamples<'f>,
    /// [`Spans::needs_sizes`] of the field.
    pub needs_sizes: bool,
    /// Visible blocks of gaps.
    pub visible: &'f OccupancyMask,
    /// Radius of the visible space, in planet radii.
    pub outer: f64,
    /// Gradients at the vertices, level-fastest; not read without lighting.
    pub gradients: &'f Gradients,
    /// Division of the tolerance along a ray.
    pub budget: Budget,
    /// Lighting; `None` shows the transfer function's own colours.
    pub shading: Option<Shading>,
    /// When set, pieces are not cut where the gradient turns.
    pub is_coarse: bool,
    /// The machine's vector instructions.
    pub level: Level,
    /// Whether frusta are integrated; false where the walk and the interpolation alone are measured.
    pub integrates: bool,
    /// The opaque core; `None` lets rays through the hollow core.
    pub core: Option<Core<'f>>,
}

impl<'f> SingleVolumeTracer<'f> {
    /// Error of the colour that is allowed per absorbed light.
    #[inline]
    pub(crate) fn color_tolerance(&self) -> f64 {
        self.budget.color_tolerance_in::<f32>(self.shading.as_ref())
    }

    /// What the integral depends on.
    #[inline]
    pub(crate) fn rules(&self) -> VolumeRules<'f, f32> {
        let SingleVolumeTracer { spans, is_coarse, budget, shading, .. } = *self;
        VolumeRules { spans, method: Method::Exact, is_coarse, budget, shading }
    }

    /// Value, and gradient where `N` is 4, at a vertex whose value is known.
    #[inline(always)]
    pub(crate) fn vertex<const N: usize>(&self, cell: u32, value: f32, layer: usize) -> Values<f32, N> {
        let mut values = [0.0; N];
        values[0] = value;
        if N == 4 {
            let gradient = self.gradients.at(cell as usize * self.shell.layers() + layer);
            values[1..].copy_from_slice(&gradient);
        }
        values
    }

    /// The kernel as a trait object.
    // Not inlined, so that crates that use the kernel do not compile it again.
    #[inline(never)]
    pub fn boxed(self) -> Box<dyn Tracer + 'f> {
        Box::new(self)
    }

    fn trace_packets(&self, rays: &mut dyn Iterator<Item = PrimaryRay>, counts: &mut Counts, mut target: Target) {
        let is_traced = match self.shading {
            Some(_) => packet::trace::<4>(self.level, self, rays, counts, &mut target),
            None => packet::trace::<1>(self.level, self, rays, counts, &mut target),
        };
        assert!(is_traced, "tables are too long for packets, which `beyond_gathers` tells before");
    }
}

impl Tracer for SingleVolumeTracer<'_> {
    fn outer(&self) -> f64 {
        self.outer
    }

    fn budget(&self) -> &Budget {
        &self.budget
    }

    fn trace(&self, rays: &mut dyn Iterator<Item = PrimaryRay>, counts: &mut Counts, report: &mut Report) {
        self.trace_packets(rays, counts, Target::Light(report));
    }

    fn fragments(
        &self,
        own: &OwnedRegion,
        rays: &mut dyn Iterator<Item = PrimaryRay>,
        counts: &mut Counts,
        report: &mut FragmentReport,
    ) {
        self.trace_packets(rays, counts, Target::Fragments(own, report));
    }
}
