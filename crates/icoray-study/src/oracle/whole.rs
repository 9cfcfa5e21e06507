//! Whole scenes to ten digits: several volumes, isosurfaces, surfaces, cuts and layers of any heights.
//!
//! A ray's columns and layers are found in double-double over all triangles of a small mesh; nothing of the renderer's
//! traversal or integration is used. Each frustum is cut at the extremum of every field, at knots, bounds of cuts and
//! surfaces; the smooth pieces between are those of [`Blend`].

#[cfg(test)]
mod tests;

use super::blend::{Blend, Course, Part};
use super::gauss::Gauss;
use super::gradients::GradientInput;
use super::panel::{MIN_TRANSMITTANCE, Radiance};
use super::spans::Spans;
use super::way::{Frustum, LayeredColumn};
use super::{FrustumInterpolant, PANEL, direction_of, over};
use crate::shading::{self, RayLighting, direction};
use crate::stability::dd::Dd;
use crate::stability::path::{Column, Ray, columns};
use glam::DVec3;
use icoray::{Clip, Error, ErrorKind, Grid, Heights, Layers, Level, Paint, Result, Scene, Source, TransferFunction};

/// A mesh with fields at its cells.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Data<'a> {
    pub grid: &'a Grid<'a>,
    /// Layers from the innermost on.
    pub layers: &'a Layers,
    /// Heights of each column's layers in metres, level-fastest; for scenes with native heights.
    pub heights: &'a [f64],
    /// Names and values, level-fastest; NaN where a value is missing.
    pub fields: &'a [(&'a str, Vec<f64>)],
}

/// A transfer function of a field.
#[derive(Debug)]
struct Map {
    field: usize,
    spans: Spans,
}

#[derive(Debug)]
struct Medium {
    color: Map,
    extinction: Map,
}

/// A scene over data, to be evaluated.
#[derive(Debug)]
pub(crate) struct WholeScene<'a> {
    scene: &'a Scene,
    data: Data<'a>,
    /// Radii of all cells' layers, planet radii.
    radius: Vec<f64>,
    layers: usize,
    /// Least radius of the innermost layer, that of the core below holes, and greatest radius of all.
    range: [f64; 2],
    media: Vec<Medium>,
    /// Gradients of each field at all vertices, in a lit scene.
    gradients: Vec<Vec<DVec3>>,
    gauss: Gauss,
    panel: f64,
}

/// A ray that is traced.
struct Tracer<'o, 'a> {
    oracle: &'o WholeScene<'a>,
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

impl<'a> WholeScene<'a> {
    /// Prepares gradients and transfer functions.
    ///
    /// # Errors
    /// As [`Layers::shell`]; [`ErrorKind::Scene`] where a field is unknown.
    pub fn new(scene: &'a Scene, data: Data<'a>) -> Result<Self> {
        let shell = data.layers.shell(scene.exaggeration)?;
        let (layers, cells) = (shell.len(), data.grid.cells());
        let stretch = scene.exaggeration / data.layers.planet_radius_m();
        let is_native = scene.scenery.heights == Heights::Native;
        let radius: Vec<f64> = match is_native {
            true => data.heights.iter().map(|height| 1.0 + stretch * height).collect(),
            false => shell.iter().copied().cycle().take(layers * cells).collect(),
        };
        let lowest = radius.iter().step_by(layers).copied().fold(shell[0], f64::min);
        let highest = radius.iter().copied().fold(shell[layers - 1], f64::max);
        let thickness = shell[layers - 1] - shell[0];
        let map = |name: &str, transfer: &TransferFunction| {
            Ok(Map { field: find(&data, name)?, spans: Spans::new(transfer, thickness) })
        };
        let medium = |volume: &icoray::Volume| {
            let own = (&volume.field, &volume.transfer);
            let (by, extinction) = volume.opacity.as_ref().map_or(own, |by| (&by.field, &by.transfer));
            Ok(Medium { color: map(own.0, own.1)?, extinction: map(by, extinction)? })
        };
        let media = scene.volumes.iter().map(medium).collect::<Result<_>>()?;
        let gradients = |(_, values): &(&str, Vec<f64>)| {
            let at = |cell: u32, layer: usize| cell as usize * layers + layer;
            let radius = |cell, layer| radius[at(cell, layer)];
            let value = |cell, layer| values[at(cell, layer)];
            GradientInput { grid: data.grid, layers, radius, value, partial: is_native }.gradients()
        };
        let lit = data.fields.iter().filter(|_| scene.lighting.is_some());
        let (gradients, range) = (lit.map(gradients).collect(), [lowest, highest]);
        Ok(WholeScene { scene, data, radius, layers, range, media, gradients, gauss: Gauss::new(), panel: PANEL })
    }

