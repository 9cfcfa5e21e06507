//! Several rays side by side, lane by lane of the machine's vectors: they walk together, cross the gaps of their columns
//! together, and their frusta fill one batch.

use super::batch::Batch;
use super::queue::Queue;
use super::{Caster, Counts, Flow, Light, Ray, Start};
use crate::kernel::column::{Ladder, MOST_RUNGS};
use crate::kernel::real::{Real, lerp};
use crate::kernel::sample::Sample;
use crate::kernel::walk::pack::{Columns, LANES, Pack, Row, lanes};
use fearless_simd::{Level, Simd, dispatch};

/// So many rays may have ended before their frusta are integrated and others take their lanes.
const MOST_WAITING: u32 = 4;

impl<'f, T: Real, S: Sample, const N: usize> Caster<'f, T, S, N> {
    /// Traces rays side by side, bit for bit as one after the other.
    pub(super) fn trace_abreast<'r>(
        &'r self,
        (level, ladder): (Level, &'r Ladder<T>),
        rays: impl Iterator<Item = Start>,
        counts: &mut Counts,
        mut tell: impl FnMut(usize, Option<Light<T>>),
    ) where
        'f: 'r,
    {
        let mut queue = Queue::new(self, rays);
        let mut abreast = Abreast::new(self, ladder);
        loop {
            for lane in lanes(!(abreast.walking | abreast.waiting) & (u32::MAX >> (32 - LANES))) {
                match queue.next(|number| tell(number, None)) {
                    Some((start, line, walk)) => {
                        abreast.pack.set(lane, &walk);
                        abreast.put(lane, start.number, self.ray(line, start.dir));
                    }
                    None => break,
                }
            }
            if abreast.walking | abreast.waiting == 0 {
                break;
            }
            dispatch!(level, simd => abreast.go_on(simd));
            for lane in lanes(std::mem::take(&mut abreast.done)) {
                if let Some((number, ray)) = abreast.rays[lane].take() {
                    *counts += ray.counts;
                    tell(number, Some(ray.light));
                }
            }
        }
        counts.columns += abreast.columns;
    }
}

/// Rays side by side. Those in `walking` go on, those in `waiting` have ended but for what is in the batch, those that are
/// `done` have their light.
struct Abreast<'r, 'f, T, S, const N: usize> {
    caster: &'r Caster<'f, T, S, N>,
    ladder: &'r Ladder<T>,
    pack: Pack<'r, 'f>,
    rays: Row<Option<(usize, Ray<'r, 'f, T, S, N>)>>,
    walking: u32,
    waiting: u32,
    done: u32,
    /// Rays that have leapt since their last frustum.
    fresh: u32,
    /// The gap that each is in.
    gap: Row<u32>,
    /// Columns walked over.
    columns: u64,
    /// Where those that wait have met the core.
    core: Row<Option<f64>>,
    batch: Batch<T, S, N>,
}

/// Where rays are on their ways through their columns, as [`crate::kernel::column::Station`].
struct Stations<T> {
    u: Row<f64>,
    tau: Row<T>,
    rho: Row<f64>,
    curvature: Row<f64>,
}

impl<'r, 'f, T: Real, S: Sample, const N: usize> Abreast<'r, 'f, T, S, N> {
    fn new(caster: &'r Caster<'f, T, S, N>, ladder: &'r Ladder<T>) -> Self {
        Abreast {
            caster,
            ladder,
            pack: Pack::new(caster.grid),
            rays: [const { None }; LANES],
            walking: 0,
            waiting: 0,
            done: 0,
            fresh: 0,
            gap: [0; LANES],
            columns: 0,
            core: [None; LANES],
            batch: Batch::new(T::of(caster.budget.share.max(T::ROUNDING))),
        }
    }

    /// Puts a ray whose walk is in the pack into a lane.
    fn put(&mut self, lane: usize, number: usize, ray: Ray<'r, 'f, T, S, N>) {
        self.rays[lane] = Some((number, ray));
        self.walking |= 1 << lane;
        self.fresh &= !(1 << lane);
        self.gap[lane] = self.caster.shell.gap(self.pack.height(lane)) as u32;
        self.core[lane] = None;
    }

