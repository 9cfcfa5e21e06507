//! The paper's Figure 6: the distance to the centre, lit, on the low-resolution grid, against a ground truth with exact
//! values and gradients and spherical layers.
//!
//! The difference is the grid's own error: layers of flat triangles lie up to `h²/6` inside the sphere (h the distance
//! of neighbouring cells), 2.4e-4 of the radius at n = 5. It is largest where rays graze a layer.

use crate::comparison::Comparison;
use crate::oracle::Spans;
use crate::ray::Ray;
use crate::shading::{self, over};
use crate::sphere::Sphere;
use glam::DVec3;
use icoray::{Frame, Method, Renderer, Result, Scene};
use rayon::prelude::*;

/// Radius of the innermost layer.
pub const INNER: f64 = 1.0;
/// Radius of the outermost layer.
pub const OUTER: f64 = 1.15;

/// The scene, in pictures of `size` × `size` pixels; `lit` by a sun.
///
/// # Errors
/// As [`Scene::parse`].
pub fn scene(size: u32, lit: bool) -> Result<Scene> {
    let light = if lit { "[light]\nkind = \"sun\"\nlon = 65\nlat = 45" } else { "" };
    Scene::parse(&format!(
        r##"field = "distance to the centre"
precision = "f64"
antialias = false
core = "#26303a"
[image]
width = {size}
height = {size}
[camera]
lon = 25
lat = 20
distance = 3.4
fov = 42
[transfer]
unit_length = 0.02
knots = [ {{ value = 1.000, color = "#3b0f70", opacity = 0.0 }}, {{ value = 1.020, color = "#3b0f70", opacity = 0.10 }},
          {{ value = 1.045, color = "#8c2981", opacity = 0.0 }}, {{ value = 1.060, color = "#de4968", opacity = 0.12 }},
          {{ value = 1.080, color = "#fe9f6d", opacity = 0.0 }}, {{ value = 1.110, color = "#fe9f6d", opacity = 0.0 }},
          {{ value = 1.125, color = "#fcfdbf", opacity = 0.10 }}, {{ value = 1.140, color = "#fcfdbf", opacity = 0.0 }} ]
{light}
"##
    ))
}

/// Light along one ray through perfect spheres, by the midpoint rule between the exact ends of the shell.
fn exact_ray(scene: &Scene, spans: &Spans, ray: &Ray, steps: usize) -> [f32; 4] {
    let dir = ray.dir;
    let along = -ray.eye.dot(dir);
    let b2 = ray.at(along).length_squared();
    let half = |r: f64| (r * r - b2).max(0.0).sqrt();
    let (start, hits_core) = (along - half(OUTER), b2 < INNER * INNER);
    let end = if hits_core { along - half(INNER) } else { along + half(OUTER) };
    let (mut color, mut transmittance) = (DVec3::ZERO, 1.0);
    let h = (end - start) / steps as f64;
    for i in 0..steps {
        let p = ray.at(start + (i as f64 + 0.5) * h);
        let span = spans.at(p.length());
        let alpha = -(-span.extinction(0.0, p.length()) * h).exp_m1();
        color += transmittance * alpha * shading::lit(scene, span.color(0.0, p.length()), p.normalize(), dir);
        transmittance *= 1.0 - alpha;
    }
    if let (true, Some(core)) = (hits_core, scene.core) {
        let normal = ray.at(end).normalize();
        color += transmittance * shading::ground(scene, DVec3::from_array(core), normal, dir);
        transmittance = 0.0;
    }
    over(scene.background, [color.x, color.y, color.z, 1.0 - transmittance]).map(|c| c as f32)
}

fn ground_truth(scene: &Scene, steps: usize, like: &Frame) -> Frame {
    let spans = Spans::new(&scene.volumes[0].transfer, OUTER - INNER);
    let pixel = |i: u32| exact_ray(scene, &spans, &Ray::of_pixel(scene, i), steps);
    let pixels = (0..scene.width * scene.height).into_par_iter().map(pixel).collect();
    Frame { pixels, ..like.clone() }
}

/// The mesh and picture of a comparison.
#[derive(Debug, Clone, Copy)]
pub struct Radial {
    /// Bisections of the icosahedron; 5 is the paper's.
    pub level: u32,
    /// Layers; 61 is the paper's.
    pub layers: usize,
    /// Width and height of the pictures.
    pub size: u32,
    /// Midpoint steps of the ground truth along each ray.
    pub steps: usize,
    /// The renderer's method.
    pub method: Method,
    /// Whether a sun lights the scene.
    pub is_lit: bool,
}

/// The picture, the ground truth, and the error.
#[derive(Debug, Clone)]
pub struct Compared {
    /// The renderer's picture.
    pub frame: Frame,
    /// The ground truth.
    pub truth: Frame,
    /// Root-mean-square difference over all channels.
    pub rmse: f64,
    /// Largest difference of a channel.
    pub max: f64,
    /// The same without rays between the core's sphere and its flat triangles, which hit the core in one picture only.
    pub max_off_limb: f64,
}

impl Radial {
    /// Renders the field and its ground truth.
    ///
    /// # Errors
    /// As [`Sphere::new`] and [`Renderer::render`].
    pub fn compare(&self) -> Result<Compared> {
        let sphere = Sphere::new(self.level, self.layers, [INNER, OUTER], |p| p.length())?;
        let scene = Scene { method: self.method, ..scene(self.size, self.is_lit)? };
        let frame = sphere.with_job(&scene, |job| job.render(&Renderer::new(0)?))?;
        let truth = ground_truth(&scene, self.steps, &frame);
        // Neighbouring cells are up to 1.2 times the mean of 63.4°/2ⁿ apart, and flat triangles h²/6 inside the sphere.
        let spacing = 1.2 * 1.107 / f64::from(1u32 << self.level);
        let limb = INNER - spacing * spacing / 6.0..=INNER;
        let Comparison { rmse, max, pixel_errors } = Comparison::new(&frame.pixels, &truth.pixels);
        let is_off_limb = |i: u32| {
            let ray = Ray::of_pixel(&scene, i);
            !limb.contains(&ray.eye.cross(ray.dir).length())
        };
        let off_limb = (0..).zip(pixel_errors).filter(|(i, _)| is_off_limb(*i));
        let max_off_limb = off_limb.map(|(_, error)| error).fold(0.0, f64::max);
        Ok(Compared { frame, truth, rmse, max, max_off_limb })
    }
}
