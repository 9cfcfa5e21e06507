//! The light of a lit scene.

use super::Job;
use glam::DVec3;
use icoray_scene::Lights;

/// Blinn and Phong's model, with what is the same for all rays of a frame; see `kernel/shade.rs`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shading {
    /// Part of the colour that is there without light.
    pub ambient: f32,
    /// Part of the colour that needs light.
    pub diffuse: f32,
    /// Strength of the highlight.
    pub specular: f32,
    /// Its exponent.
    pub shininess: f32,
    /// How many times faster than its normal a shade turns, squared.
    pub sharpness: f32,
    /// Unit vector towards the light; `None` is a headlight, at the eye.
    pub towards_light: Option<[f64; 3]>,
}

impl Job<'_> {
    /// The light, where rays are traced with any.
    pub fn shading(&self) -> Option<Shading> {
        let shading = self.plan.shading.filter(|_| self.quality().lights != Lights::Off)?;
        // All but the directions is the same along all rays.
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
