//! Several rays side by side: while one waits for the next triangle others walk.

use super::{Batch, Caster, Counts, Flow, Light, Ray, gather};
use crate::kernel::plane::RayLine;
use crate::kernel::real::Real;
use crate::kernel::sample::Sample;
use crate::kernel::walk::Walk;
use crate::kernel::walk::stride::{STEPS, Stride, Way};
use glam::DVec3;

/// Rays that walk side by side.
const ABREAST: usize = 4;

/// A ray to be traced.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Start {
    /// What its light is told with.
    pub number: usize,
    pub eye: DVec3,
    pub dir: DVec3,
    /// Whether it begins a row, and is searched for from the row before.
    pub begins_row: bool,
}

/// A ray on its way.
struct Lane<'r, 'f, T, S, const N: usize> {
    number: usize,
    stride: Stride<'r, 'f>,
    ray: Ray<'r, 'f, T, S, N>,
    gap: Option<usize>,
}

impl<'f, T: Real, S: Sample, const N: usize> Caster<'f, T, S, N> {
    /// Traces rays, in any order, and tells the light of each; `None` where it misses the shell. See [`Self::trace`].
    pub fn trace_all<'r>(
        &'r self,
        mut rays: impl Iterator<Item = Start>,
        counts: &mut Counts,
        mut tell: impl FnMut(usize, Option<Light<T>>),
    ) where
        'f: 'r,
    {
        let (mut hint, mut row_hint) = (0, 0);
        // The next ray that meets the shell.
        let mut next = |tell: &mut dyn FnMut(usize, Option<Light<T>>)| {
            for start in rays.by_ref() {
                let from = if start.begins_row { row_hint } else { hint };
                let line = RayLine::new(start.eye, start.dir, self.outer);
                let walk = line.map(|line| (line, Walk::new(self.grid, line, from)));
                hint = walk.as_ref().map_or(from, |(_, walk)| walk.triangle());
                if start.begins_row {
                    row_hint = hint;
                }
                match walk {
                    Some((line, walk)) => return Some((start, line, walk)),
                    None => tell(start.number, None),
                }
            }
            None
        };
        let mut lanes: Vec<Lane<'r, 'f, T, S, N>> = Vec::with_capacity(ABREAST);
        while lanes.len() < ABREAST {
            let Some((start, line, walk)) = next(&mut tell) else { break };
            let ray = self.ray(line, start.dir);
            lanes.push(Lane { number: start.number, stride: Stride::new(walk), ray, gap: None });
        }
        while !lanes.is_empty() {
            lanes.iter_mut().for_each(|lane| lane.stride.begin());
            for i in 0..STEPS {
                lanes.iter_mut().for_each(|lane| lane.stride.step(i));
            }
            let mut i = 0;
            while let Some(lane) = lanes.get_mut(i) {
                if self.advance(lane) == Flow::On {
                    i += 1;
                    continue;
                }
                tell(lane.number, Some(lane.ray.light));
                match next(&mut tell) {
                    Some((start, line, walk)) => {
                        lane.number = start.number;
                        lane.stride.restart(walk);
                        self.restart(&mut lane.ray, line, start.dir);
                        lane.gap = None;
                        i += 1;
                    }
                    None => {
                        *counts += lane.ray.counts;
                        lanes.swap_remove(i);
                    }
                }
            }
        }
    }

    /// A ray that has met nothing yet.
    pub(super) fn ray<'r>(&'r self, line: RayLine, dir: DVec3) -> Ray<'r, 'f, T, S, N> {
        // Less than the last digit cannot be asked for.
        let share = self.budget.share.max(T::ROUNDING);
        Ray {
            caster: self,
            line,
            shading: self.shading.map(|s| s.along::<T>(dir, share)),
            share: T::of(share),
            rest: T::of(self.budget.rest),
            span: None,
            batch: Batch::new(),
            room: gather::FIRST,
            light: Light::none(),
            counts: Counts { rays: 1, ..Counts::default() },
        }
    }

    /// Makes a new ray of one that has ended, which goes on counting.
    fn restart<'r>(&'r self, ray: &mut Ray<'r, 'f, T, S, N>, line: RayLine, dir: DVec3) {
        ray.line = line;
        ray.shading = self.shading.map(|s| s.along::<T>(dir, self.budget.share.max(T::ROUNDING)));
        ray.span = None;
        ray.batch.clear();
        ray.room = gather::FIRST;
        ray.light = Light::none();
        ray.counts.rays += 1;
    }

    /// Passes the columns that were walked ahead.
    fn advance(&self, lane: &mut Lane<'_, '_, T, S, N>) -> Flow {
        let Lane { stride, ray, gap, .. } = lane;
        let has_void = self.grid.void_triangles() > 0;
        while let Some(triangle) = stride.ahead().first().copied() {
            let is_void = has_void && self.grid.is_void(triangle);
            let blocks = self.visible.over(triangle);
            if let Some(start) = *gap
                && !self.sees(blocks, start)
                && let Some(way) = self.clear_way(stride, start)
            {
                ray.counts.columns += way.columns as u64;
                ray.span = None;
                *gap = Some(self.shell.gap_near(start, stride.leap(&way)));
                if ray.settle() == Flow::Stop {
                    return Flow::Stop;
                }
                continue;
            }
            let Some(column) = stride.next_column() else {
                ray.settle();
                return Flow::Stop;
            };
            let flow = if is_void {
                *gap = None;
                ray.void_column(&column)
            } else {
                let start = gap.unwrap_or_else(|| self.shell.gap(column.entry.rho));
                let (next, flow) = ray.column(&column, start, blocks);
                *gap = Some(next);
                flow
            };
            if flow == Flow::Stop {
                return Flow::Stop;
            }
        }
        Flow::On
    }

    /// Whether something can be seen in `gap`, or must be looked at.
    #[inline(always)]
    fn sees(&self, blocks: u32, gap: usize) -> bool {
        gap == 0 || gap == self.shell.layers() || self.visible.shows(blocks, gap)
    }

    /// The longest way on over columns in which nothing is to be seen as high as the ray is there.
    #[inline]
    fn clear_way(&self, stride: &Stride, gap: usize) -> Option<Way> {
        let ahead = stride.ahead();
        [ahead.len(), 4, 1].into_iter().filter(|n| *n <= ahead.len()).find_map(|columns| {
            let way = stride.way(columns)?;
            let low = self.shell.gap_near(gap, way.lowest);
            if low == 0 {
                return None;
            }
            let high = self.shell.gap_near(gap, way.highest * self.visible.stretch);
            let seen = ahead[..columns].iter().fold(0, |all, triangle| all | self.visible.over(*triangle));
            (seen & self.visible.between(low, high) == 0).then_some(way)
        })
    }
}
