//! Seconds per frame, and what of the machine they take: the paper's Table 2 scene, a multi-scale field under four transfer
//! functions of 16 knots, on grids of several sizes, with and without light.
//!
//! Each frame is of a new field, as a model's are: whatever depends on values is done anew. Frames on one core and on several
//! are drawn in turn, so that other work on the machine strikes both.

use crate::csv_file::CsvFile;
use crate::{io_error, make_directory, progress, readme, say};
use case::{Case, Light, Setting};
use icoray::{Error, ErrorKind, Renderer, Result};
use instructions::Counter;
use markdown::Measured;
use stage::Stage;
use std::io::Write;
use std::path::PathBuf;

mod case;
mod cost;
mod instructions;
mod machine;
mod markdown;
mod setup;
mod stage;
mod table;

/// What to measure.
#[derive(Debug, Clone, clap::Args)]
pub struct Options {
    /// Bisections of the icosahedron x layers; 5x61,7x26,8x99 unless told: 8x99 is the paper's largest grid.
    #[arg(long, value_delimiter = ',', value_parser = size)]
    pub sizes: Vec<Size>,
    /// One small grid and small pictures.
    #[arg(long)]
    pub quick: bool,
    /// Width and height of the pictures; 512 unless told.
    #[arg(long)]
    pub pixels: Option<u32>,
    /// Numbers of threads.
    #[arg(long, value_delimiter = ',', value_parser = count, default_values_t = [1, 2])]
    pub threads: Vec<usize>,
    /// Transfer functions; `walk` is none: rays walk and interpolate, and nothing is integrated.
    #[arg(long, value_delimiter = ',', default_values_t = ["dense", "lobes", "thin", "opaque", "walk"].map(String::from))]
    pub transfers: Vec<String>,
    /// With light or without.
    #[arg(long, value_delimiter = ',', value_enum, default_values_t = [Light::Unlit, Light::Lit])]
    pub lights: Vec<Light>,
    /// Tolerances.
    #[arg(long, value_delimiter = ',', default_values_t = [1e-3, 1e-2])]
    pub tolerance: Vec<f64>,
    /// Frames of each; the least and the median are told.
    #[arg(long, default_value_t = 3)]
    pub frames: usize,
    /// Integration method: exact or paper.
    #[arg(long, default_value = "exact")]
    pub method: String,
    /// Precision: f32 or f64.
    #[arg(long, default_value = "f32")]
    pub precision: String,
    /// Bisections of grids whose tables are checked beside those that are drawn.
    #[arg(long, value_delimiter = ',')]
    pub tables: Vec<u32>,
    /// Grid on which instructions are counted, by perf or valgrind.
    #[arg(long, value_parser = size, default_value = "4x31")]
    pub counted: Size,
    /// Do not count instructions.
    #[arg(long)]
    pub uncounted: bool,
    /// Draw and do nothing else: what is run under a counter of instructions.
    #[arg(long, hide = true)]
    pub bare: bool,
    /// Directory of speed.csv, speed.md and pictures.
    #[arg(long, default_value = "out/speed")]
    pub out: PathBuf,
    /// A file in which the tables take the place of those between its lines `<!-- icoray-study speed -->` and `<!-- end -->`.
    #[arg(long)]
    pub readme: Option<PathBuf>,
}

/// A grid's bisections and layers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Size {
    /// Bisections of the icosahedron.
    pub level: u32,
    /// Layers.
    pub layers: usize,
}

impl std::fmt::Display for Size {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}x{}", self.level, self.layers)
    }
}

fn size(text: &str) -> std::result::Result<Size, String> {
    let parsed = text.split_once('x').and_then(|(level, layers)| {
        let (level, layers) = (level.parse().ok()?, layers.parse().ok()?);
        (level <= icoray::MAX_LEVEL && layers >= 2).then_some(Size { level, layers })
    });
    parsed.ok_or_else(|| format!("{text:?}, expected bisections and layers, such as 8x99"))
}

fn count(text: &str) -> std::result::Result<usize, String> {
    let count = text.parse().ok().filter(|count| (1..=1024).contains(count));
    count.ok_or_else(|| "expected 1 to 1024 threads".to_owned())
}

impl Options {
    fn sizes(&self) -> Vec<Size> {
        match (self.sizes.is_empty(), self.quick) {
            (false, _) => self.sizes.clone(),
            (true, true) => vec![self.counted],
            (true, false) => [(5, 61), (7, 26), (8, 99)].map(|(level, layers)| Size { level, layers }).into(),
        }
    }

