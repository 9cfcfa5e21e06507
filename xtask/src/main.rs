//! Installs missing packages, runs the demo and the tests, draws the gallery, installs the C library, packs releases.
//!
//! `cargo xtask demo` and `cargo xtask test` are the entry points on a fresh machine; `cargo xtask install` installs
//! the library for models that link it. The few dependencies have no dependencies of their own, so this crate builds in
//! seconds with nothing but the Rust toolchain and a linker.

mod apt;
mod book;
mod check;
mod demo;
mod diagnosis;
mod disk;
mod elf;
mod error;
mod files;
mod gallery;
mod host;
mod install;
mod libclang;
mod link;
mod mpi;
mod options;
mod package;
mod pictures;
mod report;
mod requirements;
mod shallow_water;
mod step;
mod system;
mod tracer;
mod workspace;

use std::process::ExitCode;

use error::Error;
use options::{Invocation, Subcommand, USAGE};
use step::{print_error, print_line};
use workspace::Workspace;

fn main() -> ExitCode {
    match options::parse(std::env::args_os().skip(1)).and_then(run) {
        Ok(code) => code,
        Err(error @ Error::Usage(_)) => {
            print_error(&format!("error: {error}\n\n{USAGE}"));
            ExitCode::from(2)
        }
        Err(error) => {
            print_error(&format!("error: {error}"));
            ExitCode::FAILURE
        }
    }
}

fn run(Invocation { subcommand, install }: Invocation) -> Result<ExitCode, Error> {
    if subcommand == Subcommand::Help {
        print_line(USAGE);
        return Ok(ExitCode::SUCCESS);
    }
    let workspace = Workspace::find()?;
    match subcommand {
        Subcommand::Help => {}
        Subcommand::Demo(options) => demo::run(&workspace, &options, install)?,
        Subcommand::Gallery { profile } => gallery::run(&workspace, profile, install)?,
        Subcommand::Install(options) => install::run(&workspace, &options, install)?,
        Subcommand::Package => package::run(&workspace)?,
        Subcommand::Test { all } => return check::run(&workspace, all, install),
    }
    Ok(ExitCode::SUCCESS)
}
