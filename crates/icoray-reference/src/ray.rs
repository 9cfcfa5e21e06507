//! The rays of a scene.

use crate::double_double::Dd;
use glam::DVec3;
use icoray::Scene;

/// A ray as the renderer is given it: all numbers are taken as exact.
#[derive(Debug, Clone, Copy)]
pub struct Ray {
    /// The ray's origin.
    pub eye: DVec3,
    /// The ray's direction: a unit vector to rounding.
    pub dir: DVec3,
}

impl Ray {
    /// The ray of pixel `i`, row by row from the top.
    pub fn of_pixel(scene: &Scene, i: u32) -> Self {
        let dir = scene.camera.direction(i % scene.width, i / scene.width, scene.width, scene.height);
        Ray { eye: scene.camera.eye().into(), dir: dir.into() }
    }

    /// The point at distance `t`.
    pub fn at(&self, t: f64) -> DVec3 {
        self.eye + t * self.dir
    }

    /// The part of a stretch of the ray inside the sphere of `radius`.
    pub(crate) fn inside(&self, radius: f64, [from, to]: [Dd; 2]) -> Option<[Dd; 2]> {
        let dot = |a: DVec3, b: DVec3| Dd::product(a.x, b.x) + Dd::product(a.y, b.y) + Dd::product(a.z, b.z);
        // |eye + t·dir|² = radius²
        let (a, b) = (dot(self.dir, self.dir), dot(self.eye, self.dir));
        let square = b * b - a * (dot(self.eye, self.eye) - Dd::product(radius, radius));
        if square <= Dd::ZERO {
            return None;
        }
        let half = square.sqrt();
        let (first, last) = (from.max((-b - half) / a), to.min((half - b) / a));
        (first < last).then_some([first, last])
    }
}
