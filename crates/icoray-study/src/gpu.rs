//! Milliseconds of frames on a GPU, by its own clock and from end to end, with the CPU's and the paper's: the paper's
//! Table 2 scene, also in larger pictures, with and without light.
//!
//! Peak rates of the device are measured in the same run ([`icoray_gpu::Peaks`]); `cost` counts bytes and operations of
//! frames.

use crate::results::{Table, make_directory, progress, say, threads, write_file};
use crate::scenes::multi_scale;
use benchmark::{Benchmark, Row, Setting};
use icoray::device::Device;
use icoray::{Error, ErrorKind, Field, Location, Renderer, Result};
use icoray_gpu::Gpu;
use icoray_reference::sphere::{self, Sphere};
use std::io::Write;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

mod benchmark;
mod table;

/// Options of the measurement.
#[derive(Debug, Clone, clap::Args)]
pub struct Options {
    /// The adapter: its number, or a part of its name; the fastest by default.
    #[arg(long)]
    pub device: Option<icoray::Adapter>,
    /// Bisections of the icosahedron; 8, the default, gives the paper's 655,362 cells.
    #[arg(long)]
    pub level: Option<u32>,
    /// Layers, 99 by default.
    #[arg(long)]
    pub layers: Option<usize>,
    /// Widths and heights of the pictures; 512x512,1920x1080,3840x2160 by default.
    #[arg(long, value_delimiter = ',', value_parser = size)]
    pub size: Vec<(u32, u32)>,
    /// Tolerances.
    #[arg(long, value_delimiter = ',', default_values_t = [1e-3, 1e-2])]
    pub tolerance: Vec<f64>,
    /// Leave out lit scenes.
    #[arg(long)]
    pub unlit: bool,
    /// Frames of each scene behind the first; the fastest is reported.
    #[arg(long, default_value_t = 5)]
    pub frames: usize,
    /// Threads of the CPU renderer; 0 takes all processors.
    #[arg(long, default_value_t = 0)]
    pub threads: usize,
    /// A small grid and small pictures.
    #[arg(long)]
    pub quick: bool,
    /// Directory of gpu.csv and gpu.md.
    #[arg(long, default_value = "out/gpu")]
    pub out: PathBuf,
}

fn size(text: &str) -> std::result::Result<(u32, u32), String> {
    let side = |text: &str| text.parse().ok().filter(|side| (1..=16384).contains(side));
    let sides = text.split_once('x').and_then(|(width, height)| Some((side(width)?, side(height)?)));
    sides.ok_or_else(|| format!("{text:?}, expected width and height of 1 to 16384 pixels, such as 512x512"))
}

impl Options {
    fn settings(&self) -> Vec<Setting> {
        let sizes: &[(u32, u32)] = match (self.size.is_empty(), self.quick) {
            (false, _) => &self.size,
            (true, true) => &[(128, 128), (192, 108)],
            (true, false) => &[(512, 512), (1920, 1080), (3840, 2160)],
        };
        let lights: &[bool] = if self.unlit { &[false] } else { &[false, true] };
        let mut settings = Vec::new();
        for &size in sizes {
            for &is_lit in lights {
                let of = |&tolerance: &f64| Setting { size, is_lit, tolerance };
                settings.extend(self.tolerance.iter().map(of));
            }
        }
        settings
    }
}

/// Measures, prints a line per picture, and writes `gpu.csv` and `gpu.md`.
pub fn run(options: &Options, out: &mut dyn Write) -> Result<()> {
    let unsupported = |reason: &dyn std::fmt::Display| Error::new(ErrorKind::Unsupported, reason.to_string());
    let gpu = Arc::new(Gpu::new(options.device.clone()).map_err(|reason| unsupported(&reason))?);
    let name = gpu.name();
    let peaks = gpu.peaks().map_err(|reason| unsupported(&reason))?;
    make_directory(&options.out)?;
    say!(out, "{name}: {}", table::peaks(&peaks))?;
    let (level, layers) = if options.quick { (5, 20) } else { (8, 99) };
    let (level, layers) = (options.level.unwrap_or(level), options.layers.unwrap_or(layers));
    let cpu = Renderer::new(options.threads)?;
    let start = Instant::now();
    let sphere = cpu.run(|| Sphere::new(level, layers, [1.0, 1.15], sphere::multi_scale))?;
    let grid = cpu.run(|| sphere.grid())?;
    say!(
        out,
        "{} cells x {layers} layers, 16 knots, f32; CPU: {}; mesh and field in {:.1} s",
        grid.cells(),
        threads(cpu.threads()),
        start.elapsed().as_secs_f64()
    )?;
    let mut values = sphere.values.clone();
    values[0] = values[0].next_up();
    let other = Field::level_fastest(&values, layers, Location::Center)?;
    let benchmark = Benchmark {
        grid: &grid,
        layers: &sphere.layers,
        fields: [sphere.field()?, other],
        gpu: Renderer::new(options.threads)?.with_device(gpu),
        cpu,
        frames: options.frames.max(1),
        peaks,
    };
    let rows = measure(&benchmark, &options.settings(), options, out)?;
    let text = table::markdown(&rows, &format!("{} cells × {layers} layers", grid.cells()), &name, &benchmark);
    write_file(&options.out.join("gpu.md"), &text)?;
    say!(out, "\n{text}\ntables in {}", options.out.display())
}

fn measure(
    benchmark: &Benchmark,
    settings: &[Setting],
    options: &Options,
    out: &mut dyn Write,
) -> Result<Vec<Vec<Row>>> {
    let mut csv = Table::create(options.out.join("gpu.csv"), table::COLUMNS)?;
    let bar = progress(settings.len() * multi_scale::TRANSFERS.len(), "gpu");
    say!(out, "{}", csv.heading())?;
    let mut all = Vec::new();
    for setting in settings {
        let mut rows = Vec::new();
        for (transfer, opacity) in multi_scale::TRANSFERS {
            bar.set_message(format!("{}x{} {} {transfer}", setting.size.0, setting.size.1, setting.light()));
            let row = benchmark.row(setting, transfer, opacity)?;
            csv.print(&table::cells(&row, &benchmark.peaks), &bar, out)?;
            rows.push(row);
        }
        all.push(rows);
    }
    Ok(all)
}
