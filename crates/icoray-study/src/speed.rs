//! Seconds per frame: the paper's Table 2 scene, a multi-scale field under four transfer functions of 16 knots.

use crate::say;
use crate::sphere::{Sphere, multi_scale};
use icoray::{Frame, Renderer, Result, Scene};
use std::fmt::Write as _;
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

type Opacity = fn(f64) -> f64;

/// A transfer function of 16 knots over [-1, 1]: name and the opacity of a shell's thickness at each knot.
const TRANSFERS: [(&str, Opacity); 4] = [
    ("dense", |_| 0.5),
    ("lobes", |v| if v.abs() > 0.3 { 0.98 * (v.abs() - 0.3) / 0.7 } else { 0.0 }),
    ("thin", |v| if (0.45..0.62).contains(&v) { 0.98 } else { 0.0 }),
    ("opaque", |v| if v > -0.2 { 0.999_999_9 } else { 0.0 }),
];

fn scene(options: &Options, opacity: impl Fn(f64) -> f64) -> Result<Scene> {
    let mut knots = String::new();
    for i in 0..16 {
        let v = -1.0 + 2.0 * f64::from(i) / 15.0;
        let (red, blue) = (128 + 8 * i, 255 - 12 * i);
        let _ = writeln!(
            knots,
            "  {{ value = {v}, color = \"rgb({red} {} {blue})\", opacity = {} }},",
            90 + 6 * (i % 5),
            opacity(v)
        );
    }
    let light = if options.lit { "[light]\nkind = \"headlight\"" } else { "" };
    Scene::parse(&format!(
        "field = \"multi-scale\"\nmethod = \"{}\"\nprecision = \"{}\"\n[image]\nwidth = {size}\nheight = {size}\n\
         [camera]\nlon = 30\nlat = 25\ndistance = 3.2\nfov = 45\n[transfer]\nknots = [\n{knots}]\n{light}\n",
        options.method,
        options.precision,
        size = options.size,
    ))
}

/// Renders and prints a line per transfer function.
///
/// # Errors
/// Whatever the library says.
pub fn run(options: &Options, out: &mut dyn Write) -> Result<()> {
    let renderer = Renderer::new(options.threads)?;
    let start = Instant::now();
    let sphere = Sphere::new(options.level, options.layers, [1.0, 1.15], multi_scale)?;
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
    for (name, opacity) in TRANSFERS {
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
