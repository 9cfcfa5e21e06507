//! Rays side by side, in the machine's vectors: a state machine in each lane.
//!
//! A turn takes the lanes that have left their columns into the next ones ([`lanes`]), finds the way of each lane
//! through its gap ([`gap`]), interpolates the frusta ([`read`]) and integrates one piece of each ([`piece`]): the whole
//! frustum where its values stay in one span of the transfer function, else the part up to the extremum or the next
//! knot; what is left of the frustum waits in its lane for the next turn. Rays that have ended are replaced.
//!
//! Lanes do not depend on each other: a ray has the same bits in any lane beside any others. Scalar code is left for
//! what is rare: frusta at steps of the transfer function, values beyond all bounds, pieces for which the rules in
//! vectors are not near enough.

use crate::counts::Counts;
use crate::leap::{Ahead, Leaps};
use crate::owned_region::OwnedRegion;
use crate::piece::Radiance;
use crate::plane::RayLine;
use crate::ray::scalar::Ray;
use crate::shade::RayShading;
use crate::signature::BoundarySignature;
use crate::single_volume::SingleVolumeTracer;
use crate::trace::queue::{Clip, RowHints};
use crate::trace::{PrimaryRay, Target};
use crate::walk::Side;
use fearless_simd::{Level, Simd, prelude::*};
use glam::DVec3;
use icoray_grid::Grid;
use icoray_grid::array::MapInline;
use icoray_grid::real::lerp;
use icoray_simd::{Floats, Machine, Mask, Table};
use lanes::{Entries, Lanes, Mesh, lanes_of};
use light::{Lit, Slopes};
pub use limits::beyond_gathers;
use medium::SpanTables;
use part::all;
use read::Source;
use runs::Runs;

mod gap;
mod integral;
mod lanes;
mod leap;
mod light;
mod limits;
mod medium;
mod part;
mod piece;
mod read;
mod runs;
mod start;
mod turn;

/// The machine's vector instructions, where packets of rays are compiled for them: AVX2 (processors since 2013),
/// AVX-512, NEON. On other processors rays are traced one after the other.
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

/// Traces rays in packets; false where the tables are too long for gathers, and no ray is traced.
#[inline(never)]
pub(crate) fn trace<const N: usize>(
    level: Level,
    tracer: &SingleVolumeTracer<'_, f32>,
    rays: &mut dyn Iterator<Item = PrimaryRay>,
    counts: &mut Counts,
    target: &mut Target,
) -> bool {
    let region = match target {
        Target::Light(_) => None,
        Target::Fragments(own, _) => Some(*own),
    };
    let Some(tables) = Tables::new(tracer, region) else { return false };
    match level {
        #[cfg(target_arch = "x86_64")]
        Level::Avx512(simd) => simd.vectorize(
            #[inline(always)]
            || Packet::<_, N>::new(simd, tracer, &tables).trace(rays, counts, target),
        ),
        #[cfg(target_arch = "x86_64")]
        Level::Avx2(simd) => simd.vectorize(
            #[inline(always)]
            || Packet::<_, N>::new(simd, tracer, &tables).trace(rays, counts, target),
        ),
        #[cfg(target_arch = "aarch64")]
        Level::Neon(simd) => simd.vectorize(
            #[inline(always)]
            || Packet::<_, N>::new(simd, tracer, &tables).trace(rays, counts, target),
        ),
        _ => unreachable!("packets are traced at the levels of `packets` only"),
    }
    true
}

/// What all packets of a tile read.
struct Tables<'t> {
    mesh: Mesh<'t>,
    source: Source<'t>,
    spans: SpanTables<'t>,
    slopes: Slopes<'t>,
    bounds: Table<'t, f64>,
    /// The macrocells; `None` where rays do not leap.
    leaps: Option<Leaps<'t, f32>>,
    /// The region in which fragments are sought, and [`OwnedRegion::words`].
    own: Option<(&'t OwnedRegion, Table<'t, u32>)>,
}

impl<'t> Tables<'t> {
    fn new(tracer: &'t SingleVolumeTracer<'_, f32>, region: Option<&'t OwnedRegion>) -> Option<Self> {
        let slopes = match tracer.shading {
            Some(_) => Slopes::new(tracer.gradients, tracer.shell.layers())?,
            None => Slopes::None,
        };
        let own = match region {
            Some(region) => Some((region, Table::new(region.words())?)),
            None => None,
        };
        Some(Tables {
            slopes,
            mesh: Mesh::new(tracer.grid)?,
            source: Source::new(tracer.samples),
            spans: SpanTables::new(tracer.spans)?,
            bounds: Table::new(tracer.shell.bounds())?,
            leaps: own.is_none().then(|| Leaps::new(tracer.grid, tracer.shell, tracer.visible, tracer.core.is_some())).flatten(),
            own,
        })
    }
}

