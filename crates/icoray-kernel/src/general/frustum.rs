//! Volumes and surfaces along a ray between two layers of a column, in order.

use super::blend::{Blend, BlendBuffers, MediumPiece};
use super::passage::{PARTS, Passage, PassageKind, shares};
use super::surfaces::{Material, SurfaceHeight};
use super::wedge::{Facet, FacetSide, FrustumPoint, Wedge};
use super::{KernelScene, RayState};
use crate::column::Flow;
use crate::ground::SurfaceHit;
use crate::piece::Radiance;
use crate::segment::Segment;
use crate::signature::Boundary;
use crate::volume_ray::correlated;
use icoray_grid::array::MapInline;
use icoray_grid::real::lerp;

/// Data of the frustum that contains the ray; its memory is reused for the next.
#[derive(Debug, Default)]
pub(super) struct Scratch<'w> {
    /// Each field's values at the vertices, on the lower and upper facet; empty if not read yet.
    values: [Vec<[f64; 3]>; 2],
    /// Least and greatest value of each field at these vertices; `None` if a value is missing.
    ranges: Vec<Option<[f64; 2]>>,
    /// Values of the visible fields along the shown part of the frustum.
    segments: Vec<Option<Segment<f64>>>,
    /// The places that divide it into pieces.
    breaks: Vec<Break>,
    parts: Vec<MediumPiece<'w>>,
    /// The numbers of the visible media.
    media: Vec<usize>,
    /// Each field's gradient along it, if computed.
    gradients: Vec<Option<GradientCourse>>,
    blend: BlendBuffers,
}

/// A gradient along a frustum.
#[derive(Debug, Clone)]
struct GradientCourse {
    components: [Segment<f64>; 3],
    /// The largest component at the vertices.
    size: f64,
}

/// A ray's path through a frustum, or a part of it: its start, middle and end.
struct FrustumPath {
    places: [FrustumPoint; 3],
    /// The relative change of a value's denominator.
    eps: f64,
    length: f64,
}

impl FrustumPath {
    #[inline]
    fn new(places: [FrustumPoint; 3], length: f64) -> Self {
        let [start, _, end] = &places;
        let eps = if start.depth > 0.0 { end.depth / start.depth - 1.0 } else { 0.0 };
        // Where facets meet the value has no limit; near there it is taken as linear.
        let eps = if eps.is_finite() { eps.max(-1.0 + 1e-9) } else { 0.0 };
        FrustumPath { places, eps, length }
    }

    /// The interpolant of these values at the vertices of the lower and upper facet.
    #[inline]
    fn interpolant(&self, vertices: [&[f64; 3]; 2]) -> Segment<f64> {
        let FrustumPath { ref places, eps, length } = *self;
        let [f0, half, f1] = [&places[0], &places[1], &places[2]].map_inline(|place| place.value(vertices));
        let kappa = (half - 0.5 * (f0 + f1)) * 4.0 * (1.0 + 0.5 * eps);
        // Equal values have no bend; rounding must not give them one.
        let kappa = if f0 == f1 && half == f0 { 0.0 } else { kappa };
        Segment { f0, f1, kappa, eps, length }
    }
}

#[derive(Debug, Clone, Copy)]
struct Break {
    u: f64,
    meets: Option<SurfaceKind>,
}

#[derive(Debug, Clone, Copy)]
enum SurfaceKind {
    Isosurface(usize),
    Sheet(usize),
}

