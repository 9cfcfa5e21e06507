//! `icoray animate`: an animated PNG, or a film by ffmpeg.

use crate::failure::CommandResult;
use crate::render::ExistingFiles;
use icoray::output::{Animated, write_animation};
use icoray_progress::Progress;
use std::io::Write;
use std::path::PathBuf;

/// Arguments of `icoray animate`.
#[derive(clap::Args)]
pub struct Args {
    /// Pictures (.png), all of one size, in their order
    #[arg(value_name = "PICTURE.png", required = true)]
    pictures: Vec<PathBuf>,
    /// The animation: .png; or .mp4 or .gif, for which ffmpeg must be installed
    #[arg(short, long, value_name = "ANIMATION")]
    output: PathBuf,
    /// Pictures per second, 0.001 to 1000
    #[arg(long, value_name = "N", default_value_t = 10.0)]
    fps: f64,
    /// What is done with a file of the same name
    #[arg(long, value_name = "WHAT", value_enum, default_value_t = ExistingFiles::Overwrite)]
    existing: ExistingFiles,
}

/// Writes the animation and prints its size.
pub fn run(args: &Args, out: &mut impl Write) -> CommandResult {
    let progress = Progress::new();
    progress.stage(format!("encoding {} pictures", args.pictures.len()));
    let Animated { size: [width, height], frames, bytes } =
        write_animation(&args.output, &args.pictures, args.fps, args.existing.into())?;
    progress.finish();
    let (path, fps) = (args.output.display(), args.fps);
    writeln!(out, "animation {path} ({width} x {height}, {frames} pictures, {fps} per second, {bytes} bytes)")?;
    Ok(())
}