impl Tables<'_> {
    /// Where a ray enters its first column in which something may show, searched from the triangle `hint`, and the
    /// distance before which it does not leap. `None` where nothing shows.
    #[inline]
    fn first_column(&self, grid: &Grid, line: RayLine, hint: u32) -> Option<(Side, f64)> {
        let Some(leaps) = &self.leaps else { return Some((start::side(grid, &self.mesh, line, hint), 0.0)) };
        let Ahead::Shown { at, until, near } = leaps.ahead(&line, line.start) else { return None };
        let side = start::side_at(&self.mesh, line, at, near);
        Some((side.unwrap_or_else(|| start::side(grid, &self.mesh, line, near)), until))
    }
}

/// Largest number of lanes.
const MOST: usize = 16;

/// Numbers of free lanes at which they are filled.
const FREE: u32 = 2;

/// The ray in a lane.
#[derive(Clone, Copy)]
struct Start {
    number: usize,
    line: RayLine,
    dir: DVec3,
}

/// Rays that are still to be traced.
struct Rays<'q> {
    rays: &'q mut dyn Iterator<Item = PrimaryRay>,
    clip: Clip<'q>,
    hints: RowHints,
    entries: Entries,
}

impl Rays<'_> {
    /// The next ray that is not clipped away and on which something may show, and the distance before which it does not
    /// leap; those before it are reported without light.
    #[inline]
    fn next(
        &mut self,
        tracer: &SingleVolumeTracer<'_, f32>,
        tables: &Tables,
        counts: &mut Counts,
        target: &mut Target,
    ) -> Option<(Start, Side, f64)> {
        for PrimaryRay { number, eye, dir, begins_row } in &mut *self.rays {
            let hint = self.hints.get(begins_row);
            let Some(line) = self.clip.line(eye, dir) else {
                self.hints.set(begins_row, hint);
                if let Target::Light(report) = target {
                    report(number, None, BoundarySignature::default());
                }
                continue;
            };
            let Some((side, next_leap)) = tables.first_column(tracer.grid, line, hint) else {
                counts.rays += 1;
                if let Target::Light(report) = target {
                    report(number, Some(Radiance::none()), BoundarySignature::default());
                }
                continue;
            };
            self.hints.set(begins_row, side.half_edge / 3);
            return Some((Start { number, line, dir }, side, next_leap));
        }
        None
    }
}

/// Rays side by side. Sets of lanes are bits.
struct Packet<'p, 'f, V: Machine, const N: usize> {
    simd: V,
    tracer: &'p SingleVolumeTracer<'f, f32>,
    tables: &'p Tables<'p>,
    lanes: Lanes<V>,
    lit: Lit<V>,
    /// The lighting of all rays but for its directions.
    shading: Option<RayShading<f32>>,
    starts: [Option<Start>; MOST],
    /// Lanes with a ray.
    live: u32,
    /// Those that are to enter their next columns.
    fresh: u32,
    /// Those with a part of a frustum left.
    mid: u32,
    /// Those whose rays have ended.
    ended: u32,
    /// Those of them whose rays have come to the end of their last columns.
    exited: u32,
    /// Error of the colour that is allowed per absorbed light.
    color_tolerance: f32,
    /// Transmittance at which each ray ends.
    min_transmittance: Floats<V>,
    /// The fragments of the rays, where these are sought.
    runs: Option<Runs<'p, V>>,
    counts: Counts,
}

impl<'p, 'f, V: Machine, const N: usize> Packet<'p, 'f, V, N> {
    #[inline(always)]
    fn new(simd: V, tracer: &'p SingleVolumeTracer<'f, f32>, tables: &'p Tables<'p>) -> Self {
        Packet {
            simd,
            tracer,
            tables,
            lanes: Lanes::new(simd),
            lit: Lit::new(simd),
            shading: None,
            starts: [None; MOST],
            live: 0,
            fresh: 0,
            mid: 0,
            ended: 0,
            exited: 0,
            color_tolerance: tracer.color_tolerance() as f32,
            min_transmittance: all(simd, 0.0),
            runs: tables.own.map(|(region, own)| Runs::new(simd, region, own)),
            counts: Counts::default(),
        }
    }