    /// Goes on until some rays are done.
    #[inline(always)]
    fn go_on<V: Simd>(&mut self, simd: V) {
        while self.done == 0 {
            if self.walking == 0 || self.waiting.count_ones() >= MOST_WAITING {
                self.settle();
                continue;
            }
            let columns = self.pack.step(simd, self.walking);
            self.columns += u64::from(self.walking.count_ones());
            self.pass(simd, &columns);
            let ended = columns.last & self.walking;
            self.waiting |= ended;
            self.walking &= !ended;
        }
    }

    /// Integrates the batch and adds its light to the rays.
    #[inline(always)]
    fn settle(&mut self) {
        self.batch.integrate(self.caster);
        self.add_light();
    }

    #[inline(never)]
    fn add_light(&mut self) {
        for n in 0..self.batch.count() {
            let lane = self.batch.lane(n);
            if self.done >> lane & 1 != 0 {
                continue;
            }
            if let Some((_, ray)) = &mut self.rays[lane]
                && ray.meet(&self.batch, n) == Flow::Stop
            {
                self.done |= 1 << lane;
            }
        }
        for lane in lanes(self.waiting & !self.done) {
            if let (Some((_, ray)), Some(t)) = (&mut self.rays[lane], self.core[lane]) {
                ray.core(t);
            }
        }
        self.done |= self.waiting;
        self.waiting = 0;
        self.walking &= !self.done;
        self.batch.clear();
    }

    /// Takes all rays through their columns.
    #[inline(always)]
    fn pass<V: Simd>(&mut self, simd: V, columns: &Columns) {
        let caster = self.caster;
        let layers = caster.shell.layers() as u32;
        let (mut out, mut blocks) = ([0; LANES], [0; LANES]);
        for i in 0..LANES {
            out[i] = caster.shell.gap(columns.exit.rho[i]) as u32;
            blocks[i] = caster.visible.over(columns.triangles[i]);
        }
        let mut reading = 0;
        for i in 0..LANES {
            let (low, high) = (self.gap[i].min(out[i]), self.gap[i].max(out[i]));
            let shows = caster.visible.shows_any(blocks[i], low as usize, high as usize);
            reading |= u32::from((low == 0) | (high == layers) | shows) << i;
        }
        if caster.grid.void_triangles() > 0 {
            reading &= !self.pass_voids(columns);
        }
        self.fresh |= self.walking & !reading;
        if reading & self.walking != 0 {
            self.cross(simd, columns, reading & self.walking, &out, &blocks);
        }
        self.gap = out;
    }

    /// Takes rays over voids, which have no values and whose core is round; gives their bits.
    #[cold]
    #[inline(never)]
    fn pass_voids(&mut self, columns: &Columns) -> u32 {
        let mut void = 0;
        for lane in lanes(self.walking) {
            if self.caster.grid.is_void(columns.triangles[lane]) {
                void |= 1 << lane;
                let ends = [columns.entry.t[lane], columns.exit.t[lane]];
                let met = self.pack.line(lane).first_inside(self.caster.shell.inner(), ends);
                self.core[lane] = met.filter(|_| self.caster.core.is_some());
            }
        }
        self.fresh |= void;
        for lane in lanes(void) {
            if self.core[lane].is_some() {
                self.waiting |= 1 << lane;
                self.walking &= !(1 << lane);
            }
        }
        void
    }

