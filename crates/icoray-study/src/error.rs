//! Error against run time: every method over its tolerances or steps, on every scene, against the oracle.
//!
//! All methods of a scene run in turn, and all again for each repeat. Steps, tolerances and scenes are fixed here, so
//! that one command makes the table, the plots and the verdict on whether the default method is the fastest.

mod findings;
mod measure;
mod random;
mod tolerances;

use crate::picture::write_pixels;
use crate::plot::{Chart, Line};
use crate::results::{Table, progress, say, threads, write_file};
use crate::scenes::{self, Dataset, StudyScene, data_directory, select};
use findings::Finding;
use icoray::{Error, ErrorKind, Renderer, Result};
use icoray_progress::Bar;
use icoray_reference::job::Job;
use icoray_reference::oracle;
use measure::{COLUMNS, MEASURES, Measure, Measured, ladders};
use std::io::Write;
use std::path::PathBuf;

/// Options of the measurement.
#[derive(Debug, Clone, clap::Args)]
pub struct Options {
    /// Scenes, with commas between; a name ending in * stands for all that begin so. All without it.
    #[arg(long, value_delimiter = ',')]
    pub scenes: Vec<String>,
    /// Width of the pictures in pixels; else 160, and 112 for the high-resolution grid.
    #[arg(long)]
    pub size: Option<u32>,
    /// Times that each run is repeated; the median counts.
    #[arg(long, default_value_t = 3)]
    pub repeats: usize,
    /// Threads of the timed runs; the oracle takes all.
    #[arg(long, default_value_t = 1)]
    pub threads: usize,
    /// Seconds after which a run is not repeated, and no smaller step of its method is tried; at least three times the
    /// scene's first run of exact.
    #[arg(long, default_value_t = 1.0)]
    pub longest: f64,
    /// The views of the paper's Figures 8 and 9: at the wave of the real fields, near the limb of the synthetic ones.
    #[arg(long)]
    pub close_up: bool,
    /// A few small scenes and runs, for a trial run.
    #[arg(long)]
    pub quick: bool,
    /// Measures cost and error of tolerances from 1e-1 to 1e-7 in the kinds of scenes instead.
    #[arg(long)]
    pub tolerances: bool,
    /// With `--tolerances`: a file in which the table takes the place of that between its lines `<!-- icoray-study
    /// error -->` and `<!-- end -->`.
    #[arg(long, requires = "tolerances")]
    pub readme: Option<PathBuf>,
    /// Checks every pixel of this number of random scenes of all kinds on small meshes instead.
    #[arg(long, value_name = "N")]
    pub random: Option<u64>,
    /// Seed of the first random scene; each of the others has the next.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Directory of the data files; else that of ICORAY_TEST_DATA, else ../shared/data.
    #[arg(long, value_name = "DIR")]
    pub data: Option<PathBuf>,
    /// Directory of table, plots and verdict.
    #[arg(long, default_value = "out/error")]
    pub out: PathBuf,
}

const QUICK_SCENES: [&str; 3] = ["radial", "low_lobes", "stiff_step"];

/// Width of the pictures of the high-resolution grid without `--size`: each ray meets hundreds of columns.
const HIGH_WIDTH: u32 = 112;

impl Options {
    fn scenes(&self) -> Result<Vec<StudyScene>> {
        let width = self.size.unwrap_or(if self.quick { 48 } else { 160 });
        if !(1..=16384).contains(&width) {
            return Err(Error::new(ErrorKind::Argument, format!("size {width}, expected 1 to 16384 pixels")));
        }
        let quick = QUICK_SCENES.map(str::to_owned);
        let names = if self.quick && self.scenes.is_empty() { &quick[..] } else { &self.scenes };
        let mut scenes = select(scenes::all(width)?, names, |scene| &scene.name)?;
        if self.size.is_none() && !self.quick {
            let large = scenes.iter_mut().filter(|scene| scene.dataset == Dataset::MultiScaleHigh);
            large.for_each(|scene| scene.resize(HIGH_WIDTH));
        }
        if self.close_up {
            scenes.iter_mut().for_each(StudyScene::close_up);
        }
        Ok(scenes)
    }
}

/// Measures, writes `error.csv`, the oracle's picture and two charts per scene, and `verdict.txt`, and prints the
/// results.
pub fn run(options: &Options, out: &mut dyn Write) -> Result<()> {
    let all_threads = Renderer::new(0)?;
    let renderer = Renderer::new(options.threads)?;
    if let Some(count) = options.random {
        return random::run(count, options.seed, &renderer, &all_threads, out);
    }
    if options.tolerances {
        return tolerances::run(options.readme.as_deref(), &renderer, &all_threads, out);
    }
    let scenes = options.scenes()?;
    let data = data_directory(options.data.as_deref());
    let table = Table::create(options.out.join("error.csv"), COLUMNS)?;
    say!(
        out,
        "median of {} repeats on {}; errors are of premultiplied linear channels, 0 to 1\n{}",
        options.repeats,
        threads(renderer.threads()),
        table.heading()
    )?;
    let mut study = Study {
        options,
        out,
        renderer,
        all_threads: &all_threads,
        table,
        bar: progress(0, ""),
        fastest: Vec::new(),
        reported_errors: Vec::new(),
    };
    for group in scenes.chunk_by(|a, b| a.dataset == b.dataset) {
        let is_there = group[0].dataset.with(options.quick, &data, &all_threads, |grid, layers, field| {
            group.iter().try_for_each(|of| study.scene(&Job { scene: &of.scene, grid, layers, field }, of))
        })?;
        if !is_there {
            let names: Vec<&str> = group.iter().map(|s| s.name.as_str()).collect();
            say!(study.out, "{} skipped: no file in {}", names.join(", "), data.display())?;
        }
    }
    study.finish()
}

