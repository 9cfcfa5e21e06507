//! The frusta of a packet in a scene of several volumes, or of one whose opacity is that of another field: a piece of
//! each per turn, up to the next knot of any of the transfer functions.

use super::blend::{Blend, VolumeNodes, VolumePiece};
use super::cut::{Cutter, Pieces};
use super::integral::LARGEST_EPS;
use super::lanes::{Lanes, lanes_of};
use super::layers::{Crossing, Layers};
use super::light::{GradientCourse, Slopes};
use super::medium::{Medium, SpanTables, number};
use super::packet_scene::PacketVolumes;
use super::part::{Part, all};
use super::read::{FAR, LARGEST, Source};
use super::{Packet, mask};
use crate::general::RaySettings;
use fearless_simd::prelude::*;
use icoray_simd::{Floats, Machine, Mask};

/// The tables of the volumes of a scene.
pub(super) struct VolumeTables<'t> {
    /// Transfer functions with their fields.
    maps: Vec<(&'t Source<'t>, SpanTables<'t>)>,
    volumes: Vec<VolumeTable<'t>>,
}

/// A volume: the numbers of the maps of its extinction and of its colour, and the gradients of the former's field.
struct VolumeTable<'t> {
    extinction: usize,
    color: usize,
    slopes: Slopes<'t>,
}

impl<'t> VolumeTables<'t> {
    /// The tables of volumes between this number of layers, with the gradients of each if there is light; `None` if
    /// they are too long for gathers.
    pub fn new(volumes: &'t PacketVolumes<'_>, general: &'t RaySettings<'_, '_>, layers: usize) -> Option<Self> {
        let mut maps = Vec::new();
        for map in &volumes.maps {
            maps.push((&map.source, SpanTables::new(&map.spans)?));
        }
        let mut tables = Vec::new();
        for ([extinction, color], medium) in volumes.maps_of.iter().copied().zip(&general.scene.media) {
            let gradients = general.scene.sources[medium.extinction.source].gradients.values();
            let slopes = match general.shading {
                Some(_) => Slopes::new(gradients, layers)?,
                None => Slopes::None,
            };
            tables.push(VolumeTable { extinction, color, slopes });
        }
        Some(VolumeTables { maps, volumes: tables })
    }
}

/// The frusta of a packet's lanes in several fields.
pub(super) struct VolumeLanes<'p, V: Machine> {
    tables: &'p VolumeTables<'p>,
    maps: Vec<MapLanes<V>>,
    /// The gradients along the frusta, of each volume.
    courses: Vec<GradientCourse<V>>,
    nodes: Vec<VolumeNodes<V>>,
}

/// The values of a map along each lane's frustum.
struct MapLanes<V: Machine> {
    /// The rest of the frustum, and whether the scalar is monotone there.
    rest: Part<V>,
    is_monotone: Mask<V>,
    /// Lanes without missing values.
    is_there: Mask<V>,
    /// The largest magnitude of values at the vertices.
    size: Floats<V>,
    pieces: Pieces<V>,
    medium: Medium<V>,
}

impl<V: Machine> MapLanes<V> {
    /// Lanes whose pieces have no extinction.
    #[inline(always)]
    fn is_dark(&self) -> Mask<V> {
        self.medium.extinction.simd_le(0.0) & self.medium.slope.simd_eq(0.0)
    }
}

impl<'p, V: Machine> VolumeLanes<'p, V> {
    /// No rays.
    #[inline(always)]
    pub fn new(simd: V, tables: &'p VolumeTables<'p>) -> Self {
        let no = <Mask<V> as SimdMask<V>>::splat(simd, false);
        let (part, span, size) = (Part::none(simd), number(simd, 0), all(simd, 1.0));
        let mut maps = Vec::new();
        for (_, spans) in &tables.maps {
            let cutter = Cutter { simd, spans, is_monotone: no, size };
            let (pieces, medium) = (cutter.whole(part, span), spans.medium(simd, span));
            maps.push(MapLanes { rest: part, is_monotone: no, is_there: no, size, pieces, medium });
        }
        let mut courses = Vec::new();
        courses.resize_with(tables.volumes.len(), || GradientCourse::none(simd));
        VolumeLanes { tables, maps, courses, nodes: Vec::with_capacity(tables.volumes.len()) }
    }

