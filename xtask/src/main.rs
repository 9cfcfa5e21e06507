//! Installs what is missing, runs the demo and the tests, draws the gallery, installs the C library.
//!
//! `cargo xtask demo` and `cargo xtask test` are the project's two entry points on a fresh machine, and
//! `cargo xtask install` is that of a model that is to link the library.
//! This crate has no dependencies, so that it builds in about a second and needs nothing but the
//! Rust toolchain and a linker to get started.

mod apt;
mod book;
mod check;
mod demo;
mod diagnosis;
mod disk;
mod elf;
mod error;
mod gallery;
mod host;
mod install;
mod libclang;
mod link;
mod mpi;
mod options;
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
use options::{Invocation, USAGE};
use step::say;
use workspace::Workspace;

fn main() -> ExitCode {
    let arguments = std::env::args_os().skip(1);
    match options::parse(arguments).and_then(run) {
        Ok(code) => code,
        Err(error @ Error::Usage(_)) => {
            step::complain(&format!("error: {error}\n\n{USAGE}"));
            ExitCode::from(2)
        }
        Err(error) => {
            step::complain(&format!("error: {error}"));
            ExitCode::FAILURE
        }
    }
}

fn run(invocation: Invocation) -> Result<ExitCode, Error> {
    match invocation {
        Invocation::Help => say(USAGE),
        Invocation::Demo(options) => demo::run(&Workspace::find()?, &options)?,
        Invocation::Gallery(options) => gallery::run(&Workspace::find()?, &options)?,
        Invocation::Install(options) => install::run(&Workspace::find()?, &options)?,
        Invocation::Test(options) => return check::run(&Workspace::find()?, &options),
    }
    Ok(ExitCode::SUCCESS)
}
