//! Rays side by side, in the machine's vectors: a state machine in each lane.
//!
//! A turn moves the lanes that have left their columns into the next ones ([`lanes`]) or over empty space ([`leap`]),
//! finds the path of each lane through its gap ([`gap`], [`native`]), interpolates the frusta ([`read`]) and integrates
//! one piece of each ([`piece`]): the whole frustum if its values stay in one span of the transfer function, else the
//! part up to the extremum or the next knot; the rest of the frustum stays in its lane for the next turn. Rays that
//! have ended are replaced.
//!
//! Lanes do not depend on each other: a ray has the same bits in any lane and beside any other rays. Scalar code
//! handles rare cases: frusta at steps of the transfer function, values beyond all bounds, pieces for which the rules
//! in vectors are not accurate enough; and, in a [`scene`] of more than one volume, frusta in which a ray meets a
//! surface or a cut.

use crate::counts::Counts;
use crate::general::{KernelScene, Levels};
use crate::leap::{HollowCore, Leaps};
use crate::shade::RayShading;
use crate::trace::queue::RowHints;
use crate::trace::{PrimaryRay, Target};
use crate::volume_ray::VolumeRay;
use crate::walk::Side;
use fearless_simd::{Level, Simd, prelude::*};
pub(crate) use frame::PacketFrame;
use gap::Concentric;
use icoray_grid::array::MapInline;
use icoray_grid::real::lerp;
use icoray_simd::{Floats, Machine, Mask, Table};
use lanes::{Entries, Lanes, lanes_of};
use layers::{CoreHit, Layers};
use light::Lit;
pub use limits::beyond_gathers;
use medium::number;
use native::Native;
pub use packet_scene::PacketScene;
use part::all;
use runs::Runs;
use scene::{SceneLanes, SceneTables};
use several::{VolumeLanes, VolumeTables};
use start::{Rays, Start};
use tables::Tables;

mod blend;
mod core;
mod cut;
mod frame;
mod gap;
mod heights;
mod integral;
mod lanes;
mod layers;
mod leap;
mod light;
mod limits;
mod look_ahead;
mod medium;
mod native;
mod native_way;
mod packet_scene;
mod part;
mod piece;
mod read;
mod runs;
mod scene;
mod several;
mod start;
mod tables;

/// Traces rays in packets, with light if `N` is 4 and without if it is 1; returns `None`, without tracing any, if the
/// tables are too long for gathers.
#[inline(never)]
pub(crate) fn trace<const N: usize>(
    level: Level,
    frame: &PacketFrame<'_>,
    rays: &mut dyn Iterator<Item = PrimaryRay>,
    counts: &mut Counts,
    target: &mut Target,
) -> Option<()> {
    let PacketFrame { rays: tracer, packets, .. } = *frame;
    let region = match target {
        Target::Light(_) => None,
        Target::Fragments(own, _) => Some(*own),
    };
    let mut tables = Tables::new(frame, region)?;
    if region.is_none() {
        (tables.leaps, tables.hollow) = (Leaps::new(frame), HollowCore::new(frame));
    }
    if tracer.scene.is_volume_alone() {
        let layers = Concentric::<false>::new(&frame.packets.shell)?;
        trace_between::<_, N>(level, frame, &tables, layers, rays, counts, target);
        return Some(());
    }
    let volumes = match &packets.volumes {
        Some(volumes) => Some(VolumeTables::new(volumes, tracer, frame.packets.shell.layers())?),
        None => None,
    };
    let tables = Tables { scene: Some(SceneTables::new(tracer, packets)?), volumes, ..tables };
    match &tracer.scene.levels {
        Levels::Concentric(_) => {
            let layers = Concentric::<true>::new(&frame.packets.shell)?;
            trace_between::<_, N>(level, frame, &tables, layers, rays, counts, target);
        }
        Levels::Native(heights) => {
            let layers = Native::new(heights)?;
            trace_between::<_, N>(level, frame, &tables, layers, rays, counts, target);
        }
    }
    Some(())
}

