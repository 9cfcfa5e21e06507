//! `icoray render`: pictures of some of a file's times, or of all.

mod due;
mod job;
mod own_heights;
mod press;
mod subject;
mod target;

use crate::drawn::{Drawn, Opened, Scenes};
use crate::failure::Failure;
use crate::ranks::Ranked;
use crate::suggested::Suggested;
use due::Series;
use icoray::output::Existing;
use icoray::{Error, ErrorKind, Ranks, Result, Script};
use icoray_progress::Progress;
use job::Job;
use own_heights::OwnHeights;
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
    pub drawn: Drawn,
    #[command(flatten)]
    pub written: Written,
}

/// Where pictures go, and how.
#[derive(clap::Args)]
pub struct Written {
    /// Picture (.png or .exr), or the directory for pictures named by the scene and for report.csv [default: .]
    #[arg(short, long, value_name = "PICTURE|DIR")]
    output: Option<PathBuf>,
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

/// Renders, writes and prints a block for each picture. Several ranks draw each picture together, and rank 0 writes it.
pub fn run(args: &Args, out: &mut impl Write) -> std::result::Result<(), Failure> {
    let mut ranked = Ranked::new()?;
    let done = render(args, ranked.ranks(), out);
    ranked.outcome(done)
}

fn render(args: &Args, ranks: &mut Ranks, out: &mut impl Write) -> std::result::Result<(), Failure> {
    let start = Instant::now();
    let progress = if ranks.is_root() { Progress::new() } else { Progress::hidden() };
    let Some(opened) = ranks.together(args.drawn.open(&progress))? else {
        if ranks.is_root() {
            writeln!(out, "{}", args.drawn.nothing())?;
        }
        return Ok(());
    };
    let Opened { renderer, file, .. } = &opened;
    let Scenes { mut script, grid, suggested } = ranks.together(opened.scenes(&args.drawn, &progress))?;
    if args.written.error.is_some() {
        script.scenes_mut().for_each(|scene| scene.output.error = None);
    }
    let (series, target) = ranks.together(args.written.choose(&script, &opened))?;
    let press = ranks.is_root().then(|| args.written.press(&series, &target)).transpose();
    let mut press = ranks.together(press)?;
    progress.stage("checking the grid and reading layers");
    let prepared = renderer.run(|| {
        let grid = grid.map_or_else(|| file.mesh().grid(), Ok)?;
        let subjects = Subjects::new(file, &script, &args.drawn.wanted, grid.cells())?;
        Ok((grid, subjects))
    });
    let (grid, subjects) = ranks.together(prepared)?;
    let open_s = start.elapsed().as_secs_f64();
    let job = Job { subjects: &subjects, grid: &grid, renderer, target: &target, open_s };
    let pictures = series.pictures();
    progress.pictures(pictures);
    let mut said = match press {
        Some(_) => progress.suspend(|| {
            args.save_scene(suggested.as_ref(), out)?;
            say_notes(&subjects.all_notes(&script)?, out)
        }),
        None => Ok(()),
    };
    let (mut drawn, mut heights) = (0, OwnHeights::default());
    for &time in &series.times {
        agree(ranks, said)?;
        progress.stage(format!("reading time {time}"));
        let (due, read) = ranks.together(series.due(time, renderer, &subjects))?;
        let fields = ranks.together(read.borrowed())?;
        let scenes = due.iter().flat_map(|view| view.scenes());
        let from = (file, &grid, renderer);
        let heights_s = ranks.together(heights.get_ready(from, &subjects, scenes, time))?;
        let (stamp, mut read_s) = (series.stamp(time), read.seconds + heights_s);
        progress.fewer_pictures(series.given_up(time, &due));
        said = Ok(());
        for shot in due.into_iter().flat_map(|view| view.shots(&stamp)) {
            agree(ranks, said)?;
            drawn += 1;
            progress.stage(format!("drawing picture {drawn} of {pictures}"));
            let picture =
                job.picture(&shot, &stamp, (&fields, &heights), std::mem::take(&mut read_s), ranks)?;
            progress.drawn(drawn);
            said = match (&mut press, picture) {
                (Some(press), Some((frame, words))) => {
                    say(press.put(frame, shot.scene.output, stamp.clone(), words), &progress, out)
                }
                _ => Ok(()),
            };
        }
    }
    agree(ranks, said)?;
    progress.stage("writing");
    let said = match press {
        Some(_) if drawn == 0 => {
            Ok(writeln!(out, "note      nothing is drawn: these times are no view's turn")?)
        }
        Some(press) => say(press.finish(), &progress, out),
        None => Ok(()),
    };
    progress.finish();
    agree(ranks, said)
}

/// Says what is not drawn as the file has it.
fn say_notes(notes: &[String], out: &mut impl Write) -> std::result::Result<(), Failure> {
    notes.iter().try_for_each(|line| Ok(writeln!(out, "note      {line}")?))
}

/// What rank 0 could not say or write stops all; it knows best why.
fn agree(ranks: &mut Ranks, said: std::result::Result<(), Failure>) -> std::result::Result<(), Failure> {
    let told = ranks.together(said.as_ref().copied().map_err(Failure::to_error));
    said.and(told.map_err(Failure::from))
}

impl Args {
    /// Says which scene was suggested, and writes it where the command says so.
    pub fn save_scene(
        &self,
        suggested: Option<&Suggested>,
        out: &mut impl Write,
    ) -> std::result::Result<(), Failure> {
        let Some(suggested) = suggested else { return Ok(()) };
        let saved = match &self.drawn.look.save_scene {
            Some(path) => {
                suggested.save(path, self.written.existing.into())?;
                format!("; saved as {}", path.display())
            }
            None => String::new(),
        };
        Ok(writeln!(out, "scene     {}{saved}", suggested.said)?)
    }
}

impl Written {
    /// What is drawn of the file, and where it goes.
    pub fn choose<'a>(&self, script: &'a Script, opened: &'a Opened) -> Result<(Series<'a>, Target)> {
        let Opened { file, times, is_series, .. } = opened;
        for name in script.model_fields() {
            file.field_info(&name)?;
        }
        let (times, is_scheduled, seconds) = (times.clone(), *is_series, file.seconds());
        let series = Series { script, file, times, is_scheduled, seconds };
        let target = Target::new(self.output.as_deref(), series.pictures())?;
        Ok((series, target))
    }

    /// A press that can write all pictures, as far as is known before the first ray.
    fn press<'a>(&'a self, series: &Series, target: &'a Target) -> Result<Press<'a>> {
        if let Some(map) = &self.error {
            target::expect_error_map(map, series.pictures())?;
        }
        if let Target::Directory(_) = target {
            expect_distinct(series)?;
        }
        let press = Press::new(target, self.existing.into(), self.error.as_deref())?;
        for &time in &series.times {
            let stamp = series.stamp(time);
            let certain = series.scheduled(time).into_iter().filter(|view| !series.is_uncertain(view));
            for shot in certain.flat_map(|view| view.shots(&stamp)) {
                let (output, field) = (&shot.scene.output, &shot.scene.field);
                if let Some(map) = &self.error {
                    target::expect_apart(map, &target.path(output, &stamp, field)?)?;
                }
                press.check(output, &stamp, field)?;
            }
        }
        Ok(press)
    }
}

/// Prints the blocks of pictures that are on the disk, up to the first one that could not be written.
fn say(
    blocks: Vec<Result<String>>,
    progress: &Progress,
    out: &mut impl Write,
) -> std::result::Result<(), Failure> {
    for block in blocks {
        let block = block?;
        progress.suspend(|| writeln!(out, "{block}"))?;
    }
    Ok(())
}