    /// Traces all rays.
    #[inline(always)]
    fn trace(&mut self, rays: &mut dyn Iterator<Item = PrimaryRay>, counts: &mut Counts, target: &mut Target) {
        let hints = RowHints::new(self.tracer.grid);
        let mut queue = Rays { rays, clip: self.clip(), hints, entries: Entries::new() };
        // Gaps are passed in every turn where no column is passed as a whole.
        let is_full = self.tracer.visible.is_full() && self.runs.is_none();
        let mut is_empty = false;
        loop {
            if !is_empty && self.live.count_ones() + FREE <= Lanes::<V>::COUNT as u32 {
                is_empty = self.fill(&mut queue, target);
            }
            if self.live == 0 {
                break;
            }
            self.columns();
            if is_full || 2 * self.fresh.count_ones() <= self.live.count_ones() {
                self.gaps();
            }
            if self.ended != 0 {
                self.finish(target);
            }
        }
        *counts += self.counts;
    }

    /// Fills free lanes with rays; true where there are no more.
    #[inline(always)]
    fn fill(&mut self, queue: &mut Rays, target: &mut Target) -> bool {
        let before = self.live;
        let is_empty = self.take(queue, target);
        let new = self.live & !before;
        self.fresh |= new;
        self.mid &= !new;
        if self.runs.is_none() {
            self.counts.rays += u64::from(new.count_ones());
        }
        let new = mask::<V>(self.simd, new);
        let min_transmittance = all(self.simd, self.tracer.budget.min_transmittance as f32);
        self.min_transmittance = new.select(min_transmittance, self.min_transmittance);
        self.lanes.load(self.simd, &queue.entries, new);
        is_empty
    }

    /// Takes rays into free lanes; true where there are no more.
    #[inline(never)]
    fn take(&mut self, queue: &mut Rays, target: &mut Target) -> bool {
        for lane in lanes_of(!self.live & (u32::MAX >> (u32::BITS - Lanes::<V>::COUNT as u32))) {
            let next = queue.next(self.tracer, self.tables, &mut self.counts, target);
            let Some((start, side, next_leap)) = next else { return true };
            self.lanes.put(lane, &side, self.tables.source.side_bases(&side), &mut queue.entries);
            self.lanes.next_leap.set(lane, next_leap);
            self.lanes.locate(lane, self.tracer.shell, side.height);
            self.starts[lane % MOST] = Some(start);
            if let Some(runs) = &mut self.runs {
                runs.begin(lane, &start.line, self.tracer);
            }
            if let Some(shading) = self.tracer.shading.as_ref().filter(|_| N == 4) {
                let shading = shading.along::<f32>(start.dir);
                for k in 0..3 {
                    self.lit.light[k][lane] = shading.light[k];
                    self.lit.halfway[k][lane] = shading.halfway[k];
                }
                self.shading = Some(shading);
            }
            self.live |= 1 << lane;
        }
        false
    }

    /// Takes lanes that have left their columns into the next ones.
    #[inline(always)]
    fn columns(&mut self) {
        if self.fresh != 0 {
            let step = mask::<V>(self.simd, self.fresh);
            let apexes = self.lanes.step(self.simd, &self.tables.mesh, step);
            self.lanes.put_bases(step, self.tables.source.bases(self.simd, apexes, self.fresh));
            self.counts.columns += u64::from(self.fresh.count_ones());
            let entered = std::mem::take(&mut self.fresh);
            if self.runs.is_some() {
                self.pass_others(entered);
            } else if self.tracer.grid.void_triangles() > 0 {
                self.pass_voids(entered);
            }
            if !self.tracer.visible.is_full() {
                let entered = mask::<V>(self.simd, entered & !self.fresh & !self.ended);
                let (shell, visible) = (self.tracer.shell, self.tracer.visible);
                let skipped = self.lanes.skip_columns(self.simd, shell, self.tables.bounds, visible, entered);
                self.leave(skipped);
                self.leap(skipped);
            }
        }
        if !self.tracer.visible.is_full() {
            self.skip();
        }
    }

    /// Takes those of `entered` that are over void triangles, where only the round core can be met, to their columns'
    /// exits.
    #[cold]
    #[inline(never)]
    fn pass_voids(&mut self, entered: u32) {
        for lane in lanes_of(entered) {
            if !self.tracer.grid.is_void(self.lanes.triangles[lane]) {
                continue;
            }
            let ends = [0, 1].map(|k: usize| self.lanes.t[k].get(lane));
            let line = self.starts[lane].as_ref().map(|start| start.line);
            let met = line.and_then(|line| line.first_inside(self.tracer.shell.inner(), ends));
            match met.filter(|_| self.tracer.core.is_some()) {
                Some(t) => self.meet_core(lane, t),
                None => {
                    self.lanes.locate(lane, self.tracer.shell, self.lanes.rho[1].get(lane));
                    self.leave(1 << lane);
                }
            }
        }
    }

    /// Takes lanes out of gaps in which nothing shows.
    #[inline(always)]
    fn skip(&mut self) {
        let hidden = self.hidden();
        for lane in lanes_of(hidden) {
            if self.lanes.skip(lane, self.tracer.shell, self.tracer.visible) {
                self.leave(1 << lane);
            }
        }
    }

