//! Rays of a picture, whole or as fragments of a rank's part (`ray/fragment.rs` has what these are).

use super::{Run, Tracer};
use crate::kernel::column::Flow;
use crate::kernel::piece::Light;
use crate::kernel::plane::RayLine;
use crate::kernel::ray::{Budget, Casts, Counts, Fragment, Start};
use crate::kernel::walk::Walk;
use crate::ranks::Part;
use glam::DVec3;

impl Casts for Tracer<'_, '_> {
    fn outer(&self) -> f64 {
        self.world.outer
    }

    fn budget(&self) -> &Budget {
        &self.budget
    }

    fn cast(
        &self,
        rays: impl Iterator<Item = Start>,
        counts: &mut Counts,
        mut tell: impl FnMut(usize, Option<Light<f64>>),
    ) {
        let (mut hint, mut row_hint) = (0, 0);
        for Start { number, eye, dir, begins_row } in rays {
            hint = if begins_row { row_hint } else { hint };
            let light = self.trace(eye, dir, &mut hint, counts);
            row_hint = if begins_row { hint } else { row_hint };
            tell(number, light);
        }
    }

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
        let [inner, highest] = world.core_radius;
        if !part.is_near(&line, inner, world.outer) {
            return;
        }
        let whole = [line.start, line.end];
        let core = |radius: f64| line.first_inside(radius, whole).filter(|_| world.core.is_some());
        let near_core = core(highest);
        let behind_core = core(inner * part.lowest_facet()).unwrap_or(f64::INFINITY);
        let mut walk = Walk::new(world.grid, line, *hint);
        *hint = walk.triangle();
        let mut run = Run::new(self, line, dir);
        run.counts.rays = 0;
        let mut stretch: Option<[f64; 2]> = None;
        let mut gap = 0;
        loop {
            let triangle = walk.triangle();
            let is_own = part.has(triangle);
            let column = walk.next_column();
            if let (Some(t), None) = (stretch, column.filter(|_| is_own)) {
                let fragment = Fragment::new(t, &run.light, self.budget.brightest);
                if !fragment.is_clear() || near_core.is_some_and(|core| core <= t[1]) {
                    found.push(fragment);
                }
                // What is all but gone has ended the ray.
                run.rest /= 1.0 - run.light.absorbed;
                (run.light, stretch) = (Light::none(), None);
            }
            let Some(column) = column else { break };
            if !is_own {
                run.counts.columns += 1;
                if column.exit.t > behind_core {
                    break;
                }
                continue;
            }
            let (next, flow) = run.column(&column, triangle, gap);
            gap = next;
            stretch = Some([stretch.map_or(column.entry.t, |[from, _]| from), column.exit.t]);
            if flow == Flow::Stop {
                let ended =
                    |t: [f64; 2]| Fragment::new([t[0], f64::INFINITY], &run.light, self.budget.brightest);
                found.extend(stretch.map(ended));
                break;
            }
        }
        *counts += run.counts;
    }
}

impl Tracer<'_, '_> {
    /// The light along one ray; `None` where it misses everything.
    fn trace(&self, eye: DVec3, dir: DVec3, hint: &mut u32, counts: &mut Counts) -> Option<Light<f64>> {
        let line = RayLine::new(eye, dir, self.world.outer)?;
        let mut walk = Walk::new(self.world.grid, line, *hint);
        *hint = walk.triangle();
        let mut run = Run::new(self, line, dir);
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
        Some(run.light)
    }
}