struct Study<'a> {
    options: &'a Options,
    out: &'a mut dyn Write,
    renderer: Renderer,
    all_threads: &'a Renderer,
    table: Table,
    bar: Bar,
    fastest: Vec<Finding>,
    reported_errors: Vec<Finding>,
}

impl Study<'_> {
    fn scene(&mut self, job: &Job, scene: &StudyScene) -> Result<()> {
        let lit = scene.scene.lighting.is_some();
        self.bar.set_prefix(scene.name.clone());
        self.bar.set_message("oracle");
        let truth = oracle::picture(job, self.all_threads)?;
        let pixels = truth.iter().map(|p| p.map(|c| c as f32)).collect();
        let path = self.options.out.join(format!("{}.png", scene.name));
        write_pixels(&path, [scene.scene.width, scene.scene.height], pixels)?;
        let radius = job.layers.for_field(job.field.shape().layers)?.shell(scene.scene.exaggeration)?;
        let thickness = radius[radius.len() - 1] - radius[0];
        let ladders = ladders(thickness, job.grid.cells(), lit, self.options.quick);
        let runs = ladders.iter().map(Vec::len).sum::<usize>() * self.options.repeats.max(1);
        self.bar.set_length(runs as u64);
        self.bar.reset();
        let measured = measure::measure(job, &truth, &ladders, self.options, &self.renderer, &self.bar)?;
        self.bar.reset();
        for m in &measured {
            let line = self.table.row(&m.row(&scene.name))?;
            self.bar.suspend(|| say!(self.out, "{line}"))?;
        }
        self.charts(scene, &measured)?;
        self.fastest.extend(findings::fastest(&scene.name, &measured));
        self.reported_errors.push(findings::reported_errors(&scene.name, lit, &measured));
        // After each scene, so that an interrupted study has results.
        self.write_verdict()
    }

    fn charts(&self, scene: &StudyScene, measured: &[Measured]) -> Result<()> {
        for Measure { name, title, error } in MEASURES {
            let line = |(style, runs): (usize, &[Measured])| {
                let points = runs.iter().map(|m| (m.median_s(), error(m))).collect();
                Line { name: runs[0].run.series.to_owned(), style, points }
            };
            let series = measured.chunk_by(|a, b| a.run.series == b.run.series);
            let size = format!("{} × {} pixels", scene.scene.width, scene.scene.height);
            let chart = Chart {
                title: format!("{}, {size}, {}", scene.name, threads(self.renderer.threads())),
                x: "seconds per frame (median)".to_owned(),
                y: title.to_owned(),
                lines: series.enumerate().map(line).collect(),
            };
            chart.write(&self.options.out.join(format!("{}_{name}.svg", scene.name)))?;
        }
        Ok(())
    }

    fn verdict(&self) -> String {
        let sum = |findings: &[Finding]| {
            let texts: String = findings.iter().map(|finding| finding.text.as_str()).collect();
            let count = findings.iter().filter(|finding| finding.is_true).count();
            format!("On {count} of {}.\n\n{texts}", findings.len())
        };
        format!(
            "Is a run of \"exact\" neither slower nor worse than each run of other methods, by scene and measure of \
             error?\n{}\nIs each error of a pixel at most the one that \"exact\" reports, by scene?\n{}\n{NOTE}",
            sum(&self.fastest),
            sum(&self.reported_errors)
        )
    }

    fn write_verdict(&self) -> Result<()> {
        write_file(&self.options.out.join("verdict.txt"), self.verdict())
    }

    fn finish(self) -> Result<()> {
        self.bar.finish_and_clear();
        self.write_verdict()?;
        let verdict = self.verdict();
        say!(self.out, "\n{verdict}")?;
        say!(self.out, "table, plots and verdict in {}", self.options.out.display())
    }
}

const NOTE: &str = "\
The oracle integrates the wedge interpolant. \"tetrahedra\", \"mean value\" and \"constant\" interpolate otherwise between\n\
the same values, so that their distance from it does not go to zero with the step; that difference does not show\n\
which interpolant is nearer to the field. Seconds are those in the rays, without set-up such as gradients and tables.\n\
In single precision and under light \"exact\" reports an estimate of its error; unlit in double precision a bound.\n";
