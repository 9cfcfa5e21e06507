//! `icoray render`: renders pictures of some or all times of a file.

mod job;
mod pictures;
mod target;

use crate::failure::{CommandResult, Failure};
use crate::input;
use crate::ranks::RankTeam;
use crate::selection::{Opened, Selection};
use crate::suggested::{Scenes, Suggested};
use clap::builder::TypedValueParser;
use icoray::output::{Existing, FrameNames, NameTemplate};
use icoray::{Error, ErrorKind, Ranks, Result, Script};
use icoray_dataset::{Drawing, SceneFields, Series};
use icoray_progress::Progress;
pub use job::Job;
pub use pictures::Pictures;
use std::collections::HashMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;
pub use target::{OutputQueue, Target};

/// Examples of `icoray render --help`.
const EXAMPLES: &str = "\
Examples:
  icoray render history.nc                                    a first picture
  icoray render history.nc --field w --lon 180 -o w.png
  icoray render history.nc --field theta --isosurface 300 --save-scene scene.toml
  icoray render history.nc --scene scene.toml --time all -o pictures";

/// Arguments of `icoray render`.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    #[command(flatten)]
    pub selection: Selection,
    #[command(flatten)]
    pub output_options: OutputOptions,
}

/// Where pictures go, and how.
#[derive(clap::Args, Default)]
pub struct OutputOptions {
    /// Picture (.png or .exr), or the directory for pictures named by the scene and for report.csv [default: .]
    #[arg(short, long, value_name = "PICTURE|DIR")]
    output: Option<PathBuf>,
    /// Names of the pictures, in place of the scene's.
    #[arg(skip)]
    names: Option<NameTemplate>,
    /// Map of the picture's errors, instead of the scene's output.error; for one picture
    #[arg(long, value_name = "FILE.png")]
    error: Option<PathBuf>,
    /// Print all lines of a picture's summary, in place of picture, field and range
    #[arg(short, long)]
    verbose: bool,
    /// Treatment of pictures of the same name: overwrite replaces each one when the new one is complete; never-modify
    /// keeps them, and the command fails before it draws. report.csv, and the scene's lists and databases, are added to
    /// either way
    #[arg(long, value_name = "WHAT", value_parser = existing(), default_value = "overwrite")]
    existing: Existing,
}

/// The parser of `--existing`. Commands overwrite by default, like other commands; the library, used by unattended
/// models, keeps existing files by default.
pub fn existing() -> impl TypedValueParser<Value = Existing> {
    input::one_of([
        ("never-modify", Existing::NeverModify, "Keep them, and fail"),
        ("overwrite", Existing::Overwrite, "Replace them"),
    ])
}

/// Renders and writes the pictures and prints their summaries. Several ranks render each together; rank 0 writes it.
pub fn run(args: &Args, out: &mut impl Write) -> CommandResult {
    let mut ranked = RankTeam::new()?;
    let done = render(args, ranked.ranks(), out);
    ranked.outcome(done)
}

fn render(args: &Args, ranks: &mut Ranks, out: &mut impl Write) -> CommandResult {
    let start = Instant::now();
    let progress = if ranks.is_root() { Progress::new() } else { Progress::hidden() };
    let Some(opened) = ranks.collective(args.selection.open(&progress))? else {
        if ranks.is_root() {
            writeln!(out, "{}", args.selection.nothing())?;
        }
        return Ok(());
    };
    let Opened { renderer, file, .. } = &opened;
    let Scenes { mut script, grid, suggested } = ranks.collective(opened.scenes(&args.selection, &progress))?;
    if args.output_options.error.is_some() {
        script.scenes_mut().for_each(|scene| scene.output.error = None);
    }
    if let Some(names) = &args.output_options.names {
        script.scenes_mut().for_each(|scene| scene.output = names.clone().into());
    }
    let (series, target) = ranks.collective(args.output_options.choose(&script, &opened))?;
    let queue = ranks.is_root().then(|| args.output_options.queue(&series, &target)).transpose();
    let mut queue = ranks.collective(queue)?;
    progress.stage("reading layers");
    let layers = &args.selection.layer_option.layers;
    let scene_fields = ranks.collective(renderer.run(|| SceneFields::new(file, &script, layers)))?;
    let open_s = start.elapsed().as_secs_f64();
    let drawing = Drawing { scene_fields: &scene_fields, grid: &grid, renderer };
    let job = Job { drawing, target: &target, open_s, is_verbose: args.output_options.verbose };
    let mut pictures = Pictures::new(&series, job, &progress);
    let outcome = match queue {
        Some(_) => progress.suspend(|| {
            args.save_scene(suggested.as_ref(), out)?;
            print_notes(&scene_fields.all_notes(&script)?, out)
        }),
        None => Ok(()),
    };
    agree(ranks, outcome)?;
    for &time in &series.times {
        let due = ranks.collective(pictures.read(time))?;
        pictures.draw(&due, |_| true, &mut queue, out, ranks)?;
    }
    progress.stage("writing");
    let outcome = match queue {
        Some(_) if pictures.drawn == 0 => {
            Ok(writeln!(out, "note      nothing is drawn: these times are no view's turn")?)
        }
        Some(queue) => print_blocks(queue.finish(), &progress, out),
        None => Ok(()),
    };
    progress.finish();
    agree(ranks, outcome)
}