    /// Crosses the gaps of the columns of the rays in `active`, until the gap `out`.
    #[inline(always)]
    fn cross<V: Simd>(
        &mut self,
        simd: V,
        columns: &Columns,
        mut active: u32,
        out: &Row<u32>,
        blocks: &Row<u32>,
    ) {
        let Columns { entry, exit, .. } = columns;
        let (caster, ladder) = (self.caster, self.ladder);
        let (layers, shift) = (caster.shell.layers() as u32, caster.visible.shift);
        let mut gap = self.gap;
        let (mut rising, mut length) = ([false; LANES], [0.0; LANES]);
        let mut weight = [[T::zero(); LANES]; 4];
        for i in 0..LANES {
            rising[i] = exit.rho[i] >= entry.rho[i];
            length[i] = exit.t[i] - entry.t[i];
            weight[0][i] = T::of(entry.weight[0][i]);
            weight[1][i] = T::of(entry.weight[1][i]);
            weight[2][i] = T::of(exit.weight[0][i]);
            weight[3][i] = T::of(exit.weight[1][i]);
        }
        let mut base = [[0; 3]; LANES];
        for lane in lanes(active) {
            base[lane] = caster.samples.bases([0, 1, 2].map(|k| columns.cells[k][lane]));
        }
        let mut a = Stations {
            u: [0.0; LANES],
            tau: [T::zero(); LANES],
            rho: entry.rho,
            curvature: columns.curvature,
        };
        let mut is_on_layer = false;
        loop {
            let mut b = Stations { u: a.u, tau: a.tau, rho: a.rho, curvature: a.curvature };
            let mut way = [[T::zero(); LANES]; 6];
            let (mut crossing, mut hidden, mut below, mut passing) = (0, 0, 0, 0);
            for i in 0..LANES {
                let (low, high) =
                    (gap[i].wrapping_sub(1) as usize % MOST_RUNGS, gap[i] as usize % MOST_RUNGS);
                let passes = gap[i] != out[i];
                let ahead = if rising[i] { high } else { low };
                let (radius, curvature) = (ladder.radius[ahead], ladder.curvature[ahead]);
                let u = ((radius - entry.rho[i]) * columns.scale[i]).clamp(0.0, 1.0);
                let tau = (u * exit.rho[i] * curvature).clamp(0.0, 1.0);
                b.u[i] = if passes { u } else { 1.0 };
                b.tau[i] = if passes { T::of(tau) } else { T::one() };
                b.rho[i] = if passes { radius } else { exit.rho[i] };
                b.curvature[i] = curvature;
                let place = |rho: f64| {
                    let above = T::of(rho - ladder.radius[low]) * ladder.inverse[low];
                    let w = above.max(T::zero()).min(T::one());
                    if rising[i] { w } else { T::one() - w }
                };
                way[0][i] = a.tau[i];
                way[1][i] = b.tau[i];
                way[2][i] = if is_on_layer { T::zero() } else { place(a.rho[i]) };
                way[3][i] = if passes { T::one() } else { place(b.rho[i]) };
                let eps = T::of((b.rho[i] - a.rho[i]) * a.curvature[i]);
                way[4][i] = eps.max(T::of(T::ROUNDING - 1.0));
                way[5][i] = T::of(length[i] * (b.u[i] - a.u[i]));
            }
            for i in 0..LANES {
                let is_inside = (gap[i] >= 1) & (gap[i] < layers);
                let shows = blocks[i] >> ((gap[i].wrapping_sub(1) >> shift) % 32) & 1 != 0;
                crossing |= u32::from(is_inside & shows) << i;
                hidden |= u32::from(is_inside & !shows) << i;
                below |= u32::from(gap[i] == 0) << i;
                passing |= u32::from(gap[i] != out[i]) << i;
            }
            if below & active != 0 && caster.core.is_some() {
                for lane in lanes(below & active) {
                    self.core[lane] = Some(lerp(entry.t[lane], exit.t[lane], a.u[lane]));
                }
                self.waiting |= below & active;
                self.walking &= !self.waiting;
                active &= !below;
            }
            self.fresh |= hidden & active;
            crossing &= active;
            if crossing != 0 {
                let [w0, w1, w2, w3] = weight;
                let [t0, t1, p0, p1, eps, length] = way;
                let rows = [w0, w1, w2, w3, t0, t1, p0, p1, eps, length];
                let up = caster.samples.layer_stride();
                self.batch.push(simd, crossing, &rows, |lane| {
                    let (low, high) = (gap[lane] as usize - 1, gap[lane] as usize);
                    let (behind, ahead, step) = if rising[lane] { (low, high, up) } else { (high, low, -up) };
                    let elements = base[lane].map(|base| caster.samples.element(base, behind));
                    let read = |element| caster.samples.at(element);
                    let ahead_of = |element: usize| read(element.wrapping_add_signed(step));
                    let [a, b, c] = elements;
                    (
                        [read(a), read(b), read(c), ahead_of(a), ahead_of(b), ahead_of(c)],
                        [0, 1, 2].map(|k| columns.cells[k][lane]),
                        [behind as u32, ahead as u32],
                        self.fresh >> lane & 1 != 0,
                    )
                });
                self.fresh &= !crossing;
                if self.batch.is_full() {
                    self.settle();
                    active &= !self.done;
                }
            }
            active &= passing;
            if active == 0 {
                return;
            }
            for i in 0..LANES {
                gap[i] = if rising[i] { gap[i].wrapping_add(1) } else { gap[i].wrapping_sub(1) };
            }
            (a, is_on_layer) = (b, true);
        }
    }
}
