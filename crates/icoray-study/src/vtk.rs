//! Comparison with VTK's volume renderers on the same field as explicit wedges or tetrahedra.
//!
//! VTK is installed from PyPI into a virtual environment; each of its renderers runs in its own process. All have the
//! same linear colours and extinctions, one thread by default, a black background and a hollow planet, and are compared
//! with the oracle's picture. VTK's pictures have 8 bits per channel: an RMSE of 0.001 is rounding.

mod process;
mod summary;

use crate::peak::PeakMemory;
use crate::picture::{amplified, write_pixels};
use crate::results::{Table, make_directory, progress, replace_section, say, timed, write_file};
use crate::scenes::{multi_scale, select};
use icoray::{Field, Renderer, Result, Scene};
use icoray_reference::comparison::Comparison;
use icoray_reference::oracle;
use icoray_reference::sphere::{self, Sphere};
use process::Environment;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;
use summary::{COLUMNS, HEAD, OURS, Row, Seconds};

/// Options of the comparison.
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
    /// Tolerance of icoray's pictures.
    #[arg(long, default_value_t = 1e-3)]
    pub tolerance: f64,
    /// Threads; VTK's z-sweep has one.
    #[arg(long, default_value_t = 1)]
    pub threads: usize,
    /// Frames of the same values and of new ones; the first one of VTK sorts and splits, the least of the others is
    /// reported.
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
    /// Directory for VTK's environment, vtk.csv, vtk.md and the pictures.
    #[arg(long, default_value = "out/vtk")]
    pub out: PathBuf,
    /// A file in which the tables take the place of those between its lines `<!-- icoray-study vtk -->` and
    /// `<!-- end -->`.
    #[arg(long)]
    pub readme: Option<PathBuf>,
}

/// Compares; prints a Markdown table and its summary.
pub fn run(options: &Options, out: &mut dyn Write) -> Result<()> {
    make_directory(&options.out)?;
    let environment = Environment::new(&options.python, &options.out.join("environment"), out)?;
    let mut table = Table::create(options.out.join("vtk.csv"), COLUMNS)?;
    HEAD.iter().try_for_each(|line| say!(out, "{line}"))?;
    let runs = options.levels.len() * options.transfers.len() * (1 + options.renderers.len());
    let bar = progress(runs, "vtk");
    let transfers = select(multi_scale::TRANSFERS.into(), &options.transfers, |transfer| transfer.0)?;
    let (mut rows, mut failures) = (Vec::new(), Vec::new());
    for level in &options.levels {
        for &(name, opacity) in &transfers {
            let rest = "background = \"black\"\ncore = \"transparent\"";
            let scene = multi_scale::scene(options.size, opacity, rest, "")?;
            let scene = Scene { tolerance: options.tolerance, ..scene };
            let model = Model::new(*level, options, &scene, name)?;
            bar.set_message(format!("n={level} {name}, icoray"));
            let ours = model.ours()?;
            let mut add = |row: Row| {
                table.row(&row.cells(options))?;
                bar.suspend(|| say!(out, "{}", row.line()))?;
                rows.push(row);
                Ok(())
            };
            add(ours)?;
            bar.inc(1);
            for renderer in &options.renderers {
                bar.set_message(format!("n={level} {name}, {renderer}"));
                match model.theirs(&environment, renderer)? {
                    Ok(row) => add(row)?,
                    Err(why) => failures.push(format!("n={level}, {name}, {renderer}: {why}")),
                }
                bar.inc(1);
            }
        }
    }
    bar.finish_and_clear();
    let summary = summary::summary(&rows, options, &failures);
    say!(out, "{summary}")?;
    let lines: Vec<String> = rows.iter().map(Row::line).collect();
    let text = format!("{}\n{}\n{summary}", HEAD.join("\n"), lines.join("\n"));
    write_file(&options.out.join("vtk.md"), &text)?;
    replace_section(options.readme.as_deref(), "vtk", &text)
}

