//! `icoray render`: pictures of some of a file's times, or of all.

mod due;
mod job;
mod press;
mod subject;
mod target;

use crate::failure::Failure;
use crate::gpu;
use crate::input::{self, Input, Wanted};
use crate::ranks::Ranked;
use crate::times::Times;
use due::Series;
use icoray::output::Existing;
use icoray::{Error, ErrorKind, Ranks, Renderer, Result, Scene, Script};
use icoray_netcdf::ModelFile;
use indicatif::{ProgressBar, ProgressStyle};
use job::Job;
use press::Press;
use std::collections::HashMap;
use std::io::Write;
use std::path::PathBuf;
use std::time::Instant;
use subject::Subjects;
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
    /// either, without its end (0..10, 2003-01..2003-03, -5..); or "all". Of ranges and all times those are drawn that are
    /// the views' turn (every, at_steps, at_times, when), the number of a time being its step; others are drawn by all views
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
    /// Map of the picture's errors, instead of the scene's output.error; for one picture
    #[arg(long, value_name = "FILE.png")]
    error: Option<PathBuf>,
    /// What is done with pictures of the same name: overwrite replaces each one when the new one is complete; never-modify
    /// keeps them, and the command fails before it draws. report.csv, and the scene's lists and databases, are added to either way
    #[arg(long, value_name = "WHAT", value_enum, default_value_t = OnExisting::Overwrite)]
    existing: OnExisting,
}

/// [`Existing`], as a word. A command is told its files' names by a person who is there, so it overwrites, as others do;
/// what a model draws is nobody's to lose, and the library keeps it unless told otherwise.
#[derive(Clone, Copy, clap::ValueEnum)]
pub enum OnExisting {
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
fn expect_distinct(series: &Series) -> Result<()> {
    let mut seen = HashMap::new();
    for &time in &series.times {
        let stamp = series.stamp(time);
        for shot in series.scheduled(time).into_iter().flat_map(|view| view.shots(&stamp)) {
            let names = shot.scene.output.names(&stamp, &shot.scene.field)?;
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
    }
    Ok(())
}

/// The script, with what the command says instead.
fn script(args: &Args) -> Result<Script> {
    let mut script = input::script(&args.scene)?;
    for scene in script.scenes_mut() {
        if let Some((width, height)) = args.size {
            (scene.width, scene.height) = (width, height);
        }
        if let Some(tolerance) = args.tolerance {
            scene.tolerance = tolerance;
        }
        args.who.apply(scene);
        if args.error.is_some() {
            scene.output.error = None;
        }
    }
    Ok(script)
}

/// Renders, writes and prints a block for each picture. Several ranks draw each picture together, and rank 0 writes it.
pub fn run(args: &Args, out: &mut impl Write) -> std::result::Result<(), Failure> {
    let mut ranked = Ranked::new()?;
    let done = render(args, ranked.ranks(), out);
    ranked.outcome(done)
}

fn render(args: &Args, ranks: &mut Ranks, out: &mut impl Write) -> std::result::Result<(), Failure> {
    let start = Instant::now();
    let (script, renderer, file) = ranks.together(open(args))?;
    let (series, target) = ranks.together(choose(args, &script, &file))?;
    let press = ranks.is_root().then(|| checked_press(args, &series, &target)).transpose();
    let mut press = ranks.together(press)?;
    let mesh = file.mesh();
    let prepared = renderer.run(|| mesh.grid()).and_then(|grid| {
        let subjects = Subjects::new(&file, &script, &args.wanted, &grid)?;
        Ok((grid, subjects))
    });
    let (grid, subjects) = ranks.together(prepared)?;
    let open_s = start.elapsed().as_secs_f64();
    let job = Job { subjects: &subjects, grid: &grid, renderer: &renderer, target: &target, open_s };
    let bar = progress(if ranks.is_root() { series.pictures() } else { 0 });
    let mut said = match press {
        Some(_) => say_notes(&subjects.all_notes(&script), out),
        None => Ok(()),
    };
    let mut drawn = 0;
    bar.tick();
    for &time in &series.times {
        agree(ranks, said)?;
        let (due, read) = ranks.together(series.due(time, &renderer, &args.wanted))?;
        let fields = ranks.together(read.borrowed())?;
        let (stamp, mut read_s) = (series.stamp(time), read.seconds);
        // Where nobody looks at the bar it has no length.
        bar.set_length(bar.length().unwrap_or(0).saturating_sub(series.given_up(time, &due)));
        said = Ok(());
        for shot in due.into_iter().flat_map(|view| view.shots(&stamp)) {
            agree(ranks, said)?;
            drawn += 1;
            let picture = job.picture(&shot, &stamp, &fields, std::mem::take(&mut read_s), ranks)?;
            said = match (&mut press, picture) {
                (Some(press), Some((frame, words))) => {
                    say(press.put(frame, shot.scene.output, stamp.clone(), words), &bar, out)
                }
                _ => Ok(()),
            };
        }
    }
    agree(ranks, said)?;
    let said = match press {
        Some(_) if drawn == 0 => {
            Ok(writeln!(out, "note      nothing is drawn: these times are no view's turn")?)
        }
        Some(press) => say(press.finish(), &bar, out),
        None => Ok(()),
    };
    bar.finish_and_clear();
    agree(ranks, said)
}

/// Says what is not drawn as the file has it.
fn say_notes(notes: &[&String], out: &mut impl Write) -> std::result::Result<(), Failure> {
    notes.iter().try_for_each(|line| Ok(writeln!(out, "note      {line}")?))
}

/// What rank 0 could not say or write stops all; it knows best why.
fn agree(ranks: &mut Ranks, said: std::result::Result<(), Failure>) -> std::result::Result<(), Failure> {
    let told = ranks.together(said.as_ref().copied().map_err(Failure::to_error));
    said.and(told.map_err(Failure::from))
}

/// What every rank opens for itself.
fn open(args: &Args) -> Result<(Script, Renderer, ModelFile)> {
    Ok((script(args)?, gpu::renderer(args.threads)?, args.input.open()?))
}

/// What is drawn of the file, and where it goes.
fn choose<'a>(args: &Args, script: &'a Script, file: &'a ModelFile) -> Result<(Series<'a>, Target)> {
    for name in script.model_fields() {
        file.field_info(&name)?;
    }
    let times = args.time.of(file.times())?;
    let (is_scheduled, seconds) = (args.time.is_series(), file.seconds());
    let series = Series { script, file, times, is_scheduled, seconds };
    let target = Target::new(args.output.as_deref(), series.pictures())?;
    Ok((series, target))
}

/// A press that can write all pictures, as far as is known before the first ray.
fn checked_press<'a>(args: &'a Args, series: &Series, target: &'a Target) -> Result<Press<'a>> {
    if let Some(map) = &args.error {
        target::expect_error_map(map, series.pictures())?;
    }
    if let Target::Directory(_) = target {
        expect_distinct(series)?;
    }
    let press = Press::new(target, args.existing.into(), args.error.as_deref())?;
    for &time in &series.times {
        let stamp = series.stamp(time);
        let certain = series.scheduled(time).into_iter().filter(|view| !series.is_uncertain(view));
        for shot in certain.flat_map(|view| view.shots(&stamp)) {
            let (output, field) = (&shot.scene.output, &shot.scene.field);
            if let Some(map) = &args.error {
                target::expect_apart(map, &target.path(output, &stamp, field)?)?;
            }
            press.check(output, &stamp, field)?;
        }
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
