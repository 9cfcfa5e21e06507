//! Several rays side by side, lane by lane of the machine's vectors: they walk together, cross the gaps of their
//! columns together, and their frusta fill one batch.

use super::batch::{Batch, FrustumCrossing};
use super::scalar::Ray;
use crate::column::Flow;
use crate::column::packet_traversal::{GapCrossings, PacketTraversal};
use crate::counts::Counts;
use crate::signature::BoundarySignature;
use crate::single_volume::SingleVolumeTracer;
use crate::trace::queue::Queue;
use crate::trace::{PrimaryRay, Report};
use crate::walk::packet::{LANES, Lanes, PacketColumns, RayPacket, lanes};
use fearless_simd::{Level, Simd, prelude::*, u32x16};
use icoray_grid::array::MapInline;
use icoray_grid::real::{Real, lerp};

/// The machine's vector instructions, where packets of rays are compiled for them: AVX2 (processors since 2013),
/// AVX-512, NEON. On other processors rays are traced one after the other, with the same pictures.
#[inline]
pub fn packets() -> Option<Level> {
    let level = Level::new();
    match level {
        #[cfg(target_arch = "x86_64")]
        Level::Avx512(_) | Level::Avx2(_) => Some(level),
        #[cfg(target_arch = "aarch64")]
        Level::Neon(_) => Some(level),
        _ => None,
    }
}

/// Weights of the second and third vertex at the columns' entries and at their exits.
type Weights<T> = [[Lanes<T>; 2]; 2];

/// Number of terminated rays that triggers integration of the batch and refilling of their lanes.
const MAX_ENDED_LANES: u32 = 4;

impl<T: Real> SingleVolumeTracer<'_, T> {
    /// Traces rays side by side, bit for bit as one after the other.
    #[inline]
    pub(super) fn trace_packets<const N: usize>(
        &self,
        level: Level,
        rays: &mut dyn Iterator<Item = PrimaryRay>,
        counts: &mut Counts,
        report: &mut Report,
    ) {
        let mut queue = Queue::new(self.grid, self.outer, rays);
        let mut tracer = PacketTracer::<T, N>::new(self);
        loop {
            for lane in lanes(!(tracer.walking | tracer.ended) & (u32::MAX >> (32 - LANES))) {
                match queue.next(|number| report(number, None, BoundarySignature::default())) {
                    Some((start, line, walk)) => {
                        tracer.packet.set(lane, &walk);
                        tracer.put(lane, start.number, Ray::new(self, line, start.dir));
                    }
                    None => break,
                }
            }
            if tracer.walking | tracer.ended == 0 {
                break;
            }
            tracer.advance_at(level);
            for lane in lanes(std::mem::take(&mut tracer.done)) {
                if let Some((number, ray)) = tracer.rays[lane].take() {
                    *counts += ray.counts;
                    report(number, Some(ray.light.wide()), BoundarySignature::default());
                }
            }
        }
        counts.columns += tracer.columns;
    }
}

/// Rays side by side. Those in `walking` go on, those in `waiting` have ended but for what is in the batch, those that
/// are `done` have their light.
struct PacketTracer<'r, 'f, T, const N: usize> {
    tracer: &'r SingleVolumeTracer<'f, T>,
    packet: RayPacket<'r, 'f>,
    rays: Lanes<Option<(usize, Ray<'r, 'f, T, N>)>>,
    walking: u32,
    ended: u32,
    done: u32,
    /// Bits of the rays that have skipped empty space since their last frustum.
    fresh: u32,
    /// The gap that each is in.
    gap: Lanes<u32>,
    /// Columns walked over.
    columns: u64,
    /// Where those that wait have met the core.
    core: Lanes<Option<f64>>,
    batch: Batch<T, N>,
}

impl<'r, 'f, T: Real, const N: usize> PacketTracer<'r, 'f, T, N> {
    #[inline]
    fn new(tracer: &'r SingleVolumeTracer<'f, T>) -> Self {
        PacketTracer {
            tracer,
            packet: RayPacket::new(tracer.grid),
            rays: [const { None }; LANES],
            walking: 0,
            ended: 0,
            done: 0,
            fresh: 0,
            gap: [0; LANES],
            columns: 0,
            core: [None; LANES],
            batch: Batch::new(T::of(tracer.color_tolerance())),
        }
    }

    /// Puts a ray whose walk is in the packet into a lane.
    #[inline]
    fn put(&mut self, lane: usize, number: usize, ray: Ray<'r, 'f, T, N>) {
        self.rays[lane] = Some((number, ray));
        self.walking |= 1 << lane;
        self.fresh &= !(1 << lane);
        self.gap[lane] = self.tracer.shell.gap(self.packet.height(lane)) as u32;
        self.core[lane] = None;
    }

