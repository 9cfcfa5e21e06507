//! Packets in a scene of more than one volume: if a ray meets an isosurface, a surface on a layer or at a radius, or a
//! bound of a cut, a [single ray](crate::general) takes it through that frustum, in double precision. All other
//! frusta contain only the volume. So the cost of other parts of a scene depends on how often rays meet them.

use super::lanes::{Lanes, lanes_of};
use super::layers::{CoreHit, Crossing, Layers};
use super::packet_scene::PacketScene;
use super::part::{Part, all};
use super::read::{Source, Vertices};
use super::start::Start;
use super::{MOST, Packet};
use crate::column::Flow;
use crate::counts::Counts;
use crate::general::{FacetSide, Met, RaySettings, RayState, SurfaceHeight};
use crate::piece::Radiance;
use crate::walk::{Column, ColumnEnd};
use fearless_simd::prelude::*;
use icoray_grid::array::MapInline;
use icoray_simd::{Floats, Machine, Numbers, Table, Wide};

/// The visible parts of a scene beside the volume.
pub(super) struct SceneTables<'t> {
    tracer: &'t RaySettings<'t, 't>,
    /// The fields with isosurfaces, and the values of these.
    isosurfaces: Vec<(Source<'t>, Vec<f32>)>,
    /// The layers with surfaces.
    layers: Vec<u32>,
    /// The radii of surfaces between layers.
    radii: Vec<f64>,
    clips: Option<ClipTables<'t>>,
}

/// The cuts, a bit each.
#[derive(Clone, Copy)]
struct ClipTables<'t> {
    of_gaps: Table<'t, u32>,
    inside_out: u32,
    all: u32,
}

impl<'t> SceneTables<'t> {
    /// The tables of a scene; `None` if they are too long for gathers.
    pub fn new(tracer: &'t RaySettings<'t, 't>, packets: &'t PacketScene<'_>) -> Option<Self> {
        let scene = tracer.scene;
        let mut isosurfaces = Vec::new();
        for (number, source) in scene.sources.iter().enumerate() {
            let here = scene.isosurfaces.iter().filter(|surface| surface.source == number);
            let values: Vec<f32> = here.map(|surface| surface.value as f32).collect();
            if !values.is_empty() {
                isosurfaces.push((Source::new(&source.field, [0.0, 1.0]), values));
            }
        }
        let (mut layers, mut radii) = (Vec::new(), Vec::new());
        for surface in &scene.surface_layers {
            match surface.place {
                SurfaceHeight::Layer(layer) => layers.push(layer as u32),
                SurfaceHeight::Radius(radius) => radii.push(radius),
            }
        }
        layers.sort_unstable();
        layers.dedup();
        let clips = match scene.clips.regions().len() {
            0 => None,
            count => Some(ClipTables {
                of_gaps: Table::new(&packets.clips_of_gaps)?,
                inside_out: scene.clips.inside_out(),
                all: u32::MAX >> (u32::BITS as usize - count),
            }),
        };
        Some(SceneTables { tracer, isosurfaces, layers, radii, clips })
    }
}

/// The rays of a packet as single rays.
pub(super) struct SceneLanes<'p, V: Machine> {
    tables: &'p SceneTables<'p>,
    rays: [Option<RayState<'p, 'p>>; MOST],
    /// Lanes in space that is cut away.
    cut: u32,
    /// The bits of the cuts that contain each lane, regardless of layers, and the distance up to which it stays in
    /// them.
    inside: Numbers<V>,
    next_bound: Wide<V>,
}

/// Lanes that a cut affects.
#[derive(Clone, Copy, Default)]
struct ClippedLanes {
    /// Lanes whose frusta are cut away as a whole.
    hidden: u32,
    /// Lanes that meet a bound.
    met: u32,
}

impl<'p, V: Machine> SceneLanes<'p, V> {
    /// No rays.
    #[inline(always)]
    pub fn new(simd: V, tables: &'p SceneTables<'p>) -> Self {
        SceneLanes {
            tables,
            rays: [const { None }; MOST],
            cut: 0,
            inside: super::medium::number(simd, 0),
            next_bound: Wide::splat(simd, 0.0),
        }
    }

    /// Continues the rays of these lanes as new fragments.
    #[inline]
    pub fn restart(&mut self, lanes: u32) {
        self.cut &= !lanes;
    }

    /// Puts a ray into a lane.
    #[inline]
    pub fn begin(&mut self, lane: usize, start: &Start) {
        let ended = self.rays[lane].take();
        let ray = RayState::begin(self.tables.tracer, start.line, (start.dir, start.from_eye), ended);
        self.rays[lane] = Some(ray);
        self.cut &= !(1 << lane);
        self.next_bound.set(lane, f64::NEG_INFINITY);
    }

