//! Speed of the gradients at all vertices of a field, beside a plain copy of as many bytes.
//!
//! The pass reads a field in single precision once and writes 8 bytes per vertex; the copy reads and writes 6 bytes per
//! vertex, each thread a part of its own. Runs alternate, and memory is in use before the first one that counts. Cells
//! are numbered along a space-filling curve, as models do it, or with `--generated` in the order of the generator.

use crate::renumber::along_curve;
use crate::results::say;
use crate::scenes::multi_scale;
use crate::speed::{self, Size};
use icoray::{Grid, IcosahedralMesh, Reals, Renderer, Result};
use icoray_grid::gradient::{GradientOptions, Gradients, gradients};
use icoray_grid::samples::Samples;
use icoray_reference::sphere::{self, Sphere};
use rayon::prelude::*;
use std::hint::black_box;
use std::io::Write;
use std::time::Instant;

/// Options of the measurement.
#[derive(Debug, Clone, clap::Args)]
pub struct Options {
    /// Bisections of the icosahedron x layers.
    #[arg(long, value_parser = speed::size, default_value = "8x99")]
    pub size: Size,
    /// Numbers of threads.
    #[arg(long, value_delimiter = ',', value_parser = speed::count, default_values_t = [1, 2])]
    pub threads: Vec<usize>,
    /// Leave the cells in the order in which the mesh is generated: neighbours are far from each other in memory.
    #[arg(long)]
    pub generated: bool,
    /// Runs of each; the least time is reported.
    #[arg(long, default_value_t = 7)]
    pub runs: usize,
}

/// Bytes per vertex that the pass reads and writes.
const VERTEX_BYTES: usize = size_of::<f32>() + size_of::<u64>();

/// Measures and prints a line per number of threads.
pub fn run(options: &Options, out: &mut dyn Write) -> Result<()> {
    let Size { level, layers } = options.size;
    let mut mesh = IcosahedralMesh::new(level)?;
    if !options.generated {
        along_curve(&mut mesh);
    }
    let sphere = Sphere::over(mesh, layers, [1.0, 1.15], sphere::multi_scale)?;
    let grid = sphere.grid()?;
    let bytes = sphere.values.len() * VERTEX_BYTES;
    say!(out, "{} cells x {layers} layers, {:.1} MB read and written", grid.cells(), bytes as f64 / 1e6)?;
    for &threads in &options.threads {
        let seconds = measure(&Renderer::new(threads)?, &sphere, &grid, options.runs)?;
        let [copy, single, double] = seconds.map(|seconds| bytes as f64 / seconds / 1e9);
        let [copy_s, single_s, double_s] = seconds;
        say!(
            out,
            "{threads} threads: copy {copy_s:.4} s, {copy:.2} GB/s; stencil {single_s:.4} s, {single:.2} GB/s, {:.0} % \
             of the copy; double precision {double_s:.4} s, {double:.2} GB/s",
            100.0 * single / copy
        )?;
    }
    Ok(())
}

/// Least seconds of the copy, of the stencil and of the gradients in double precision.
fn measure(renderer: &Renderer, sphere: &Sphere, grid: &Grid, runs: usize) -> Result<[f64; 3]> {
    let field = sphere.field()?;
    let Reals::F32(values) = field.samples() else { unreachable!("the sphere's values are f32") };
    let samples = Samples::new(values, &field, false, multi_scale::RANGE);
    let words = values.len() * VERTEX_BYTES / (2 * size_of::<u64>());
    let (source, mut target) = (vec![1u64; words], vec![0u64; words]);
    let part = words.div_ceil(renderer.threads()).max(1);
    let mut copy = || {
        let parts = target.par_chunks_mut(part).zip(source.par_chunks(part));
        parts.for_each(|(target, source)| target.copy_from_slice(black_box(source)));
    };
    let mut memory = Gradients::none();
    let mut pass = |single: bool| -> Result<f64> {
        let start = Instant::now();
        let options = GradientOptions { visible: None, packed: true, single };
        let old = std::mem::replace(&mut memory, Gradients::none());
        memory = gradients(grid, sphere.layers.radius_m(), &samples, 0..grid.cells(), options, old)?;
        black_box(&memory);
        Ok(start.elapsed().as_secs_f64())
    };
    let mut least = [f64::INFINITY; 3];
    for run in 0..=runs.max(1) {
        let seconds = [renderer.run(|| timed(&mut copy)), renderer.run(|| pass(true))?];
        let double = if run <= 2 { renderer.run(|| pass(false))? } else { f64::INFINITY };
        if run > 0 {
            least = [least[0].min(seconds[0]), least[1].min(seconds[1]), least[2].min(double)];
        }
    }
    Ok(least)
}

fn timed(work: impl FnOnce()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64()
}
