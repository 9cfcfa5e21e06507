//! What a user would pick instead: VTK's volume renderers on the same field as explicit wedges or tetrahedra.
//!
//! VTK comes from PyPI into an environment of its own; each of its renderers runs in a process of its own. All are given the
//! same linear colours and extinctions, one thread unless told, a black background and a hollow planet, and are compared with
//! the oracle's picture. VTK's pictures have 8 bits a channel: an RMSE of 0.001 is rounding.

mod export;
mod process;

use crate::compare::Comparison;
use crate::csv_file::CsvFile;
use crate::methods::Job;
use crate::montage::{self, Montage, Tile};
use crate::oracle::Oracle;
use crate::peak::Peak;
use crate::scenes::multi_scale;
use crate::sphere::{self, Sphere};
use crate::{make_directory, progress, say};
use icoray::{Renderer, Result, Scene};
use process::{Environment, Outcome};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// What to compare.
#[derive(Debug, Clone, clap::Args)]
pub struct Options {
    /// Bisections of the icosahedron, one size after another.
    #[arg(long, value_delimiter = ',', default_value = "4,5")]
    pub levels: Vec<u32>,
    /// Layers.
    #[arg(long, default_value_t = 20)]
    pub layers: usize,
    /// Width and height of the picture.
    #[arg(long, default_value_t = 512)]
    pub size: u32,
    /// Transfer functions: dense, lobes, thin, opaque.
    #[arg(long, value_delimiter = ',', default_value = "dense,lobes")]
    pub transfers: Vec<String>,
    /// VTK's renderers: bunyk and projected-tetrahedra are given tetrahedra, zsweep wedges.
    #[arg(long, value_delimiter = ',', default_value = "bunyk,zsweep,projected-tetrahedra")]
    pub renderers: Vec<String>,
    /// Threads; VTK's z-sweep has one.
    #[arg(long, default_value_t = 1)]
    pub threads: usize,
    /// Frames; the first one of VTK sorts and splits, the least of the others is reported.
    #[arg(long, default_value_t = 3)]
    pub frames: usize,
    /// GiB that a VTK process may have; where it does not fit, that is reported.
    #[arg(long, default_value_t = 12.0)]
    pub memory: f64,
    /// Seconds that a VTK process may take.
    #[arg(long, default_value_t = 600)]
    pub patience: u64,
    /// The Python that makes VTK's environment.
    #[arg(long, default_value = "python3")]
    pub python: PathBuf,
    /// Directory for VTK's environment, the table and the pictures.
    #[arg(long, default_value = "target/study/vtk")]
    pub out: PathBuf,
}

/// A renderer's row of the table.
struct Row {
    level: u32,
    transfer: &'static str,
    renderer: String,
    /// Seconds until rays can start, of the first frame and of a later one.
    seconds: [f64; 3],
    /// Most bytes at any time beyond the model's arrays.
    memory: u64,
    wedges: u64,
    far: Comparison,
}

impl Row {
    fn line(&self) -> String {
        let [prepare, first, frame] = self.seconds;
        format!(
            "| {} | {} | {} | {prepare:.3} | {first:.3} | {frame:.3} | {:.1} | {:.1} | {:.1e} | {:.3} |",
            self.level,
            self.transfer,
            self.renderer,
            self.memory as f64 / f64::from(1 << 20),
            self.memory as f64 / self.wedges as f64,
            self.far.rmse,
            self.far.max,
        )
    }

    fn cells(&self) -> Vec<String> {
        let mut cells = vec![self.level.to_string(), self.transfer.to_owned(), self.renderer.clone()];
        cells.extend(self.seconds.map(|s| format!("{s:.6}")));
        cells.extend([self.memory, self.wedges].map(|n| n.to_string()));
        cells.extend([self.far.rmse, self.far.max].map(|d| format!("{d:.6e}")));
        cells
    }
}

const COLUMNS: [&str; 10] = [
    "level",
    "transfer",
    "renderer",
    "prepare_s",
    "first_frame_s",
    "frame_s",
    "memory_bytes",
    "wedges",
    "rmse",
    "max_error",
];

