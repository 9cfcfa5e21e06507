//! `icoray colormaps`: a picture of all colour maps.

use crate::failure::CommandResult;
use crate::render::ExistingFiles;
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
    #[arg(long, value_name = "WHAT", value_enum, default_value_t = ExistingFiles::Overwrite)]
    existing: ExistingFiles,
}

/// Writes the picture and prints the names.
pub fn run(args: &Args, out: &mut impl Write) -> CommandResult {
    let existing = Existing::from(args.existing);
    existing.prepare(&args.output)?;
    write_color_maps(&args.output, existing)?;
    writeln!(out, "picture   {}\nnames     {}", args.output.display(), icoray::color_maps())?;
    Ok(())
}
