//! icoray on the command line: pictures of files of MPAS and ICON.
//!
//! `icoray render` makes pictures, `icoray view` shows a file on a page, `icoray watch` draws files as a model writes
//! them, `icoray animate` makes an animation, `icoray info` prints the contents of a file, `icoray plan` the data that
//! a scene reads and leaves out, `icoray devices` the GPUs; `icoray colormaps` draws all colour maps, `icoray sample`
//! writes a file to try these on, `icoray manual` writes manual pages and completions. Results go to stdout, progress
//! to stderr where that is a terminal; an error is one line on stderr and exit code 1, wrong usage exit code 2. A
//! command that reads NetCDF-4 files runs in a child process, as damage of such a file may end it.
#![forbid(unsafe_code)]

mod animate;
mod color_maps;
mod failure;
mod gpu;
mod info;
mod input;
mod isolated;
mod manual;
mod overrides;
mod plan;
mod ranks;
mod render;
mod sample;
mod scene_options;
mod selection;
mod suggested;
mod view;
mod watch;

use clap::{CommandFactory, Parser, Subcommand};
use icoray::printable;
use std::ffi::OsString;
use std::io::{self, StdoutLock, Write};
use std::path::Path;
use std::process::ExitCode;

/// In-situ ray casting of geodesic grids.
///
/// `icoray FILE.nc` is `icoray render FILE.nc`.
#[derive(Parser)]
#[command(name = "icoray", version)]
struct Cli {
    /// Be the child of a process that waits for it
    #[arg(long = "isolated", hide = true)]
    is_isolated: bool,
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Render a field of a file with a scene file or a suggested scene
    Render(render::Args),
    /// Make an animated PNG, MP4 or GIF of pictures, or of the times of files
    Animate(animate::Args),
    /// Look at a file on a page: turn, colour and probe it, save the scene
    View(view::Args),
    /// Draw the files of a directory as a model writes them
    Watch(watch::Args),
    /// Print the contents of a file: mesh, times, layers, fields
    Info(info::Args),
    /// Print which data of a file a scene reads and which it leaves out
    ///
    /// Takes the options of `icoray render` and draws nothing: -o names the planned picture, --save-scene writes
    /// the suggested scene, --error has no effect.
    Plan(render::Args),
    /// Write a file to try the other commands on: 2,562 cells, 16 layers, two times, three fields
    Sample(sample::Args),
    /// Draw all colour maps with their names
    Colormaps(color_maps::Args),
    /// Write manual pages of all commands, and completions for bash, zsh and fish
    Manual(manual::Args),
    /// List the GPUs that can render, with the numbers by which scenes select them
    Devices,
    /// Read a file whose damage may end this process, and keep nothing
    #[command(hide = true)]
    TryReading(isolated::Args),
    /// A program of its own
    #[command(hide = true)]
    Study {
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        words: Vec<String>,
    },
}

impl Command {
    /// The files that the command reads in its own process.
    fn input(&self) -> Option<&input::Input> {
        match self {
            Command::Render(args) | Command::Plan(args) => Some(&args.selection.input),
            Command::View(args) => Some(&args.selection.input),
            Command::Info(args) => Some(&args.input),
            Command::Animate(args) => args.input(),
            _ => None,
        }
    }
}

fn main() -> ExitCode {
    let Cli { is_isolated, command } = Cli::parse_from(with_command(std::env::args_os().collect()));
    if is_isolated {
        isolated::begin();
    } else if let Some(input) = command.input() {
        match isolated::run_apart(input) {
            Ok(None) => (),
            Ok(Some(code)) => return code,
            Err(error) => return complain(&error.into()),
        }
    }
    let mut out = Printed(io::stdout().lock());
    let done = match command {
        Command::Render(args) => render::run(&args, &mut out),
        Command::Animate(args) => animate::run(args, &mut out),
        Command::View(args) => view::run(&args, &mut out),
        Command::Watch(args) => watch::run(&args, &mut out),
        Command::TryReading(args) => isolated::run(&args).map_err(failure::Failure::from),
        Command::Info(args) => info::run(&args, &mut out),
        Command::Plan(args) => plan::run(&args, &mut out),
        Command::Sample(args) => sample::run(&args, &mut out),
        Command::Colormaps(args) => color_maps::run(&args, &mut out),
        Command::Manual(args) => manual::run(&args, Cli::command()),
        Command::Devices => gpu::list().iter().try_for_each(|line| Ok(writeln!(out, "{line}")?)),
        Command::Study { words } => return no_study(&words),
    };
    match done.and_then(|()| Ok(out.flush()?)) {
        Ok(()) => ExitCode::SUCCESS,
        // The reader of stdout has closed it, as `head` does.
        Err(failure::Failure::Stdout(error)) if error.kind() == io::ErrorKind::BrokenPipe => ExitCode::SUCCESS,
        // A launcher ends all ranks as soon as one has failed, so only the rank that prints the error returns a
        // failure.
        Err(failure::Failure::ReportedByRoot) => ExitCode::SUCCESS,
        Err(failure) => complain(&failure),
    }
}

/// stdout, without the control characters of files, paths and scenes. Each text that is written, as each piece of
/// `writeln!`, has whole characters.
struct Printed(StdoutLock<'static>);

impl Write for Printed {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let text = String::from_utf8_lossy(bytes);
        let lines: Vec<_> = text.split('\n').map(printable).collect();
        self.0.write_all(lines.join("\n").as_bytes())?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

/// The words of the command line, with `render` before a file that stands in place of a command.
fn with_command(mut words: Vec<OsString>) -> Vec<OsString> {
    let first = words.iter().skip(1).position(|word| !word.to_string_lossy().starts_with('-')).map(|at| at + 1);
    if let Some(at) = first
        && Cli::command().find_subcommand(&words[at]).is_none()
        && Path::new(&words[at]).extension().is_some_and(|ending| ending == "nc" || ending == "nc4")
    {
        words.insert(at, "render".into());
    }
    words
}

/// Prints an error; the exit code of one.
fn complain(failure: &failure::Failure) -> ExitCode {
    // Nothing is left to be done where stderr is closed too.
    let _ = writeln!(io::stderr(), "icoray: error: {failure}");
    ExitCode::FAILURE
}

/// Prints the name of the program with the studies.
fn no_study(words: &[String]) -> ExitCode {
    let words = words.join(" ");
    let program = format!("icoray-study {words}");
    // Nothing is left to be done where stderr is closed too.
    let _ = writeln!(io::stderr(), "icoray: the studies are a program of their own: {}", program.trim_end());
    ExitCode::from(2)
}
