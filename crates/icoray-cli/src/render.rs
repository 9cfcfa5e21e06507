//! `icoray render`: pictures of one time, or of all.

use crate::failure::Failure;
use crate::input::{self, Input};
use icoray::output::{Output, Stamp, write_error_map, write_frame, write_picture};
use icoray::{Error, ErrorKind, Frame, Grid, Layers, Location, Renderer, Result, Scene};
use icoray_netcdf::{FieldInfo, LayerHeights, MpasFile};
use indicatif::{ProgressBar, ProgressStyle};
use std::collections::HashMap;
use std::io::Write;
use std::ops::Range;
use std::path::{Path, PathBuf, absolute};
use std::time::Instant;

/// What `icoray render` is told.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    input: Input,
    /// What to draw and how
    #[arg(long, value_name = "SCENE.toml")]
    scene: PathBuf,
    /// Time index from 0, negative from the last (-1), or "all"
    #[arg(long, value_name = "N|all", default_value = "0", allow_hyphen_values = true, value_parser = time)]
    time: Time,
    /// Picture (.png or .exr), or the directory for pictures named by the scene and for report.csv [default: .]
    #[arg(short, long, value_name = "PICTURE|DIR")]
    output: Option<PathBuf>,
    /// Number of threads; 0 is as many as there are cores to use
    #[arg(long, value_name = "N", default_value_t = 0)]
    threads: usize,
    /// Picture size in pixels, instead of the scene's
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<(u32, u32)>,
    /// Largest error allowed in a channel of a pixel, 0 to 1, instead of the scene's
    #[arg(long, value_name = "E", allow_hyphen_values = true, value_parser = tolerance)]
    tolerance: Option<f64>,
    /// Map of the picture's errors, instead of the scene's output.error; for one time
    #[arg(long, value_name = "FILE.png")]
    error: Option<PathBuf>,
}

/// Which records are rendered.
#[derive(Clone, Copy)]
enum Time {
    All,
    Index(i64),
}

fn time(text: &str) -> std::result::Result<Time, String> {
    if text == "all" {
        return Ok(Time::All);
    }
    let index = text.parse().map(Time::Index);
    index.map_err(|_| "expected a whole number or \"all\"".to_owned())
}

fn size(text: &str) -> std::result::Result<(u32, u32), String> {
    let side = |t: &str| t.parse().ok().filter(|s| (1..=16384).contains(s));
    let sides = text.split_once('x');
    sides
        .and_then(|(w, h)| Some((side(w)?, side(h)?)))
        .ok_or_else(|| "expected WxH with sides of 1 to 16384 pixels, such as 640x480".to_owned())
}

fn tolerance(text: &str) -> std::result::Result<f64, String> {
    let (low, high) = (Scene::TOLERANCE.start(), Scene::TOLERANCE.end());
    let tolerance = text.parse().ok().filter(|t| Scene::TOLERANCE.contains(t));
    tolerance.ok_or_else(|| format!("expected a number from {low:e} to {high}"))
}

impl Time {
    /// The records that are meant, of `count`.
    fn of(self, count: usize) -> Result<Range<usize>> {
        let Time::Index(index) = self else {
            return Ok(0..count);
        };
        let records = i64::try_from(count).unwrap_or(i64::MAX);
        let from_first = if index < 0 { index + records } else { index };
        match usize::try_from(from_first) {
            Ok(record) if record < count => Ok(record..record + 1),
            _ => {
                let context =
                    format!("--time {index}: expected {} to {}, the file's times", -records, records - 1);
                Err(Error::new(ErrorKind::Argument, context))
            }
        }
    }
}

/// Where pictures go.
enum Target {
    /// To this very file.
    Picture(PathBuf),
    /// Into this directory, named by the scene's template, with `report.csv`.
    Directory(PathBuf),
}

