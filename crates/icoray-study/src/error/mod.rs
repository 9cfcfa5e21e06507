//! Error against run time: every method over its tolerances or steps, on every scene, against the oracle.
//!
//! All methods of a scene run in turn, and all again for each repeat. Steps, tolerances and scenes are fixed here, so that
//! one command makes the table, the plots and the verdict on whether the default method's curve is the lowest.

mod bounds;
mod measure;
mod sweep;
mod table;
mod verdict;

use crate::csv_file::CsvFile;
use crate::montage::frame;
use crate::oracle::Oracle;
use crate::plot::{Chart, Line};
use crate::scenes::{self, Detail, Stage, StudyScene, World, data_directory};
use crate::{io_error, make_directory, progress, say};
use icoray::output::write_picture;
use icoray::{Error, ErrorKind, Renderer, Result};
use icoray_progress::Bar;
use measure::{Effort, Measured};
use std::io::Write;
use std::path::PathBuf;
use verdict::Point;

/// What to measure.
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
    /// A few small scenes and runs, to see whether all goes well.
    #[arg(long)]
    pub quick: bool,
    /// Directory of the data files; else what ICORAY_TEST_DATA names, else ../shared/data.
    #[arg(long, value_name = "DIR")]
    pub data: Option<PathBuf>,
    /// Directory of table, plots and verdict.
    #[arg(long, default_value = "out/error")]
    pub out: PathBuf,
}

/// The scenes of `--quick`.
const QUICK_SCENES: [&str; 3] = ["radial", "low_lobes", "stiff_step"];

/// Width of the pictures of the high-resolution grid, unless another is asked for: each ray meets hundreds of columns.
const HIGH_WIDTH: u32 = 112;

impl Options {
    fn scenes(&self) -> Result<Vec<StudyScene>> {
        let width = self.size.unwrap_or(if self.quick { 48 } else { 160 });
        if !(1..=16384).contains(&width) {
            return Err(Error::new(ErrorKind::Argument, format!("size {width}, expected 1 to 16384 pixels")));
        }
        let quick = QUICK_SCENES.map(str::to_owned);
        let names = if self.quick && self.scenes.is_empty() { &quick[..] } else { &self.scenes };
        let mut scenes = scenes::select(scenes::all(width)?, names)?;
        if self.size.is_none() && !self.quick {
            let large = scenes.iter_mut().filter(|scene| scene.world == World::MultiScaleHigh);
            large.for_each(|scene| scene.resize(HIGH_WIDTH));
        }
        Ok(scenes)
    }

    fn detail(&self) -> Detail {
        if self.quick { Detail::Quick } else { Detail::Full }
    }
}

/// Measures, writes `error.csv`, the oracle's picture and two charts per scene, and `verdict.txt`, and prints what it finds.
///
/// # Errors
/// Whatever the library says, and [`ErrorKind::Io`] when a result cannot be written.
pub fn run(options: &Options, out: &mut dyn Write) -> Result<()> {
    let scenes = options.scenes()?;
    make_directory(&options.out)?;
    let data = data_directory(options.data.as_deref());
    let all_threads = Renderer::new(0)?;
    let mut study = Study::new(options, out, &all_threads, scenes.len())?;
    study.head()?;
    for group in scenes.chunk_by(|a, b| a.world == b.world) {
        match group[0].world.load(options.detail(), &data)? {
            Some(world) => world
                .with(&all_threads, |stage| group.iter().try_for_each(|scene| study.scene(stage, scene)))?,
            None => {
                study.begun += group.len();
                let names: Vec<&str> = group.iter().map(|s| s.name.as_str()).collect();
                say(study.out, &format!("{} skipped: no file in {}", names.join(", "), data.display()))?;
            }
        }
    }
    study.finish()
}

/// A study under way.
struct Study<'a> {
    options: &'a Options,
    out: &'a mut dyn Write,
    renderer: Renderer,
    all_threads: &'a Renderer,
    table: CsvFile,
    bar: Bar,
    scenes: usize,
    begun: usize,
    verdicts: String,
    bounds: String,
    lower: (usize, usize),
    held: (usize, usize),
}

impl<'a> Study<'a> {
    fn new(
        options: &'a Options,
        out: &'a mut dyn Write,
        all_threads: &'a Renderer,
        scenes: usize,
    ) -> Result<Self> {
        Ok(Study {
            options,
            out,
            renderer: Renderer::new(options.threads)?,
            all_threads,
            table: table::create(options.out.join("error.csv"))?,
            bar: progress(0, ""),
            scenes,
            begun: 0,
            verdicts: String::new(),
            bounds: String::new(),
            lower: (0, 0),
            held: (0, 0),
        })
    }

    fn head(&mut self) -> Result<()> {
        let line = format!(
            "median of {} repeats on {}; errors are of premultiplied linear channels, 0 to 1",
            self.options.repeats,
            threads(&self.renderer)
        );
        say(self.out, &line)?;
        say(self.out, &table::heading())
    }

