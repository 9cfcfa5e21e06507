//! Scenes to ten digits: volumes, isosurfaces, surfaces, cuts and layers of any heights, in f64 and by other numerical
//! methods than the renderer's.
//!
//! A ray's columns and layers are found in double-double, over all triangles of a small mesh; [`picture`] takes the
//! columns of [`icoray::Traversal`] instead, which any mesh affords. Each frustum is cut at the extremum of every field,
//! at knots, bounds of cuts and surfaces; the smooth pieces between are integrated by panels of order 16. Values are
//! taken relative to a vertex of the frustum, so that errors are measured by the field's variation in a frustum, not by
//! its size.

mod blend;
mod gauss;
mod gradients;
mod interpolant;
mod spans;
#[cfg(test)]
mod tests;
mod tracer;
pub(crate) mod way;

pub(crate) use blend::{Blend, Course, MIN_TRANSMITTANCE, Part, Radiance};
pub(crate) use gauss::Gauss;
pub(crate) use gradients::gradients;
pub(crate) use interpolant::FrustumInterpolant;
pub(crate) use spans::{Span, Spans};

use crate::job::{Job, PreparedJob};
use crate::shading::direction;
use crate::stability::path::{Ray, columns};
use glam::DVec3;
use gradients::GradientInput;
use icoray::{Clip, Error, ErrorKind, Grid, Heights, Layers, Renderer, Result, Scene, Stretch, TransferFunction};
use std::ops::ControlFlow;
use tracer::Tracer;

/// Optical depth of a panel.
pub(crate) const PANEL: f64 = 0.25;

/// All pixels of a job, row by row from the top: premultiplied linear RGBA over the background. The renderer's traversal
/// finds the frusta; the core is round, and volumes alone are shown.
///
/// Unlit pixels are right to 1e-10 whatever the transfer function, lit ones to 1e-8, as far as f64 defines the picture:
/// a step met by a value that is constant along the ray to rounding, or a value that turns inside a spike a millionth
/// wide, magnifies the rounding of the ray's points.
///
/// # Errors
/// As [`icoray::Plan::new`].
pub fn picture(job: &Job, renderer: &Renderer) -> Result<Vec<[f64; 4]>> {
    walk(job, renderer, PANEL)
}

/// As [`picture`], with panels of the given optical depth.
fn walk(job: &Job, renderer: &Renderer, panel: f64) -> Result<Vec<[f64; 4]>> {
    with(job, panel, |oracle, prepared| {
        prepared.pixels(renderer, |x, y, hint| {
            let (eye, dir) = prepared.ray(x, y);
            oracle.walked(prepared, eye, dir, hint)
        })
    })
}

/// The same as [`picture`] by intersection with all triangles, in place of the traversal; NaN where the mesh has a gap.
///
/// # Errors
/// As [`icoray::Plan::new`].
pub fn brute_force(job: &Job, renderer: &Renderer) -> Result<Vec<[f64; 4]>> {
    with(job, PANEL, |oracle, prepared| {
        prepared.pixels(renderer, |x, y, _| {
            let (eye, dir) = prepared.ray(x, y);
            oracle.pixel(eye, dir).unwrap_or([f64::NAN; 4])
        })
    })
}

/// Prepares a job for `work`, with panels of the given optical depth.
fn with<R>(job: &Job, panel: f64, work: impl FnOnce(&Oracle, &PreparedJob) -> R) -> Result<R> {
    let prepared = PreparedJob::new(job)?;
    let (field, layers) = (prepared.field(), prepared.radius.len());
    let places = (0..job.grid.cells() as u32).flat_map(|cell| (0..layers).map(move |layer| (cell, layer)));
    let values = places.map(|(cell, layer)| prepared.value(&field, cell, layer)).collect();
    let layers = job.layers.for_field(layers)?;
    let fields = [(job.scene.volumes[0].field.as_str(), values)];
    let data = Data { grid: job.grid, layers: &layers, heights: &[], fields: &fields };
    Ok(work(&Oracle::new(job.scene, data, panel)?, &prepared))
}

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
pub(crate) struct Oracle<'a> {
    scene: &'a Scene,
    data: Data<'a>,
    /// Radii of the layers, or of all cells' layers on native heights, planet radii.
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

impl<'a> Oracle<'a> {
    /// Prepares gradients and transfer functions; `panel` is the most optical depth of a panel.
    ///
    /// # Errors
    /// As [`Layers::shell`]; [`ErrorKind::Scene`] where a field is unknown.
    pub fn new(scene: &'a Scene, data: Data<'a>, panel: f64) -> Result<Self> {
        let shell = data.layers.shell(scene.exaggeration)?;
        let layers = shell.len();
        let stretch = scene.exaggeration / data.layers.planet_radius_m();
        let is_native = scene.scenery.heights == Heights::Native;
        let radius: Vec<f64> = match is_native {
            true => data.heights.iter().map(|height| 1.0 + stretch * height).collect(),
            false => shell.clone(),
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
            let radius = |cell, layer| if is_native { radius[at(cell, layer)] } else { radius[layer] };
            let value = |cell, layer| values[at(cell, layer)];
            GradientInput { grid: data.grid, layers, radius, value, partial: is_native }.gradients()
        };
        let lit = data.fields.iter().filter(|_| scene.lighting.is_some());
        let (gradients, range) = (lit.map(gradients).collect(), [lowest, highest]);
        Ok(Oracle { scene, data, radius, layers, range, media, gradients, gauss: Gauss::new(), panel })
    }

    /// Premultiplied linear RGBA along a ray, over the background; `None` where the mesh has a gap.
    pub fn pixel(&self, eye: DVec3, dir: DVec3) -> Option<[f64; 4]> {
        let mut tracer = Tracer::new(self, eye, dir);
        let inner = self.scene.core.map(|_| self.range[0]);
        for column in columns(self.data.grid, &Ray { eye, dir }, self.range[1], inner).ok()? {
            tracer.column(&column);
            if tracer.ends() {
                break;
            }
        }
        Some(tracer.pixel())
    }

    /// The same along the traversal, below which the core is round.
    fn walked(&self, prepared: &PreparedJob, eye: DVec3, dir: DVec3, hint: &mut u32) -> [f64; 4] {
        let mut tracer = Tracer::new(self, eye, dir);
        prepared.traversal.ray(eye, dir, hint, |stretch| {
            match stretch {
                Stretch::Frustum(frustum) => tracer.stretch(frustum),
                Stretch::Core { t } => tracer.core((eye + *t * dir).normalize()),
            }
            if tracer.ends() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        tracer.pixel()
    }

    fn radius(&self, cell: u32, layer: usize) -> f64 {
        let is_native = self.scene.scenery.heights == Heights::Native;
        self.radius[if is_native { cell as usize * self.layers + layer } else { layer }]
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

/// Composites over the background, if there is one.
pub(crate) fn over(background: Option<[f64; 3]>, [r, g, b, a]: [f64; 4]) -> [f64; 4] {
    match background {
        None => [r, g, b, a],
        Some(back) => {
            let transmittance = 1.0 - a;
            [r + transmittance * back[0], g + transmittance * back[1], b + transmittance * back[2], 1.0]
        }
    }
}

/// Unit vector of a gradient of any size; zero for none.
pub(crate) fn direction_of(gradient: DVec3) -> DVec3 {
    let largest = gradient.abs().max_element();
    if largest > 0.0 && largest.is_finite() { (gradient / largest).normalize() } else { DVec3::ZERO }
}