    /// [`Self::go_on`] with the machine's instructions, of which [`packets`] named the level.
    #[inline]
    fn advance_at(&mut self, level: Level) {
        match level {
            #[cfg(target_arch = "x86_64")]
            Level::Avx512(simd) => simd.vectorize(
                #[inline(always)]
                || self.advance(simd),
            ),
            #[cfg(target_arch = "x86_64")]
            Level::Avx2(simd) => simd.vectorize(
                #[inline(always)]
                || self.advance(simd),
            ),
            #[cfg(target_arch = "aarch64")]
            Level::Neon(simd) => simd.vectorize(
                #[inline(always)]
                || self.go_on(simd),
            ),
            _ => unreachable!("packets are traced at the levels of `packets` only"),
        }
    }

    /// Goes on until some rays are done.
    #[inline(always)]
    fn advance<V: Simd>(&mut self, simd: V) {
        while self.done == 0 {
            if self.walking == 0 || self.ended.count_ones() >= MAX_ENDED_LANES {
                self.integrate_batch(simd);
                continue;
            }
            let columns = self.packet.step(simd, self.walking);
            self.columns += u64::from(self.walking.count_ones());
            self.pass(simd, &columns);
            let ended = columns.last & self.walking;
            self.ended |= ended;
            self.walking &= !ended;
        }
    }

