//! Rays of a picture, whole or as fragments of a rank's part (`ray/fragment.rs` has what these are).

use super::{Run, Tracer};
use crate::kernel::column::Flow;
use crate::kernel::piece::Light;
use crate::kernel::plane::RayLine;
use crate::kernel::ray::{Budget, Casts, Counts, Fragment, Runs, Start};
use crate::kernel::signature::Signature;
use crate::kernel::walk::Walk;
use crate::ranks::Part;
use glam::DVec3;

impl Casts for Tracer<'_, '_> {
    #[inline]
    fn outer(&self) -> f64 {
        self.world.outer
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
        let (mut hint, mut row_hint) = (0, 0);
        for Start { number, eye, dir, begins_row } in rays {
            hint = if begins_row { row_hint } else { hint };
            let met = self.trace(eye, dir, &mut hint, counts);
            row_hint = if begins_row { hint } else { row_hint };
            let (light, surfaces) = met.unzip();
            tell(number, light, surfaces.unwrap_or_default());
        }
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
        let world = self.world;
        let Some(line) = RayLine::new(eye, dir, world.outer) else { return };
        if !part.is_near(&line, world.core_radius[0], world.outer) {
            return;
        }
        let is_solid = world.core.is_some();
        let mut runs = Runs::new(part, &line, world.core_radius, is_solid, self.budget.brightest, found);
        let mut walk = Walk::new(world.grid, line, *hint);
        *hint = walk.triangle();
        let mut run = Run::new(self, line, eye, dir);
        run.counts.rays = 0;
        let mut gap = 0;
        loop {
            let triangle = walk.triangle();
            let is_own = part.has(triangle);
            let column = walk.next_column();
            if column.filter(|_| is_own).is_none() && runs.close(&run.light, run.surfaces) {
                // What is all but gone has ended the ray.
                run.rest /= 1.0 - run.light.absorbed;
                (run.light, run.surfaces) = (Light::none(), Signature::default());
                run.is_cut = false;
            }
            let Some(column) = column else { break };
            if !is_own {
                run.counts.columns += 1;
                if runs.is_behind_core(&column) {
                    break;
                }
                continue;
            }
            let (next, flow) = run.column(&column, triangle, gap);
            gap = next;
            runs.pass(&column);
            if flow == Flow::Stop {
                runs.end(&run.light, run.surfaces);
                break;
            }
        }
        *counts += run.counts;
    }
}

impl Tracer<'_, '_> {
    /// The light along one ray, and the surfaces that it meets; `None` where it misses everything.
    #[inline]
    fn trace(
        &self,
        eye: DVec3,
        dir: DVec3,
        hint: &mut u32,
        counts: &mut Counts,
    ) -> Option<(Light<f64>, Signature)> {
        let line = RayLine::new(eye, dir, self.world.outer)?;
        let mut walk = Walk::new(self.world.grid, line, *hint);
        *hint = walk.triangle();
        let mut run = Run::new(self, line, eye, dir);
        let mut gap = 0;
        loop {
            let (triangle, is_void) = (walk.triangle(), walk.is_void());
            let Some(column) = walk.next_column() else { break };
            let flow = if is_void {
                run.void_column(&column)
            } else {
                let (next, flow) = run.column(&column, triangle, gap);
                gap = next;
                flow
            };
            if flow == Flow::Stop {
                break;
            }
        }
        *counts += run.counts;
        Some((run.light, run.surfaces))
    }
}
