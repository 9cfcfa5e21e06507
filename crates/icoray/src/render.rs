//! The CPU renderer: a scene's work on a thread pool of its own.

use crate::error::Result;
use crate::field::{CenterField, Field};
use crate::frame::{Certainty, Counts, ErrorSummary, Frame, FrameReport};
use crate::gradient::gradients;
use crate::grid::{Grid, Reals};
use crate::kernel::Real;
use crate::kernel::column::Shell;
use crate::kernel::piece::{Light, Method};
use crate::kernel::ray::{Budget, Caster};
use crate::kernel::sample::{Sample, Samples};
use crate::kernel::transfer::Spans;
use crate::layers::Layers;
use crate::output::Stamp;
use crate::plan::Plan;
use crate::quality::{Deadline, Lights, Quality};
use crate::raster::{Pixel, Raster};
use crate::scene::{Precision, Scene};
use crate::threads::Threads;
use glam::DVec3;
use std::time::Instant;

/// A CPU renderer with its own threads, which have ended when it is dropped.
#[derive(Debug)]
pub struct Renderer {
    threads: Threads,
}

impl Renderer {
    /// A renderer with `threads` threads, or as many as the affinity mask allows when that is 0.
    ///
    /// # Errors
    /// [`ErrorKind::Io`](crate::ErrorKind::Io) when the threads cannot be made.
    pub fn new(threads: usize) -> Result<Self> {
        Ok(Renderer { threads: Threads::new(threads)? })
    }

    /// Number of threads.
    pub fn threads(&self) -> usize {
        self.threads.count()
    }

    /// Runs `work` on the renderer's threads: parallel passes inside use them and no others.
    pub fn run<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        self.threads.run(work)
    }

    /// Renders `scene`.
    ///
    /// # Errors
    /// As [`Plan::new`].
    pub fn render(&self, scene: &Scene, grid: &Grid, layers: &Layers, field: &Field) -> Result<Frame> {
        let plan = Plan::new(scene, grid, layers, field)?;
        self.run(|| {
            let start = Instant::now();
            let center = plan.from_corners.then(|| CenterField::average(grid, field)).transpose()?;
            let derived = center.as_ref().map_or(0, CenterField::bytes);
            let field = center.as_ref().map_or(*field, CenterField::field);
            let mut frame = match (field.samples(), scene.precision) {
                (Reals::F32(data), Precision::F32) => {
                    draw::<f32, f32>(scene, &plan, grid, &field, data, start)
                }
                (Reals::F32(data), Precision::F64) => {
                    draw::<f64, f32>(scene, &plan, grid, &field, data, start)
                }
                (Reals::F64(data), Precision::F32) => {
                    draw::<f32, f64>(scene, &plan, grid, &field, data, start)
                }
                (Reals::F64(data), Precision::F64) => {
                    draw::<f64, f64>(scene, &plan, grid, &field, data, start)
                }
            };
            frame.report.derived_bytes += derived;
            frame.report.threads = self.threads();
            Ok(frame)
        })
    }
}

fn draw<T: Real, S: Sample>(
    scene: &Scene,
    plan: &Plan,
    grid: &Grid,
    field: &Field,
    data: &[S],
    start: Instant,
) -> Frame {
    let spans = Spans::<T>::new(&plan.knots);
    let shell = Shell::<T>::new(&plan.radius);
    let samples = Samples::new(data, field, plan.falling, spans.range());
    let (value_range, missing_values) = field.range();
    let deadline = Deadline::of(scene, start);
    let mut quality = asked(scene);
    let sample = |part: usize| gradients(grid, &plan.radius, &samples, 0..grid.cells().div_ceil(part));
    let is_short = |d: Deadline| !d.has_time_for_gradients(1.0 / 64.0, || drop(sample(64)));
    if plan.shading.is_some() && deadline.is_some_and(is_short) {
        quality.lights = Lights::Off;
    }
    let vertex_gradients = if quality.lights == Lights::Off { Vec::new() } else { sample(1) };
    let prepare_s = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let work =
        Work { scene, plan, grid, shell: &shell, spans: &spans, samples, gradients: &vertex_gradients };
    let (drawn, counts, quality) = if quality.lights == Lights::Off {
        work.draw::<1>(quality, deadline)
    } else {
        work.draw::<4>(quality, deadline)
    };
    let error: Vec<f32> = drawn.iter().map(|p| p.error).collect();
    let report = FrameReport {
        error: ErrorSummary::of(&error, certainty(scene, &quality)),
        prepare_s,
        render_s: start.elapsed().as_secs_f64(),
        counts,
        value_range,
        missing_values,
        quality,
        derived_bytes: size_of_val(vertex_gradients.as_slice()),
        left_out: plan.left_out().to_vec(),
        ..FrameReport::default()
    };
    let [low, high] = scene.transfer.range();
    let notes = vec![
        ("transfer range", format!("{low} to {high}")),
        ("camera", scene.camera.describe()),
        ("exaggeration", scene.exaggeration.to_string()),
    ];
    Frame {
        width: scene.width,
        height: scene.height,
        pixels: drawn.iter().map(|p| p.color).collect(),
        error,
        field: scene.field.clone(),
        notes,
        stamp: Stamp::default(),
        report,
    }
}