    /// The same with panels of half the depth.
    pub fn halved(self) -> Self {
        WholeScene { panel: 0.5 * self.panel, ..self }
    }

    /// Premultiplied linear RGBA along a ray, over the background; `None` where the mesh has a gap.
    pub fn pixel(&self, eye: DVec3, dir: DVec3) -> Option<[f64; 4]> {
        let lighting = RayLighting::new(self.scene, dir);
        let radiance = Radiance { color: DVec3::ZERO, transmittance: 1.0 };
        let bounds = self.scene.scenery.clips.iter().flat_map(|clip| self.bounds(clip, eye, dir)).collect();
        let mut tracer = Tracer { oracle: self, eye, dir, lighting, bounds, radiance };
        let inner = self.scene.core.map(|_| self.range[0]);
        for column in columns(self.data.grid, &Ray { eye, dir }, self.range[1], inner).ok()? {
            tracer.column(&column);
            if tracer.radiance.transmittance <= MIN_TRANSMITTANCE {
                break;
            }
        }
        let [r, g, b] = tracer.radiance.color.to_array();
        Some(over(self.scene.background, [r, g, b, 1.0 - tracer.radiance.transmittance]))
    }

    fn radius(&self, cell: u32, layer: usize) -> f64 {
        self.radius[cell as usize * self.layers + layer]
    }

    fn radius_of(&self, height_m: f64) -> f64 {
        1.0 + self.scene.exaggeration * height_m / self.data.layers.planet_radius_m()
    }

    /// Values of a quantity at the vertices below and above a gap.
    fn six(&self, cells: [u32; 3], gap: usize, value: impl Fn(usize) -> f64) -> [f64; 6] {
        [0, 1, 2, 3, 4, 5].map(|k| value(cells[k % 3] as usize * self.layers + gap + k / 3))
    }

    /// All places where a ray may pass a bound of a cut.
    fn bounds(&self, clip: &Clip, eye: DVec3, dir: DVec3) -> Vec<f64> {
        let mut found = Vec::new();
        // a t² + 2 b t + c = 0
        let mut quadratic = |a: f64, b: f64, c: f64| {
            let root = (b * b - a * c).max(0.0).sqrt();
            let q = -(b + root.copysign(b));
            found.extend([q / a, c / q]);
        };
        for height in clip.height_m.into_iter().flatten() {
            quadratic(1.0, eye.dot(dir), eye.length_squared() - self.radius_of(height).powi(2));
        }
        for lat in clip.region.into_iter().flat_map(|region| region.lat_deg) {
            let s2 = lat.to_radians().sin().powi(2);
            let of = |p: DVec3, q: DVec3| p.z * q.z - s2 * p.dot(q);
            quadratic(of(dir, dir), of(eye, dir), of(eye, eye));
        }
        let plane = |normal: DVec3, distance: f64| (distance - normal.dot(eye)) / normal.dot(dir);
        let meridians = clip.region.into_iter().flat_map(|region| region.lon_deg);
        found.extend(meridians.map(|lon| plane(direction(lon.to_radians() + std::f64::consts::FRAC_PI_2, 0.0), 0.0)));
        found.extend(clip.half_space.map(|half| plane(lon_lat(half.towards_deg), half.distance)));
        found
    }

