//! What pictures ask of a kernel: rays, whole or as fragments.

use super::{Budget, Caster, Counts, Fragment, Start};
use crate::kernel::piece::Light;
use crate::kernel::real::Real;
use crate::kernel::signature::Signature;
use crate::ranks::Part;
use glam::DVec3;

/// What traces rays, and finds what a part of the cells does to them.
pub(crate) trait Casts: Sync {
    /// Outside of this radius nothing is seen.
    fn outer(&self) -> f64;
    /// How rays may spend the tolerance.
    fn budget(&self) -> &Budget;
    /// Traces rays, in any order, and tells the light of each, premultiplied; `None` where it misses the shell. The signature is
    /// that of the surfaces that it meets, and empty of rays through one field alone.
    fn cast(
        &self,
        rays: &mut dyn Iterator<Item = Start>,
        counts: &mut Counts,
        tell: &mut dyn FnMut(usize, Option<Light<f64>>, Signature),
    );
    /// Adds the ray's fragments of `part` to `found`, in order along the ray. The first triangle is searched from `hint`,
    /// which becomes that triangle. The ray itself is not counted, as several ranks trace it.
    ///
    /// One that shows nothing is left out, but where the core may be met, whom it tells where data are.
    fn fragments(
        &self,
        part: &Part,
        eye: DVec3,
        dir: DVec3,
        hint: &mut u32,
        counts: &mut Counts,
        found: &mut Vec<Fragment>,
    );
}

impl<T: Real, const N: usize> Casts for Caster<'_, T, N> {
    #[inline]
    fn outer(&self) -> f64 {
        self.outer
    }

    #[inline]
    fn budget(&self) -> &Budget {
        &self.budget
    }

    #[inline]
    fn cast(
        &self,
        rays: &mut dyn Iterator<Item = Start>,
        counts: &mut Counts,
        tell: &mut dyn FnMut(usize, Option<Light<f64>>, Signature),
    ) {
        self.trace_all(rays, counts, &mut |number, light: Option<Light<T>>| {
            tell(number, light.map(|light| light.wide()), Signature::default());
        });
    }

    #[inline]
    fn fragments(
        &self,
        part: &Part,
        eye: DVec3,
        dir: DVec3,
        hint: &mut u32,
        counts: &mut Counts,
        found: &mut Vec<Fragment>,
    ) {
        Caster::fragments(self, part, eye, dir, hint, counts, found);
    }
}
