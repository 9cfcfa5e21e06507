//! The interface of the kernel to a picture: rays traced whole, or as fragments of a part of the cells.

use crate::budget::Budget;
use crate::counts::Counts;
use crate::fragment::Fragment;
use crate::owned_region::OwnedRegion;
use crate::piece::Radiance;
use crate::signature::BoundarySignature;
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
    Fragments(&'t OwnedRegion<'t>, &'t mut FragmentReport<'r>),
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
