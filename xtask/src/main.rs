//! Installs missing packages, runs the demo and the tests, draws the gallery, installs the C library, packs releases.
//!
//! `cargo xtask demo` and `cargo xtask test` are the entry points on a fresh machine; `cargo xtask install` installs
//! the library for models that link it. This crate builds with nothing but the Rust toolchain and a linker.

mod book;
mod check;
mod demo;
mod error;
mod files;
mod gallery;
mod install;
mod libclang;
mod link;
mod models;
mod mpi;
mod options;
mod package;
mod requirements;
mod side_by_side;
mod step;
mod system;
mod workspace;

use std::process::ExitCode;

use clap::Parser;

use error::Error;
use options::{CommandLine, Subcommand};
use step::{print_error, print_line};
use workspace::Workspace;

fn main() -> ExitCode {
    run(CommandLine::parse()).unwrap_or_else(|error| {
        print_error(&format!("error: {error}"));
        ExitCode::FAILURE
    })
}

fn run(CommandLine { subcommand, no_install }: CommandLine) -> Result<ExitCode, Error> {
    let workspace = Workspace::find()?;
    let install = !no_install;
    match subcommand {
        Subcommand::Demo(options) => demo::run(&workspace, &options, install)?,
        Subcommand::Gallery => gallery::run(&workspace, install)?,
        Subcommand::Install(options) => install::run(&workspace, &options, install)?,
        Subcommand::Package => package::run(&workspace)?,
        Subcommand::Requirements { all } => requirements::listed(all).iter().for_each(|package| print_line(package)),
        Subcommand::Test { all, only } => return check::run(&workspace, all, &only, install),
    }
    Ok(ExitCode::SUCCESS)
}