    fn pixels(&self) -> u32 {
        self.pixels.unwrap_or(if self.quick { 128 } else { 512 })
    }

    fn cases(&self) -> Result<Vec<Case>> {
        let find = |name: &String| {
            Case::all().find(|case| case.name == name).ok_or_else(|| {
                let there: Vec<_> = Case::all().map(|case| case.name).collect();
                let context =
                    format!("there is no transfer function {name}; expected of {}", there.join(", "));
                Error::new(ErrorKind::Argument, context)
            })
        };
        self.transfers.iter().map(find).collect()
    }

    /// What is drawn of each grid: the walk only once, as it knows neither light nor tolerance.
    fn settings(&self) -> Result<Vec<Setting>> {
        let cases = self.cases()?;
        let mut settings = Vec::new();
        for &light in &self.lights {
            for &tolerance in &self.tolerance {
                let of = |&case: &Case| Setting { case, light, tolerance };
                settings.extend(cases.iter().filter(|case| case.integrates).map(of));
            }
        }
        let walk = cases.iter().find(|case| !case.integrates);
        settings.extend(walk.map(|&case| Setting { case, light: Light::Unlit, tolerance: 1e-3 }));
        Ok(settings)
    }

    fn renderers(&self) -> Result<Vec<Renderer>> {
        self.threads.iter().map(|threads| Renderer::new(*threads)).collect()
    }
}

/// Measures, prints a line per scene and number of threads, and writes `speed.csv`, `speed.md` and pictures.
///
/// # Errors
/// [`ErrorKind::Argument`] for an unknown transfer function; whatever the library says; [`ErrorKind::Io`] when a result
/// cannot be written.
pub fn run(options: &Options, out: &mut dyn Write) -> Result<()> {
    let settings = options.settings()?;
    if options.bare {
        return draw(options, &settings, out);
    }
    make_directory(&options.out)?;
    let bandwidths = machine::read_bandwidths(&options.threads)?;
    say(out, &table::bandwidths(&bandwidths))?;
    let counter = if options.uncounted { None } else { Some(Counter::find()) };
    let mut csv = CsvFile::create(options.out.join("speed.csv"), &table::COLUMNS)?;
    let (mut setups, mut memory, mut rows) = (Vec::new(), Vec::new(), Vec::new());
    let bar = progress(options.sizes().len() * settings.len(), "speed");
    for size in options.sizes() {
        let stage = Stage::new(size, options)?;
        setups.push(stage.setup.clone());
        memory.extend(stage.memory.iter().map(|(light, bytes)| (size, *light, *bytes)));
        let grid = stage.sphere.grid()?;
        bar.suspend(|| say(out, &stage.setup.line()).and_then(|()| say(out, &table::heading())))?;
        for setting in &settings {
            bar.set_message(format!("{size} {} {}", setting.light.name(), setting.case.name));
            for row in stage.rows(&grid, setting)? {
                csv.row(&table::cells(&row, options, &bandwidths))?;
                bar.suspend(|| say(out, &table::line(&row, &bandwidths)))?;
                rows.push(row);
            }
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    for level in &options.tables {
        let setup = setup::Setup::of_tables(*level, options)?;
        say(out, &setup.line())?;
        setups.push(setup);
    }
    let counted = counter.map(|counter| counter.and_then(|counter| counter.count_all(options, &settings)));
    let (rows, setups, memory, bandwidths) = (&rows, &setups, &memory, &bandwidths);
    let text = Measured { options, rows, setups, memory, bandwidths, counted }.markdown();
    let path = options.out.join("speed.md");
    std::fs::write(&path, &text).map_err(|e| io_error(&path, e))?;
    if let Some(path) = &options.readme {
        readme::put(path, "speed", &text)?;
    }
    say(out, &format!("\n{text}\ntables in {}", options.out.display()))
}

/// Draws all frames, and says how many frusta the last one had.
fn draw(options: &Options, settings: &[Setting], out: &mut dyn Write) -> Result<()> {
    for size in options.sizes() {
        let stage = Stage::new(size, options)?;
        for setting in settings {
            let frusta = stage.frusta(setting, options.frames)?;
            say(out, &format!("frusta {frusta}"))?;
        }
    }
    Ok(())
}