fn trace_between<L: Layers, const N: usize>(
    level: Level,
    frame: &PacketFrame<'_>,
    tables: &Tables<'_>,
    layers: L,
    rays: &mut dyn Iterator<Item = PrimaryRay>,
    counts: &mut Counts,
    target: &mut Target,
) {
    match level {
        #[cfg(target_arch = "x86_64")]
        Level::Avx512(simd) => simd.vectorize(
            #[inline(always)]
            || Packet::<_, L, N>::new(simd, frame, tables, layers).trace(rays, counts, target),
        ),
        #[cfg(target_arch = "x86_64")]
        Level::Avx2(simd) => simd.vectorize(
            #[inline(always)]
            || Packet::<_, L, N>::new(simd, frame, tables, layers).trace(rays, counts, target),
        ),
        #[cfg(target_arch = "aarch64")]
        Level::Neon(simd) => simd.vectorize(
            #[inline(always)]
            || Packet::<_, L, N>::new(simd, frame, tables, layers).trace(rays, counts, target),
        ),
        _ => unreachable!("packets are traced at the levels of `packets` only"),
    }
}

/// Maximum number of lanes.
const MOST: usize = 16;

/// Number of free lanes at which they are filled.
const FREE: u32 = 2;

/// Rays side by side. Sets of lanes are bits.
struct Packet<'p, 'f, V: Machine, L, const N: usize> {
    simd: V,
    frame: &'p PacketFrame<'f>,
    tables: &'p Tables<'p>,
    layers: L,
    lanes: Lanes<V>,
    lit: Lit<V>,
    /// The lighting of all rays, except for its directions.
    shading: Option<RayShading<f32>>,
    starts: [Option<Start>; MOST],
    /// Lanes with a ray.
    live: u32,
    /// Lanes that have entered columns and have not looked ahead from there.
    stepped: u32,
    /// Lanes that will enter their next columns.
    fresh: u32,
    /// Lanes with a part of a frustum left.
    mid: u32,
    /// Lanes whose rays have ended.
    ended: u32,
    /// Lanes of `ended` whose rays have reached the end of their last columns.
    exited: u32,
    /// Allowed error of the colour per absorbed light.
    color_tolerance: f32,
    /// Transmittance at which each ray ends.
    min_transmittance: Floats<V>,
    /// The visible parts of the scene beside the volume, if there are more than the core.
    scene: Option<SceneLanes<'p, V>>,
    /// The frusta in several fields, if there is more than one volume, or opacity by another field.
    volumes: Option<VolumeLanes<'p, V>>,
    /// The fragments of the rays, if requested.
    runs: Option<Runs<'p, V>>,
    counts: Counts,
}

impl<'p, 'f, V: Machine, L: Layers, const N: usize> Packet<'p, 'f, V, L, N> {
    #[inline(always)]
    fn new(simd: V, frame: &'p PacketFrame<'f>, tables: &'p Tables<'p>, layers: L) -> Self {
        Packet {
            simd,
            frame,
            tables,
            layers,
            lanes: Lanes::new(simd),
            lit: Lit::new(simd),
            shading: None,
            starts: [None; MOST],
            live: 0,
            stepped: 0,
            fresh: 0,
            mid: 0,
            ended: 0,
            exited: 0,
            color_tolerance: frame.rays.budget.color_tolerance_in::<f32>(frame.shading.as_ref()) as f32,
            min_transmittance: all(simd, 0.0),
            scene: tables.scene.as_ref().map(|tables| SceneLanes::new(simd, tables)),
            volumes: tables.volumes.as_ref().map(|tables| VolumeLanes::new(simd, tables)),
            runs: tables.own.map(|(region, own)| Runs::new(simd, region, own)),
            counts: Counts::default(),
        }
    }

    /// Traces all rays.
    #[inline(always)]
    fn trace(&mut self, rays: &mut dyn Iterator<Item = PrimaryRay>, counts: &mut Counts, target: &mut Target) {
        let hints = RowHints::new(self.frame.scene.grid);
        let mut queue = Rays { rays, clip: self.clip(), hints, last_shown: [u32::MAX; 2], entries: Entries::new() };
        // Gaps are passed in every turn if no column is passed as a whole.
        let is_full = self.frame.scene.visible.is_full() && self.runs.is_none();
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

    /// Fills free lanes with rays; returns true if there are no more.
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
        let min_transmittance = all(self.simd, self.frame.rays.budget.min_transmittance as f32);
        self.min_transmittance = new.select(min_transmittance, self.min_transmittance);
        self.lanes.load::<L>(self.simd, &queue.entries, new);
        is_empty
    }