    /// Integrates the batch and adds its light to the rays.
    #[inline(always)]
    fn integrate_batch<V: Simd>(&mut self, simd: V) {
        self.batch.integrate(simd, self.tracer);
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
                && ray.add_frustum(&self.batch, n) == Flow::Stop
            {
                self.done |= 1 << lane;
            }
        }
        for lane in lanes(self.ended & !self.done) {
            if let (Some((_, ray)), Some(t)) = (&mut self.rays[lane], self.core[lane]) {
                ray.core(t);
            }
        }
        self.done |= self.ended;
        self.ended = 0;
        self.walking &= !self.done;
        self.batch.clear();
    }

    /// Takes all rays through their columns.
    #[inline(always)]
    fn pass<V: Simd>(&mut self, simd: V, columns: &PacketColumns) {
        let tracer = self.tracer;
        let (mut out, mut blocks) = ([0; LANES], [0; LANES]);
        for i in 0..LANES {
            out[i] = tracer.shell.gap(columns.exit.rho[i]) as u32;
            blocks[i] = tracer.visible.blocks_over(columns.triangles[i]);
        }
        let mut reading = self.occupied_lanes(simd, &out, &blocks);
        if tracer.grid.void_triangles() > 0 {
            reading &= !self.pass_voids(columns);
        }
        self.fresh |= self.walking & !reading;
        if reading & self.walking != 0 {
            self.cross(simd, columns, reading & self.walking, &out, &blocks);
        }
        self.gap = out;
    }

    /// Bits of the columns in which something can be seen between the gaps of entry and `out`, or which reach to the
    /// core or out of the shell.
    #[inline(always)]
    fn occupied_lanes<V: Simd>(&self, simd: V, out: &Lanes<u32>, blocks: &Lanes<u32>) -> u32 {
        let all = |number: u32| u32x16::splat(simd, number);
        let [gap, out, blocks] = [&self.gap, out, blocks].map_inline(|row| u32x16::from_slice(simd, row));
        let (low, high) = (gap.min(out), gap.max(out));
        let block = |gap: u32x16<V>| ((gap - all(1)) >> self.tracer.visible.shift).min(all(31));
        let between = (all(u32::MAX) << block(low)) & (all(u32::MAX) >> (all(31) - block(high)));
        let shows = (blocks & between).simd_ne(all(0));
        let ends = low.simd_eq(all(0)) | high.simd_eq(all(self.tracer.shell.layers() as u32));
        (shows | ends).to_bitmask() as u32
    }

    /// Takes rays over voids, which have no values and whose core is round; gives their bits.
    #[cold]
    #[inline(never)]
    fn pass_voids(&mut self, columns: &PacketColumns) -> u32 {
        let mut void = 0;
        for lane in lanes(self.walking) {
            if self.tracer.grid.is_void(columns.triangles[lane]) {
                void |= 1 << lane;
                let ends = [columns.entry.t[lane], columns.exit.t[lane]];
                let met = self.packet.line(lane).first_inside(self.tracer.shell.inner(), ends);
                self.core[lane] = met.filter(|_| self.tracer.core.is_some());
            }
        }
        self.fresh |= void;
        for lane in lanes(void) {
            if self.core[lane].is_some() {
                self.ended |= 1 << lane;
                self.walking &= !(1 << lane);
            }
        }
        void
    }

    /// Crosses the gaps of the columns of the rays in `active`, until the gaps `out`.
    #[inline(always)]
    fn cross<V: Simd>(
        &mut self,
        simd: V,
        columns: &PacketColumns,
        mut active: u32,
        out: &Lanes<u32>,
        blocks: &Lanes<u32>,
    ) {
        let PacketColumns { entry, exit, .. } = columns;
        let tracer = self.tracer;
        let mut weight: Weights<T> = [[[T::zero(); LANES]; 2]; 2];
        for i in 0..LANES {
            weight[0][0][i] = T::of(entry.weight[0][i]);
            weight[0][1][i] = T::of(entry.weight[1][i]);
            weight[1][0][i] = T::of(exit.weight[0][i]);
            weight[1][1][i] = T::of(exit.weight[1][i]);
        }
        let mut base = [[0; 3]; LANES];
        for lane in lanes(active) {
            base[lane] = tracer.samples.bases([0, 1, 2].map_inline(|k| columns.cells[k][lane]));
        }
        let mut passages = PacketTraversal::<T>::new(simd, columns, &self.gap, out);
        loop {
            let (below, inside, shown) = self.gap_masks(simd, &passages.gap, blocks);
            if below & active != 0 && tracer.core.is_some() {
                for lane in lanes(below & active) {
                    self.core[lane] = Some(lerp(entry.t[lane], exit.t[lane], passages.u(lane)));
                }
                self.ended |= below & active;
                self.walking &= !self.ended;
                active &= !below;
            }
            self.fresh |= inside & !shown & active;
            let passing = passages.passing(simd);
            let crossings = passages.cross(simd, tracer.shell, active);
            let crossing = inside & shown & active;
            if crossing != 0 {
                self.push(simd, crossing, columns, &passages, (&weight, &crossings, &base));
                if self.batch.is_full() {
                    self.integrate_batch(simd);
                    active &= !self.done;
                }
            }
            active &= passing;
            if active == 0 {
                return;
            }
            passages.pass();
        }
    }

    /// Bits of the gaps that are below all layers, that are between two, and that can be seen.
    #[inline(always)]
    fn gap_masks<V: Simd>(&self, simd: V, gap: &Lanes<u32>, blocks: &Lanes<u32>) -> (u32, u32, u32) {
        let all = |number: u32| u32x16::splat(simd, number);
        let [gap, blocks] = [gap, blocks].map_inline(|row| u32x16::from_slice(simd, row));
        // Gap 0 wraps to more than there are.
        let below = gap - all(1);
        let is_inside = below.simd_lt(all(self.tracer.shell.layers() as u32 - 1));
        let block = (below >> self.tracer.visible.shift) & all(31);
        let shown = ((blocks >> block) & all(1)).simd_ne(all(0));
        let bits = [gap.simd_eq(all(0)), is_inside, shown].map_inline(|mask| mask.to_bitmask() as u32);
        (bits[0], bits[1], bits[2])
    }

    /// Adds the frusta of the rays in `crossing` to the batch.
    #[inline(always)]
    fn push<V: Simd>(
        &mut self,
        simd: V,
        crossing: u32,
        columns: &PacketColumns,
        passages: &PacketTraversal<T>,
        (weight, crossings, base): (&Weights<T>, &GapCrossings<T>, &Lanes<[isize; 3]>),
    ) {
        let GapCrossings { tau, place, eps, length } = crossings;
        let weight = weight.each_ref().map_inline(|end| end.each_ref());
        let way = FrustumCrossing { weight, tau: tau.each_ref(), place: place.each_ref(), eps, length };
        let samples = &self.tracer.samples;
        let up = samples.layer_stride();
        let fresh = self.fresh;
        self.batch.push(simd, crossing, way, |lane| {
            let (low, high) = (passages.gap[lane] as usize - 1, passages.gap[lane] as usize);
            let (behind, ahead, step) = if passages.rises(lane) { (low, high, up) } else { (high, low, -up) };
            let [a, b, c] = base[lane];
            let element = |base| samples.element(base, behind);
            let [a, b, c] = [element(a), element(b), element(c)];
            let ahead_of = |element: usize| samples.at(element.wrapping_add_signed(step));
            let read = [samples.at(a), samples.at(b), samples.at(c), ahead_of(a), ahead_of(b), ahead_of(c)];
            let cells = [columns.cells[0][lane], columns.cells[1][lane], columns.cells[2][lane]];
            (read, cells, [behind as u32, ahead as u32], fresh >> lane & 1 != 0)
        });
        self.fresh &= !crossing;
    }
}