    /// Whether a place between or on `layers` is shown.
    fn shows(&self, layers: [usize; 2], at: DVec3) -> bool {
        self.scene.scenery.clips.iter().all(|clip| {
            let heights = clip.height_m.map(|ends| ends.map(|height| self.radius_of(height)));
            let is_inside = clip.region.is_none_or(|region| region.holds(at))
                && clip.layers.is_none_or(|[low, high]| layers[0] >= low && layers[1] <= high)
                && heights.is_none_or(|[low, high]| low <= at.length() && at.length() <= high)
                && clip.half_space.is_none_or(|half| lon_lat(half.towards_deg).dot(at) > half.distance);
            is_inside != clip.cuts_inside
        })
    }

    /// The outward normal of a layer where facet weights are `weight`; that of a sphere on concentric layers.
    fn normal(&self, cells: [u32; 3], layer: usize, weight: [f64; 3], at: DVec3) -> DVec3 {
        if self.scene.scenery.heights == Heights::Mean {
            return at.normalize();
        }
        let grid = self.data.grid;
        let place = |cell: u32| self.radius(cell, layer) * grid.direction(cell);
        let vertex = |cell: u32| {
            let facets = grid.corners_of(cell).filter(|corner| grid.is_triangle(*corner)).map(|triangle| {
                let [a, b, c] = grid.triangle(triangle).map(place);
                let across = (b - a).cross(c - a);
                across * across.dot(grid.direction(cell)).signum()
            });
            facets.sum::<DVec3>().normalize()
        };
        (0..3).map(|k| weight[k] * vertex(cells[k])).sum::<DVec3>().normalize()
    }
}

fn lon_lat([lon, lat]: [f64; 2]) -> DVec3 {
    direction(lon.to_radians(), lat.to_radians())
}

fn find(data: &Data, name: &str) -> Result<usize> {
    let found = data.fields.iter().position(|field| field.0 == name);
    found.ok_or_else(|| Error::new(ErrorKind::Scene, format!("the scene shows {name:?}, expected a field of the data")))
}

impl<'o> Tracer<'o, '_> {
    fn ends(&self) -> bool {
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
        let is_turned = light.is_some_and(|light| light.source == Source::Headlight) && normal.dot(self.dir) > 0.0;
        shading::ground(self.oracle.scene, color, if is_turned { -normal } else { normal }, self.dir)
    }

    fn core(&mut self, normal: DVec3) {
        if let Some(color) = self.oracle.scene.core {
            self.over(shading::ground(self.oracle.scene, DVec3::from_array(color), normal, self.dir), 1.0);
        }
    }

    fn column(&mut self, column: &Column) {
        let oracle = self.oracle;
        if column.is_void {
            let ray = Ray { eye: self.eye, dir: self.dir };
            if let Some([t, _]) = ray.inside(oracle.range[0], column.t) {
                self.core(self.at(t.to_f64()).normalize());
            }
            return;
        }
        let layered = LayeredColumn::new(column, oracle.layers, |cell, layer| oracle.radius(cell, layer));
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

    /// The surfaces on a layer, the first in front.
    fn layer(&mut self, layered: &LayeredColumn, layer: usize, t: Dd) {
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

    fn frustum(&mut self, layered: &LayeredColumn, gap: usize, ends: [Dd; 2]) {
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
        [from, to]: [f64; 2],
        length: f64,
    ) {
        let oracle = self.oracle;
        let middle = 0.5 * (from + to);
        let mut parts = Vec::new();
        for medium in &oracle.media {
            let of = |map: &'o Map| {
                let course = courses[map.field]?;
                Some((course, map.spans.at(course.base + course.f.at(middle))))
            };
            let (Some(color), Some(extinction)) = (of(&medium.color), of(&medium.extinction)) else { continue };
            if extinction.1.is_clear {
                continue;
            }
            let normal = self.gradient(medium.extinction.field, frustum, place);
            let normal =
                normal.map(|axes| axes.map(|Course { base, f }| FrustumInterpolant { f: f.f.map(|f| base + f), ..f }));
            parts.push(Part { color, extinction, normal });
        }
        if parts.is_empty() {
            return;
        }
        let (lighting, limit, eps) = (self.lighting.as_ref(), oracle.panel, frustum.eps);
        let blend = Blend { gauss: &oracle.gauss, parts, length, eps, lighting, limit };
        blend.add([from, to], &mut self.radiance);
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
