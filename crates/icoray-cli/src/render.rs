//! `icoray render`: pictures of some of a file's times, or of all.

mod job;
mod press;
mod target;

use crate::failure::Failure;
use crate::gpu;
use crate::input::{self, Input, Wanted};
use crate::ranks::Ranked;
use crate::times::Times;
use icoray::output::Existing;
use icoray::{Error, ErrorKind, Ranks, Renderer, Result, Scene};
use icoray_netcdf::{FieldInfo, ModelFile};
use indicatif::{ProgressBar, ProgressStyle};
use job::{Job, notes, stamp};
use press::Press;
use std::collections::HashMap;
use std::io::Write;
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
    /// Time by number from 0, negative from the last (-1); by date (2003-01-01T06; 2003-01 is a whole month); by a range of
    /// either, without its end (0..10, 2003-01..2003-03, -5..); or "all"
    #[arg(long, value_name = "TIME|A..B|all", default_value = "0", allow_hyphen_values = true)]
    time: Times,
    #[command(flatten)]
    wanted: Wanted,
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

/// Refuses templates that would let one file replace another of the same run.
fn expect_distinct(file: &ModelFile, scene: &Scene, times: &[usize]) -> Result<()> {
    let mut seen = HashMap::new();
    for &time in times {
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

/// Renders, writes and prints a block for each picture. Several ranks draw each picture together, and rank 0 writes it.
pub fn run(args: &Args, out: &mut impl Write) -> std::result::Result<(), Failure> {
    let mut ranked = Ranked::new()?;
    let done = render(args, ranked.ranks(), out);
    ranked.outcome(done)
}

fn render(args: &Args, ranks: &mut Ranks, out: &mut impl Write) -> std::result::Result<(), Failure> {
    let start = Instant::now();
    let (scene, renderer, file) = ranks.together(open(args))?;
    let (info, times, target) = ranks.together(choose(args, &scene, &file))?;
    let press = ranks.is_root().then(|| checked_press(args, &scene, &file, &target, &times)).transpose();
    let mut press = ranks.together(press)?;
    let mesh = file.mesh();
    let prepared = renderer.run(|| mesh.grid()).and_then(|grid| {
        let heights = file.layer_heights(&info.name)?;
        Ok((grid, args.wanted.radii(&heights, info)?, heights))
    });
    let (grid, layers, heights) = ranks.together(prepared)?;
    let notes = notes(info, &layers, &grid, &heights);
    let job = Job {
        scene: &scene,
        file: &file,
        info,
        wanted: &args.wanted,
        grid: &grid,
        layers: &layers,
        renderer: &renderer,
        target: &target,
        notes: &notes,
        open_s: start.elapsed().as_secs_f64(),
    };
    let bar = progress(if ranks.is_root() { times.len() } else { 0 });
    let mut said = match press {
        Some(_) => notes.iter().try_for_each(|line| Ok(writeln!(out, "note      {line}")?)),
        None => Ok(()),
    };
    bar.tick();
    for time in times {
        agree(ranks, said)?;
        let picture = job.picture(time, ranks)?;
        said = match (&mut press, picture) {
            (Some(press), Some((frame, stamp, words))) => say(press.put(frame, stamp, words), &bar, out),
            _ => Ok(()),
        };
    }
    agree(ranks, said)?;
    let said = press.map_or(Ok(()), |press| say(press.finish(), &bar, out));
    bar.finish_and_clear();
    agree(ranks, said)
}

/// What rank 0 could not say or write stops all; it knows best why.
fn agree(ranks: &mut Ranks, said: std::result::Result<(), Failure>) -> std::result::Result<(), Failure> {
    let told = ranks.together(said.as_ref().copied().map_err(Failure::to_error));
    said.and(told.map_err(Failure::from))
}

/// What every rank opens for itself.
fn open(args: &Args) -> Result<(Scene, Renderer, ModelFile)> {
    Ok((scene(args)?, gpu::renderer(args.threads)?, args.input.open()?))
}

/// What is drawn of the file, and where it goes.
fn choose<'a>(
    args: &Args,
    scene: &Scene,
    file: &'a ModelFile,
) -> Result<(&'a FieldInfo, Vec<usize>, Target)> {
    let info = file.field_info(&scene.field)?;
    let times = args.time.of(file.times())?;
    let target = Target::new(args.output.as_deref(), times.len())?;
    Ok((info, times, target))
}

/// A press that can write all pictures, as far as is known before the first ray.
fn checked_press<'a>(
    args: &'a Args,
    scene: &'a Scene,
    file: &ModelFile,
    target: &'a Target,
    times: &[usize],
) -> Result<Press<'a>> {
    if let Some(map) = &args.error {
        target::expect_error_map(map, times.len())?;
        target::expect_apart(map, &target.path(&scene.output, &stamp(file, times[0]), &scene.field)?)?;
    }
    if let Target::Directory(_) = target {
        expect_distinct(file, scene, times)?;
    }
    let press = Press::new(target, &scene.output, args.existing.into(), args.error.as_deref())?;
    for &time in times {
        press.check(&stamp(file, time), &scene.field)?;
    }
    Ok(press)
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