    /// The effect of cuts on the frusta of the lanes `new`.
    #[inline(always)]
    fn clip<E>(&mut self, simd: V, lanes: &Lanes<V>, crossing: &Crossing<V, E>, new: u32) -> ClippedLanes {
        let Some(clips) = self.tables.clips else { return ClippedLanes::default() };
        let length = lanes.t[1] - lanes.t[0];
        let (start, end) = (lanes.t[0] + length * lanes.u, lanes.t[0] + length * crossing.u);
        let passed = self.next_bound.le(start).narrow().to_bitmask() as u32 & new;
        for lane in lanes_of(passed) {
            let Some(ray) = &self.rays[lane] else { continue };
            let (inside, next_bound) = ray.cuts_behind(start.get(lane));
            self.inside[lane] = inside;
            self.next_bound.set(lane, next_bound);
        }
        let met = self.next_bound.lt(end).narrow().to_bitmask() as u32 & new;
        let here = self.inside & simd.gather_u32(clips.of_gaps, lanes.gap);
        let shown = (here ^ clips.inside_out) & clips.all;
        let hidden = shown.simd_ne(clips.all).to_bitmask() as u32 & new & !met;
        // The first visible frustum behind a cut has the cut's face.
        let met = met | self.cut & new & !hidden;
        self.cut |= hidden;
        ClippedLanes { hidden, met }
    }

    /// Lanes whose frusta may contain a surface at a radius.
    #[inline(always)]
    fn at_radii<E>(&self, simd: V, lanes: &Lanes<V>, crossing: &Crossing<V, E>) -> u32 {
        /// More than the rounding of a radius.
        const SLACK: f64 = 1e-12;
        let rise = lanes.rho[1] - lanes.rho[0];
        let [from, to] = [lanes.rho[0] + lanes.u * rise, lanes.rho[0] + crossing.u * rise];
        let mut met = 0;
        for radius in &self.tables.radii {
            let [low, high] = [radius * (1.0 - SLACK), radius * (1.0 + SLACK)].map_inline(|r| Wide::splat(simd, r));
            let is_below = from.lt(low).narrow() & to.lt(low).narrow();
            let is_above = high.lt(from).narrow() & high.lt(to).narrow();
            met |= (!(is_below | is_above)).to_bitmask() as u32;
        }
        met
    }

    /// Lanes whose frusta may contain an isosurface.
    #[inline(always)]
    fn at_isosurfaces<L: Layers>(&self, simd: V, lanes: &Lanes<V>, crossing: &Crossing<V, L::End<V>>, new: u32) -> u32 {
        let mut met = 0;
        let way = L::way(lanes, crossing);
        for (source, values) in &self.tables.isosurfaces {
            let [a, b, c] = lanes.cells;
            let bases = [source.bases(simd, a, new), source.bases(simd, b, new), source.bases(simd, c, new)];
            let vertices = source.read(simd, lanes, bases, new);
            let [f0, f1, kappa] = source.normalised(simd, &vertices, &way);
            let course = Part { f0, f1, kappa, eps: crossing.eps, length: crossing.length };
            let [low, high] = range(simd, &vertices, &course);
            for value in values {
                let value = all(simd, *value);
                met |= (low.simd_le(value) & value.simd_le(high)).to_bitmask() as u32;
            }
        }
        met
    }
}

/// A range that contains all values along each frustum, slightly widened.
#[inline(always)]
fn range<V: Machine>(simd: V, vertices: &Vertices<V>, course: &Part<V>) -> [Floats<V>; 2] {
    /// More than the rounding of a value to single precision.
    const SLACK: f32 = 16.0 * f32::EPSILON;
    /// [`Part::within`] bounds the values of frusta with a larger ε.
    const LEAST_EPS: f32 = -0.7;
    let Vertices { low: [a, b, c], high: [d, e, f] } = *vertices;
    let low = a.min(b).min(c).min(d.min(e).min(f));
    let high = a.max(b).max(c).max(d.max(e).max(f));
    let slack = low.abs().max(high.abs()) * SLACK;
    let is_round = course.eps.simd_gt(all(simd, LEAST_EPS));
    let [least, most] = course.within();
    let (least, most) = (is_round.select(least.max(low), low), is_round.select(most.min(high), high));
    [least - slack, most + slack]
}

impl<V: Machine, L: Layers, const N: usize> Packet<'_, '_, V, L, N> {
    /// Moves the lanes `inside` gaps through those new frusta in which they meet more than the volume, or in which all
    /// is cut away; returns the others, which contain only the volume.
    #[inline(always)]
    pub(super) fn scene_frusta(&mut self, crossing: &Crossing<V, L::End<V>>, inside: u32) -> u32 {
        let new = inside & !self.mid;
        let Some(scene) = self.scene.as_mut().filter(|_| new != 0) else { return inside };
        let ClippedLanes { hidden, mut met } = scene.clip(self.simd, &self.lanes, crossing, new);
        let tables = scene.tables;
        if !tables.radii.is_empty() {
            met |= scene.at_radii(self.simd, &self.lanes, crossing);
        }
        if !tables.isosurfaces.is_empty() {
            met |= scene.at_isosurfaces::<L>(self.simd, &self.lanes, crossing, new);
        }
        met &= new & !hidden;
        for lane in lanes_of(met) {
            self.scene_frustum(lane, crossing);
        }
        let gone = if tables.tracer.scene.media.is_empty() { inside } else { hidden | met };
        self.counts.frusta += u64::from((gone & new).count_ones());
        inside & !gone
    }

