//! `icoray sample`: a file to try the other commands on.

use crate::failure::CommandResult;
use crate::render::existing;
use icoray::output::Existing;
use icoray_dataset::Sample;
use std::io::Write;
use std::path::PathBuf;

/// Arguments of `icoray sample`.
#[derive(clap::Args)]
pub struct Args {
    /// The file (.nc)
    #[arg(value_name = "SAMPLE.nc")]
    output: PathBuf,
    /// Treatment of a file of the same name
    #[arg(long, value_name = "WHAT", value_parser = existing(), default_value = "overwrite")]
    existing: Existing,
}

/// Writes the file and prints a command that draws it.
pub fn run(args: &Args, out: &mut impl Write) -> CommandResult {
    args.existing.prepare(&args.output)?;
    icoray_netcdf::write_sample(&args.output, &Sample::new()?)?;
    let path = args.output.display();
    writeln!(out, "sample    {path}; icoray render {path} draws it")?;
    Ok(())
}
