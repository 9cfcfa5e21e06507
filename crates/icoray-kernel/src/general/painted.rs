//! The light of lines and grounds at places that a device's rays meet: a device finds the facet, these rays its light.

use super::{RaySettings, RayState, SurfaceHeight};
use crate::ground::SurfaceHit;
use crate::piece::Radiance;
use crate::plane::RayLine;
use crate::signature::EyeDistance;
use glam::{DVec3, Vec3};
use icoray_grid::array::MapInline;

/// A place at which a ray meets lines on a surface layer, or a core with a ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PaintedPlace {
    /// Distance along the ray from its closest point to the centre, planet radii; rounded.
    pub t: f64,
    /// The triangle above or below the place.
    pub triangle: u32,
    /// The number of the surface layer; `None` is the core.
    pub surface: Option<usize>,
}

/// Bound of the rounding of [`PaintedPlace::t`].
const NEAR: f64 = 1e-6;

impl RaySettings<'_, '_> {
    /// The light of the lines, or of the core, that the ray from `eye` along `dir` meets at a place.
    pub fn painted(&self, eye: DVec3, dir: DVec3, place: &PaintedPlace) -> Radiance<f64> {
        let line = RayLine::new(eye, dir, self.scene.outer);
        let ray = line.map(|line| RayState::from_eye(self, line, dir, EyeDistance::new(eye, dir)));
        ray.map_or(Radiance::none(), |ray| ray.painted(place))
    }
}

impl RayState<'_, '_> {
    fn painted(&self, place: &PaintedPlace) -> Radiance<f64> {
        let (scene, line) = (self.scene, &self.line);
        let cells = scene.grid.triangle(place.triangle);
        let height = place.surface.map_or(SurfaceHeight::Layer(0), |k| scene.surface_layers[k].place);
        let (inverse, normals) = match height {
            SurfaceHeight::Layer(layer) => {
                (scene.levels.inverse(cells, layer), scene.normals.iter().find(|(known, _)| *known == layer))
            }
            SurfaceHeight::Radius(radius) => ([1.0 / radius; 3], None),
        };
        let [a, b, c] = cells.map_inline(|cell| scene.grid.direction(cell));
        let volume = a.dot(b.cross(c));
        // The products of a place with these are the weights of the vertices; their sum is 1 on the facet.
        let [wa, wb, wc] = [b.cross(c) * inverse[0], c.cross(a) * inverse[1], a.cross(b) * inverse[2]];
        let plane = (wa + wb + wc) / volume;
        let t = (1.0 - plane.dot(line.position(0.0))) / plane.dot(line.plane.y);
        let position = line.position(if (t - place.t).abs() < NEAR { t } else { place.t });
        let normal = normals.map_or(position, |(_, normals)| {
            let [x, y, z] = cells.map_inline(|cell| Vec3::from_array(normals[cell as usize]).as_dvec3());
            (x * wa.dot(position) + y * wb.dot(position) + z * wc.dot(position)) / volume
        });
        let (hit, over) = (SurfaceHit { position, normal }, (scene.grid, place.triangle));
        match (place.surface, scene.core) {
            (Some(k), _) => scene.surface_layers[k].lines(self.solid(normal), &hit, over),
            (None, Some(core)) => {
                let body = self.shading.as_ref().map_or(1.0, |shading| shading.solid(normal.normalize_or_zero()));
                core.light(&hit, Some(over), body)
            }
            (None, None) => Radiance::none(),
        }
    }
}