    /// Reads the frusta of the lanes `new`; returns those with values beyond all bounds, and those in which every
    /// volume misses a value.
    #[inline(always)]
    fn enter<L: Layers>(&mut self, simd: V, lanes: &Lanes<V>, crossing: &Crossing<V, L::End<V>>, new: u32) -> [u32; 2] {
        let is_new = mask::<V>(simd, new);
        let way = L::way(lanes, crossing);
        let [a, b, c] = lanes.cells;
        let mut beyond = 0;
        for (map, (source, spans)) in self.maps.iter_mut().zip(&self.tables.maps) {
            let bases = [source.bases(simd, a, new), source.bases(simd, b, new), source.bases(simd, c, new)];
            let vertices = source.read(simd, lanes, bases, new);
            let [f0, f1, kappa] = source.normalised(simd, &vertices, &way);
            let read = Part { f0, f1, kappa, eps: crossing.eps, length: crossing.length };
            let mut is_there = !source.not_finite(simd, &vertices);
            if let Some(missing) = source.missing(simd, &vertices) {
                is_there &= !missing;
            }
            let is_usual =
                (f0.abs() + f1.abs() + kappa.abs()).simd_le(LARGEST) & crossing.eps.abs().simd_lt(LARGEST_EPS);
            beyond |= (is_there & !is_usual).to_bitmask() as u32 & new;
            map.rest = read.over(is_new, map.rest);
            map.is_monotone &= !is_new;
            map.is_there = is_new.select(is_there, map.is_there);
            let size = source.size(simd, &vertices).max(all(simd, if spans.has_steps { 0.0 } else { 1.0 }));
            beyond |= (is_there & size.simd_gt(FAR)).to_bitmask() as u32 & new;
            map.size = is_new.select(size, map.size);
        }
        let there = self.tables.volumes.iter().fold(0, |there, volume| there | self.there(volume).to_bitmask() as u32);
        [beyond, new & !there]
    }

    /// Lanes in whose frusta no value of a volume is missing.
    #[inline(always)]
    fn there(&self, volume: &VolumeTable) -> Mask<V> {
        self.maps[volume.extinction].is_there & self.maps[volume.color].is_there
    }

    /// The pieces of `active` lanes, which end at the first knot of any map, or at `fraction` of that; returns this
    /// place, and the lanes with steps of transfer functions, which only scalar code crosses.
    #[inline(always)]
    fn cut(&mut self, simd: V, [active, new]: [u32; 2], fraction: Floats<V>) -> (Floats<V>, u32) {
        let one = all(simd, 1.0);
        let mut steps = 0;
        for (map, (_, spans)) in self.maps.iter_mut().zip(&self.tables.maps) {
            let cutter = Cutter { simd, spans, is_monotone: map.is_monotone, size: map.size };
            let there = active & map.is_there.to_bitmask() as u32;
            map.pieces = cutter.pieces(map.rest, map.pieces.span, [there, new], &mut steps);
            map.medium = spans.medium(simd, map.pieces.span);
        }
        let mut upto = one;
        for volume in &self.tables.volumes {
            let (is_there, extinction) = (self.there(volume), &self.maps[volume.extinction]);
            upto = is_there.select(upto.min(extinction.pieces.upto), upto);
            if volume.color != volume.extinction {
                let color = &self.maps[volume.color];
                upto = (is_there & !extinction.is_dark()).select(upto.min(color.pieces.upto), upto);
            }
        }
        let upto = upto * fraction;
        for map in &mut self.maps {
            let is_other = !map.pieces.upto.simd_eq(upto);
            if is_other.any_true() {
                map.pieces.end_at(simd, &map.rest, upto, (is_other, map.is_monotone));
            }
        }
        (upto, steps)
    }

    /// Reads the gradients along the frusta of the lanes `new`, for the volumes that are visible in any of them.
    /// Returns the lanes whose normals require double precision.
    #[inline(always)]
    fn enter_light<L: Layers>(
        &mut self,
        simd: V,
        lanes: &Lanes<V>,
        crossing: &Crossing<V, L::End<V>>,
        new: u32,
    ) -> u32 {
        let mut scalar = 0;
        for (volume, course) in self.tables.volumes.iter().zip(&mut self.courses) {
            let map = &self.maps[volume.extinction];
            let is_dark = map.is_dark() & map.pieces.upto.simd_eq(1.0);
            let seen = new & (!is_dark).to_bitmask() as u32;
            if seen != 0 {
                let read = volume.slopes.read(simd, lanes, &L::way(lanes, crossing));
                course.put(mask::<V>(simd, new), &read);
                scalar |= read.is_cancelled().to_bitmask() as u32 & seen;
            }
        }
        scalar
    }

