//! What a rank that has a part of the cells sees of a ray: a fragment for each run of columns that are its own.
//!
//! The rank's mesh is closed like any other, so the ray walks over it from end to end; columns of other ranks and void ones
//! are passed over. Own columns have the bits that they have in the whole mesh, and so have the distances at their sides:
//! where one rank's run ends the next rank's begins.
//!
//! Light that is all but gone behind the rank's own columns is gone in the whole ray too, so the early end asks for that
//! alone. An opaque core is met under own columns only; behind where it must have been met, wherever facets lie, nothing
//! is looked for.

use super::{Caster, Counts, Flow, Light};
use crate::array::MapInline;
use crate::kernel::plane::RayLine;
use crate::kernel::real::Real;
use crate::kernel::signature::Signature;
use crate::kernel::walk::{Column, Walk};
use crate::ranks::Part;
use glam::DVec3;

/// Light of a part of a ray, in single precision: what is sent to the rank that puts the ray together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fragment {
    /// From where to where along the ray, from its closest point to the centre. Endless where the ray ended in it: what lies
    /// behind is hidden by the core, or told by the error.
    pub t: [f64; 2],
    /// Premultiplied linear RGB.
    pub color: [f32; 3],
    /// The part of what lies behind that is absorbed.
    pub absorbed: f32,
    /// How far a channel may be off: rounding to single precision included, other rounding apart.
    pub error: f32,
    /// Variance of rounding.
    pub variance: f32,
    /// The surfaces that the ray met in it: none of rays through one field alone.
    pub surfaces: Signature,
}

impl Fragment {
    #[inline]
    fn new<T: Real>(t: [f64; 2], light: &Light<T>, surfaces: Signature, brightest: f64) -> Self {
        let color = light.color.map_inline(|c| c.wide() as f32);
        let absorbed = light.absorbed.wide();
        // What is absorbed dims all that is behind.
        let most = color.iter().fold(absorbed * brightest, |most, c| most.max(f64::from(*c)));
        let stored =
            if size_of::<T>() > size_of::<f32>() { 0.5 * f64::from(f32::EPSILON) * most } else { 0.0 };
        Fragment {
            t,
            color,
            absorbed: absorbed as f32,
            error: (light.error.wide() + stored) as f32,
            variance: light.variance.wide() as f32,
            surfaces,
        }
    }

    /// The light, to be composed.
    #[inline]
    pub(crate) fn light(&self) -> Light<f64> {
        Light {
            color: self.color.map_inline(f64::from),
            absorbed: self.absorbed.into(),
            error: self.error.into(),
            variance: self.variance.into(),
        }
    }

    /// Whether it adds nothing to a picture.
    #[inline]
    fn is_clear(&self) -> bool {
        self.absorbed == 0.0
            && self.error == 0.0
            && self.variance == 0.0
            && self.color == [0.0; 3]
            && self.surfaces == Signature::default()
    }
}

/// A ray's fragments while it is traced: runs of a rank's own columns.
pub(crate) struct Runs<'r> {
    found: &'r mut Vec<Fragment>,
    brightest: f64,
    /// Where the core may be met at the earliest, and behind where it must have been.
    core: [f64; 2],
    run: Option<[f64; 2]>,
}

impl<'r> Runs<'r> {
    /// Of a ray that meets an opaque core, if `is_solid`, below a layer whose radius lies between `radius`.
    #[inline]
    pub fn new(
        part: &Part,
        line: &RayLine,
        radius: [f64; 2],
        is_solid: bool,
        brightest: f64,
        found: &'r mut Vec<Fragment>,
    ) -> Self {
        let core = |radius: f64| line.first_inside(radius, [line.start, line.end]).filter(|_| is_solid);
        let core =
            [radius[1], radius[0] * part.lowest_facet()].map_inline(|r| core(r).unwrap_or(f64::INFINITY));
        Runs { found, brightest, core, run: None }
    }

    /// The ray passes an own column.
    #[inline]
    pub fn pass(&mut self, column: &Column) {
        self.run = Some([self.run.map_or(column.entry.t, |[from, _]| from), column.exit.t]);
    }

    /// The ray is not over own columns any more: whether it was, and `light` and `surfaces` are of a run that ends.
    #[inline]
    pub fn close<T: Real>(&mut self, light: &Light<T>, surfaces: Signature) -> bool {
        let Some(t) = self.run.take() else { return false };
        let fragment = Fragment::new(t, light, surfaces, self.brightest);
        if !fragment.is_clear() || self.core[0] <= t[1] {
            self.found.push(fragment);
        }
        true
    }

    /// The ray has ended in its run.
    #[inline]
    pub fn end<T: Real>(&mut self, light: &Light<T>, surfaces: Signature) {
        let endless = |t: [f64; 2]| Fragment::new([t[0], f64::INFINITY], light, surfaces, self.brightest);
        self.found.extend(self.run.take().map(endless));
    }

    /// Whether a column lies behind where the core must have been met.
    #[inline]
    pub fn is_behind_core(&self, column: &Column) -> bool {
        column.exit.t > self.core[1]
    }
}

impl<T: Real, const N: usize> Caster<'_, T, N> {
    /// As [`Casts::fragments`](super::Casts::fragments).
    #[inline]
    pub fn fragments(
        &self,
        part: &Part,
        eye: DVec3,
        dir: DVec3,
        hint: &mut u32,
        counts: &mut Counts,
        found: &mut Vec<Fragment>,
    ) {
        let Some(line) = RayLine::new(eye, dir, self.shell.outer()) else { return };
        let inner = self.shell.inner();
        if !part.is_near(&line, inner, self.shell.outer()) {
            return;
        }
        let mut runs =
            Runs::new(part, &line, [inner, inner], self.core.is_some(), self.budget.brightest, found);
        let mut walk = Walk::new(self.grid, line, *hint);
        *hint = walk.triangle();
        let mut ray = self.ray(line, dir);
        ray.counts.rays = 0;
        let mut gap = None;
        loop {
            let is_own = part.has(walk.triangle());
            let blocks = self.visible.over(walk.triangle());
            let column = walk.next_column();
            if column.filter(|_| is_own).is_none() && runs.close(&ray.light, Signature::default()) {
                let passed = T::one() - ray.light.absorbed;
                // What is all but gone has ended the ray.
                ray.rest = ray.rest / passed;
                ray.light = Light::none();
                ray.span = None;
                gap = None;
            }
            let Some(column) = column else { break };
            if !is_own {
                ray.counts.columns += 1;
                if runs.is_behind_core(&column) {
                    break;
                }
                continue;
            }
            let start = gap.unwrap_or_else(|| self.shell.gap(column.entry.rho));
            let (next, flow) = ray.column(&column, start, blocks);
            runs.pass(&column);
            if flow == Flow::Stop {
                runs.end(&ray.light, Signature::default());
                break;
            }
            gap = Some(next);
        }
        *counts += ray.counts;
    }
}
