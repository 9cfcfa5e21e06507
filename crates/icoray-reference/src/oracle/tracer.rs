//! One ray through a scene: its columns, layers and frusta, cut into pieces between surfaces.

use super::blend::{Blend, FieldInSpan, MIN_TRANSMITTANCE, Radiance, VolumePiece};
use super::interpolant::FrustumInterpolant;
use super::prepared::{FieldTransfer, Oracle};
use crate::columns::{Column, FrustumWeights, LayeredColumn};
use crate::double_double::Dd;
use crate::ray::Ray;
use crate::shading::{self, RayLighting, Shade, direction_of, over};
use glam::DVec3;
use icoray::{Level, LightSource, Paint};

pub(super) struct Tracer<'o, 'a> {
    oracle: &'o Oracle<'a>,
    ray: Ray,
    lighting: Option<RayLighting>,
    /// Distances at which it passes a bound of a cut.
    bounds: Vec<f64>,
    radiance: Radiance,
}

/// A surface in a frustum: number of an isosurface, or of a surface at a height.
enum Met {
    Isosurface(usize),
    Sheet(usize),
}

/// An end of a piece, and the surface there.
struct Break {
    u: f64,
    met: Option<Met>,
}

/// A frustum on the ray, with the fields of the data along it.
struct FrustumFields {
    cells: [u32; 3],
    /// The lower layer.
    layer: usize,
    weights: FrustumWeights,
    /// By field; `None` where a value is missing.
    fields: Vec<Option<FrustumInterpolant>>,
    /// Distance at which the ray enters, and length in the frustum.
    start: f64,
    length: f64,
}

impl FrustumFields {
    fn t(&self, u: f64) -> f64 {
        self.start + u * self.length
    }
}

impl<'o, 'a> Tracer<'o, 'a> {
    pub fn new(oracle: &'o Oracle<'a>, ray: Ray) -> Self {
        let lighting = RayLighting::new(oracle.scene, ray.dir);
        let bounds = oracle.scene.scenery.clips.iter().flat_map(|clip| oracle.bounds(clip, ray)).collect();
        Tracer { oracle, ray, lighting, bounds, radiance: Radiance::NONE }
    }

    /// Premultiplied linear RGBA over the background.
    pub fn pixel(&self) -> [f64; 4] {
        let [r, g, b] = self.radiance.color.to_array();
        over(self.oracle.scene.background, [r, g, b, 1.0 - self.radiance.transmittance])
    }

    pub fn ends(&self) -> bool {
        self.radiance.transmittance <= MIN_TRANSMITTANCE
    }

    fn over(&mut self, color: DVec3, opacity: f64) {
        self.radiance.color += self.radiance.transmittance * opacity * color;
        self.radiance.transmittance *= 1.0 - opacity;
    }

    /// The colour of a surface on a layer or at a height; a headlight lights its visible side.
    fn lit(&self, color: DVec3, normal: DVec3) -> DVec3 {
        let light = self.oracle.scene.lighting;
        let is_turned =
            light.is_some_and(|light| light.source == LightSource::Headlight) && normal.dot(self.ray.dir) > 0.0;
        shading::ground(self.oracle.scene, color, if is_turned { -normal } else { normal }, self.ray.dir)
    }

    pub fn core(&mut self, normal: DVec3) {
        if let Some(color) = self.oracle.scene.core {
            self.over(shading::ground(self.oracle.scene, DVec3::from_array(color), normal, self.ray.dir), 1.0);
        }
    }