/// What the scene asks for.
fn asked(scene: &Scene) -> Quality {
    let lights = if scene.lighting.is_some() { Lights::Full } else { Lights::Off };
    Quality { pixel_step: 1, tolerance: scene.tolerance, lights }
}

/// All that rays need, prepared.
struct Work<'f, T, S> {
    scene: &'f Scene,
    plan: &'f Plan,
    grid: &'f Grid<'f>,
    shell: &'f Shell<T>,
    spans: &'f Spans<T>,
    samples: Samples<'f, S>,
    gradients: &'f [[f32; 3]],
}

impl<T: Real, S: Sample> Work<'_, T, S> {
    /// Draws the picture in the quality that is asked, or in the best one that keeps the deadline.
    fn draw<const N: usize>(
        &self,
        asked: Quality,
        deadline: Option<Deadline>,
    ) -> (Vec<Pixel>, Counts, Quality) {
        let raster = Raster { width: self.scene.width, height: self.scene.height, step: 1 };
        let trace = |quality: &Quality, raster: Raster| {
            let caster = self.caster::<N>(quality);
            raster.draw(|x, y, hint, counts| pixel(self.scene, &caster, x, y, hint, counts))
        };
        let quality = match deadline {
            Some(deadline) => deadline.pick(asked, raster, |quality, raster| drop(trace(quality, raster))),
            None => asked,
        };
        let (pixels, counts) = trace(&quality, Raster { step: quality.pixel_step, ..raster });
        (pixels, counts, quality)
    }

    fn caster<const N: usize>(&self, quality: &Quality) -> Caster<'_, T, S, N> {
        let is_lit = quality.lights != Lights::Off;
        Caster {
            grid: self.grid,
            shell: self.shell,
            spans: self.spans,
            samples: self.samples,
            gradients: self.gradients,
            method: self.scene.method,
            budget: Budget::new(quality.tolerance, brightest(self.scene)),
            shading: self.plan.shading.filter(|_| is_lit),
            is_coarse: quality.lights == Lights::Coarse,
            core: self.scene.core,
        }
    }
}

/// The most that a channel can hold behind a ray's end: the brightest of what is in the scene.
fn brightest(scene: &Scene) -> f64 {
    let most = |colors: &mut dyn Iterator<Item = [f64; 3]>| colors.flatten().fold(0.0, f64::max);
    let field = most(&mut scene.transfer.knots.iter().map(|k| k.color));
    let lit = scene.lighting.map_or(field, |l| (l.ambient + l.diffuse) * field + l.specular);
    let core = most(&mut scene.core.into_iter()) * scene.lighting.map_or(1.0, |l| l.ambient + l.diffuse);
    // A transparent picture has an opacity that goes to 1.
    let back = scene.background.map_or(1.0, |back| most(&mut [back].into_iter()));
    lit.max(core).max(back).max(0.01)
}

/// Only an unlit integral in f64 is bounded throughout, where each pixel is traced.
fn certainty(scene: &Scene, quality: &Quality) -> Certainty {
    let is_exact = scene.method == Method::Exact && scene.precision == Precision::F64;
    let is_bound = is_exact && scene.lighting.is_none() && quality.pixel_step == 1;
    if is_bound { Certainty::Bound } else { Certainty::Estimate }
}

/// Standard deviations of rounding that the error of a pixel counts. Each rounding's largest size, 1.7 times its standard
/// deviation, stands for the latter.
const DEVIATIONS: f64 = 4.0;

/// What rounding of positions may do to a ray that grazes an edge of the mesh.
const GEOMETRY: f64 = 1e-9;

/// The light of one pixel, over the background.
fn pixel<T: Real, S: Sample, const N: usize>(
    scene: &Scene,
    caster: &Caster<'_, T, S, N>,
    x: u32,
    y: u32,
    hint: &mut u32,
    counts: &mut Counts,
) -> Pixel {
    let dir = DVec3::from_array(scene.camera.direction(x, y, scene.width, scene.height));
    let met = caster.trace(DVec3::from_array(scene.camera.eye()), dir, hint, counts);
    let light = met.unwrap_or(Light::none());
    let absorbed = light.absorbed.wide();
    let color = light.color.map(T::wide);
    let color = match scene.background {
        None => [color[0], color[1], color[2], absorbed],
        Some(back) => {
            let [r, g, b] = [0, 1, 2].map(|k| color[k] + (1.0 - absorbed) * back[k]);
            [r, g, b, 1.0]
        }
    };
    let rounding = DEVIATIONS * light.variance.wide().sqrt();
    // The picture itself is in f32.
    let stored = color.iter().fold(0.0f64, |most, c| most.max(*c)) * f64::from(f32::EPSILON) / 2.0;
    let error = if met.is_some() { light.error.wide() + rounding + stored + GEOMETRY } else { 0.0 };
    Pixel { color: color.map(|c| c as f32), error: error.min(caster.budget.brightest.max(1.0)) as f32 }
}
