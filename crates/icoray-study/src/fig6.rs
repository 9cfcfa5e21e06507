//! The paper's Figure 6: the distance to the centre, lit, on the low-resolution grid, against a ground truth with exact
//! values and gradients and spherical layers.
//!
//! The difference is the grid's own error: layers of flat triangles lie up to `h²/6` inside the sphere (h the distance
//! of neighbouring cells), 2.4e-4 of the radius at n = 5. It is largest where rays graze a layer.

use crate::compare::Comparison;
use crate::montage::amplified;
use crate::oracle::{Spans, over};
use crate::results::{make_directory, progress, say};
use crate::shading::{self, pixel_direction};
use crate::sphere::Sphere;
use glam::DVec3;
use icoray::output::{Stamp, write_picture};
use icoray::{Frame, Method, Renderer, Result, Scene};
use rayon::prelude::*;
use std::io::Write;
use std::path::PathBuf;

/// What to draw.
#[derive(Debug, Clone, clap::Args)]
pub struct Options {
    /// Bisections of the icosahedron; 5 is the paper's.
    #[arg(long, default_value_t = 5)]
    pub level: u32,
    /// Layers; 61 is the paper's.
    #[arg(long, default_value_t = 61)]
    pub layers: usize,
    /// Width and height of the pictures.
    #[arg(long, default_value_t = 512)]
    pub size: u32,
    /// Midpoint steps of the ground truth along each ray.
    #[arg(long, default_value_t = 4000)]
    pub steps: usize,
    /// Directory of the pictures.
    #[arg(long, default_value = "out/fig6")]
    pub out: PathBuf,
}

/// Radii of the innermost and outermost layer.
pub(crate) const INNER: f64 = 1.0;
pub(crate) const OUTER: f64 = 1.15;

/// Error of a picture against the ground truth.
#[derive(Debug, Clone, Copy)]
pub struct Distance {
    /// Root-mean-square difference over all channels.
    pub rmse: f64,
    /// Largest difference of a channel.
    pub max: f64,
    /// The same without rays between the core's sphere and its flat triangles, which hit the core in one picture only.
    pub max_off_limb: f64,
}

/// The scene; `lit` by a sun.
pub(crate) fn scene(size: u32, lit: bool) -> Result<Scene> {
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
fn exact_ray(scene: &Scene, spans: &Spans, eye: DVec3, dir: DVec3, steps: usize) -> [f32; 4] {
    let along = -eye.dot(dir);
    let b2 = (eye + along * dir).length_squared();
    let half = |r: f64| (r * r - b2).max(0.0).sqrt();
    let (start, hits_core) = (along - half(OUTER), b2 < INNER * INNER);
    let end = if hits_core { along - half(INNER) } else { along + half(OUTER) };
    let (mut color, mut transmittance) = (DVec3::ZERO, 1.0);
    let h = (end - start) / steps as f64;
    for i in 0..steps {
        let p = eye + (start + (i as f64 + 0.5) * h) * dir;
        let span = spans.at(p.length());
        let alpha = -(-span.extinction(0.0, p.length()) * h).exp_m1();
        color += transmittance * alpha * shading::lit(scene, span.color(0.0, p.length()), p.normalize(), dir);
        transmittance *= 1.0 - alpha;
    }
    if let (true, Some(core)) = (hits_core, scene.core) {
        let normal = (eye + end * dir).normalize();
        color += transmittance * shading::ground(scene, DVec3::from_array(core), normal, dir);
        transmittance = 0.0;
    }
    over(scene.background, [color.x, color.y, color.z, 1.0 - transmittance]).map(|c| c as f32)
}

/// The ground truth as a frame.
fn ground_truth(scene: &Scene, steps: usize, like: &Frame) -> Frame {
    let eye = DVec3::from_array(scene.camera.eye());
    let spans = Spans::new(&scene.volumes[0].transfer, OUTER - INNER);
    let pixel = |i: u32| exact_ray(scene, &spans, eye, pixel_direction(scene, i), steps);
    let pixels = (0..scene.width * scene.height).into_par_iter().map(pixel).collect();
    Frame { pixels, ..like.clone() }
}

fn distance(options: &Options, scene: &Scene, a: &Frame, b: &Frame) -> Distance {
    // Neighbouring cells are up to 1.2 times the mean of 63.4°/2ⁿ apart, and flat triangles h²/6 inside the sphere.
    let spacing = 1.2 * 1.107 / f64::from(1u32 << options.level);
    let inside = spacing * spacing / 6.0;
    let eye = DVec3::from_array(scene.camera.eye());
    let off_limb = |(i, _): &(u32, f64)| {
        let off_centre = eye.cross(pixel_direction(scene, *i)).length();
        !(INNER - inside..=INNER).contains(&off_centre)
    };
    let Comparison { rmse, max, pixel_errors } = Comparison::new(&a.pixels, &b.pixels);
    let max_off_limb = (0..).zip(pixel_errors).filter(off_limb).fold(0.0, |max: f64, (_, d)| max.max(d));
    Distance { rmse, max, max_off_limb }
}

/// Renders the field and its ground truth; returns frame, truth and their distance.
///
/// # Errors
/// Whatever the library says.
pub fn compare(options: &Options, method: Method, lit: bool) -> Result<(Frame, Frame, Distance)> {
    let sphere = Sphere::new(options.level, options.layers, [INNER, OUTER], |p| p.length())?;
    let mut scene = scene(options.size, lit)?;
    scene.method = method;
    let frame = Renderer::new(0)?.render(&scene, &sphere.grid()?, &sphere.layers, &sphere.field()?)?;
    let truth = ground_truth(&scene, options.steps, &frame);
    let distance = distance(options, &scene, &frame, &truth);
    Ok((frame, truth, distance))
}

/// Writes the pictures and prints RMSE and maximum.
///
/// # Errors
/// Whatever the library says.
pub fn run(options: &Options, out: &mut dyn Write) -> Result<()> {
    make_directory(&options.out)?;
    let save = |name: String, frame: &Frame| write_picture(&options.out.join(name), frame);
    let Options { level, layers, size, .. } = options;
    say!(out, "{layers} layers, n = {level}, {size} x {size} pixels, linear premultiplied channels 0 to 1")?;
    let bar = progress(4, "fig6");
    for (name, method, lit) in [
        ("lit", Method::Exact, true),
        ("unlit", Method::Exact, false),
        ("lit_paper", Method::Paper, true),
        ("unlit_paper", Method::Paper, false),
    ] {
        bar.set_message(name);
        let (mut frame, truth, distance) = compare(options, method, lit)?;
        frame.stamp = Stamp::default();
        save(format!("fig6_{name}.png"), &frame)?;
        save(format!("fig6_{name}_truth.png"), &truth)?;
        let difference = Frame { pixels: amplified(&frame.pixels, &truth.pixels, 20.0), ..frame.clone() };
        save(format!("fig6_{name}_difference_x20.png"), &difference)?;
        let Distance { rmse, max, max_off_limb } = distance;
        let seconds = frame.report.timing.render_s;
        bar.suspend(|| {
            say!(
                out,
                "{name:>12}: RMSE {rmse:.2e}, maximum {max:.2e} ({max_off_limb:.2e} off the core's limb), rendered in {seconds:.3} s"
            )
        })?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    say!(out, "pictures in {}", options.out.display())
}
