//! `icoray animate`: an animated PNG, or a film by ffmpeg, of pictures or of the times of files.

use crate::failure::CommandResult;
use crate::input::Input;
use crate::render::{self, OutputOptions, existing};
use crate::selection::Selection;
use icoray::output::{Animated, Existing, NameTemplate, write_animation};
use icoray::{Error, ErrorKind};
use icoray_dataset::TimeSelection;
use icoray_progress::Progress;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Arguments of `icoray animate`.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  icoray animate pictures/*.png -o film.mp4\n  \
                        icoray animate history.*.nc --field w --size 640x480 -o film.gif")]
pub struct Args {
    /// Files of a model, of which all times are drawn by default; or pictures (.png) of one size, in their order, for
    /// which the other options have no effect
    #[command(flatten)]
    selection: Selection,
    /// The animation: .png; or .mp4 or .gif, for which ffmpeg must be installed
    #[arg(short, long, value_name = "ANIMATION")]
    output: PathBuf,
    /// Pictures per second, 0.001 to 1000
    #[arg(long, value_name = "N", default_value_t = 10.0)]
    fps: f64,
    /// Treatment of a file of the same name
    #[arg(long, value_name = "WHAT", value_parser = existing(), default_value = "overwrite")]
    existing: Existing,
}

impl Args {
    /// The files to draw; `None` if they are pictures.
    pub fn input(&self) -> Option<&Input> {
        let is_picture = |path: &PathBuf| path.extension().is_some_and(|ending| ending == "png");
        let input = &self.selection.input;
        (!input.files.iter().all(is_picture)).then_some(input)
    }
}

/// Writes the animation and prints its size; pictures of files are drawn into a temporary folder first.
pub fn run(mut args: Args, out: &mut impl Write) -> CommandResult {
    let existing = args.existing;
    existing.prepare(&args.output)?;
    if args.input().is_none() {
        return write(&args.output, &args.selection.input.files, args.fps, existing, out);
    }
    let failed = |e: io::Error| Error::new(ErrorKind::Io, format!("cannot keep pictures for the animation: {e}"));
    let folder = tempfile::tempdir().map_err(failed)?;
    args.selection.time.get_or_insert(TimeSelection::ALL);
    let output_options = OutputOptions::named(folder.path(), NameTemplate::new("{when}.png")?);
    let drawn = render::Args { selection: args.selection, output_options };
    render::run(&drawn, &mut io::sink())?;
    let entries = fs::read_dir(folder.path()).map_err(failed)?.map(|entry| Ok(entry?.path()));
    let mut pictures = entries.collect::<io::Result<Vec<_>>>().map_err(failed)?;
    pictures.retain(|path| path.extension().is_some_and(|ending| ending == "png"));
    pictures.sort();
    write(&args.output, &pictures, args.fps, existing, out)
}

fn write(output: &Path, pictures: &[PathBuf], fps: f64, existing: Existing, out: &mut impl Write) -> CommandResult {
    let progress = Progress::new();
    progress.stage(format!("encoding {} pictures", pictures.len()));
    let Animated { size: [width, height], frames, bytes } = write_animation(output, pictures, fps, existing)?;
    progress.finish();
    let path = output.display();
    writeln!(out, "animation {path} ({width} x {height}, {frames} pictures, {fps} per second, {bytes} bytes)")?;
    Ok(())
}