pub fn print_notes(notes: &[String], out: &mut impl Write) -> CommandResult {
    notes.iter().try_for_each(|line| Ok(writeln!(out, "note      {line}")?))
}

/// Collective: fails on all ranks if rank 0 could not print or write, with its error on rank 0.
fn agree(ranks: &mut Ranks, outcome: CommandResult) -> CommandResult {
    let agreed = ranks.collective(outcome.as_ref().copied().map_err(Failure::to_error));
    outcome.and(agreed.map_err(Failure::from))
}

impl Args {
    /// Prints for which field a scene was suggested, and writes the scene if `--save-scene` is given.
    pub fn save_scene(&self, suggested: Option<&Suggested>, out: &mut impl Write) -> CommandResult {
        let Some(suggested) = suggested else { return Ok(()) };
        let saved = match &self.selection.scene_options.save_scene {
            Some(path) => {
                suggested.save(path, self.output_options.existing)?;
                format!("; saved as {}", path.display())
            }
            None => String::new(),
        };
        Ok(writeln!(out, "scene     {}{saved}", suggested.summary)?)
    }
}

impl OutputOptions {
    /// Pictures of these names in a directory.
    pub fn named(directory: &Path, names: NameTemplate) -> Self {
        OutputOptions { output: Some(directory.to_owned()), names: Some(names), ..Self::default() }
    }

    /// The times to render and the target of the pictures.
    pub fn choose<'a>(&self, script: &'a Script, opened: &'a Opened) -> Result<(Series<'a>, Target)> {
        let Opened { file, times, is_series, .. } = opened;
        for name in script.model_fields() {
            file.field_info(&name)?;
        }
        let series = Series::of(file, script, times.clone(), *is_series);
        let target = Target::new(self.output.as_deref(), series.pictures())?;
        Ok((series, target))
    }

    /// The output queue, after checking that all pictures can be written, as far as is known before rendering.
    fn queue<'a>(&'a self, series: &Series, target: &'a Target) -> Result<OutputQueue<'a>> {
        if let Some(map) = &self.error {
            target::expect_error_map(map, series.pictures())?;
        }
        let queue = OutputQueue::new(target, self.existing, self.error.as_deref())?;
        let mut seen = HashMap::new();
        for &time in &series.times {
            let stamp = series.stamp(time);
            let views = series.scheduled(time).into_iter();
            for (view, shot) in views.flat_map(|view| view.shots(&stamp).map(move |shot| (view, shot))) {
                let (output, field) = (&shot.scene.output, shot.scene.field());
                if let Target::Directory(_) = target {
                    expect_distinct(&mut seen, output.names(&stamp, field)?, time)?;
                }
                if series.is_uncertain(view) {
                    continue;
                }
                if let Some(map) = &self.error {
                    target::expect_apart(map, &target.path(output, &stamp, field)?)?;
                }
                queue.check(output, &stamp, field)?;
            }
        }
        Ok(queue)
    }
}

/// Fails if an earlier picture of the run has one of these names; `seen` has the time of each.
fn expect_distinct(seen: &mut HashMap<String, usize>, names: FrameNames, time: usize) -> Result<()> {
    let named = [("output.file", Some(names.file)), ("output.error", names.error)];
    for (key, name) in named.into_iter().filter_map(|(key, name)| Some((key, name?))) {
        if let Some(earlier) = seen.insert(name.clone(), time) {
            let context = format!(
                "{key} names the pictures of times {earlier} and {time} both {name:?}, expected {{step}} or a date in it"
            );
            return Err(Error::new(ErrorKind::Scene, context));
        }
    }
    Ok(())
}

/// Prints the summaries of written pictures, up to the first failure.
pub fn print_blocks(blocks: Vec<Result<String>>, progress: &Progress, out: &mut impl Write) -> CommandResult {
    for block in blocks {
        let block = block?;
        progress.suspend(|| writeln!(out, "{block}"))?;
    }
    Ok(())
}
