//! A scene over data, prepared for the rays of the oracle.

use super::gauss::Gauss;
use super::gradients::GradientInput;
use super::spans::Spans;
use crate::ray::Ray;
use crate::shading::direction;
use glam::DVec3;
use icoray::{Clip, Error, ErrorKind, Grid, Heights, Layers, Result, Scene, TransferFunction};

/// A mesh with fields at its cells.
#[derive(Debug, Clone, Copy)]
pub struct Data<'a> {
    /// The mesh.
    pub grid: &'a Grid<'a>,
    /// Layers from the innermost on.
    pub layers: &'a Layers,
    /// Heights of each column's layers in metres, level-fastest; for scenes with native heights.
    pub heights: &'a [f64],
    /// The fields.
    pub fields: &'a [NamedField<'a>],
}

/// A field at cells.
#[derive(Debug, Clone)]
pub struct NamedField<'a> {
    /// Its name in scenes.
    pub name: &'a str,
    /// Values, level-fastest; NaN where one is missing.
    pub values: Vec<f64>,
}

#[derive(Debug)]
pub(super) struct FieldTransfer {
    pub field: usize,
    pub spans: Spans,
}

#[derive(Debug)]
pub(super) struct Medium {
    pub color: FieldTransfer,
    pub extinction: FieldTransfer,
}

/// A scene over data, to be evaluated.
#[derive(Debug)]
pub struct Oracle<'a> {
    pub(super) scene: &'a Scene,
    pub(super) data: Data<'a>,
    /// Radii of the layers, or of all cells' layers on native heights, planet radii.
    radius: Vec<f64>,
    pub(super) layers: usize,
    /// Least radius of the innermost layer, that of the core below holes, and greatest radius of all.
    pub(super) range: [f64; 2],
    pub(super) media: Vec<Medium>,
    /// Gradients of each field at all vertices, in a lit scene.
    pub(super) gradients: Vec<Vec<DVec3>>,
    pub(super) gauss: Gauss,
    /// Largest optical depth of a panel.
    pub(super) panel: f64,
}

impl<'a> Oracle<'a> {
    /// Prepares gradients and transfer functions; `panel` is the largest optical depth of a panel, such as
    /// [`super::PANEL`].
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
            Ok(FieldTransfer { field: data.find(name)?, spans: Spans::new(transfer, thickness) })
        };
        let medium = |volume: &icoray::Volume| {
            let own = (&volume.field, &volume.transfer);
            let (by, extinction) = volume.opacity.as_ref().map_or(own, |by| (&by.field, &by.transfer));
            Ok(Medium { color: map(own.0, own.1)?, extinction: map(by, extinction)? })
        };
        let media = scene.volumes.iter().map(medium).collect::<Result<_>>()?;
        let gradients = |NamedField { values, .. }: &NamedField| {
            let at = |cell: u32, layer: usize| cell as usize * layers + layer;
            let radius = |cell, layer| if is_native { radius[at(cell, layer)] } else { radius[layer] };
            let value = |cell, layer| values[at(cell, layer)];
            GradientInput { grid: data.grid, layers, radius, value, partial: is_native }.gradients()
        };
        let lit = data.fields.iter().filter(|_| scene.lighting.is_some());
        let (gradients, range) = (lit.map(gradients).collect(), [lowest, highest]);
        Ok(Oracle { scene, data, radius, layers, range, media, gradients, gauss: Gauss::new(), panel })
    }

    pub(super) fn radius(&self, cell: u32, layer: usize) -> f64 {
        let is_native = self.scene.scenery.heights == Heights::Native;
        self.radius[if is_native { cell as usize * self.layers + layer } else { layer }]
    }

    pub(super) fn radius_of(&self, height_m: f64) -> f64 {
        1.0 + self.scene.exaggeration * height_m / self.data.layers.planet_radius_m()
    }

    /// Values of a quantity at the vertices below and above a gap.
    pub(super) fn six(&self, cells: [u32; 3], gap: usize, value: impl Fn(usize) -> f64) -> [f64; 6] {
        [0, 1, 2, 3, 4, 5].map(|k| value(cells[k % 3] as usize * self.layers + gap + k / 3))
    }

    /// All places where a ray may pass a bound of a cut.
    pub(super) fn bounds(&self, clip: &Clip, Ray { eye, dir }: Ray) -> Vec<f64> {
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
    pub(super) fn shows(&self, layers: [usize; 2], at: DVec3) -> bool {
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
    pub(super) fn normal(&self, cells: [u32; 3], layer: usize, weight: [f64; 3], at: DVec3) -> DVec3 {
        if self.scene.scenery.heights == Heights::Mean {
            return at.normalize();
        }
        let grid = self.data.grid;
        let place = |cell: u32| self.radius(cell, layer) * grid.direction(cell);
        let vertex = |cell: u32| {
            let facets = grid.triangles_around(cell).map(|triangle| {
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

impl Data<'_> {
    /// The number of a field.
    pub(super) fn find(&self, name: &str) -> Result<usize> {
        let found = self.fields.iter().position(|field| field.name == name);
        let context = || format!("the scene shows {name:?}, expected a field of the data");
        found.ok_or_else(|| Error::new(ErrorKind::Scene, context()))
    }
}