    fn scene(&mut self, stage: &Stage, scene: &StudyScene) -> Result<()> {
        let job = stage.job(&scene.scene);
        let lit = scene.scene.lighting.is_some();
        self.begun += 1;
        self.bar.set_prefix(format!("{} ({} of {})", scene.name, self.begun, self.scenes));
        self.bar.set_message("oracle");
        let truth = Oracle::new(&job)?.picture(self.all_threads);
        self.picture(scene, &truth)?;
        let ladders = sweep::ladders(stage.thickness(&scene.scene)?, lit, self.options.quick);
        let effort = Effort { repeats: self.options.repeats, longest_s: self.options.longest };
        let runs = ladders.iter().map(Vec::len).sum::<usize>() * effort.repeats.max(1);
        self.bar.set_length(runs as u64);
        self.bar.reset();
        let measured = measure::measure(&job, &truth, &ladders, effort, &self.renderer, &self.bar)?;
        self.bar.reset();
        for m in &measured {
            self.table.row(&table::row(&scene.name, m))?;
            let line = table::line(&scene.name, m);
            let out = &mut *self.out;
            self.bar.suspend(|| say(out, &line))?;
        }
        self.charts(scene, &measured)?;
        self.judge(&scene.name, lit, &measured);
        // After each scene, so that a study that is stopped has its say.
        self.write_verdict()
    }

    /// Writes the oracle's picture, to show what the scene is.
    fn picture(&self, scene: &StudyScene, truth: &[[f64; 4]]) -> Result<()> {
        let pixels = truth.iter().map(|p| p.map(|c| c as f32)).collect();
        let picture = frame(scene.scene.width, scene.scene.height, pixels);
        write_picture(&self.options.out.join(format!("{}.png", scene.name)), &picture)
    }

    fn charts(&self, scene: &StudyScene, measured: &[Measured]) -> Result<()> {
        for (file, title, error) in MEASURES {
            let line = |(style, series): (usize, &&str)| {
                let points = measured.iter().filter(|m| m.run.series == *series);
                let points: Vec<_> = points.map(|m| (m.median_s(), error(m))).collect();
                (!points.is_empty()).then(|| Line { name: (*series).to_owned(), style, points })
            };
            let size = format!("{} × {} pixels", scene.scene.width, scene.scene.height);
            let chart = Chart {
                title: format!("{}, {size}, {}", scene.name, threads(&self.renderer)),
                x: "seconds per frame (median)".to_owned(),
                y: title.to_owned(),
                lines: sweep::SERIES.iter().enumerate().filter_map(line).collect(),
            };
            chart.write(&self.options.out.join(format!("{}_{file}.svg", scene.name)))?;
        }
        Ok(())
    }

    fn judge(&mut self, scene: &str, lit: bool, measured: &[Measured]) {
        for (_, title, error) in MEASURES {
            let point = |m: &Measured| Point { label: m.run.label(), seconds: m.median_s(), error: error(m) };
            let of = |wanted: fn(&Measured) -> bool| -> Vec<Point> {
                measured.iter().filter(|m| wanted(m)).map(point).collect()
            };
            let curve = of(|m| m.run.series == sweep::EXACT);
            let others = of(|m| m.run.series != sweep::EXACT && m.run.series != sweep::EXACT_F64);
            let (lower, text) = verdict::say_verdict(scene, title, &curve, &others);
            self.verdicts += &text;
            self.lower = (self.lower.0 + usize::from(lower), self.lower.1 + 1);
        }
        let (held, text) = bounds::say_bounds(scene, lit, measured);
        self.bounds += &text;
        self.held = (self.held.0 + usize::from(held), self.held.1 + 1);
    }

    fn verdict(&self) -> String {
        format!(
            "Is the curve of error against time of \"exact\" lower or equal at every point of every other method?\n\
             Yes on {} of {} curves.\n\n{}\n\
             Is no pixel farther off than \"exact\" says?\nOn {} of {} scenes, at every tolerance.\n\n{}\n{NOTE}",
            self.lower.0, self.lower.1, self.verdicts, self.held.0, self.held.1, self.bounds
        )
    }

    fn write_verdict(&self) -> Result<()> {
        let path = self.options.out.join("verdict.txt");
        std::fs::write(&path, self.verdict()).map_err(|e| io_error(&path, e))
    }

    fn finish(self) -> Result<()> {
        self.bar.finish_and_clear();
        self.write_verdict()?;
        let text = format!("\n{}", self.verdict());
        say(self.out, &text)?;
        say(self.out, &format!("table, plots and verdict in {}", self.options.out.display()))
    }
}

/// The renderer's threads in words.
fn threads(renderer: &Renderer) -> String {
    match renderer.threads() {
        1 => "one thread".to_owned(),
        n => format!("{n} threads"),
    }
}

/// A number that says how far a run is off.
type Measure = fn(&Measured) -> f64;

/// File name, words and number of each measure of error.
const MEASURES: [(&str, &str, Measure); 2] = [
    ("rmse", "RMSE against the oracle", |m| m.distance.rmse),
    ("max", "largest error against the oracle", |m| m.distance.max),
];

const NOTE: &str = "\
The oracle integrates the wedge interpolant. \"tetrahedra\", \"mean value\" and \"constant\" interpolate otherwise between\n\
the same values, so that their distance from it does not go to zero with the step; that difference says nothing of\n\
which interpolant is nearer to the field. Seconds are those in the rays, without set-up such as gradients and tables.\n\
In single precision and under light the error of \"exact\" is told as an estimate; unlit in double precision it is a\n\
bound.\n";