    pub fn column(&mut self, column: &Column) {
        let oracle = self.oracle;
        if column.is_void {
            if let Some([t, _]) = self.ray.inside(oracle.range[0], column.t) {
                self.core(self.ray.at(t.to_f64()).normalize());
            }
            return;
        }
        let layered = self.layered(column);
        for pair in layered.crossings().windows(2) {
            let ends = [pair[0].t, pair[1].t];
            if ends[0] < ends[1] {
                match layered.layers_below((ends[0] + ends[1]) / 2.0) {
                    0 => {
                        let weight = layered.on_layer(0, ends[0]);
                        self.core(oracle.normal(column.cells, 0, weight, self.ray.at(ends[0].to_f64())));
                    }
                    below if below < oracle.layers => self.frustum(&layered, below - 1, ends),
                    _ => {}
                }
            }
            if let Some(layer) = pair[1].layer {
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
        let (oracle, cells, at) = (self.oracle, layered.column.cells, self.ray.at(t.to_f64()));
        for surface in &oracle.scene.scenery.surfaces {
            let number = match surface.at {
                Level::Layer(number) => number,
                Level::Top => oracle.layers - 1,
                Level::Ground | Level::Height(_) => continue,
            };
            if number == layer && oracle.shows([layer, layer], at) {
                let weight = layered.on_layer(layer, t);
                let color = paint(&surface.paint, |name| {
                    let values = &oracle.data.fields[oracle.data.find(name).ok()?].values;
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

    fn frustum(&mut self, layered: &LayeredColumn<'_, impl Fn(u32, usize) -> f64>, layer: usize, ends: [Dd; 2]) {
        let (oracle, cells) = (self.oracle, layered.column.cells);
        let weights = layered.frustum(layer, ends);
        let interpolant = |values: &[f64]| FrustumInterpolant::new(&weights, oracle.six(cells, layer, |i| values[i]));
        let fields = oracle.data.fields.iter().map(|field| interpolant(&field.values)).collect();
        let (start, length) = (ends[0].to_f64(), (ends[1] - ends[0]).to_f64());
        let frustum = FrustumFields { cells, layer, weights, fields, start, length };
        let mut done = 0.0;
        for Break { u, met } in self.breaks(layered, &frustum, ends) {
            let is_shown = |u: f64| oracle.shows([layer, layer + 1], self.ray.at(frustum.t(u)));
            let (is_piece_shown, is_surface_shown) = (is_shown(0.5 * (done + u)), is_shown(u));
            if u > done && is_piece_shown {
                self.piece(&frustum, [done, u]);
            }
            done = u;
            if let Some(met) = met.filter(|_| is_surface_shown) {
                self.surface(met, &frustum, u);
            }
            if self.ends() {
                return;
            }
        }
    }

    /// The ends of a frustum's pieces, in order.
    fn breaks(
        &self,
        layered: &LayeredColumn<'_, impl Fn(u32, usize) -> f64>,
        frustum: &FrustumFields,
        ends: [Dd; 2],
    ) -> Vec<Break> {
        let oracle = self.oracle;
        let mut breaks = vec![Break { u: 1.0, met: None }];
        for (number, field) in frustum.fields.iter().enumerate() {
            if let Some(field) = field {
                self.field_breaks(number, field, &mut breaks);
            }
        }
        let bounds = self.bounds.iter().map(|t| (Dd::from(*t) - ends[0]).to_f64() / frustum.length);
        breaks.extend(bounds.map(|u| Break { u, met: None }));
        for (k, surface) in oracle.scene.scenery.surfaces.iter().enumerate() {
            if let Level::Height(height) = surface.at
                && let Some(t) = layered.meets(oracle.radius_of(height)).filter(|t| ends[0] <= *t && *t < ends[1])
            {
                let u = ((t - ends[0]) / (ends[1] - ends[0])).to_f64();
                breaks.push(Break { u, met: Some(Met::Sheet(k)) });
            }
        }
        breaks.retain(|Break { u, .. }| (0.0..=1.0).contains(u));
        breaks.sort_by(|a, b| a.u.total_cmp(&b.u));
        breaks
    }

    /// Where a field turns, meets a knot or an isosurface.
    fn field_breaks(&self, number: usize, field: &FrustumInterpolant, breaks: &mut Vec<Break>) {
        let (oracle, base) = (self.oracle, field.base);
        let turn = field.extremum();
        breaks.extend(turn.map(|u| Break { u, met: None }));
        let middle = turn.unwrap_or(1.0);
        for [from, to] in [[0.0, middle], [middle, 1.0]] {
            let [start, end] = [from, to].map(|u| field.at(u));
            let (low, high) = (start.min(end), start.max(end));
            let transfers = oracle.media.iter().flat_map(|medium| [&medium.color, &medium.extinction]);
            for transfer in transfers.filter(|transfer| transfer.field == number) {
                let knots = transfer.spans.knots_between(base + low, base + high).iter().map(|knot| knot - base);
                let inside = knots.filter(|knot| low < *knot && *knot < high);
                breaks.extend(inside.map(|knot| Break { u: field.meets(knot, from, to), met: None }));
            }
            for (k, surface) in oracle.scene.scenery.isosurfaces.iter().enumerate() {
                let value = surface.value - base;
                if oracle.data.fields[number].name == surface.field && (start >= value) != (end >= value) {
                    breaks.push(Break { u: field.meets(value, from, to), met: Some(Met::Isosurface(k)) });
                }
            }
        }
    }

    fn gradient(&self, field: usize, frustum: &FrustumFields) -> Option<[FrustumInterpolant; 3]> {
        let gradients = self.oracle.gradients.get(field)?;
        let six = |axis: usize| self.oracle.six(frustum.cells, frustum.layer, |i| gradients[i][axis]);
        let axis = |axis: usize| FrustumInterpolant::new(&frustum.weights, six(axis));
        Some([axis(0)?, axis(1)?, axis(2)?])
    }

    fn piece(&mut self, frustum: &FrustumFields, range: [f64; 2]) {
        let oracle = self.oracle;
        let middle = 0.5 * (range[0] + range[1]);
        let mut parts = Vec::new();
        for medium in &oracle.media {
            let of = |transfer: &'o FieldTransfer| {
                let field = frustum.fields[transfer.field].as_ref()?;
                Some(FieldInSpan::new(field, range, transfer.spans.at(field.value(middle))))
            };
            let (Some(color), Some(extinction)) = (of(&medium.color), of(&medium.extinction)) else { continue };
            if extinction.span.is_clear {
                continue;
            }
            let normal = self.gradient(medium.extinction.field, frustum);
            let normal = normal.map(|axes| axes.map(|axis| axis.part(range, 0.0, range.map(|u| axis.value(u)))));
            parts.push(VolumePiece { color, extinction, normal });
        }
        if parts.is_empty() {
            return;
        }
        let length = frustum.length * (range[1] - range[0]);
        let (lighting, limit) = (self.lighting.as_ref(), oracle.panel);
        Blend { gauss: &oracle.gauss, parts, length, lighting, limit }.add(&mut self.radiance);
    }

    fn surface(&mut self, met: Met, frustum: &FrustumFields, u: f64) {
        let oracle = self.oracle;
        let value = |name: &str| Some(frustum.fields[oracle.data.find(name).ok()?].as_ref()?.value(u));
        match met {
            Met::Isosurface(k) => {
                let surface = &oracle.scene.scenery.isosurfaces[k];
                let Some(color) = paint(&surface.paint, value) else { return };
                let field = oracle.data.find(&surface.field).unwrap_or_default();
                let shade = match (&self.lighting, self.gradient(field, frustum)) {
                    (Some(lighting), Some(axes)) => {
                        lighting.shade(direction_of(DVec3::from_array(axes.map(|axis| axis.value(u)))))
                    }
                    _ => Shade::NONE,
                };
                self.over(shade.of(color), surface.opacity);
            }
            Met::Sheet(k) => {
                let surface = &oracle.scene.scenery.surfaces[k];
                if let Some(color) = paint(&surface.paint, value) {
                    self.over(self.lit(color, self.ray.at(frustum.t(u)).normalize()), surface.opacity);
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