    /// Lanes that are about to enter a frustum in which nothing shows.
    #[inline(always)]
    fn hidden(&self) -> u32 {
        let visible = self.tracer.visible;
        let Some(blocks) = Table::new(&visible.blocks) else { return 0 };
        let below = self.lanes.gap - 1;
        let inside = below.simd_lt(self.tracer.shell.layers() as u32 - 1);
        let blocks = self.simd.gather_u32(blocks, self.lanes.triangles);
        let shown = ((blocks >> (below >> visible.shift)) & 1).simd_ne(0);
        (inside & !shown).to_bitmask() as u32 & self.live & !self.fresh & !self.mid & !self.ended
    }

    /// Lanes at the exits of their columns.
    #[inline(always)]
    fn leave(&mut self, lanes: u32) {
        let last = self.lanes.last.to_bitmask() as u32;
        self.ended |= lanes & last;
        self.exited |= lanes & last;
        self.fresh |= lanes & !last;
    }

    /// An opaque core ends the ray in a lane at distance `t`.
    #[inline(never)]
    fn meet_core(&mut self, lane: usize, t: f64) {
        if let (Some(mut ray), Some(core)) = (self.ray(lane), &self.tracer.core) {
            let position = self.starts[lane].map(|start| start.line.position(t)).unwrap_or_default();
            ray.light.over(&core.round_light(position, ray.shading.as_ref()));
            self.lanes.put_light(lane, &ray.light);
        }
        self.ended |= 1 << lane;
    }

    /// Takes all lanes through their gaps, by a piece of their frusta each.
    #[inline(always)]
    fn gaps(&mut self) {
        let simd = self.simd;
        let active = self.live & !self.fresh & !self.ended;
        let crossing = self.lanes.cross(simd, self.tables.bounds);
        let below = (self.lanes.gap - 1).simd_lt(self.tracer.shell.layers() as u32 - 1);
        let inside = below.to_bitmask() as u32 & active;
        let mut done = active;
        if self.tracer.core.is_some() {
            let core = self.lanes.gap.simd_eq(0).to_bitmask() as u32 & active;
            for lane in lanes_of(core) {
                let [t0, t1] = [0, 1].map(|k: usize| self.lanes.t[k].get(lane));
                self.meet_core(lane, lerp(t0, t1, self.lanes.u.get(lane)));
            }
            done &= !core;
        }
        if inside != 0 {
            self.frusta(&crossing, inside);
        }
        done &= !self.mid & !self.ended;
        let passes = crossing.passes.to_bitmask() as u32;
        let (passing, leaving) = (done & passes, done & !passes);
        self.lanes.pass(simd, &crossing, mask::<V>(simd, passing), mask::<V>(simd, leaving));
        self.leave(leaving);
    }

    /// Reports the rays that have ended.
    #[inline(never)]
    fn finish(&mut self, target: &mut Target) {
        for lane in lanes_of(self.ended) {
            let Some(start) = self.starts[lane].take() else { continue };
            match target {
                Target::Light(report) => {
                    report(start.number, Some(self.lanes.light(lane).wide()), BoundarySignature::default());
                }
                Target::Fragments(_, report) => self.finish_runs(lane, start.number, report),
            }
        }
        self.exited = 0;
        self.live &= !self.ended;
        self.fresh &= !self.ended;
        self.mid &= !self.ended;
        self.ended = 0;
    }

    /// The ray in a lane for scalar code, with its light.
    fn ray(&self, lane: usize) -> Option<Ray<'p, 'f, f32, N>> {
        let start = self.starts[lane]?;
        let mut ray = Ray::new(self.tracer, start.line, start.dir);
        ray.light = self.lanes.light(lane);
        ray.min_transmittance = self.min_transmittance[lane];
        Some(ray)
    }
}

impl<V: Machine> Lanes<V> {
    /// The light of a lane.
    fn light(&self, lane: usize) -> Radiance<f32> {
        Radiance {
            color: self.color.map_inline(|row| row[lane]),
            alpha: self.alpha[lane],
            error: self.error[lane],
            variance: self.variance[lane],
        }
    }

    /// Sets the light of a lane.
    fn put_light(&mut self, lane: usize, light: &Radiance<f32>) {
        self.color.iter_mut().zip(light.color).for_each(|(row, channel)| row[lane] = channel);
        (self.alpha[lane], self.error[lane], self.variance[lane]) = (light.alpha, light.error, light.variance);
    }
}

/// The mask of these lanes.
#[inline(always)]
fn mask<V: Machine>(simd: V, bits: u32) -> Mask<V> {
    <Mask<V> as SimdMask<V>>::from_bitmask(simd, u64::from(bits))
}
