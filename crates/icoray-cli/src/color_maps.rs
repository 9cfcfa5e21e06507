//! `icoray colormaps`: a picture of all colour maps.

use crate::failure::CommandResult;
use crate::render::existing;
use icoray::output::{Existing, write_color_maps};
use std::io::Write;
use std::path::PathBuf;

/// Arguments of `icoray colormaps`.
#[derive(clap::Args)]
pub struct Args {
    /// The picture
    #[arg(short, long, value_name = "PICTURE.png", default_value = "colormaps.png")]
    output: PathBuf,
    /// Treatment of a file of the same name
    #[arg(long, value_name = "WHAT", value_parser = existing(), default_value = "overwrite")]
    existing: Existing,
}

/// Writes the picture and prints the names.
pub fn run(args: &Args, out: &mut impl Write) -> CommandResult {
    args.existing.prepare(&args.output)?;
    write_color_maps(&args.output, args.existing)?;
    writeln!(out, "picture   {}\nnames     {}", args.output.display(), icoray::color_maps())?;
    Ok(())
}