impl Scratch<'_> {
    /// Starts a new column.
    #[inline]
    pub fn forget(&mut self) {
        self.values.iter_mut().for_each(Vec::clear);
    }

    /// Passes through a layer: its values become those of the other facet.
    #[inline]
    pub fn shift(&mut self, rises: bool) {
        self.values.swap(0, 1);
        self.values[usize::from(rises)].clear();
    }

    #[inline]
    fn read(&mut self, scene: &KernelScene, wedge: &Wedge, gap: usize) {
        for (layer, values) in [gap - 1, gap].into_iter().zip(&mut self.values) {
            if values.is_empty() {
                for source in &scene.sources {
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

impl<'r> RayState<'r, '_> {
    /// Passes `gap` from one place of the column to another.
    #[inline]
    pub(super) fn gap(
        &mut self,
        wedge: &Wedge,
        facets: [&Facet; 2],
        [(a, from), (b, to)]: [(f64, FacetSide); 2],
    ) -> Flow {
        if b <= a {
            return Flow::On;
        }
        self.counts.frusta += 1;
        let (scene, gap) = (self.scene, facets[1].layer);
        self.scratch.read(scene, wedge, gap);
        let ranges = &self.scratch.ranges;
        self.scratch.media.clear();
        self.scratch.media.extend((0..scene.media.len()).filter(|&number| {
            let medium = &scene.media[number];
            let range = ranges[medium.extinction.source].filter(|_| ranges[medium.color.source].is_some());
            range.is_some_and(|[low, high]| !medium.extinction.is_clear_between(low, high))
        }));
        let meets_isosurface = scene.isosurfaces.iter().any(|surface| {
            ranges[surface.source].is_some_and(|[low, high]| low <= surface.value && surface.value <= high)
        });
        let has_radii = scene.surface_layers.iter().any(|surface| matches!(surface.place, SurfaceHeight::Radius(_)));
        if self.scratch.media.is_empty()
            && let Some(single) = &mut self.single
        {
            single.span = None;
        }
        if self.scratch.media.is_empty() && !meets_isosurface && !has_radii && self.passages.is_none() {
            self.counts.void_frusta += u64::from(ranges.iter().all(Option::is_none));
            return Flow::On;
        }
        if self.clips.is_empty() {
            let length = wedge.distance(b) - wedge.distance(a);
            return self.part(wedge, facets, [(a, from), (b, to)], length);
        }
        let (mut shown, ends) = (Vec::new(), [a, b].map_inline(|u| wedge.distance(u)));
        self.clips.parts([gap - 1, gap], ends, |part| {
            shown.push(part);
            true
        });
        let mut reached = ends[0];
        for [t0, t1] in shown {
            if (self.is_cut || t0 > reached) && !self.scratch.media.is_empty() {
                self.cross_boundary(Boundary::CutFace, t0);
            }
            (reached, self.is_cut) = (t1, false);
            let end = |t: f64, (u, on): (f64, FacetSide)| {
                if t == wedge.distance(u) { (u, on) } else { (wedge.fraction(t), FacetSide::Between) }
            };
            let ends = [end(t0, (a, from)), end(t1, (b, to))];
            if self.part(wedge, facets, ends, t1 - t0) == Flow::Stop {
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
        facets: [&Facet; 2],
        [(a, from), (b, to)]: [(f64, FacetSide); 2],
        length: f64,
    ) -> Flow {
        let place = |u: f64, on: FacetSide| FrustumPoint::new(wedge, facets, u, on);
        let way = FrustumPath::new([place(a, from), place(0.5 * (a + b), FacetSide::Between), place(b, to)], length);
        self.segments(&way);
        self.find_breaks(wedge, [a, b]);
        let mut breaks = std::mem::take(&mut self.scratch.breaks);
        breaks.sort_by(|one, other| one.u.total_cmp(&other.u));
        let mut done = 0.0;
        let mut flow = Flow::On;
        for Break { u, meets } in &breaks {
            if *u > done {
                let before = self.light.transmittance();
                flow = self.piece(wedge, facets[1].layer, &way, [done, *u]);
                self.record(before, |ray, alpha| {
                    ray.passage(wedge, [lerp(a, b, done), lerp(a, b, *u)], 0.5 * (done + u), alpha)
                });
                done = *u;
            }
            if let (Flow::On, Some(meets)) = (flow, meets) {
                flow = self.cross_surface(wedge, facets, [a, b], (*u, *meets));
            }
            if flow == Flow::Stop {
                break;
            }
        }
        self.scratch.breaks = breaks;
        flow
    }

    /// The passage through a part of the frustum between two places of the column; `middle` is the place between them
    /// along the fields' interpolants.
    fn passage(&self, wedge: &Wedge, ends: [f64; 2], middle: f64, alpha: f64) -> Passage {
        let values = self.values_at(middle);
        let kind = PassageKind::Frustum(shares(&self.scene.media, &values));
        let rho = wedge.alpha(0.5 * (ends[0] + ends[1])).iter().sum();
        let t = ends.map_inline(|u| wedge.distance(u));
        Passage { kind, cells: Some(wedge.cells), t, rho, alpha, values }
    }

    /// The value of each field at a place of the shown part of the frustum.
    fn values_at(&self, u: f64) -> Vec<f64> {
        let value = |segment: &Option<Segment<f64>>| segment.map_or(f64::NAN, |segment| segment.value(u));
        self.scratch.segments.iter().map(value).collect()
    }

    /// The interpolant of each field along the path where the field may be visible, without gradients.
    #[inline]
    fn segments(&mut self, way: &FrustumPath) {
        let Scratch { values: [lower, upper], ranges, segments, gradients, .. } = &mut self.scratch;
        segments.clear();
        for k in 0..lower.len() {
            segments.push(ranges[k].map(|_| way.interpolant([&lower[k], &upper[k]])));
        }
        gradients.clear();
        gradients.resize(lower.len(), None);
    }

    /// Finds all places between 0 and 1 at which a field takes the value of a knot, or a surface is met; and 1.
    #[inline]
    fn find_breaks(&mut self, wedge: &Wedge, [a, b]: [f64; 2]) {
        let scene = self.scene;
        let Scratch { segments, breaks, ranges, .. } = &mut self.scratch;
        breaks.clear();
        breaks.push(Break { u: 1.0, meets: None });
        if self.passages.is_some() {
            breaks.extend((1..PARTS).map(|part| Break { u: part as f64 / PARTS as f64, meets: None }));
        }
        // A single volume is cut at its knots by itself.
        if self.single.is_some() && scene.isosurfaces.is_empty() && scene.surface_layers.is_empty() {
            return;
        }
        for (number, (source, segment)) in scene.sources.iter().zip(&*segments).enumerate() {
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
                for cut in source.cuts_between(low, high).iter().filter(|_| self.single.is_none()) {
                    breaks.push(Break { u: at(*cut), meets: None });
                }
                for (k, surface) in scene.isosurfaces.iter().enumerate() {
                    // Two columns each find the value on the side between them to some roundings: a surface of exactly
                    // that value must not exist on one side only.
                    let reach = ranges[number].map_or(0.0, |[l, h]| l.abs().max(h.abs()));
                    let is_above = |f: f64| f >= surface.value - 8.0 * f64::EPSILON * reach;
                    if surface.source == number && is_above(part.f0) != is_above(part.f1) {
                        let u = at(surface.value.clamp(low, high));
                        breaks.push(Break { u, meets: Some(SurfaceKind::Isosurface(k)) });
                    }
                }
            }
        }
        for (k, surface) in scene.surface_layers.iter().enumerate() {
            let SurfaceHeight::Radius(radius) = surface.place else { continue };
            let facet = Facet::of_radii(wedge, 0, [1.0 / radius; 3]);
            if let Some(u) = facet.up().or_else(|| facet.down()).filter(|u| *u >= a && *u < b) {
                breaks.push(Break { u: (u - a) / (b - a), meets: Some(SurfaceKind::Sheet(k)) });
            }
        }
    }

    /// Adds the volumes between two neighbouring breaks.
    #[inline]
    fn piece(&mut self, wedge: &Wedge, gap: usize, way: &FrustumPath, [from, to]: [f64; 2]) -> Flow {
        let scene = self.scene;
        if self.single.is_some() {
            return self.single_piece(wedge, gap, way, [from, to]);
        }
        let Scratch { segments, parts, media, gradients, blend: memory, .. } = &mut self.scratch;
        let middle = 0.5 * (from + to);
        parts.clear();
        parts.extend(media.iter().filter_map(|&number| {
            let medium = &scene.media[number];
            let of = |source: usize| segments[source];
            let interpolants = [of(medium.color.source)?, of(medium.extinction.source)?];
            MediumPiece::new(medium, interpolants, middle, medium.extinction.source)
        }));
        if parts.is_empty() {
            return Flow::On;
        }
        if self.shading.is_some() {
            for part in parts.iter_mut() {
                let course = gradients[part.slot].get_or_insert_with(|| {
                    let vertices @ [lower, upper] = &at_vertices(scene, wedge, gap, part.slot);
                    let components = [0, 1, 2].map_inline(|axis| way.interpolant([&lower[axis], &upper[axis]]));
                    GradientCourse { components, size: size_of(vertices) }
                });
                part.gradient_size = course.size;
            }
        }
        let gradient = |source: usize, u: f64| {
            let bend = u * (1.0 - u) / (1.0 + way.eps * u);
            let at = |axis: &Segment<f64>| axis.f0 + (axis.f1 - axis.f0) * u + axis.kappa * bend;
            gradients[source].as_ref().map_or([0.0; 3], |course| course.components.each_ref().map_inline(at))
        };
        let (color_tolerance, min_transmittance) = (self.color_tolerance, self.min_transmittance);
        let blend = Blend { parts, gradient, shading: self.shading.as_ref(), color_tolerance, min_transmittance };
        blend.add(&mut self.light, from, to, memory);
        self.passed()
    }

    /// The scene's only volume between two neighbouring surfaces.
    #[inline]
    fn single_piece(&mut self, wedge: &Wedge, gap: usize, way: &FrustumPath, range: [f64; 2]) -> Flow {
        let Scratch { segments, ranges, media, .. } = &self.scratch;
        let Some(single) = self.single.as_mut().filter(|_| !media.is_empty()) else { return Flow::On };
        let map = &self.scene.media[0].extinction;
        let (Some(value), Some(values)) = (segments[map.source], ranges[map.source]) else { return Flow::On };
        (single.light, single.min_transmittance) = (self.light, self.min_transmittance);
        if map.spans().needs_sizes(self.scene.sources[map.source].value_range) {
            let [low, high] = values.map_inline(|value| map.normal(value).abs());
            single.size = correlated(low.max(high));
        }
        let flow = if self.shading.is_some() {
            let vertices @ [lower, upper] = &at_vertices(self.scene, wedge, gap, map.source);
            let [x, y, z] = [0, 1, 2].map_inline(|axis| way.interpolant([&lower[axis], &upper[axis]]));
            single.gradient_size = size_of(vertices);
            single.part(map, [&value, &x, &y, &z], range)
        } else {
            single.part(map, [&value], range)
        };
        self.light = single.light;
        flow
    }

    /// A surface between two pieces.
    #[inline]
    fn cross_surface(
        &mut self,
        wedge: &Wedge,
        facets: [&Facet; 2],
        [a, b]: [f64; 2],
        (u, meets): (f64, SurfaceKind),
    ) -> Flow {
        let scene = self.scene;
        let at = lerp(a, b, u);
        let segments = &self.scratch.segments;
        let value = |source: usize| segments[source].map(|segment| segment.value(u));
        let color = |material: &Material| match material {
            Material::Plain(color) => Some(*color),
            Material::By { map, .. } => Material::of_value(map, value(map.source)?),
        };
        let t = wedge.distance(at);
        match meets {
            SurfaceKind::Isosurface(k) => {
                let surface = &scene.isosurfaces[k];
                let Some(mut color) = color(&surface.material) else { return Flow::On };
                let mut off = 0.0;
                if let Some(shading) = &self.shading {
                    let place = FrustumPoint::new(wedge, facets, at, FacetSide::Between);
                    let vertices = at_vertices(scene, wedge, facets[1].layer, surface.source);
                    let gradient = mixed(&vertices, &place);
                    let shade = shading.shade(gradient);
                    color = color.map_inline(|c| c * shade.body + shade.highlight);
                    off = surface.opacity * shading.deviation_of(size_of(&vertices), largest(&gradient));
                }
                self.cross_boundary(Boundary::Isosurface(k), t);
                let before = self.light.transmittance();
                self.light.over(&Radiance { variance: off * off, ..Radiance::plain(color, surface.opacity) });
                self.record_at(before, PassageKind::Isosurface(k), wedge, at, |ray| ray.values_at(u));
            }
            SurfaceKind::Sheet(k) => {
                let hit = SurfaceHit::round(self.line.position(t));
                let over = (scene.grid, wedge.triangle);
                let (light, materials) = scene.surface_layers[k].light(self.solid(hit.normal), (&hit, over), color);
                self.surface_layer(k, light, materials, wedge, at, |ray| ray.values_at(u));
            }
        }
        self.passed()
    }
}

/// The gradients of a field at the vertices of the facets of a gap, by facet and axis.
#[inline]
fn at_vertices(scene: &KernelScene, wedge: &Wedge, gap: usize, source: usize) -> [[[f64; 3]; 3]; 2] {
    [gap - 1, gap].map_inline(|layer| scene.sources[source].gradients_at(wedge.cells, layer))
}

/// The largest component of a vector.
#[inline]
fn largest(vector: &[f64; 3]) -> f64 {
    vector.iter().fold(0.0, |most, x| most.max(x.abs()))
}

/// The largest component of gradients at vertices.
#[inline]
fn size_of(vertices: &[[[f64; 3]; 3]; 2]) -> f64 {
    vertices.as_flattened().iter().fold(0.0, |most, components| most.max(largest(components)))
}

/// The gradient at a place between them.
#[inline]
fn mixed([lower, upper]: &[[[f64; 3]; 3]; 2], place: &FrustumPoint) -> [f64; 3] {
    [0, 1, 2].map_inline(|axis| place.value([&lower[axis], &upper[axis]]))
}
