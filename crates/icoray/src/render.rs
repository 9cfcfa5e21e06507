//! The CPU renderer: tiles over a thread pool.
//!
//! A picture is cut into tiles of 32 × 32 pixels whatever the number of threads, and each tile starts its search for the
//! first column afresh: two renders are bitwise equal on any number of threads.

use crate::error::{Error, ErrorKind, Result};
use crate::field::{CenterField, Field};
use crate::frame::{Counts, Frame, FrameReport};
use crate::gradient::gradients;
use crate::grid::{Grid, Reals};
use crate::kernel::Real;
use crate::kernel::column::Shell;
use crate::kernel::ray::Caster;
use crate::kernel::sample::{Sample, Samples};
use crate::kernel::transfer::Spans;
use crate::layers::Layers;
use crate::output::Stamp;
use crate::plan::Plan;
use crate::scene::{Precision, Scene};
use glam::DVec3;
use rayon::prelude::*;
use std::time::Instant;

/// Side of a tile in pixels.
const TILE: u32 = 32;

/// A CPU renderer with its own threads.
#[derive(Debug)]
pub struct Renderer {
    pool: rayon::ThreadPool,
}

impl Renderer {
    /// A renderer with `threads` threads, or as many as the affinity mask allows when that is 0.
    ///
    /// # Errors
    /// [`ErrorKind::Argument`] when the threads cannot be made.
    pub fn new(threads: usize) -> Result<Self> {
        let name = |i| format!("icoray-{i}");
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).thread_name(name).build();
        let pool =
            pool.map_err(|e| Error::new(ErrorKind::Argument, format!("cannot make {threads} threads: {e}")))?;
        Ok(Renderer { pool })
    }

    /// Number of threads.
    pub fn threads(&self) -> usize {
        self.pool.current_num_threads()
    }

    /// Runs `work` on the renderer's threads: parallel passes inside use them and no others.
    pub fn run<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        self.pool.install(work)
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
    let gradients = if plan.shading.is_some() { gradients(grid, &plan.radius, &samples) } else { Vec::new() };
    let prepare_s = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let (pixels, counts) = if plan.shading.is_some() {
        let caster: Caster<'_, T, S, 4> = caster(scene, plan, grid, &shell, &spans, samples, &gradients);
        tiles(scene, |x, y, hint, counts| pixel(scene, &caster, x, y, hint, counts))
    } else {
        let caster: Caster<'_, T, S, 1> = caster(scene, plan, grid, &shell, &spans, samples, &gradients);
        tiles(scene, |x, y, hint, counts| pixel(scene, &caster, x, y, hint, counts))
    };
    let report = FrameReport {
        prepare_s,
        render_s: start.elapsed().as_secs_f64(),
        counts,
        value_range,
        missing_values,
        derived_bytes: size_of_val(gradients.as_slice()),
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
        pixels,
        field: scene.field.clone(),
        notes,
        stamp: Stamp::default(),
        report,
    }
}

fn caster<'f, T: Real, S: Sample, const N: usize>(
    scene: &Scene,
    plan: &Plan,
    grid: &'f Grid<'f>,
    shell: &'f Shell<T>,
    spans: &'f Spans<T>,
    samples: Samples<'f, S>,
    gradients: &'f [[f32; 3]],
) -> Caster<'f, T, S, N> {
    Caster {
        grid,
        shell,
        spans,
        samples,
        gradients,
        method: scene.method,
        shading: plan.shading,
        core: scene.core,
    }
}

/// The light of one pixel, over the background.
fn pixel<T: Real, S: Sample, const N: usize>(
    scene: &Scene,
    caster: &Caster<'_, T, S, N>,
    x: u32,
    y: u32,
    hint: &mut u32,
    counts: &mut Counts,
) -> [f32; 4] {
    let dir = DVec3::from_array(scene.camera.direction(x, y, scene.width, scene.height));
    let light = caster.trace(DVec3::from_array(scene.camera.eye()), dir, hint, counts);
    let absorbed = light.absorbed.wide();
    let color = light.color.map(T::wide);
    match scene.background {
        None => [color[0] as f32, color[1] as f32, color[2] as f32, absorbed as f32],
        Some(back) => {
            let [r, g, b] = [0, 1, 2].map(|k| (color[k] + (1.0 - absorbed) * back[k]) as f32);
            [r, g, b, 1.0]
        }
    }
}

/// Renders all tiles, dealt to threads one by one, and lays them out as rows.
fn tiles(
    scene: &Scene,
    pixel: impl Fn(u32, u32, &mut u32, &mut Counts) -> [f32; 4] + Sync,
) -> (Vec<[f32; 4]>, Counts) {
    let (width, height) = (scene.width, scene.height);
    let (across, down) = (width.div_ceil(TILE), height.div_ceil(TILE));
    let tile = |number: u32| {
        let (x0, y0) = (number % across * TILE, number / across * TILE);
        let (x1, y1) = ((x0 + TILE).min(width), (y0 + TILE).min(height));
        let mut counts = Counts::default();
        let mut pixels = Vec::with_capacity(((x1 - x0) * (y1 - y0)) as usize);
        let mut row_hint = 0;
        for y in y0..y1 {
            let mut hint = row_hint;
            for x in x0..x1 {
                pixels.push(pixel(x, y, &mut hint, &mut counts));
                if x == x0 {
                    row_hint = hint;
                }
            }
        }
        (pixels, counts)
    };
    let tiles: Vec<_> = (0..across * down).into_par_iter().with_max_len(1).map(tile).collect();
    let mut picture = vec![[0.0; 4]; width as usize * height as usize];
    let mut counts = Counts::default();
    for (number, (pixels, tile_counts)) in (0u32..).zip(&tiles) {
        counts += *tile_counts;
        let (x0, y0) = ((number % across * TILE) as usize, (number / across * TILE) as usize);
        let side = (TILE as usize).min(width as usize - x0);
        for (row, line) in pixels.chunks_exact(side).enumerate() {
            let start = (y0 + row) * width as usize + x0;
            picture[start..start + side].copy_from_slice(line);
        }
    }
    (picture, counts)
}
