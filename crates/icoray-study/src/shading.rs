//! Rays and lighting of a scene, evaluated from its keys, for references.

use glam::DVec3;
use icoray::{LightSource, Lighting, Scene};

/// Unit direction of the ray of pixel `i`, row by row from the top.
pub(crate) fn pixel_direction(scene: &Scene, i: u32) -> DVec3 {
    scene.camera.direction(i % scene.width, i / scene.width, scene.width, scene.height).into()
}

/// Unit vector towards the light, for a ray along `dir`.
pub(crate) fn towards(source: &LightSource, dir: DVec3) -> DVec3 {
    match source {
        LightSource::Headlight => -dir,
        LightSource::Sun { lon_deg, lat_deg } => direction(lon_deg.to_radians(), lat_deg.to_radians()),
    }
}

/// Unit vector at a longitude and latitude.
pub(crate) fn direction(lon_rad: f64, lat_rad: f64) -> DVec3 {
    DVec3::new(lat_rad.cos() * lon_rad.cos(), lat_rad.cos() * lon_rad.sin(), lat_rad.sin())
}

/// The lighting of a scene for rays along one direction.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RayLighting {
    lighting: Lighting,
    /// Unit vector towards the light.
    pub towards: DVec3,
    /// Unit vector half-way between light and eye; zero if the light is opposite to the eye.
    pub halfway: DVec3,
}

impl RayLighting {
    /// For rays along `dir`; `None` in an unlit scene.
    pub fn new(scene: &Scene, dir: DVec3) -> Option<Self> {
        let lighting = scene.lighting?;
        let towards = towards(&lighting.source, dir);
        Some(RayLighting { lighting, towards, halfway: (towards - dir).normalize_or_zero() })
    }

    /// Distance of two unit normals over which a shade may have changed beyond what is between.
    pub fn sharpness(&self) -> f64 {
        self.lighting.shininess.max(8.0).sqrt().recip()
    }

    /// Factor for the colour, and the white highlight, on a surface with the unit normal `normal`, or zero for none.
    #[inline]
    pub fn shade(&self, normal: DVec3) -> (f64, f64) {
        let light = &self.lighting;
        let body = light.ambient + light.diffuse * normal.dot(self.towards).abs();
        let gleam = normal.dot(self.halfway).abs();
        (body, if gleam > 0.0 { light.specular * gleam.powf(light.shininess) } else { 0.0 })
    }
}

/// `color` under the scene's light, on a surface with the unit normal `normal` (or none).
pub(crate) fn lit(scene: &Scene, color: DVec3, normal: DVec3, dir: DVec3) -> DVec3 {
    let Some(light) = RayLighting::new(scene, dir) else { return color };
    let (body, highlight) = light.shade(normal);
    color * body + highlight
}

/// The opaque core's `color` under the scene's light, where its outward normal is `normal`.
pub(crate) fn ground(scene: &Scene, color: DVec3, normal: DVec3, dir: DVec3) -> DVec3 {
    let Some(light) = &scene.lighting else { return color };
    color * (light.ambient + light.diffuse * normal.dot(towards(&light.source, dir)).max(0.0))
}
