//! What icoray claims, measured: `icoray study NAME`.
//!
//! [`fig6`] the paper's radial field against its ground truth, [`speed`] seconds per frame. [`mod@reference`] is an
//! independent, slow evaluation of the same picture, for the tests.

pub mod fig6;
mod look;
pub mod reference;
pub mod speed;
pub mod sphere;

use icoray::{Error, ErrorKind};
use std::io::Write;

/// Writes a line at once, so that a long study is seen to go on.
fn say(out: &mut dyn Write, line: &str) -> icoray::Result<()> {
    let written = writeln!(out, "{line}").and_then(|()| out.flush());
    written.map_err(|e| Error::new(ErrorKind::Io, format!("standard output: {e}")))
}

/// The studies that there are.
#[derive(Debug, Clone, clap::Subcommand)]
pub enum Study {
    /// The paper's Figure 6: a radial field, lit, against a ground truth; writes both pictures and the difference.
    Fig6(fig6::Options),
    /// Seconds per frame and frusta per second for four transfer functions.
    Speed(speed::Options),
}

impl Study {
    /// Runs the study and writes what it finds to `out`, line by line.
    ///
    /// # Errors
    /// Whatever the library says, and [`ErrorKind::Io`] when `out` fails.
    pub fn run(&self, out: &mut dyn Write) -> icoray::Result<()> {
        match self {
            Study::Fig6(options) => fig6::run(options, out),
            Study::Speed(options) => speed::run(options, out),
        }
    }
}
