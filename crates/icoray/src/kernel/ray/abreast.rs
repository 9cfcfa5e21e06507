//! Several rays side by side: while one waits for the next triangle others walk, and their frusta fill one batch.

use super::batch::{Batch, Passed};
use super::{Caster, Counts, Flow, Light, Ray};
use crate::kernel::column::{Crossed, Passage};
use crate::kernel::plane::RayLine;
use crate::kernel::real::{Real, lerp};
use crate::kernel::sample::Sample;
use crate::kernel::walk::Walk;
use crate::kernel::walk::stride::{STEPS, Stride};
use fearless_simd::{Level, Simd, dispatch};
use glam::DVec3;
use std::ops::Range;

/// Rays that walk side by side.
const ABREAST: usize = 8;

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

/// What comes behind a ray's frusta.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Behind {
    /// More columns.
    More,
    /// The core, at this distance.
    Core(f64),
    /// Nothing.
    End,
}

/// A ray on its way.
struct Lane<'r, 'f, T, S, const N: usize> {
    number: usize,
    stride: Stride<'r, 'f>,
    ray: Ray<'r, 'f, T, S, N>,
    ahead: Ahead,
    /// Where a full batch has stopped it inside a column.
    stopped: Option<Passage<T>>,
    behind: Behind,
    /// Whether it has leapt behind its last frustum.
    is_fresh: bool,
    /// What it has of the batch.
    frusta: Range<usize>,
}

/// What is known of the columns that a lane has walked ahead.
#[derive(Debug, Clone, Copy, Default)]
struct Ahead {
    /// The gap that each column is entered in, and that in which the last one is left.
    gaps: [u32; STEPS + 1],
    /// The blocks of its gaps in which something can be seen.
    blocks: [u32; STEPS],
    /// Whether it has to be read.
    is_read: [bool; STEPS],
}