/// A model, its scene, and the oracle's picture.
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
        let renderer = Renderer::new(0)?;
        let truth = sphere.with_job(scene, |job| oracle::picture(job, &renderer))?;
        make_directory(&directory)?;
        process::write_model(&directory, scene, &sphere)?;
        Ok(Model { options, level, transfer, scene, sphere, truth, directory })
    }

    fn ours(&self) -> Result<Row> {
        let peak = PeakMemory::start()?;
        let start = Instant::now();
        let renderer = Renderer::new(self.options.threads)?;
        let grid = renderer.run(|| self.sphere.grid())?;
        let prepare = start.elapsed().as_secs_f64();
        let mut last = None;
        let mut draw = |field: &Field| {
            let (seconds, frame) = timed(&renderer, self.scene, &grid, &self.sphere.layers, field)?;
            last = Some(frame);
            Ok(seconds)
        };
        let field = self.sphere.field()?;
        let frames = self.options.frames.max(1);
        let same = (0..frames).map(|_| draw(&field)).collect::<Result<Vec<_>>>()?;
        // As in the next step of a model: nothing derived from the new field is cached.
        let steps = (0..frames).map(|_| draw(&self.sphere.field()?)).collect::<Result<Vec<_>>>()?;
        let memory = peak.bytes()?;
        let step = steps.iter().copied().fold(f64::INFINITY, f64::min);
        let seconds = Seconds { prepare, first: same[0], frame: min_of_later(&same), step };
        let of_frame = last.as_ref().map_or(0, |frame| frame.report.bytes_derived);
        let derived = Some((grid.derived_bytes() + of_frame) as u64);
        let pixels = last.map_or_else(Vec::new, |frame| frame.pixels);
        let frames: Vec<_> = pixels.iter().map(|&[r, g, b, _]| [r, g, b, 1.0]).collect();
        let wedges = (grid.triangles() * (self.options.layers - 1)) as u64;
        let row = self.row(OURS, seconds, memory, wedges, &frames)?;
        Ok(Row { derived, ..row })
    }

    fn theirs(&self, environment: &Environment, renderer: &str) -> Result<std::result::Result<Row, String>> {
        let picture = self.directory.join(format!("{renderer}.f32"));
        let output = match environment.draw(&self.directory, renderer, self.options, &picture)? {
            Ok(output) => output,
            Err(why) => return Ok(Err(why)),
        };
        let seconds = Seconds {
            prepare: output.number("build_s")?,
            first: output.number("first_s")?,
            frame: output.number("frame_s")?,
            step: output.number("step_s")?,
        };
        let (memory, wedges) = (output.number("memory")?, output.number("wedges")?);
        let pixels = read_pixels(&picture)?;
        self.row(renderer, seconds, memory as u64, wedges as u64, &pixels).map(Ok)
    }

    fn row(&self, renderer: &str, seconds: Seconds, memory: u64, wedges: u64, pixels: &[[f32; 4]]) -> Result<Row> {
        let comparison = Comparison::new(pixels, &self.truth);
        let (name, size) = (|rest: &str| self.directory.join(format!("{renderer}{rest}.png")), [self.options.size; 2]);
        write_pixels(&name(""), size, pixels.to_vec())?;
        write_pixels(&name("_difference_x10"), size, amplified(pixels, &self.truth, 10.0))?;
        let (level, transfer, renderer) = (self.level, self.transfer, renderer.to_owned());
        Ok(Row { level, transfer, renderer, seconds, memory, derived: None, wedges, comparison })
    }
}

/// Minimum of all frames but the first, which includes the setup.
fn min_of_later(seconds: &[f64]) -> f64 {
    let later = if seconds.len() > 1 { &seconds[1..] } else { seconds };
    later.iter().copied().fold(f64::INFINITY, f64::min)
}

/// Linear RGB as the script wrote it, opaque.
fn read_pixels(path: &Path) -> Result<Vec<[f32; 4]>> {
    let bytes = std::fs::read(path).map_err(|e| crate::results::io_error(path, e))?;
    let values: Vec<f32> = bytes.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
    Ok(values.as_chunks().0.iter().map(|&[r, g, b]| [r, g, b, 1.0]).collect())
}
