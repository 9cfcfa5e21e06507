//! What a ray meets between two layers of a column, in order.

use super::blend::{Blend, Memory, Part};
use super::surfaces::{Coat, SheetPlace};
use super::wedge::{Facet, On, Place, Wedge};
use super::{Run, World};
use crate::array::MapInline;
use crate::ground::Sight;
use crate::kernel::column::Flow;
use crate::kernel::piece::Light;
use crate::kernel::real::lerp;
use crate::kernel::segment::Segment;
use crate::kernel::signature::Boundary;

/// What is known of the frustum that a ray is in; memory that is used again for the next.
#[derive(Debug, Default)]
pub(super) struct Scratch<'w> {
    /// Each field's values at the vertices, on the lower and upper facet; empty where they were not read yet.
    values: [Vec<[f64; 3]>; 2],
    /// Least and greatest value of each field there; none where one is missing.
    ranges: Vec<Option<[f64; 2]>>,
    /// Of the fields that are asked for, along the part of the frustum that is shown.
    segments: Vec<Option<Segment<f64>>>,
    /// The places that part it.
    breaks: Vec<Break>,
    parts: Vec<Part<'w>>,
    /// The number of each medium that may be seen.
    media: Vec<usize>,
    /// The courses of each field's gradient along it, axis by axis, where they were asked for.
    gradients: Vec<Option<[Segment<f64>; 3]>>,
    blend: Memory,
}

/// A ray's way through a frustum, or a part of it: its start, middle and end.
struct Way {
    places: [Place; 3],
    /// The relative change of a value's denominator.
    eps: f64,
    length: f64,
}

impl Way {
    #[inline]
    fn new(places: [Place; 3], length: f64) -> Self {
        let [start, _, end] = &places;
        let eps = if start.depth > 0.0 { end.depth / start.depth - 1.0 } else { 0.0 };
        // Where facets meet the value has no limit of its own; near there its course is as good as straight.
        let eps = if eps.is_finite() { eps.max(-1.0 + 1e-9) } else { 0.0 };
        Way { places, eps, length }
    }

    /// The course of what has these values at the vertices of the lower and upper facet.
    #[inline]
    fn course(&self, vertices: [&[f64; 3]; 2]) -> Segment<f64> {
        let Way { ref places, eps, length } = *self;
        let [f0, half, f1] = [&places[0], &places[1], &places[2]].map_inline(|place| place.value(vertices));
        let kappa = (half - 0.5 * (f0 + f1)) * 4.0 * (1.0 + 0.5 * eps);
        // Of values without any difference rounding makes no bend.
        let kappa = if f0 == f1 && half == f0 { 0.0 } else { kappa };
        Segment { f0, f1, kappa, eps, length }
    }
}

#[derive(Debug, Clone, Copy)]
struct Break {
    u: f64,
    meets: Option<Meets>,
}

#[derive(Debug, Clone, Copy)]
enum Meets {
    Isosurface(usize),
    Sheet(usize),
}

impl Scratch<'_> {
    /// In a new column.
    #[inline]
    pub fn forget(&mut self) {
        self.values.iter_mut().for_each(Vec::clear);
    }

    /// Through a layer: what was above is below, or the other way round.
    #[inline]
    pub fn shift(&mut self, rises: bool) {
        self.values.swap(0, 1);
        self.values[usize::from(rises)].clear();
    }

    #[inline]
    fn read(&mut self, world: &World, wedge: &Wedge, gap: usize) {
        for (layer, values) in [gap - 1, gap].into_iter().zip(&mut self.values) {
            if values.is_empty() {
                for source in &world.sources {
                    values.push(source.at(wedge.cells, layer));
                }
            }
        }
        let [lower, upper] = &self.values;
        self.ranges.clear();
        for k in 0..lower.len() {
            let (a, b) = (&lower[k], &upper[k]);
            let [a0, a1, a2] = *a;
            let [b0, b1, b2] = *b;
            let is_known = a.iter().all(|value| value.is_finite()) && b.iter().all(|value| value.is_finite());
            let low = a0.min(a1).min(a2).min(b0.min(b1).min(b2));
            let high = a0.max(a1).max(a2).max(b0.max(b1).max(b2));
            self.ranges.push(is_known.then_some([low, high]));
        }
    }
}