impl Target {
    fn new(output: Option<&Path>, time: Time) -> Result<Self> {
        let Some(path) = output else {
            return Ok(Target::Directory(PathBuf::new()));
        };
        let bad = |what: &str| Error::new(ErrorKind::Argument, format!("-o {}: {what}", path.display()));
        let ending = path.extension().and_then(|e| e.to_str());
        let is_directory = path.is_dir() || path.to_string_lossy().ends_with(['/', '\\']);
        match (ending, time) {
            _ if is_directory => Ok(Target::Directory(path.to_owned())),
            (Some("png" | "exr"), Time::Index(_)) => Ok(Target::Picture(path.to_owned())),
            (Some("png" | "exr"), Time::All) => Err(bad(
                "one picture for --time all; expected a directory, the scene's output.file names the pictures",
            )),
            (None, _) => Ok(Target::Directory(path.to_owned())),
            _ => Err(bad("expected a name that ends in .png or .exr, or a directory")),
        }
    }

    /// Where the picture of a time goes.
    fn path(&self, names: &Output, stamp: &Stamp, field: &str) -> Result<PathBuf> {
        match self {
            Target::Directory(directory) => Ok(directory.join(names.names(stamp, field)?.file)),
            Target::Picture(path) => Ok(path.clone()),
        }
    }

    /// Writes the frame; returns where, and sets the seconds that it took.
    fn write(&self, names: &Output, stamp: Stamp, frame: &mut Frame) -> Result<PathBuf> {
        match self {
            Target::Directory(directory) => write_frame(directory, names, &stamp, frame),
            Target::Picture(path) => {
                let start = Instant::now();
                frame.stamp = stamp;
                write_picture(path, frame)?;
                frame.report.write_s = start.elapsed().as_secs_f64();
                Ok(path.clone())
            }
        }
    }
}

/// Refuses a map of errors that is no PNG or that would be one for several pictures.
fn expect_error_map(path: &Path, time: Time) -> Result<()> {
    match time {
        _ if path.extension().is_none_or(|e| e != "png") => {
            Err(bad_map(path, "expected a name that ends in .png"))
        }
        Time::All => {
            Err(bad_map(path, "one map for --time all; expected output.error in the scene to name the maps"))
        }
        Time::Index(_) => Ok(()),
    }
}

/// Refuses a map of errors that would replace the picture.
fn expect_apart(map: &Path, picture: &Path) -> Result<()> {
    let same =
        map == picture || absolute(map).ok().is_some_and(|map| absolute(picture).is_ok_and(|p| p == map));
    if same { Err(bad_map(map, "names the picture too, expected another file")) } else { Ok(()) }
}

fn bad_map(path: &Path, what: &str) -> Error {
    Error::new(ErrorKind::Argument, format!("--error {}: {what}", path.display()))
}

/// When record `time` was. MPAS files give a date; seconds since the start are not made of it, since that would need
/// the run's calendar.
fn stamp(file: &MpasFile, time: usize) -> Stamp {
    Stamp { step: time as i64, time_s: 0.0, date: file.times()[time].clone() }
}

/// Refuses templates that would let one file replace another of the same run.
fn expect_distinct(file: &MpasFile, scene: &Scene, times: Range<usize>) -> Result<()> {
    let mut seen = HashMap::new();
    for time in times {
        let names = scene.output.names(&stamp(file, time), &scene.field)?;
        let named = [("output.file", Some(names.file)), ("output.error", names.error)];
        for (key, name) in named.into_iter().filter_map(|(key, name)| Some((key, name?))) {
            if let Some(earlier) = seen.insert(name.clone(), time) {
                let context = format!(
                    "{key} names the pictures of times {earlier} and {time} both {name:?}, expected {{step}} or a date in it"
                );
                return Err(Error::new(ErrorKind::Scene, context));
            }
        }
    }
    Ok(())
}

/// The scene, with what the command says instead.
fn scene(args: &Args) -> Result<Scene> {
    let mut scene = input::scene(&args.scene)?;
    if let Some((width, height)) = args.size {
        (scene.width, scene.height) = (width, height);
    }
    if let Some(tolerance) = args.tolerance {
        scene.tolerance = tolerance;
    }
    if args.error.is_some() {
        scene.output.error = None;
    }
    Ok(scene)
}

