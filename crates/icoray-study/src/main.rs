//! `icoray-study NAME` runs a study. Results go to stdout; an error is one line on stderr and exit code 1, wrong usage
//! exit code 2.
#![forbid(unsafe_code)]

use clap::Parser;
use icoray_study::CommandLine;
use std::io::{self, Write};
use std::process::ExitCode;

fn main() -> ExitCode {
    match CommandLine::parse().study.run(&mut io::stdout().lock()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // Nothing is left to be done where stderr is closed too.
            let _ = writeln!(io::stderr(), "icoray-study: error: {error}");
            ExitCode::FAILURE
        }
    }
}
