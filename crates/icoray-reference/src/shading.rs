//! Lighting and composition of a scene, evaluated from its keys.

use glam::DVec3;
use icoray::{LightSource, Lighting, Scene};

/// Unit vector towards the light, for a ray along `dir`.
pub(crate) fn towards(source: &LightSource, dir: DVec3) -> DVec3 {
    match source {
        LightSource::Headlight => -dir,
        LightSource::Sun { lon_deg, lat_deg } => direction(lon_deg.to_radians(), lat_deg.to_radians()),
    }
}

/// Unit vector at a longitude and latitude.
pub fn direction(lon_rad: f64, lat_rad: f64) -> DVec3 {
    DVec3::new(lat_rad.cos() * lon_rad.cos(), lat_rad.cos() * lon_rad.sin(), lat_rad.sin())
}

/// The lighting of a scene for rays along one direction.
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

    /// Distance of two unit normals between which the shade may have an extremum.
    pub fn sharpness(&self) -> f64 {
        self.lighting.shininess.max(8.0).sqrt().recip()
    }

    /// The shade of a surface with the unit normal `normal`, or zero for none.
    #[inline]
    pub fn shade(&self, normal: DVec3) -> Shade {
        let light = &self.lighting;
        let body = light.ambient + light.diffuse * normal.dot(self.towards).abs();
        let gleam = normal.dot(self.halfway).abs();
        let highlight = if gleam > 0.0 { light.specular * gleam.powf(light.shininess) } else { 0.0 };
        Shade { body, highlight }
    }
}

/// A factor for the colour, and a white highlight.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shade {
    pub body: f64,
    pub highlight: f64,
}

impl Shade {
    pub const NONE: Self = Shade { body: 1.0, highlight: 0.0 };

    pub fn of(self, color: DVec3) -> DVec3 {
        self.body * color + self.highlight
    }
}

/// `color` under the scene's light, on a surface with the unit normal `normal` (or none).
pub(crate) fn lit(scene: &Scene, color: DVec3, normal: DVec3, dir: DVec3) -> DVec3 {
    RayLighting::new(scene, dir).map_or(Shade::NONE, |light| light.shade(normal)).of(color)
}

/// The opaque core's `color` under the scene's light, where its outward normal is `normal`.
pub(crate) fn ground(scene: &Scene, color: DVec3, normal: DVec3, dir: DVec3) -> DVec3 {
    let Some(light) = &scene.lighting else { return color };
    color * (light.ambient + light.diffuse * normal.dot(towards(&light.source, dir)).max(0.0))
}

/// Composites premultiplied RGBA over the background, if there is one.
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
