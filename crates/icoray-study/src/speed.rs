//! Seconds per frame: the paper's Table 2 scene, a multi-scale field under four transfer functions of 16 knots.

use crate::say;
use crate::scenes::multi_scale;
use crate::sphere::{self, Sphere};
use icoray::{Frame, Renderer, Result, Scene};
use std::io::Write;
use std::time::Instant;

/// What to measure.
#[derive(Debug, Clone, clap::Args)]
pub struct Options {
    /// Bisections of the icosahedron; 8 gives the paper's 655,362 cells.
    #[arg(long, default_value_t = 8)]
    pub level: u32,
    /// Layers.
    #[arg(long, default_value_t = 99)]
    pub layers: usize,
    /// Width and height of the picture.
    #[arg(long, default_value_t = 512)]
    pub size: u32,
    /// Threads.
    #[arg(long, default_value_t = 1)]
    pub threads: usize,
    /// Frames per transfer function; the median is reported.
    #[arg(long, default_value_t = 3)]
    pub frames: usize,
    /// Integration method: exact or paper.
    #[arg(long, default_value = "exact")]
    pub method: String,
    /// Precision: f32 or f64.
    #[arg(long, default_value = "f32")]
    pub precision: String,
    /// Light the scene with a headlight.
    #[arg(long)]
    pub lit: bool,
    /// Directory for the pictures, if they are wanted.
    #[arg(long)]
    pub out: Option<std::path::PathBuf>,
}

fn scene(options: &Options, opacity: multi_scale::Opacity) -> Result<Scene> {
    let rest = format!("method = \"{}\"\nprecision = \"{}\"", options.method, options.precision);
    let light = if options.lit { "[light]\nkind = \"headlight\"" } else { "" };
    multi_scale::scene(options.size, opacity, &rest, light)
}

/// Renders and prints a line per transfer function.
///
/// # Errors
/// Whatever the library says.
pub fn run(options: &Options, out: &mut dyn Write) -> Result<()> {
    let renderer = Renderer::new(options.threads)?;
    let start = Instant::now();
    let sphere = Sphere::new(options.level, options.layers, [1.0, 1.15], sphere::multi_scale)?;
    let made = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let grid = renderer.run(|| sphere.grid())?;
    say(
        out,
        &format!(
            "{} cells x {} layers, {} x {} pixels, {} thread(s), {} {}{}; mesh and field {made:.2} s, tables checked in {:.2} s, {} bytes derived",
            grid.cells(),
            options.layers,
            options.size,
            options.size,
            renderer.threads(),
            options.method,
            options.precision,
            if options.lit { ", lit" } else { "" },
            start.elapsed().as_secs_f64(),
            grid.derived_bytes(),
        ),
    )?;
    say(
        out,
        &format!(
            "{:>8} {:>10} {:>10} {:>10} {:>12} {:>12} {:>14}",
            "transfer", "render s", "prepare s", "rays", "columns", "frusta", "frusta/s"
        ),
    )?;
    for (name, opacity) in multi_scale::TRANSFERS {
        let scene = scene(options, opacity)?;
        let mut frames = Vec::new();
        for _ in 0..options.frames.max(1) {
            frames.push(renderer.render(&scene, &grid, &sphere.layers, &sphere.field()?)?);
        }
        frames.sort_by(|a, b| a.report.render_s.total_cmp(&b.report.render_s));
        let frame: &Frame = &frames[frames.len() / 2];
        let r = &frame.report;
        say(
            out,
            &format!(
                "{name:>8} {:>10.3} {:>10.3} {:>10} {:>12} {:>12} {:>14.3e}",
                r.render_s,
                r.prepare_s,
                r.counts.rays,
                r.counts.columns,
                r.counts.frusta,
                r.counts.frusta as f64 / r.render_s,
            ),
        )?;
        if let Some(directory) = &options.out {
            std::fs::create_dir_all(directory).map_err(|e| {
                icoray::Error::new(icoray::ErrorKind::Io, format!("{}: {e}", directory.display()))
            })?;
            icoray::output::write_picture(&directory.join(format!("speed_{name}.png")), frame)?;
        }
    }
    Ok(())
}
