//! The light of a lit scene.

use super::Job;
use glam::DVec3;
use icoray_scene::Lights;

/// Blinn and Phong's model with the values that all rays of a frame share; see `kernel/shade.rs`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shading {
    /// The unlit part of the colour.
    pub ambient: f32,
    /// The part of the colour that is scaled by the light.
    pub diffuse: f32,
    /// Strength of the highlight.
    pub specular: f32,
    /// Exponent of the highlight.
    pub shininess: f32,
    /// The square of how many times faster than its normal a shade turns.
    pub sharpness: f32,
    /// Unit vector towards the light; `None` is a headlight, at the eye.
    pub towards_light: Option<[f64; 3]>,
}

impl Job<'_> {
    /// The shading, if rays are traced with light.
    pub fn shading(&self) -> Option<Shading> {
        let shading = self.plan.shading.filter(|_| self.quality().lights != Lights::Off)?;
        // All but the directions is equal along all rays.
        let ray = shading.along::<f32>(DVec3::Z);
        Some(Shading {
            ambient: ray.ambient,
            diffuse: ray.diffuse,
            specular: ray.specular,
            shininess: ray.shininess,
            sharpness: ray.sharpness,
            towards_light: shading.towards_light.map(|light| light.to_array()),
        })
    }
}
