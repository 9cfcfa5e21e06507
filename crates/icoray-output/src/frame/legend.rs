//! Contents of a frame's labels.

use icoray_scene::{Labels, Scene};

/// Contents of a frame's labels; a renderer makes it for scenes with labels.
#[derive(Debug, Clone, PartialEq)]
pub struct Legend {
    /// The labels of the scene.
    pub(crate) labels: Labels,
    /// The scene as drawn, with known ranges of its colours.
    pub(crate) scene: Scene,
    /// The radius of the ground, exaggerated.
    pub(crate) inner: f64,
    /// The outermost layer's radius, exaggerated.
    pub(crate) outer: f64,
}

impl Legend {
    /// The legend of a scene, if it requests one.
    pub fn of(scene: &Scene, radius: &[f64]) -> Option<Box<Self>> {
        let labels = scene.labels.clone()?;
        let [inner, outer] = [radius.first(), radius.last()].map(|radius| radius.copied().unwrap_or(1.0));
        Some(Box::new(Legend { labels, scene: scene.clone(), inner, outer }))
    }

    /// The radius of the ground, the innermost layer's, exaggerated, planet radii.
    pub fn ground_radius(&self) -> f64 {
        self.inner
    }
}
