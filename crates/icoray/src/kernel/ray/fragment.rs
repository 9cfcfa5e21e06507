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
use crate::kernel::plane::RayLine;
use crate::kernel::real::Real;
use crate::kernel::sample::Sample;
use crate::kernel::walk::Walk;
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
}

impl Fragment {
    pub(crate) fn new<T: Real>(t: [f64; 2], light: &Light<T>, brightest: f64) -> Self {
        let color = light.color.map(|c| c.wide() as f32);
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
        }
    }

    /// The light, to be composed.
    pub(crate) fn light(&self) -> Light<f64> {
        Light {
            color: self.color.map(f64::from),
            absorbed: self.absorbed.into(),
            error: self.error.into(),
            variance: self.variance.into(),
        }
    }

    /// Whether it adds nothing to a picture.
    pub(crate) fn is_clear(&self) -> bool {
        self.absorbed == 0.0 && self.error == 0.0 && self.variance == 0.0 && self.color == [0.0; 3]
    }
}

impl<T: Real, S: Sample, const N: usize> Caster<'_, T, S, N> {
    /// As [`Casts::fragments`](super::Casts::fragments).
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
        if !part.is_near(&line, self.shell.inner(), self.shell.outer()) {
            return;
        }
        let whole = [line.start, line.end];
        let is_solid = self.core.is_some();
        let core = |radius: f64| line.first_inside(radius, whole).filter(|_| is_solid);
        let near_core = core(self.shell.inner());
        let behind_core = core(self.shell.inner() * part.lowest_facet()).unwrap_or(f64::INFINITY);
        let mut walk = Walk::new(self.grid, line, *hint);
        *hint = walk.triangle();
        let mut ray = self.ray(line, dir);
        ray.counts.rays = 0;
        let mut gap = None;
        let mut run: Option<[f64; 2]> = None;
        loop {
            let is_own = part.has(walk.triangle());
            let blocks = self.visible.over(walk.triangle());
            let column = walk.next_column();
            let own = column.filter(|_| is_own);
            if let (Some(t), None) = (run, own) {
                let fragment = Fragment::new(t, &ray.light, self.budget.brightest);
                if !fragment.is_clear() || near_core.is_some_and(|core| core <= t[1]) {
                    found.push(fragment);
                }
                let passed = T::one() - ray.light.absorbed;
                // What is all but gone has ended the ray.
                ray.rest = ray.rest / passed;
                ray.light = Light::none();
                ray.span = None;
                (run, gap) = (None, None);
            }
            let Some(column) = column else { break };
            if !is_own {
                ray.counts.columns += 1;
                if column.exit.t > behind_core {
                    break;
                }
                continue;
            }
            let start = gap.unwrap_or_else(|| self.shell.gap(column.entry.rho));
            let (next, flow) = ray.column(&column, start, blocks);
            run = Some([run.map_or(column.entry.t, |[from, _]| from), column.exit.t]);
            if flow == Flow::Stop {
                found.extend(
                    run.map(|t| Fragment::new([t[0], f64::INFINITY], &ray.light, self.budget.brightest)),
                );
                break;
            }
            gap = Some(next);
        }
        *counts += ray.counts;
    }
}
