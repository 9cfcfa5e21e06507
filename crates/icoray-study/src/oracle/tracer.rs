//! One ray through a scene: its columns, layers and frusta, cut into pieces between surfaces.

use super::way::{Frustum, LayeredColumn};
use super::{Blend, Course, MIN_TRANSMITTANCE, Map, Oracle, Part, Radiance, direction_of, find, over};
use crate::shading::{self, RayLighting};
use crate::stability::dd::Dd;
use crate::stability::path::{Column, Ray};
use glam::DVec3;
use icoray::{Level, LightSource, Paint};

/// A ray that is traced.
pub(super) struct Tracer<'o, 'a> {
    oracle: &'o Oracle<'a>,
    eye: DVec3,
    dir: DVec3,
    lighting: Option<RayLighting>,
    /// Where it passes a bound of a cut.
    bounds: Vec<f64>,
    radiance: Radiance,
}

/// A surface in a frustum: number of an isosurface, or of a surface at a height.
#[derive(Debug, Clone, Copy)]
enum Met {
    Isosurface(usize),
    Sheet(usize),
}

impl<'o, 'a> Tracer<'o, 'a> {
    pub fn new(oracle: &'o Oracle<'a>, eye: DVec3, dir: DVec3) -> Self {
        let lighting = RayLighting::new(oracle.scene, dir);
        let radiance = Radiance { color: DVec3::ZERO, transmittance: 1.0 };
        let bounds = oracle.scene.scenery.clips.iter().flat_map(|clip| oracle.bounds(clip, eye, dir)).collect();
        Tracer { oracle, eye, dir, lighting, bounds, radiance }
    }

    /// Premultiplied linear RGBA over the background.
    pub fn pixel(&self) -> [f64; 4] {
        let [r, g, b] = self.radiance.color.to_array();
        over(self.oracle.scene.background, [r, g, b, 1.0 - self.radiance.transmittance])
    }

    pub fn ends(&self) -> bool {
        self.radiance.transmittance <= MIN_TRANSMITTANCE
    }

    fn at(&self, t: f64) -> DVec3 {
        self.eye + t * self.dir
    }

    /// Adds a surface.
    fn over(&mut self, color: DVec3, opacity: f64) {
        self.radiance.color += self.radiance.transmittance * opacity * color;
        self.radiance.transmittance *= 1.0 - opacity;
    }

    /// The colour of a surface on a layer or at a height, whose side that is seen a headlight lights.
    fn lit(&self, color: DVec3, normal: DVec3) -> DVec3 {
        let light = self.oracle.scene.lighting;
        let is_turned = light.is_some_and(|light| light.source == LightSource::Headlight) && normal.dot(self.dir) > 0.0;
        shading::ground(self.oracle.scene, color, if is_turned { -normal } else { normal }, self.dir)
    }

    pub fn core(&mut self, normal: DVec3) {
        if let Some(color) = self.oracle.scene.core {
            self.over(shading::ground(self.oracle.scene, DVec3::from_array(color), normal, self.dir), 1.0);
        }
    }

    pub fn column(&mut self, column: &Column) {
        let oracle = self.oracle;
        if column.is_void {
            let ray = Ray { eye: self.eye, dir: self.dir };
            if let Some([t, _]) = ray.inside(oracle.range[0], column.t) {
                self.core(self.at(t.to_f64()).normalize());
            }
            return;
        }
        let layered = self.layered(column);
        for pair in layered.crossings().windows(2) {
            let (ends, crossed) = ([pair[0].0, pair[1].0], pair[1].1);
            if ends[0] < ends[1] {
                match layered.layers_below((ends[0] + ends[1]) / 2.0) {
                    0 => {
                        let weight = layered.on_layer(0, ends[0]);
                        self.core(oracle.normal(column.cells, 0, weight, self.at(ends[0].to_f64())));
                    }
                    below if below < oracle.layers => self.frustum(&layered, below - 1, ends),
                    _ => {}
                }
            }
            if let Some(layer) = crossed {
                self.layer(&layered, layer, ends[1]);
            }
            if self.ends() {
                return;
            }
        }
    }

