//! The paper's Figure 6: the field is the distance to the centre, lit, on its low-resolution grid, beside a ground truth
//! in which value and gradient are exact at each sample and the layers are spheres.
//!
//! What remains is the grid's own error: layers of flat triangles lie up to `h²/6` inside the sphere (h the distance of
//! neighbouring cells), 2.4e-4 of the radius at n = 5. It is largest where rays graze a layer.

use crate::sphere::Sphere;
use crate::{look, progress, say};
use glam::DVec3;
use icoray::output::{Stamp, write_picture};
use icoray::{Error, ErrorKind, Frame, Method, Renderer, Result, Scene};
use rayon::prelude::*;
use std::io::Write;
use std::path::{Path, PathBuf};

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

/// How far a picture is from the ground truth.
#[derive(Debug, Clone, Copy)]
pub struct Distance {
    /// Root-mean-square difference over all channels.
    pub rmse: f64,
    /// Largest difference of a channel.
    pub max: f64,
    /// The same without the rays that pass between the core's sphere and its flat triangles, which see the core in one
    /// picture and the shell behind it in the other.
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
fn exact_ray(scene: &Scene, eye: DVec3, dir: DVec3, steps: usize) -> [f32; 4] {
    let along = -eye.dot(dir);
    let b2 = (eye + along * dir).length_squared();
    let half = |r: f64| (r * r - b2).max(0.0).sqrt();
    let (start, hits_core) = (along - half(OUTER), b2 < INNER * INNER);
    let end = if hits_core { along - half(INNER) } else { along + half(OUTER) };
    let (mut color, mut through) = (DVec3::ZERO, 1.0);
    let h = (end - start) / steps as f64;
    for i in 0..steps {
        let p = eye + (start + (i as f64 + 0.5) * h) * dir;
        let (own, extinction) = look::transfer(scene, OUTER - INNER, p.length());
        let absorbed = -(-extinction * h).exp_m1();
        color += through * absorbed * look::lit(scene, own, p.normalize(), dir);
        through *= 1.0 - absorbed;
    }
    if let (true, Some(core)) = (hits_core, scene.core) {
        let normal = (eye + end * dir).normalize();
        color += through * look::ground(scene, DVec3::from_array(core), normal, dir);
        through = 0.0;
    }
    let back = scene.background.map_or(DVec3::ZERO, DVec3::from_array);
    let [r, g, b] = (color + through * back).to_array().map(|c| c as f32);
    [r, g, b, if scene.background.is_some() { 1.0 } else { (1.0 - through) as f32 }]
}

/// The ground truth in the shape of a frame.
fn ground_truth(scene: &Scene, steps: usize, like: &Frame) -> Frame {
    let eye = DVec3::from_array(scene.camera.eye());
    let pixel = |i: u32| {
        let dir = scene.camera.direction(i % scene.width, i / scene.width, scene.width, scene.height);
        exact_ray(scene, eye, DVec3::from_array(dir), steps)
    };
    let pixels = (0..scene.width * scene.height).into_par_iter().map(pixel).collect();
    Frame { pixels, ..like.clone() }
}

fn distance(options: &Options, scene: &Scene, a: &Frame, b: &Frame) -> Distance {
    // Neighbouring cells are up to 1.2 times the mean of 63.4°/2ⁿ apart, and flat triangles h²/6 inside the sphere.
    let spacing = 1.2 * 1.107 / f64::from(1u32 << options.level);
    let inside = spacing * spacing / 6.0;
    let eye = DVec3::from_array(scene.camera.eye());
    let mut distance = Distance { rmse: 0.0, max: 0.0, max_off_limb: 0.0 };
    for (i, (x, y)) in (0u32..).zip(a.pixels.iter().zip(&b.pixels)) {
        let dir = scene.camera.direction(i % scene.width, i / scene.width, scene.width, scene.height);
        let off_centre = eye.cross(DVec3::from_array(dir)).length();
        let off_limb = !(INNER - inside..=INNER).contains(&off_centre);
        for k in 0..4 {
            let d = f64::from((x[k] - y[k]).abs());
            distance.rmse += d * d;
            distance.max = distance.max.max(d);
            distance.max_off_limb = distance.max_off_limb.max(if off_limb { d } else { 0.0 });
        }
    }
    distance.rmse = (distance.rmse / (4 * a.pixels.len()) as f64).sqrt();
    distance
}

/// Renders the field and its ground truth: frame, truth and how far they are apart.
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

/// Twenty times the difference, on black.
fn amplified(a: &Frame, b: &Frame) -> Frame {
    let pixel = |(x, y): (&[f32; 4], &[f32; 4])| {
        let [r, g, b] = [0, 1, 2].map(|k| 20.0 * (x[k] - y[k]).abs());
        [r, g, b, 1.0]
    };
    Frame { pixels: a.pixels.iter().zip(&b.pixels).map(pixel).collect(), ..a.clone() }
}

/// Writes the pictures and prints RMSE and maximum.
///
/// # Errors
/// Whatever the library says.
pub fn run(options: &Options, out: &mut dyn Write) -> Result<()> {
    let directory: &Path = &options.out;
    std::fs::create_dir_all(directory)
        .map_err(|e| Error::new(ErrorKind::Io, format!("{}: {e}", directory.display())))?;
    say(
        out,
        &format!(
            "{} layers, n = {}, {} x {} pixels, linear premultiplied channels 0 to 1",
            options.layers, options.level, options.size, options.size
        ),
    )?;
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
        write_picture(&directory.join(format!("fig6_{name}.png")), &frame)?;
        write_picture(&directory.join(format!("fig6_{name}_truth.png")), &truth)?;
        write_picture(
            &directory.join(format!("fig6_{name}_difference_x20.png")),
            &amplified(&frame, &truth),
        )?;
        let line = format!(
            "{name:>12}: RMSE {:.2e}, maximum {:.2e} ({:.2e} off the core's limb), rendered in {:.3} s",
            distance.rmse, distance.max, distance.max_off_limb, frame.report.render_s
        );
        bar.suspend(|| say(out, &line))?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    say(out, &format!("pictures in {}", directory.display()))?;
    Ok(())
}
