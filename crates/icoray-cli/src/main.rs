//! icoray on the command line: pictures of files of MPAS and ICON.
//!
//! `icoray render` makes pictures, `icoray animate` one that moves, `icoray info` says what a file holds, `icoray plan` what a scene leaves out, `icoray
//! devices` which GPUs can draw, `icoray study` measures what the library claims. Results go to stdout; an error is one line on stderr and exit code 1, wrong usage exit code 2.
#![forbid(unsafe_code)]

mod animate;
mod failure;
mod gpu;
mod info;
mod input;
mod layering;
mod plan;
mod ranks;
mod render;
mod times;

use clap::{Parser, Subcommand};
use std::io::{self, Write};
use std::process::ExitCode;

/// In-situ ray casting of geodesic grids.
#[derive(Parser)]
#[command(name = "icoray", version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Render a field of a file as a scene says
    Render(render::Args),
    /// Make an animated PNG of pictures
    Animate(animate::Args),
    /// Say what a file holds: mesh, times, layers, fields
    Info(info::Args),
    /// Say what a scene reads of a file and leaves out
    Plan(plan::Args),
    /// List the GPUs that can draw, with the numbers by which scenes choose them
    Devices,
    /// Measure what icoray claims
    #[command(subcommand)]
    Study(icoray_study::Study),
}

fn main() -> ExitCode {
    let mut out = io::stdout().lock();
    let done = match Cli::parse().command {
        Command::Render(args) => render::run(&args, &mut out),
        Command::Animate(args) => animate::run(&args, &mut out),
        Command::Info(args) => info::run(&args, &mut out),
        Command::Plan(args) => plan::run(&args, &mut out),
        Command::Devices => gpu::list().iter().try_for_each(|line| Ok(writeln!(out, "{line}")?)),
        Command::Study(study) => study.run(&mut out).map_err(Into::into),
    };
    match done.and_then(|()| Ok(out.flush()?)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) if failure.is_closed_pipe() => ExitCode::SUCCESS,
        Err(failure::Failure::SaidElsewhere) => ExitCode::FAILURE,
        Err(failure) => {
            // Nothing is left to be done where stderr is closed too.
            let _ = writeln!(io::stderr(), "icoray: error: {failure}");
            ExitCode::FAILURE
        }
    }
}
