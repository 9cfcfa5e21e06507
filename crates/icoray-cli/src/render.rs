//! `icoray render`: pictures of one time, or of all.

mod press;
mod target;

use crate::failure::Failure;
use crate::gpu;
use crate::input::{self, Input};
use icoray::output::{Existing, Stamp};
use icoray::{Description, Error, ErrorKind, Frame, Grid, Layers, Location, Renderer, Result, Scene};
use icoray_netcdf::{FieldInfo, LayerHeights, MpasFile};
use indicatif::{ProgressBar, ProgressStyle};
use press::{Press, Said};
use std::collections::HashMap;
use std::io::Write;
use std::ops::Range;
use std::path::PathBuf;
use std::time::Instant;
use target::Target;

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
    #[command(flatten)]
    who: gpu::Who,
    /// Picture size in pixels, instead of the scene's
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<(u32, u32)>,
    /// Largest error allowed in a channel of a pixel, 0 to 1, instead of the scene's
    #[arg(long, value_name = "E", allow_hyphen_values = true, value_parser = tolerance)]
    tolerance: Option<f64>,
    /// Map of the picture's errors, instead of the scene's output.error; for one time
    #[arg(long, value_name = "FILE.png")]
    error: Option<PathBuf>,
    /// What is done with pictures of the same name: overwrite replaces each one when the new one is complete; never-modify
    /// keeps them, and the command fails before it draws. report.csv gets a line more either way
    #[arg(long, value_name = "WHAT", value_enum, default_value_t = OnExisting::Overwrite)]
    existing: OnExisting,
}

/// [`Existing`], as a word. A command is told its files' names by a person who is there, so it overwrites, as others do;
/// what a model draws is nobody's to lose, and the library keeps it unless told otherwise.
#[derive(Clone, Copy, clap::ValueEnum)]
enum OnExisting {
    /// Keep them, and fail
    NeverModify,
    /// Replace them
    Overwrite,
}

impl From<OnExisting> for Existing {
    fn from(word: OnExisting) -> Self {
        match word {
            OnExisting::NeverModify => Existing::NeverModify,
            OnExisting::Overwrite => Existing::Overwrite,
        }
    }
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
    args.who.apply(&mut scene);
    if args.error.is_some() {
        scene.output.error = None;
    }
    Ok(scene)
}

/// Renders, writes and prints a block for each picture.
pub fn run(args: &Args, out: &mut impl Write) -> std::result::Result<(), Failure> {
    let target = Target::new(args.output.as_deref(), args.time)?;
    if let Some(map) = &args.error {
        target::expect_error_map(map, args.time)?;
    }
    let scene = scene(args)?;
    let renderer = gpu::renderer(args.threads)?;
    let start = Instant::now();
    let file = args.input.open()?;
    let info = file.field_info(&scene.field)?;
    let times = args.time.of(file.times().len())?;
    if let Target::Directory(_) = target {
        expect_distinct(&file, &scene, times.clone())?;
    }
    if let Some(map) = &args.error {
        target::expect_apart(map, &target.path(&scene.output, &stamp(&file, times.start), &scene.field)?)?;
    }
    let error_map = args.error.as_deref();
    let mut press = Press::new(&target, &scene.output, args.existing.into(), error_map)?;
    for time in times.clone() {
        press.check(&stamp(&file, time), &scene.field)?;
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
    };
    let open_s = start.elapsed().as_secs_f64();
    for line in notes(info, &grid, &heights) {
        writeln!(out, "note      {line}")?;
    }
    let bar = progress(times.len());
    bar.tick();
    for time in times {
        let (frame, stamp, said) = job.picture(time, open_s)?;
        say(press.put(frame, stamp, said), &bar, out)?;
    }
    say(press.finish(), &bar, out)?;
    bar.finish_and_clear();
    Ok(())
}

/// Prints the blocks of pictures that are on the disk, up to the first one that could not be written.
fn say(
    blocks: Vec<Result<String>>,
    bar: &ProgressBar,
    out: &mut impl Write,
) -> std::result::Result<(), Failure> {
    for block in blocks {
        let block = block?;
        bar.suspend(|| writeln!(out, "{block}"))?;
        bar.inc(1);
    }
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
}

impl Job<'_> {
    /// Draws record `time`: the frame, when it is, and what is to be said of it.
    fn picture(&self, time: usize, open_s: f64) -> Result<(Frame, Stamp, Said)> {
        let start = Instant::now();
        let owned = self.file.read_field(&self.info.name, time)?;
        let read_s = start.elapsed().as_secs_f64();
        let mut frame = self.renderer.render(self.scene, self.grid, self.layers, &owned.field()?)?;
        let FieldInfo { long_name, units, .. } = self.info.clone();
        frame.description = Description { long_name, units };
        let stamp = stamp(self.file, time);
        let date = stamp.date.as_deref().unwrap_or("no date");
        let path = self.target.path(&self.scene.output, &stamp, &self.scene.field)?;
        let (info, report, counts) = (self.info, &frame.report, &frame.report.counts);
        let before = format!(
            "picture   {} ({} x {})\n\
             field     {} at {}, {} layers, time {time} ({date})\n\
             range     {}, {} missing\n\
             rays      {}, {} columns, {} frusta ({} void)\n\
             error     {}\n\
             quality   {}\n\
             seconds   open {open_s:.3}, read {read_s:.3}, prepare {:.3}, render {:.3}, write ",
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
        );
        let drawn_on = gpu::drawn_on(report.device.as_deref(), report.left_to_cpu.as_deref());
        let (threads, left_out) = (report.threads, report.left_out.join("; "));
        let after = format!(" ({threads} threads)\ndrawn on  {drawn_on}\nleft out  {left_out}");
        Ok((frame, stamp, Said(before, after)))
    }
}