/// Renders, writes and prints a block for each picture.
pub fn run(args: &Args, out: &mut impl Write) -> std::result::Result<(), Failure> {
    let target = Target::new(args.output.as_deref(), args.time)?;
    if let Some(map) = &args.error {
        expect_error_map(map, args.time)?;
    }
    let scene = scene(args)?;
    let renderer = Renderer::new(args.threads)?;
    let start = Instant::now();
    let file = args.input.open()?;
    let info = file.field_info(&scene.field)?;
    let times = args.time.of(file.times().len())?;
    if let Target::Directory(_) = target {
        expect_distinct(&file, &scene, times.clone())?;
    }
    if let Some(map) = &args.error {
        expect_apart(map, &target.path(&scene.output, &stamp(&file, times.start), &scene.field)?)?;
    }
    let mesh = file.mesh();
    let grid = renderer.run(|| mesh.grid())?;
    let heights = file.layer_heights()?;
    let job = Job {
        scene: &scene,
        file: &file,
        info,
        grid: &grid,
        layers: &heights.layers,
        renderer: &renderer,
        target: &target,
        error_map: args.error.as_deref(),
    };
    let open_s = start.elapsed().as_secs_f64();
    for line in notes(info, &grid, &heights) {
        writeln!(out, "note      {line}")?;
    }
    let bar = progress(times.len());
    bar.tick();
    for time in times {
        let block = job.picture(time, open_s)?;
        bar.suspend(|| writeln!(out, "{block}"))?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(())
}

/// A bar on stderr where that is a terminal and there is more than one picture.
fn progress(pictures: usize) -> ProgressBar {
    if pictures < 2 {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} pictures, {eta} left");
    ProgressBar::new(pictures as u64).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

/// What is not drawn as the file has it.
fn notes(info: &FieldInfo, grid: &Grid, heights: &LayerHeights) -> Vec<String> {
    let mut notes = Vec::new();
    if info.location == Location::Corner {
        let bytes = grid.cells() * info.layers * info.precision.bytes();
        notes.push(format!(
            "{} lives on corners: averaged to cell centres (derived, {bytes} bytes)",
            info.name
        ));
    }
    if heights.deviation_m > 0.0 {
        notes.push(format!(
            "concentric mean heights are rendered; columns deviate by up to {:.1} m",
            heights.deviation_m
        ));
    }
    notes
}

/// All that the pictures of one run share.
struct Job<'a> {
    scene: &'a Scene,
    file: &'a MpasFile,
    info: &'a FieldInfo,
    grid: &'a Grid<'a>,
    layers: &'a Layers,
    renderer: &'a Renderer,
    target: &'a Target,
    /// Where the map of errors goes, where the command says.
    error_map: Option<&'a Path>,
}

impl Job<'_> {
    /// Makes the picture of record `time` and says what came of it.
    fn picture(&self, time: usize, open_s: f64) -> Result<String> {
        let start = Instant::now();
        let owned = self.file.read_field(&self.info.name, time)?;
        let read_s = start.elapsed().as_secs_f64();
        let mut frame = self.renderer.render(self.scene, self.grid, self.layers, &owned.field()?)?;
        let stamp = stamp(self.file, time);
        let date = stamp.date.clone().unwrap_or_else(|| "no date".to_owned());
        let path = self.target.write(&self.scene.output, stamp, &mut frame)?;
        if let Some(path) = self.error_map {
            write_error_map(path, &frame)?;
        }
        let (info, report, counts) = (self.info, &frame.report, &frame.report.counts);
        Ok(format!(
            "picture   {} ({} x {})\n\
             field     {} at {}, {} layers, time {time} ({date})\n\
             range     {}, {} missing\n\
             rays      {}, {} columns, {} frusta ({} void)\n\
             error     {}\n\
             quality   {}\n\
             seconds   open {open_s:.3}, read {read_s:.3}, prepare {:.3}, render {:.3}, write {:.3} ({} threads)\n\
             left out  {}",
            path.display(),
            frame.width,
            frame.height,
            info.name,
            input::place(info.location),
            info.layers,
            input::range(report.value_range, info.units.as_deref()),
            report.missing_values,
            counts.rays,
            counts.columns,
            counts.frusta,
            counts.void_frusta,
            report.error,
            report.quality,
            report.prepare_s,
            report.render_s,
            report.write_s,
            self.renderer.threads(),
            report.left_out.join("; "),
        ))
    }
}
