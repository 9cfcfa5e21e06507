//! The interface of both kernels to a picture: rays traced whole or as fragments, and the loop over the columns of a
//! ray.
//!
//! A picture uses a [`Tracer`], a trait object per tile. A kernel implements [`Kernel`], which makes its rays, and
//! [`ColumnRay`] for these; [`boxed`] joins the two. Both kernels are compiled in this crate only: the functions that
//! return a `Box<dyn Tracer>` are not generic.

use crate::budget::Budget;
use crate::column::Flow;
use crate::column_ray::ColumnRay;
use crate::counts::Counts;
use crate::fragment::{Fragment, FragmentBuilder, FragmentRules};
use crate::owned_region::OwnedRegion;
use crate::piece::Radiance;
use crate::plane::RayLine;
use crate::signature::BoundarySignature;
use crate::walk::Walk;
use glam::DVec3;
use icoray_grid::Grid;
use queue::{Clip, Queue};

pub use queue::PrimaryRay;

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
    /// Traces rays, in any order, and reports the light of each. The signature is empty for rays through one field.
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

/// The space that the rays of a kernel cross.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Extent<'g> {
    pub grid: &'g Grid<'g>,
    /// Radius of the visible space.
    pub outer: f64,
    /// Radius of the sphere to which rays are clipped for fragments.
    pub top: f64,
    /// Least and greatest radius of the innermost layer.
    pub core_radius: [f64; 2],
    /// Whether the core is opaque.
    pub is_solid: bool,
}

/// A kernel: makes the rays that are driven from column to column.
pub(crate) trait Kernel: Sync {
    type Ray<'r>: ColumnRay
    where
        Self: 'r;

    fn extent(&self) -> Extent<'_>;

    fn budget(&self) -> &Budget;

    /// The ray from `eye` along `dir` at its start; `line` is the same ray in its plane.
    fn ray(&self, line: RayLine, eye: DVec3, dir: DVec3) -> Self::Ray<'_>;

    /// Traces all rays in packets and returns true, or traces none if the kernel or the machine has no packets.
    #[inline]
    fn trace_packets(&self, _: &mut dyn Iterator<Item = PrimaryRay>, _: &mut Counts, _: &mut Target) -> bool {
        false
    }
}

/// Passes all columns of a walk until the ray ends.
#[inline]
fn pass(ray: &mut impl ColumnRay, has_voids: bool, mut walk: Walk) {
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

/// A kernel as a trait object.
#[inline]
pub(crate) fn boxed<'k>(kernel: impl Kernel + 'k) -> Box<dyn Tracer + 'k> {
    Box::new(Compiled(kernel))
}

struct Compiled<K>(K);

impl<K: Kernel> Tracer for Compiled<K> {
    fn outer(&self) -> f64 {
        self.0.extent().outer
    }

    fn budget(&self) -> &Budget {
        self.0.budget()
    }

    fn trace(&self, rays: &mut dyn Iterator<Item = PrimaryRay>, counts: &mut Counts, report: &mut Report) {
        if self.0.trace_packets(rays, counts, &mut Target::Light(report)) {
            return;
        }
        let Extent { grid, outer, .. } = self.0.extent();
        let has_voids = grid.void_triangles() > 0;
        let mut queue = Queue::new(grid, Clip { outer, region: None }, rays);
        while let Some((start, line, walk)) = queue.next(|number| report(number, None, BoundarySignature::default())) {
            let mut ray = self.0.ray(line, start.eye, start.dir);
            pass(&mut ray, has_voids, walk);
            *counts += *ray.counts();
            let (light, surfaces) = ray.met();
            report(start.number, Some(light.wide()), surfaces);
        }
    }

    fn fragments(
        &self,
        own: &OwnedRegion,
        rays: &mut dyn Iterator<Item = PrimaryRay>,
        counts: &mut Counts,
        report: &mut FragmentReport,
    ) {
        if self.0.trace_packets(rays, counts, &mut Target::Fragments(own, report)) {
            return;
        }
        let Extent { grid, top, core_radius, is_solid, .. } = self.0.extent();
        let clip = Clip { outer: top, region: Some((own, core_radius[0])) };
        let (mut queue, mut found) = (Queue::new(grid, clip, rays), Vec::new());
        while let Some((start, line, walk)) = queue.next(|_| ()) {
            let rules = FragmentRules::new(own, &line, core_radius, is_solid, self.0.budget().brightest);
            let mut ray = self.0.ray(line, start.eye, start.dir);
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