    /// Moves those lanes that are `passing` layers with surfaces through these.
    #[inline(always)]
    pub(super) fn scene_layers(&mut self, crossing: &Crossing<V, L::End<V>>, passing: u32) {
        let Some(scene) = &self.scene else { return };
        let tables = scene.tables;
        if tables.layers.is_empty() {
            return;
        }
        let gap = self.lanes.gap;
        let met = L::rising(&self.lanes, crossing).select(gap, gap - 1);
        for layer in &tables.layers {
            let here = met.simd_eq(*layer).to_bitmask() as u32 & passing;
            for lane in lanes_of(here) {
                let u = crossing.u.get(lane);
                self.follow(lane, |ray, column, triangle| ray.pass_layer(column, triangle, *layer as usize, u));
            }
        }
    }

    /// Moves a lane through a frustum in which it meets more than the volume.
    #[inline(never)]
    pub(super) fn scene_frustum(&mut self, lane: usize, crossing: &Crossing<V, L::End<V>>) {
        let (lanes, gap) = (&self.lanes, self.lanes.gap[lane] as usize);
        let from = match lanes.place[lane] {
            0.0 => FacetSide::Lower,
            1.0 => FacetSide::Upper,
            _ => FacetSide::Between,
        };
        let to = match (crossing.passes.test(lane), L::rising(lanes, crossing).test(lane)) {
            (false, _) => FacetSide::Between,
            (true, true) => FacetSide::Upper,
            (true, false) => FacetSide::Lower,
        };
        let ends = [(lanes.u.get(lane), from), (crossing.u.get(lane), to)];
        self.follow(lane, |ray, column, triangle| ray.pass_gap(column, triangle, (gap, ends)));
    }

    /// Meets the core in a scene.
    pub(super) fn scene_core(&mut self, lane: usize, hit: &CoreHit) {
        self.follow(lane, |ray, column, triangle| {
            match hit.u {
                Some(u) => ray.meet_core(column, triangle, u),
                None => ray.meet_round_core(hit.t),
            }
            Flow::Stop
        });
    }

    /// Continues a lane's ray as a single ray.
    #[inline(never)]
    fn follow(&mut self, lane: usize, step: impl FnOnce(&mut RayState, &Column, u32) -> Flow) {
        let column = self.lanes.column(lane);
        let triangle = self.lanes.triangles[lane];
        let (Some(scene), Some(start)) = (&mut self.scene, &mut self.starts[lane]) else { return };
        let Some(ray) = &mut scene.rays[lane] else { return };
        let bit = 1 << lane;
        let light = self.lanes.light(lane).wide();
        let min_transmittance = f64::from(self.min_transmittance[lane]);
        ray.go_on(Met { light, surfaces: start.surfaces, is_cut: scene.cut & bit != 0 }, min_transmittance);
        if step(ray, &column, triangle) == Flow::Stop {
            self.ended |= bit;
        }
        let Counts { void_frusta, .. } = ray.take_counts();
        self.counts.void_frusta += void_frusta;
        self.counts.scalar_pieces += 1;
        let Met { light, surfaces, is_cut } = ray.met_so_far();
        start.surfaces = surfaces;
        scene.cut = scene.cut & !bit | u32::from(is_cut) << lane;
        self.lanes.put_light(lane, &narrow(&light));
    }
}

/// Converts light to single precision.
#[inline]
fn narrow(light: &Radiance<f64>) -> Radiance<f32> {
    let off = light.alpha * f64::from(0.25 * f32::EPSILON);
    Radiance {
        color: light.color.map_inline(|c| c as f32),
        alpha: light.alpha as f32,
        error: light.error as f32,
        variance: (light.variance + off * off) as f32,
        shade_variance: light.shade_variance as f32,
    }
}

impl<V: Machine> Lanes<V> {
    /// The column that contains a lane's ray.
    fn column(&self, lane: usize) -> Column {
        let [entry, exit] = [0, 1].map_inline(|k: usize| ColumnEnd {
            t: self.t[k].get(lane),
            rho: self.rho[k].get(lane),
            weight: self.wide_weights[k].map_inline(|row| row.get(lane)),
        });
        Column { cells: self.cells.map_inline(|row| row[lane]), entry, exit }
    }
}