impl<'r> Run<'r, '_> {
    /// Passes `gap` from one place of the column to another.
    #[inline]
    pub(super) fn gap(
        &mut self,
        wedge: &Wedge,
        (gap, facets): (usize, [&Facet; 2]),
        [(a, from), (b, to)]: [(f64, On); 2],
    ) -> Flow {
        if b <= a {
            return Flow::On;
        }
        self.counts.frusta += 1;
        let world = self.world;
        self.scratch.read(world, wedge, gap);
        let ranges = &self.scratch.ranges;
        self.scratch.media.clear();
        self.scratch.media.extend((0..world.media.len()).filter(|&number| {
            let medium = &world.media[number];
            let range = ranges[medium.extinction.source].filter(|_| ranges[medium.color.source].is_some());
            range.is_some_and(|[low, high]| !medium.extinction.is_clear_between(low, high))
        }));
        let meets_isosurface = world.isosurfaces.iter().any(|surface| {
            ranges[surface.source].is_some_and(|[low, high]| low <= surface.value && surface.value <= high)
        });
        let has_radii = world.sheets.iter().any(|sheet| matches!(sheet.place, SheetPlace::Radius(_)));
        if self.scratch.media.is_empty() && !meets_isosurface && !has_radii {
            self.counts.void_frusta += u64::from(ranges.iter().all(Option::is_none));
            return Flow::On;
        }
        if self.clips.is_empty() {
            let length = wedge.distance(b) - wedge.distance(a);
            return self.part(wedge, (gap, facets), [(a, from), (b, to)], length);
        }
        let (mut shown, ends) = (Vec::new(), [a, b].map_inline(|u| wedge.distance(u)));
        self.clips.parts([gap - 1, gap], ends, |part| {
            shown.push(part);
            true
        });
        let mut reached = ends[0];
        for [t0, t1] in shown {
            if (self.is_cut || t0 > reached) && !self.scratch.media.is_empty() {
                self.meets(Boundary::CutFace, t0);
            }
            (reached, self.is_cut) = (t1, false);
            let end = |t: f64, (u, on): (f64, On)| {
                if t == wedge.distance(u) { (u, on) } else { (wedge.fraction(t), On::Between) }
            };
            let ends = [end(t0, (a, from)), end(t1, (b, to))];
            if self.part(wedge, (gap, facets), ends, t1 - t0) == Flow::Stop {
                return Flow::Stop;
            }
        }
        self.is_cut |= reached < ends[1];
        Flow::On
    }

    /// The shown part of a frustum between two places of the column, `length` apart.
    #[inline]
    fn part(
        &mut self,
        wedge: &Wedge,
        (gap, facets): (usize, [&Facet; 2]),
        [(a, from), (b, to)]: [(f64, On); 2],
        length: f64,
    ) -> Flow {
        let place = |u: f64, on: On| Place::new(wedge, facets, u, on);
        let way = Way::new([place(a, from), place(0.5 * (a + b), On::Between), place(b, to)], length);
        self.segments(&way);
        self.breaks(wedge, [a, b]);
        let mut breaks = std::mem::take(&mut self.scratch.breaks);
        breaks.sort_by(|one, other| one.u.total_cmp(&other.u));
        let mut done = 0.0;
        let mut flow = Flow::On;
        for Break { u, meets } in &breaks {
            if *u > done {
                flow = self.piece(wedge, gap, &way, [done, *u]);
                done = *u;
            }
            if let (Flow::On, Some(meets)) = (flow, meets) {
                flow = self.meet(wedge, (gap, facets), [a, b], (*u, *meets));
            }
            if flow == Flow::Stop {
                break;
            }
        }
        self.scratch.breaks = breaks;
        flow
    }

    /// Each field's course along the way, where something of it may be seen; gradients are not known yet.
    #[inline]
    fn segments(&mut self, way: &Way) {
        let Scratch { values: [lower, upper], ranges, segments, gradients, .. } = &mut self.scratch;
        segments.clear();
        for k in 0..lower.len() {
            segments.push(ranges[k].map(|_| way.course([&lower[k], &upper[k]])));
        }
        gradients.clear();
        gradients.resize(lower.len(), None);
    }

    /// All places between 0 and 1 where a field takes the value of a knot, or a surface is met; and 1.
    #[inline]
    fn breaks(&mut self, wedge: &Wedge, [a, b]: [f64; 2]) {
        let world = self.world;
        let Scratch { segments, breaks, ranges, .. } = &mut self.scratch;
        breaks.clear();
        breaks.push(Break { u: 1.0, meets: None });
        for (number, (source, segment)) in world.sources.iter().zip(&*segments).enumerate() {
            let Some(segment) = segment else { continue };
            let start = (0.0, segment.f0);
            let end = (1.0, segment.f1);
            let turn = segment.extremum();
            let halves = match turn {
                Some(turn) => [Some((start, turn)), Some((turn, end))],
                None => [Some((start, end)), None],
            };
            for (start, end) in halves.into_iter().flatten() {
                let part = segment.part(start, end);
                let at = |value: f64| lerp(start.0, end.0, part.solve(value));
                let (low, high) = (part.f0.min(part.f1), part.f0.max(part.f1));
                for cut in source.cuts_between(low, high) {
                    breaks.push(Break { u: at(*cut), meets: None });
                }
                for (k, surface) in world.isosurfaces.iter().enumerate() {
                    // Two columns find the value on the side between them to some roundings each: a surface of the
                    // very value that they have there is not one on one side alone.
                    let reach = ranges[number].map_or(0.0, |[l, h]| l.abs().max(h.abs()));
                    let is_above = |f: f64| f >= surface.value - 8.0 * f64::EPSILON * reach;
                    if surface.source == number && is_above(part.f0) != is_above(part.f1) {
                        let u = at(surface.value.clamp(low, high));
                        breaks.push(Break { u, meets: Some(Meets::Isosurface(k)) });
                    }
                }
            }
        }
        for (k, sheet) in world.sheets.iter().enumerate() {
            let SheetPlace::Radius(radius) = sheet.place else { continue };
            let facet = Facet::new(wedge, [1.0 / radius; 3]);
            if let Some(u) = facet.up().or_else(|| facet.down()).filter(|u| *u >= a && *u < b) {
                breaks.push(Break { u: (u - a) / (b - a), meets: Some(Meets::Sheet(k)) });
            }
        }
    }

    /// The volumes between two neighbouring breaks.
    #[inline]
    fn piece(&mut self, wedge: &Wedge, gap: usize, way: &Way, [from, to]: [f64; 2]) -> Flow {
        let world = self.world;
        let Scratch { segments, parts, media, gradients, blend: memory, .. } = &mut self.scratch;
        let middle = 0.5 * (from + to);
        parts.clear();
        parts.extend(media.iter().filter_map(|&number| {
            let medium = &world.media[number];
            let of = |source: usize| segments[source];
            let courses = [of(medium.color.source)?, of(medium.extinction.source)?];
            Part::new(medium, courses, middle, medium.extinction.source)
        }));
        if parts.is_empty() {
            return Flow::On;
        }
        if self.shading.is_some() {
            for part in &*parts {
                gradients[part.slot].get_or_insert_with(|| {
                    let [lower, upper] = at_vertices(world, wedge, gap, part.slot);
                    [0, 1, 2].map_inline(|axis| way.course([&lower[axis], &upper[axis]]))
                });
            }
        }
        let gradient = |source: usize, u: f64| {
            let bend = u * (1.0 - u) / (1.0 + way.eps * u);
            let at = |axis: &Segment<f64>| axis.f0 + (axis.f1 - axis.f0) * u + axis.kappa * bend;
            gradients[source].as_ref().map_or([0.0; 3], |[x, y, z]| [at(x), at(y), at(z)])
        };
        let (share, rest) = (self.share, self.rest);
        let blend = Blend { parts, gradient, shading: self.shading.as_ref(), share, rest };
        blend.add(&mut self.light, from, to, memory);
        self.passed()
    }

    /// A surface between two pieces.
    #[inline]
    fn meet(
        &mut self,
        wedge: &Wedge,
        (gap, facets): (usize, [&Facet; 2]),
        [a, b]: [f64; 2],
        (u, meets): (f64, Meets),
    ) -> Flow {
        let world = self.world;
        let at = lerp(a, b, u);
        let segments = &self.scratch.segments;
        let value = |source: usize| segments[source].map(|segment| segment.value(u));
        let color = |coat: &Coat| match coat {
            Coat::Plain(color) => Some(*color),
            Coat::By { map, .. } => Coat::of_value(map, value(map.source)?),
        };
        let t = wedge.distance(at);
        match meets {
            Meets::Isosurface(k) => {
                let surface = &world.isosurfaces[k];
                let Some(mut color) = color(&surface.coat) else { return Flow::On };
                if let Some(shading) = &self.shading {
                    let place = Place::new(wedge, facets, at, On::Between);
                    let shade = shading.shade(mixed(&at_vertices(world, wedge, gap, surface.source), &place));
                    color = color.map_inline(|c| c * shade.body + shade.highlight);
                }
                self.meets(Boundary::Isosurface(k), t);
                self.light.over(&Light::plain(color, surface.opacity));
            }
            Meets::Sheet(k) => {
                let sight = Sight::round(self.line.position(t));
                let over = (world.grid, wedge.triangle);
                let met = world.sheets[k].light(self.solid(sight.normal), (&sight, over), color);
                self.sheet(k, met, t);
            }
        }
        self.passed()
    }
}

/// The gradients of a field at the vertices of the facets of a gap, by facet and axis.
#[inline]
fn at_vertices(world: &World, wedge: &Wedge, gap: usize, source: usize) -> [[[f64; 3]; 3]; 2] {
    [gap - 1, gap].map_inline(|layer| world.sources[source].gradients_at(wedge.cells, layer))
}

/// The gradient at a place between them.
#[inline]
fn mixed([lower, upper]: &[[[f64; 3]; 3]; 2], place: &Place) -> [f64; 3] {
    [0, 1, 2].map_inline(|axis| place.value([&lower[axis], &upper[axis]]))
}