/// Compares, and prints a Markdown table and what it comes to.
///
/// # Errors
/// Whatever the library says; [`ErrorKind::Io`](icoray::ErrorKind::Io) where VTK cannot be installed or its script fails.
pub fn run(options: &Options, out: &mut dyn Write) -> Result<()> {
    make_directory(&options.out)?;
    let environment = Environment::new(&options.python, &options.out.join("environment"), out)?;
    let mut table = CsvFile::create(options.out.join("vtk.csv"), &COLUMNS)?;
    say(
        out,
        "| n | transfer | renderer | prepare s | first frame s | frame s | memory MiB | bytes/wedge | RMSE | max |",
    )?;
    say(out, "|---|---|---|---|---|---|---|---|---|---|")?;
    let runs = options.levels.len() * options.transfers.len() * (1 + options.renderers.len());
    let bar = progress(runs, "vtk");
    let (mut rows, mut failures) = (Vec::new(), Vec::new());
    for level in &options.levels {
        for (name, opacity) in multi_scale::TRANSFERS {
            if !options.transfers.iter().any(|asked| asked == name) {
                continue;
            }
            let rest = "background = \"black\"\ncore = \"transparent\"";
            let scene = multi_scale::scene(options.size, opacity, rest, "")?;
            let model = Model::new(*level, options, &scene, name)?;
            bar.set_message(format!("n={level} {name}, icoray"));
            let ours = model.ours()?;
            table.row(&ours.cells())?;
            bar.suspend(|| say(out, &ours.line()))?;
            bar.inc(1);
            rows.push(ours);
            for renderer in &options.renderers {
                bar.set_message(format!("n={level} {name}, {renderer}"));
                match model.theirs(&environment, renderer)? {
                    Ok(row) => {
                        table.row(&row.cells())?;
                        bar.suspend(|| say(out, &row.line()))?;
                        rows.push(row);
                    }
                    Err(why) => failures.push(format!("n={level}, {name}, {renderer}: {why}")),
                }
                bar.inc(1);
            }
        }
    }
    bar.finish_and_clear();
    failures.iter().try_for_each(|failure| say(out, failure))?;
    summary(&rows, options).iter().try_for_each(|line| say(out, line))
}

/// How many times slower and larger VTK's renderers are.
fn summary(rows: &[Row], options: &Options) -> Vec<String> {
    let mut lines = Vec::new();
    for renderer in &options.renderers {
        let pairs = rows.iter().filter(|row| row.renderer == *renderer).filter_map(|theirs| {
            let is_ours = |row: &&Row| {
                row.renderer == OURS && row.level == theirs.level && row.transfer == theirs.transfer
            };
            Some((rows.iter().find(is_ours)?, theirs))
        });
        let (mut frames, mut memories): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
        for (ours, theirs) in pairs {
            frames.push(theirs.seconds[2] / ours.seconds[2]);
            memories.push(theirs.memory as f64 / ours.memory.max(1) as f64);
        }
        let span = |all: &[f64]| {
            let (low, high) = all.iter().fold((f64::INFINITY, 0.0f64), |(l, h), x| (l.min(*x), h.max(*x)));
            format!("{low:.1} to {high:.1}")
        };
        if !frames.is_empty() {
            lines.push(format!(
                "{renderer}: {} times icoray's time for a frame, {} times its memory",
                span(&frames),
                span(&memories)
            ));
        }
    }
    lines
}

const OURS: &str = "icoray";

/// A model, its scene, and the picture that is right.
struct Model<'o> {
    options: &'o Options,
    level: u32,
    transfer: &'static str,
    scene: &'o Scene,
    sphere: Sphere,
    truth: Vec<[f64; 4]>,
    directory: PathBuf,
}