    fn layered<'c>(&self, column: &'c Column) -> LayeredColumn<'c, impl Fn(u32, usize) -> f64 + use<'o, 'c, 'a>> {
        let oracle = self.oracle;
        LayeredColumn { column, layers: oracle.layers, radius: |cell, layer| oracle.radius(cell, layer) }
    }

    /// A frustum of the traversal.
    pub fn stretch(&mut self, frustum: &icoray::Frustum) {
        if frustum.t[0] < frustum.t[1] {
            let column = Column::around(frustum);
            self.frustum(&self.layered(&column), frustum.layer, column.t);
        }
    }

    /// The surfaces on a layer, the first in front.
    fn layer(&mut self, layered: &LayeredColumn<'_, impl Fn(u32, usize) -> f64>, layer: usize, t: Dd) {
        let (oracle, cells, at) = (self.oracle, layered.column.cells, self.at(t.to_f64()));
        for surface in &oracle.scene.scenery.surfaces {
            let number = match surface.at {
                Level::Layer(number) => number,
                Level::Top => oracle.layers - 1,
                Level::Ground | Level::Height(_) => continue,
            };
            if number == layer && oracle.shows([layer, layer], at) {
                let weight = layered.on_layer(layer, t);
                let color = paint(&surface.paint, |name| {
                    let values = &oracle.data.fields[find(&oracle.data, name).ok()?].1;
                    let value = cells.map(|cell| values[cell as usize * oracle.layers + layer]);
                    let rest = weight[1] * (value[1] - value[0]) + weight[2] * (value[2] - value[0]);
                    Some(value[0] + rest).filter(|value| value.is_finite())
                });
                if let Some(color) = color {
                    self.over(self.lit(color, oracle.normal(cells, layer, weight, at)), surface.opacity);
                }
            }
        }
    }

    fn frustum(&mut self, layered: &LayeredColumn<'_, impl Fn(u32, usize) -> f64>, gap: usize, ends: [Dd; 2]) {
        let (oracle, cells) = (self.oracle, layered.column.cells);
        let frustum = layered.frustum(gap, ends);
        let fields = oracle.data.fields.iter();
        let courses: Vec<Option<Course>> =
            fields.map(|(_, values)| frustum.course(oracle.six(cells, gap, |i| values[i]))).collect();
        let length = (ends[1] - ends[0]).to_f64();
        let mut breaks: Vec<(f64, Option<Met>)> = vec![(1.0, None)];
        for (field, course) in courses.iter().enumerate() {
            if let Some(course) = course {
                self.meets(field, course, &mut breaks);
            }
        }
        breaks.extend(self.bounds.iter().map(|t| ((Dd::from(*t) - ends[0]).to_f64() / length, None)));
        for (k, surface) in oracle.scene.scenery.surfaces.iter().enumerate() {
            if let Level::Height(height) = surface.at
                && let Some(t) = layered.meets(oracle.radius_of(height)).filter(|t| ends[0] <= *t && *t < ends[1])
            {
                breaks.push((((t - ends[0]) / (ends[1] - ends[0])).to_f64(), Some(Met::Sheet(k))));
            }
        }
        breaks.retain(|(u, _)| (0.0..=1.0).contains(u));
        breaks.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut done = 0.0;
        for (u, met) in breaks {
            let place = |u: f64| self.at(ends[0].to_f64() + u * length);
            if u > done && oracle.shows([gap, gap + 1], place(0.5 * (done + u))) {
                self.piece(&frustum, (cells, gap), &courses, [done, u], length);
            }
            done = u;
            if let Some(met) = met.filter(|_| oracle.shows([gap, gap + 1], self.at(ends[0].to_f64() + u * length))) {
                self.surface(met, &frustum, (cells, gap), &courses, (u, ends[0].to_f64() + u * length));
            }
            if self.ends() {
                return;
            }
        }
    }

    /// Where a field turns, meets a knot or an isosurface.
    fn meets(&self, field: usize, course: &Course, breaks: &mut Vec<(f64, Option<Met>)>) {
        let (oracle, Course { base, f }) = (self.oracle, course);
        let turn = f.extremum();
        breaks.extend(turn.map(|u| (u, None)));
        let middle = turn.unwrap_or(1.0);
        for [from, to] in [[0.0, middle], [middle, 1.0]] {
            let [start, end] = [from, to].map(|u| f.at(u));
            let (low, high) = (start.min(end), start.max(end));
            let maps = oracle.media.iter().flat_map(|medium| [&medium.color, &medium.extinction]);
            for map in maps.filter(|map| map.field == field) {
                let knots = map.spans.knots_between(base + low, base + high).iter();
                let inside = knots.filter(|knot| low < **knot - base && **knot - base < high);
                breaks.extend(inside.map(|knot| (f.meets(knot - base, from, to), None)));
            }
            for (k, surface) in oracle.scene.scenery.isosurfaces.iter().enumerate() {
                let value = surface.value - base;
                if oracle.data.fields[field].0 == surface.field && (start >= value) != (end >= value) {
                    breaks.push((f.meets(value, from, to), Some(Met::Isosurface(k))));
                }
            }
        }
    }

    /// Components of a field's gradient.
    fn gradient(&self, field: usize, frustum: &Frustum, (cells, gap): ([u32; 3], usize)) -> Option<[Course; 3]> {
        let gradients = self.oracle.gradients.get(field)?;
        let axis = |axis: usize| frustum.course(self.oracle.six(cells, gap, |i| gradients[i][axis]));
        Some([axis(0)?, axis(1)?, axis(2)?])
    }

    fn piece(
        &mut self,
        frustum: &Frustum,
        place: ([u32; 3], usize),
        courses: &[Option<Course>],
        range: [f64; 2],
        length: f64,
    ) {
        let oracle = self.oracle;
        let middle = 0.5 * (range[0] + range[1]);
        let mut parts = Vec::new();
        for medium in &oracle.media {
            let of = |map: &'o Map| {
                let course = courses[map.field]?;
                let span = map.spans.at(course.base + course.f.at(middle));
                Some((course.part(range, span), span))
            };
            let (Some(color), Some(extinction)) = (of(&medium.color), of(&medium.extinction)) else { continue };
            if extinction.1.is_clear {
                continue;
            }
            let normal = self.gradient(medium.extinction.field, frustum, place);
            let normal = normal.map(|axes| axes.map(|Course { base, f }| f.part(range, range.map(|u| base + f.at(u)))));
            parts.push(Part { color, extinction, normal });
        }
        if parts.is_empty() {
            return;
        }
        let (lighting, limit, length) = (self.lighting.as_ref(), oracle.panel, length * (range[1] - range[0]));
        Blend { gauss: &oracle.gauss, parts, length, lighting, limit }.add(&mut self.radiance);
    }

    /// A surface at `u` of a frustum, `t` along the ray.
    fn surface(
        &mut self,
        met: Met,
        frustum: &Frustum,
        place: ([u32; 3], usize),
        courses: &[Option<Course>],
        (u, t): (f64, f64),
    ) {
        let oracle = self.oracle;
        let value = |name: &str| {
            let course = courses[find(&oracle.data, name).ok()?]?;
            Some(course.base + course.f.at(u))
        };
        match met {
            Met::Isosurface(k) => {
                let surface = &oracle.scene.scenery.isosurfaces[k];
                let Some(color) = paint(&surface.paint, value) else { return };
                let field = find(&oracle.data, &surface.field).unwrap_or_default();
                let (body, highlight) = match (&self.lighting, self.gradient(field, frustum, place)) {
                    (Some(lighting), Some(axes)) => {
                        lighting.shade(direction_of(DVec3::from_array(axes.map(|axis| axis.base + axis.f.at(u)))))
                    }
                    _ => (1.0, 0.0),
                };
                self.over(body * color + highlight, surface.opacity);
            }
            Met::Sheet(k) => {
                let surface = &oracle.scene.scenery.surfaces[k];
                if let Some(color) = paint(&surface.paint, value) {
                    self.over(self.lit(color, self.at(t).normalize()), surface.opacity);
                }
            }
        }
    }
}

/// The colour of a paint, with the values of fields by name; `None` where the value is missing.
fn paint(paint: &Paint, value: impl Fn(&str) -> Option<f64>) -> Option<DVec3> {
    match paint {
        Paint::Plain(color) => Some(DVec3::from_array(*color)),
        Paint::Field { field, transfer, .. } => value(field).map(|value| DVec3::from_array(transfer.at(value).0)),
    }
}