    /// Takes rays into free lanes; returns true if there are no more.
    #[inline(never)]
    fn take(&mut self, queue: &mut Rays, target: &mut Target) -> bool {
        for lane in lanes_of(!self.live & (u32::MAX >> (u32::BITS - Lanes::<V>::COUNT as u32))) {
            let next = queue.next(self.frame, self.tables, &mut self.counts, target);
            let Some((start, side, next_leap)) = next else { return true };
            self.lanes.put(lane, &side, self.bases_of(&side), &mut queue.entries);
            self.lanes.next_leap.set(lane, next_leap);
            self.layers.locate(&mut self.lanes, lane, side.height);
            self.starts[lane % MOST] = Some(start);
            if let Some(scene) = &mut self.scene {
                scene.begin(lane, &start);
            }
            if let Some(runs) = &mut self.runs {
                runs.begin(lane, &start.line, self.frame);
            }
            if let Some(shading) = self.frame.shading.as_ref().filter(|_| N == 4) {
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

    /// Offsets of the values and heights of a side's two cells.
    #[inline]
    fn bases_of(&self, side: &Side) -> [[u32; 2]; 2] {
        let (source, [left, right]) = (&self.frame.packets.source, [side.left.cell, side.right.cell]);
        [[source.base(left), source.base(right)], [self.layers.base(left), self.layers.base(right)]]
    }

    /// Moves lanes that have left their columns into the next ones.
    #[inline(always)]
    fn columns(&mut self) {
        let simd = self.simd;
        if self.fresh != 0 {
            self.leap_core();
            let step = mask::<V>(simd, self.fresh);
            let apexes = self.lanes.step::<L>(simd, &self.tables.mesh, step);
            let bases = self.frame.packets.source.bases(simd, apexes, self.fresh);
            self.lanes.put_bases::<L>(step, bases, self.layers.bases(simd, apexes, self.fresh));
            self.counts.columns += u64::from(self.fresh.count_ones());
            let entered = std::mem::take(&mut self.fresh);
            self.fetch_half_edges(entered);
            self.stepped = entered;
            if self.runs.is_some() {
                self.pass_others(entered);
            } else if self.frame.scene.grid.void_triangles() > 0 {
                self.pass_voids(entered);
            }
            let entered = entered & !self.fresh & !self.ended;
            self.layers.enter(simd, &mut self.lanes, entered);
            if !self.frame.scene.visible.is_full() {
                let entered = mask::<V>(simd, entered);
                let skipped = self.skip_columns(entered);
                self.leave(skipped);
                self.leap(skipped);
            }
        }
        if !self.frame.scene.visible.is_full() {
            self.skip();
        }
    }

    /// Moves the lanes of `entered` in whose columns nothing is visible to their columns' exits; returns their bits.
    /// Columns that extend to the core or above all layers are not skipped.
    #[inline(always)]
    fn skip_columns(&mut self, entered: Mask<V>) -> u32 {
        let (simd, lanes) = (self.simd, &mut self.lanes);
        let KernelScene { visible, beside, .. } = self.frame.scene;
        let Some(blocks) = Table::new(&visible.blocks) else { return 0 };
        let blocks = simd.gather_u32(blocks, lanes.triangles) | *beside;
        let (exit, place) = self.layers.exits(simd, lanes, entered);
        let (low, high) = (lanes.gap.min(exit), lanes.gap.max(exit));
        let most = number(simd, u32::MAX);
        let (first, last) = (((low - 1) >> visible.shift).min(31), ((high - 1) >> visible.shift).min(31));
        let between = (most << first) & (most >> (number(simd, 31) - last));
        let is_beyond = low.simd_eq(0) | high.simd_eq(self.frame.packets.shell.layers() as u32);
        let skipped = entered & !((blocks & between).simd_ne(0) | is_beyond);
        lanes.gap = skipped.select(exit, lanes.gap);
        if let Some(place) = place {
            lanes.place = skipped.select(place, lanes.place);
        }
        skipped.to_bitmask() as u32
    }

    /// Moves lanes out of invisible gaps.
    #[inline(always)]
    fn skip(&mut self) {
        let (hidden, scene) = (self.hidden(), self.frame.scene);
        for lane in lanes_of(hidden) {
            let blocks = scene.blocks_over(self.lanes.triangles[lane]);
            if self.layers.skip(&mut self.lanes, lane, blocks, scene.visible.shift) {
                self.leave(1 << lane);
            }
        }
    }

    /// Lanes that are about to enter an invisible frustum.
    #[inline(always)]
    fn hidden(&self) -> u32 {
        let KernelScene { visible, beside, .. } = self.frame.scene;
        let Some(blocks) = Table::new(&visible.blocks) else { return 0 };
        let below = self.lanes.gap - 1;
        let inside = below.simd_lt(self.frame.packets.shell.layers() as u32 - 1);
        let blocks = self.simd.gather_u32(blocks, self.lanes.triangles) | *beside;
        let shown = ((blocks >> (below >> visible.shift)) & 1).simd_ne(0);
        (inside & !shown).to_bitmask() as u32 & self.live & !self.fresh & !self.mid & !self.ended
    }

    /// Processes lanes at the exits of their columns.
    #[inline(always)]
    fn leave(&mut self, lanes: u32) {
        let last = self.lanes.last.to_bitmask() as u32;
        self.ended |= lanes & last;
        self.exited |= lanes & last;
        self.fresh |= lanes & !last;
    }

    /// Moves all lanes through their gaps, by a piece of their frusta each.
    #[inline(always)]
    fn gaps(&mut self) {
        let simd = self.simd;
        let active = self.live & !self.fresh & !self.ended;
        let crossing = self.layers.cross(simd, &self.lanes);
        let below = (self.lanes.gap - 1).simd_lt(self.frame.packets.shell.layers() as u32 - 1);
        let inside = below.to_bitmask() as u32 & active;
        let mut done = active;
        if self.frame.scene.core.is_some() {
            let core = self.lanes.gap.simd_eq(0).to_bitmask() as u32 & active;
            for lane in lanes_of(core) {
                let [t0, t1] = [0, 1].map_inline(|k: usize| self.lanes.t[k].get(lane));
                let u = self.lanes.u.get(lane);
                self.meet_core(lane, &CoreHit { t: lerp(t0, t1, u), u: Some(u) });
            }
            done &= !core;
        }
        let inside = if L::HAS_SCENE { self.scene_frusta(&crossing, inside) } else { inside };
        if inside != 0 {
            match &self.volumes {
                Some(_) if L::HAS_SCENE => self.several_frusta(&crossing, inside),
                _ => self.frusta(&crossing, inside),
            }
        }
        done &= !self.mid & !self.ended;
        let passes = crossing.passes.to_bitmask() as u32;
        if L::HAS_SCENE {
            self.scene_layers(&crossing, done & passes);
            done &= !self.ended;
        }
        let (passing, leaving) = (done & passes, done & !passes);
        let (passed, left) = (mask::<V>(simd, passing), mask::<V>(simd, leaving));
        self.layers.pass(simd, &mut self.lanes, &crossing, passed, left);
        if self.stepped != 0 {
            self.look_ahead();
        }
        self.leave(leaving);
    }

    /// Reports the rays that have ended.
    #[inline(never)]
    fn finish(&mut self, target: &mut Target) {
        if self.tables.deviations.is_some() {
            self.settle_color(mask::<V>(self.simd, self.ended));
        }
        for lane in lanes_of(self.ended) {
            let Some(start) = self.starts[lane].take() else { continue };
            match target {
                Target::Light(report) => report(start.number, Some(self.lanes.light(lane).wide()), start.surfaces),
                Target::Fragments(_, report) => self.finish_runs(lane, &start, report),
            }
        }
        self.exited = 0;
        self.live &= !self.ended;
        self.fresh &= !self.ended;
        self.mid &= !self.ended;
        self.ended = 0;
    }

    /// The ray in a lane for scalar code, with its light.
    fn ray(&self, lane: usize) -> Option<VolumeRay<'p, f32>> {
        let start = self.starts[lane]?;
        let mut ray = VolumeRay::new(&self.frame.packets.spans, self.frame.rays, start.dir);
        ray.light = self.lanes.light(lane);
        ray.min_transmittance = self.min_transmittance[lane];
        ray.size = self.lanes.size[lane];
        Some(ray)
    }
}

/// The mask of these lanes.
#[inline(always)]
fn mask<V: Machine>(simd: V, bits: u32) -> Mask<V> {
    <Mask<V> as SimdMask<V>>::from_bitmask(simd, u64::from(bits))
}