impl<'f, T: Real, S: Sample, const N: usize> Caster<'f, T, S, N> {
    /// Traces rays side by side, bit for bit as one after the other.
    pub(super) fn trace_abreast<'r>(
        &'r self,
        level: Level,
        rays: impl Iterator<Item = Start>,
        counts: &mut Counts,
        mut tell: impl FnMut(usize, Option<Light<T>>),
    ) where
        'f: 'r,
    {
        let mut queue = Queue::new(self, rays);
        let mut lanes: Vec<Lane<'r, 'f, T, S, N>> = Vec::with_capacity(ABREAST);
        while lanes.len() < ABREAST {
            let Some((start, line, walk)) = queue.next(&mut tell) else { break };
            lanes.push(Lane {
                number: start.number,
                stride: Stride::new(walk),
                ray: self.ray(line, start.dir),
                ahead: Ahead::default(),
                stopped: None,
                behind: Behind::More,
                is_fresh: false,
                frusta: 0..0,
            });
        }
        let mut batch = Batch::<T, S, N>::new();
        let share = T::of(self.budget.share.max(T::ROUNDING));
        while !lanes.is_empty() {
            self.walk(level, &mut lanes);
            batch.clear();
            lanes.iter_mut().for_each(|lane| self.gather(lane, &mut batch));
            batch.integrate(level, self, share);
            let mut i = 0;
            while let Some(lane) = lanes.get_mut(i) {
                if self.settle(lane, &batch) == Flow::On {
                    i += 1;
                    continue;
                }
                tell(lane.number, Some(lane.ray.light));
                match queue.next(&mut tell) {
                    Some((start, line, walk)) => {
                        lane.number = start.number;
                        lane.stride.restart(walk);
                        lane.ray.restart(line, start.dir);
                        (lane.stopped, lane.behind, lane.is_fresh) = (None, Behind::More, false);
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

    /// Walks on with all lanes that have no column left.
    #[inline(never)]
    fn walk(&self, level: Level, lanes: &mut [Lane<'_, '_, T, S, N>]) {
        dispatch!(level, simd => self.walk_all(simd, lanes));
    }

    #[inline(always)]
    fn walk_all<V: Simd>(&self, simd: V, lanes: &mut [Lane<'_, '_, T, S, N>]) {
        for i in 0..STEPS {
            // In two goes, short enough for the machine to be in several lanes at a time.
            for lane in &mut *lanes {
                if lane.stride.next().is_none() {
                    lane.stride.turn(i);
                }
            }
            for lane in &mut *lanes {
                if lane.stride.next().is_none() {
                    lane.stride.look(i);
                }
            }
        }
        for lane in lanes {
            if lane.stride.next().is_none() {
                lane.stride.measure(simd);
                self.look_ahead(lane);
            }
        }
    }

    /// Finds which of the columns that were walked ahead have to be read.
    #[inline(always)]
    fn look_ahead(&self, lane: &mut Lane<'_, '_, T, S, N>) {
        let Lane { stride, ahead, .. } = lane;
        let layers = self.shell.layers();
        ahead.gaps[0] = self.shell.gap(stride.height_in()) as u32;
        for i in 0..STEPS {
            ahead.gaps[i + 1] = self.shell.gap(stride.heights_out()[i]) as u32;
        }
        let triangles = stride.triangles();
        for i in 0..STEPS {
            ahead.blocks[i] = self.visible.over(triangles[i]);
            let [a, b] = [ahead.gaps[i] as usize, ahead.gaps[i + 1] as usize];
            let (low, high) = (a.min(b), a.max(b));
            ahead.is_read[i] =
                (low == 0) | (high == layers) || self.visible.shows_any(ahead.blocks[i], low, high);
        }
        if self.grid.void_triangles() > 0 {
            ahead.is_read.iter_mut().zip(triangles).for_each(|(is_read, t)| *is_read |= self.grid.is_void(t));
        }
    }

    /// Adds frusta of the columns that were walked ahead to the batch, while there is room.
    #[inline(never)]
    fn gather(&self, lane: &mut Lane<'_, '_, T, S, N>, batch: &mut Batch<T, S, N>) {
        let from = batch.count();
        let has_void = self.grid.void_triangles() > 0;
        while lane.behind == Behind::More && !batch.is_full() {
            let Some(i) = lane.stride.next() else { break };
            if !lane.ahead.is_read[i] {
                lane.ray.counts.columns += 1;
                lane.is_fresh = true;
                lane.stride.pass();
            } else if has_void && self.grid.is_void(lane.stride.triangles()[i]) {
                self.pass_void(lane);
            } else {
                self.gather_column(lane, i, batch);
            }
        }
        if lane.behind == Behind::More && lane.stride.has_ended() {
            lane.behind = Behind::End;
        }
        lane.frusta = from..batch.count();
    }

    /// A void has no values, and its core is round.
    #[cold]
    #[inline(never)]
    fn pass_void(&self, lane: &mut Lane<'_, '_, T, S, N>) {
        let column = lane.stride.column();
        lane.stride.pass();
        lane.ray.counts.columns += 1;
        lane.is_fresh = true;
        let met = lane.ray.line.first_inside(self.shell.inner(), [column.entry.t, column.exit.t]);
        if let (Some(t), true) = (met, self.core.is_some()) {
            lane.behind = Behind::Core(t);
        }
    }

    #[inline(always)]
    fn gather_column(&self, lane: &mut Lane<'_, '_, T, S, N>, i: usize, batch: &mut Batch<T, S, N>) {
        let (column, shell, layers) = (lane.stride.column(), self.shell, self.shell.layers());
        let mut passage = match lane.stopped.take() {
            Some(passage) => passage,
            None => {
                lane.ray.counts.columns += 1;
                Passage::new(&column, lane.ahead.gaps[i] as usize)
            }
        };
        let base = self.samples.bases(column.cells);
        let ([w0, w1], [w2, w3]) = (column.entry.weight, column.exit.weight);
        let weight = [[T::of(w0), T::of(w1)], [T::of(w2), T::of(w3)]];
        let up = self.samples.layer_stride();
        let length = column.exit.t - column.entry.t;
        loop {
            let (gap, crossed) = (passage.gap, passage.crossed(shell));
            if gap == 0 {
                if self.core.is_some() {
                    lane.behind = Behind::Core(lerp(column.entry.t, column.exit.t, passage.a.u));
                    return;
                }
            } else if gap < layers {
                if !self.visible.shows(lane.ahead.blocks[i], gap) {
                    lane.is_fresh = true;
                } else if batch.is_full() {
                    lane.stopped = Some(passage);
                    return;
                } else {
                    let Crossed { behind, ahead, b, .. } = crossed;
                    let at = |base: isize| self.samples.element(base, behind);
                    batch.push(&Passed {
                        elements: [at(base[0]), at(base[1]), at(base[2])],
                        step: if ahead > behind { up } else { -up },
                        cells: column.cells,
                        layers: [behind as u32, ahead as u32],
                        weight,
                        tau: [passage.a.tau, b.tau],
                        place: passage.places(shell, &crossed),
                        eps: passage.eps(&crossed),
                        length: T::of(length * (b.u - passage.a.u)),
                        is_fresh: lane.is_fresh,
                    });
                    lane.is_fresh = false;
                }
            }
            if !crossed.passes {
                lane.stride.pass();
                return;
            }
            passage.pass(&crossed);
        }
    }

    /// Adds the light of a lane's frusta, in the ray's order.
    #[inline(never)]
    fn settle(&self, lane: &mut Lane<'_, '_, T, S, N>, batch: &Batch<T, S, N>) -> Flow {
        for n in lane.frusta.clone() {
            if lane.ray.meet(batch, n) == Flow::Stop {
                return Flow::Stop;
            }
        }
        match lane.behind {
            Behind::More => Flow::On,
            Behind::Core(t) => lane.ray.core(t),
            Behind::End => Flow::Stop,
        }
    }
}

/// Rays that wait for a lane.
pub(super) struct Queue<'r, 'f, T, S, I, const N: usize> {
    caster: &'r Caster<'f, T, S, N>,
    rays: I,
    /// The first triangle of the last ray, and of the first one of its row.
    hint: u32,
    row_hint: u32,
}

impl<'r, 'f, T: Real, S: Sample, I: Iterator<Item = Start>, const N: usize> Queue<'r, 'f, T, S, I, N> {
    pub fn new(caster: &'r Caster<'f, T, S, N>, rays: I) -> Self {
        Queue { caster, rays, hint: 0, row_hint: 0 }
    }

    /// The next ray that meets the shell; those that miss it are told.
    pub fn next(
        &mut self,
        tell: &mut impl FnMut(usize, Option<Light<T>>),
    ) -> Option<(Start, RayLine, Walk<'r, 'f>)> {
        for start in self.rays.by_ref() {
            let from = if start.begins_row { self.row_hint } else { self.hint };
            let line = RayLine::new(start.eye, start.dir, self.caster.shell.outer());
            let walk = line.map(|line| (line, Walk::new(self.caster.grid, line, from)));
            self.hint = walk.as_ref().map_or(from, |(_, walk)| walk.triangle());
            if start.begins_row {
                self.row_hint = self.hint;
            }
            match walk {
                Some((line, walk)) => return Some((start, line, walk)),
                None => tell(start.number, None),
            }
        }
        None
    }
}