    /// The volumes that are visible in any of the `active` lanes, at the places of the pieces; returns false if there
    /// are none.
    #[inline(always)]
    fn find_nodes(&mut self, simd: V, active: u32) -> bool {
        self.nodes.clear();
        for (number, volume) in self.tables.volumes.iter().enumerate() {
            let (extinction, color) = (&self.maps[volume.extinction], &self.maps[volume.color]);
            let is_seen = extinction.is_there & color.is_there & !extinction.is_dark();
            if is_seen.to_bitmask() as u32 & active == 0 {
                continue;
            }
            let piece = VolumePiece {
                extinction: (&extinction.pieces.part, &extinction.medium),
                color: (&color.pieces.part, &color.medium),
                sizes: [extinction.size, color.size],
                is_seen,
            };
            self.nodes.push(VolumeNodes::new(simd, number, &piece));
        }
        !self.nodes.is_empty()
    }

    /// Continues behind the pieces of the lanes of `more`.
    #[inline(always)]
    fn go_on(&mut self, more: Mask<V>) {
        for map in &mut self.maps {
            map.rest = map.pieces.rest.over(more, map.rest);
            map.is_monotone = more.select(map.pieces.is_monotone, map.is_monotone);
        }
    }
}

impl<V: Machine, L: Layers, const N: usize> Packet<'_, '_, V, L, N> {
    /// [`Packet::frusta`] in several fields.
    #[inline(always)]
    pub(super) fn several_frusta(&mut self, crossing: &Crossing<V, L::End<V>>, inside: u32) {
        let simd = self.simd;
        let Some(volumes) = &mut self.volumes else { return };
        let new = inside & !self.mid;
        self.counts.frusta += u64::from(new.count_ones());
        let (mut active, mut scalar) = (inside, 0);
        if new != 0 {
            self.lit.enter(simd, mask::<V>(simd, new), crossing.eps);
            let [beyond, void] = volumes.enter::<L>(simd, &self.lanes, crossing, new);
            self.counts.void_frusta += u64::from(void.count_ones());
            (active, scalar) = (active & !void, beyond);
        }
        self.mid = 0;
        if !self.frame.integrates {
            return;
        }
        let (upto, steps) = volumes.cut(simd, [active, new], self.lit.fraction);
        scalar |= steps;
        active &= !scalar;
        if N == 4 {
            scalar |= volumes.enter_light::<L>(simd, &self.lanes, crossing, new & active);
            active &= !scalar;
        }
        let from = self.lit.from;
        let to = upto.mul_add(all(simd, 1.0) - from, from);
        let (mut left, mut shown) = (0, None);
        if volumes.find_nodes(simd, active) {
            let shading = self.shading.as_ref().filter(|_| N == 4);
            let lighting = shading.map(|shading| (&self.lit, shading, volumes.courses.as_slice(), [from, to]));
            let blend = Blend::of(simd, &mut volumes.nodes, lighting, self.frame.rays.is_coarse);
            let has_room = self.lit.may_halve(to) & (to - from).simd_gt(LEAST_PART);
            let is_far = blend.is_far(simd, &self.lanes, self.color_tolerance, N == 4);
            left = (is_far & has_room).to_bitmask() as u32 & active;
            shown = Some(blend);
        }
        let taken = active & !left;
        let more = taken & upto.simd_lt(1.0).to_bitmask() as u32;
        volumes.go_on(mask::<V>(simd, more));
        if let Some(Blend { light, absorbs, .. }) = shown {
            self.lanes.add(simd, mask::<V>(simd, taken) & absorbs, &light);
        }
        self.mid = more | left;
        self.lit.go_on(simd, mask::<V>(simd, taken), mask::<V>(simd, left), to);
        for lane in lanes_of(scalar) {
            self.scene_frustum(lane, crossing);
        }
        self.end(active);
    }
}

/// A piece that is no longer than this fraction of its frustum is taken as it is: if the extinction of all volumes goes
/// to zero towards its end, colours differ in any part of it.
pub(super) const LEAST_PART: f32 = 1e-5;