impl<'o> Model<'o> {
    fn new(level: u32, options: &'o Options, scene: &'o Scene, transfer: &'static str) -> Result<Self> {
        let sphere = Sphere::new(level, options.layers, [1.0, 1.15], sphere::multi_scale)?;
        let directory = options.out.join(format!("n{level}_{transfer}"));
        let truth = {
            let renderer = Renderer::new(0)?;
            let (grid, field) = (sphere.grid()?, sphere.field()?);
            let job = Job { scene, grid: &grid, layers: &sphere.layers, field: &field };
            Oracle::new(&job)?.picture(&renderer)
        };
        make_directory(&directory)?;
        export::write(&directory, scene, &sphere)?;
        Ok(Model { options, level, transfer, scene, sphere, truth, directory })
    }

    fn ours(&self) -> Result<Row> {
        let peak = Peak::start()?;
        let start = Instant::now();
        let renderer = Renderer::new(self.options.threads)?;
        let grid = renderer.run(|| self.sphere.grid())?;
        let field = self.sphere.field()?;
        let prepare = start.elapsed().as_secs_f64();
        let (mut seconds, mut last) = (Vec::new(), None);
        for _ in 0..self.options.frames.max(1) {
            let start = Instant::now();
            last = Some(renderer.render(self.scene, &grid, &self.sphere.layers, &field)?);
            seconds.push(start.elapsed().as_secs_f64());
        }
        let memory = peak.bytes()?;
        let pixels = last.map_or_else(Vec::new, |frame| frame.pixels);
        let frames: Vec<_> = pixels.iter().map(|&[r, g, b, _]| [r, g, b, 1.0]).collect();
        let wedges = (grid.triangles() * (self.options.layers - 1)) as u64;
        self.row(OURS, [prepare, seconds[0], least(&seconds)], memory, wedges, &frames)
    }

    fn theirs(&self, environment: &Environment, renderer: &str) -> Result<std::result::Result<Row, String>> {
        let picture = self.directory.join(format!("{renderer}.f32"));
        let said = match environment.draw(&self.directory, renderer, self.options, &picture)? {
            Outcome::Said(said) => said,
            Outcome::Failed(why) => return Ok(Err(why)),
        };
        let [build, first, frame] = ["build_s", "first_s", "frame_s"].map(|name| said.number(name));
        let (memory, wedges) = (said.number("memory")?, said.number("wedges")?);
        let pixels = read_pixels(&picture)?;
        let seconds = [build?, first?, frame?];
        self.row(renderer, seconds, memory as u64, wedges as u64, &pixels).map(Ok)
    }

    fn row(
        &self,
        renderer: &str,
        seconds: [f64; 3],
        memory: u64,
        wedges: u64,
        pixels: &[[f32; 4]],
    ) -> Result<Row> {
        let far = Comparison::new(pixels, &self.truth);
        self.sheet(renderer, pixels)?;
        let renderer = renderer.to_owned();
        Ok(Row { level: self.level, transfer: self.transfer, renderer, seconds, memory, wedges, far })
    }

    /// The picture beside its difference from the right one, ten times as bright.
    fn sheet(&self, renderer: &str, pixels: &[[f32; 4]]) -> Result<()> {
        let mut sheet = Montage::new(self.options.size, self.options.size);
        let difference = montage::amplified(pixels, &self.truth, 10.0);
        sheet.push(vec![
            Tile { pixels: pixels.to_vec(), label: renderer.to_owned() },
            Tile { pixels: difference, label: "10 x |difference|".to_owned() },
        ]);
        sheet.write(&self.directory.join(format!("{renderer}.png")))
    }
}

/// The least of all frames but the first, which sets things up.
fn least(seconds: &[f64]) -> f64 {
    let later = if seconds.len() > 1 { &seconds[1..] } else { seconds };
    later.iter().copied().fold(f64::INFINITY, f64::min)
}

/// Linear RGB as the script wrote it, opaque.
fn read_pixels(path: &Path) -> Result<Vec<[f32; 4]>> {
    let bytes = std::fs::read(path).map_err(|e| crate::io_error(path, e))?;
    let values: Vec<f32> = bytes.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
    Ok(values.as_chunks().0.iter().map(|&[r, g, b]| [r, g, b, 1.0]).collect())
}
