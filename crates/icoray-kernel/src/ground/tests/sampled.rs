//! Pictures of hard lines, sampled many times in each pixel.

use crate::ground::CROWDED;
use crate::ground::screen_jacobian::{ScreenJacobian, SurfaceHit, View};
use crate::plane::RayLine;
use glam::{DVec2, DVec3};
use icoray_scene::Scene;

/// Samples along a pixel's side.
const SAMPLES: usize = 16;

/// The surface of the lines.
#[derive(Debug, Clone, Copy)]
pub enum Surface {
    /// The unit sphere.
    Sphere,
    /// A plane.
    Plane { on: DVec3, normal: DVec3 },
}

/// A picture.
pub struct Sampled<'s> {
    pub scene: &'s Scene,
    pub surface: Surface,
    pub width: f64,
    /// Degrees between lines, by latitude: those that fade are not compared.
    pub apart: &'s dyn Fn(f64) -> f64,
}

/// Result of a comparison, over pixels that show only the surface, and not at a grazing angle.
#[derive(Debug, Clone, Copy)]
pub struct Off {
    /// Root of the mean square of the differences of pixels on and beside lines.
    pub rms: f64,
    /// Pixels that are covered in the sampled picture and in the other one.
    pub ink: f64,
    pub drawn: f64,
}

impl Surface {
    /// The intersection of the ray from `eye` towards `dir`.
    fn meets(self, eye: DVec3, dir: DVec3) -> Option<SurfaceHit> {
        match self {
            Surface::Sphere => {
                let line = RayLine::new(eye, dir, 1.0)?;
                Some(SurfaceHit::round(line.position(line.start)))
            }
            Surface::Plane { on, normal } => {
                let t = (on - eye).dot(normal) / dir.dot(normal);
                (t > 0.0).then(|| SurfaceHit { position: eye + t * dir, normal })
            }
        }
    }

    /// The intersection of a direction with the surface, if it is visible from the eye.
    fn lift(self, direction: DVec3, eye: DVec3) -> Option<DVec3> {
        match self {
            Surface::Sphere => (direction.dot(eye) > 1.0).then_some(direction),
            Surface::Plane { on, normal } => {
                let height = direction.dot(normal) / on.dot(normal);
                (height > 0.3).then(|| direction / height)
            }
        }
    }
}

impl Sampled<'_> {
    /// Compares with the result of `covered` for each pixel.
    pub fn compare(&self, polylines: &[Vec<DVec3>], covered: impl Fn(&SurfaceHit) -> f64) -> Off {
        /// Cosine between ray and normal.
        const GRAZING: f64 = 0.12;
        let picture = self.sample(polylines);
        let eye = DVec3::from_array(self.scene.camera.eye());
        let (width, height) = (self.scene.width, self.scene.height);
        let (mut squares, mut count) = (0.0, 0.0);
        let mut off = Off { rms: 0.0, ink: 0.0, drawn: 0.0 };
        for (i, expected) in picture.iter().enumerate() {
            let (x, y) = (i as u32 % width, i as u32 / width);
            let dir = DVec3::from_array(self.scene.camera.direction(x, y, width, height));
            let Some(hit) = self.surface.meets(eye, dir) else { continue };
            if hit.normal.normalize().dot(dir).abs() < GRAZING {
                continue;
            }
            let jacobian = ScreenJacobian::new(&View::of(self.scene), &hit).unwrap();
            let gap = (self.apart)(jacobian.lat_deg()).to_radians() * jacobian.min_stretch();
            if gap < CROWDED * self.width.max(1.0) {
                continue;
            }
            let found = covered(&hit);
            (off.ink, off.drawn) = (off.ink + expected, off.drawn + found);
            if *expected > 0.0 || found > 0.0 {
                (squares, count) = (squares + (found - expected).powi(2), count + 1.0);
            }
        }
        off.rms = f64::sqrt(squares / count);
        off
    }

    /// The fraction of each pixel that lies within half a line's width of a line.
    fn sample(&self, polylines: &[Vec<DVec3>]) -> Vec<f64> {
        let size = [self.scene.width, self.scene.height].map(|pixels| pixels as usize * SAMPLES);
        let mut is_line = vec![false; size[0] * size[1]];
        let ([forward, right, up], half) = self.scene.camera.frame();
        let [forward, right, up] = [forward, right, up].map(DVec3::from_array);
        let eye = DVec3::from_array(self.scene.camera.eye());
        let shown = |direction: &DVec3| {
            let seen = self.surface.lift(*direction, eye)? - eye;
            let depth = seen.dot(forward);
            let scale = 0.5 * size[1] as f64 / (half * depth);
            let middle = 0.5 * DVec2::new(size[0] as f64, size[1] as f64);
            (depth > 0.0).then(|| middle + scale * DVec2::new(seen.dot(right), -seen.dot(up)))
        };
        for polyline in polylines {
            for pair in polyline.windows(2) {
                if let (Some(from), Some(to)) = (shown(&pair[0]), shown(&pair[1])) {
                    stroke(&mut is_line, size, from, to, 0.5 * self.width * SAMPLES as f64);
                }
            }
        }
        let pixels = size[0] / SAMPLES * (size[1] / SAMPLES);
        let mut covered = vec![0.0; pixels];
        for (i, _) in is_line.iter().enumerate().filter(|(_, is_line)| **is_line) {
            let (x, y) = (i % size[0], i / size[0]);
            covered[y / SAMPLES * (size[0] / SAMPLES) + x / SAMPLES] += 1.0 / (SAMPLES * SAMPLES) as f64;
        }
        covered
    }
}

/// Marks all samples within `radius` of the line between two points.
fn stroke(is_line: &mut [bool], size: [usize; 2], from: DVec2, to: DVec2, radius: f64) {
    let range = |low: f64, high: f64, size: usize| {
        (low - radius).clamp(0.0, size as f64) as usize..(high + radius + 1.0).clamp(0.0, size as f64) as usize
    };
    for y in range(from.y.min(to.y), from.y.max(to.y), size[1]) {
        for x in range(from.x.min(to.x), from.x.max(to.x), size[0]) {
            let sample = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
            let along = to - from;
            let part = ((sample - from).dot(along) / along.length_squared().max(1e-300)).clamp(0.0, 1.0);
            is_line[y * size[0] + x] |= sample.distance(from + part * along) <= radius;
        }
    }
}
