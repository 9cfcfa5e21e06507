//! What icoray claims, measured: the program `icoray-study NAME`.
//!
//! [`mod@error`] error against run time of all methods, [`fig6`] the paper's radial field against its ground truth,
//! [`fig8`] and [`fig9`] its comparisons with other interpolations, [`orders`] orders of convergence, [`mod@plan`] what each
//! saving spares, [`speed`] seconds per frame, [`ranks`] how several processes share a frame out, [`stability`] how far pictures are from the exact integral
//! where it is hard, [`mod@vtk`] VTK on the same field. [`mod@oracle`] is the same
//! picture to ten digits, [`methods`] are the ways to render it that the paper compares with, and [`mod@reference`] is an
//! independent, slow evaluation that oracle and renderer are tested against.

mod closeup;
mod compare;
mod csv_file;
pub mod error;
pub mod fig6;
pub mod fig8;
pub mod fig9;
#[cfg(feature = "gpu")]
pub mod gpu;
mod look;
pub mod methods;
mod montage;
pub mod oracle;
pub mod orders;
mod peak;
pub mod plan;
mod plot;
pub mod ranks;
mod readme;
pub mod reference;
pub mod scenes;
mod setting;
pub mod speed;
pub mod sphere;
pub mod stability;
pub mod vtk;

use icoray::{Error, ErrorKind};
use icoray_progress::steps as progress;
use std::io::Write;
use std::path::Path;

/// Writes a line at once, so that a long study is seen to go on.
fn say(out: &mut dyn Write, line: &str) -> icoray::Result<()> {
    let written = writeln!(out, "{line}").and_then(|()| out.flush());
    written.map_err(|e| Error::new(ErrorKind::Io, format!("standard output: {e}")))
}

/// What went wrong with a file of results.
fn io_error(path: &Path, e: impl std::fmt::Display) -> Error {
    Error::new(ErrorKind::Io, format!("{}: {e}", path.display()))
}

/// Makes a directory for results.
fn make_directory(path: &Path) -> icoray::Result<()> {
    std::fs::create_dir_all(path).map_err(|e| io_error(path, e))
}

/// A step along a ray from the command line.
fn step(text: &str) -> Result<f64, String> {
    let step = text.parse().ok().filter(|s| (1e-6..=1.0).contains(s));
    step.ok_or_else(|| "expected a number of planet radii from 1e-6 to 1".to_owned())
}

/// The studies that there are.
#[derive(Debug, Clone, clap::Subcommand)]
pub enum Study {
    /// The paper's Figure 6: a radial field, lit, against a ground truth; writes both pictures and the difference.
    Fig6(fig6::Options),
    /// Error against run time of all methods on all scenes: table, plots and a verdict.
    Error(error::Options),
    /// The paper's Figure 8: close-ups by several interpolations with their amplified errors, at equal step and time.
    Fig8(fig8::Options),
    /// The paper's Figure 9: frame rate against sampling step for three interpolations.
    Fig9(fig9::Options),
    /// Milliseconds of frames on a GPU, beside the CPU's and the paper's, and what they take of what the device has.
    #[cfg(feature = "gpu")]
    Gpu(gpu::Options),
    /// Orders of convergence of all methods, in the step and in the mesh.
    Orders(orders::Options),
    /// What each saving of the plan spares in time and bytes, and what it costs where it spares nothing.
    Plan(plan::Options),
    /// How evenly 1 to 64 ranks share a picture out, and what they send, simulated in one process.
    Ranks(ranks::Options),
    /// Seconds per frame and frusta per second for four transfer functions.
    Speed(speed::Options),
    /// Error, bound and lost rays in some 200 hard cases, against the exact integral in double-double.
    Stability(stability::Options),
    /// Frame time, memory and error beside VTK's renderers of unstructured grids.
    Vtk(vtk::Options),
}

impl Study {
    /// Runs the study and writes what it finds to `out`, line by line.
    ///
    /// # Errors
    /// Whatever the library says, and [`ErrorKind::Io`] when `out` fails.
    pub fn run(&self, out: &mut dyn Write) -> icoray::Result<()> {
        match self {
            Study::Fig6(options) => fig6::run(options, out),
            Study::Error(options) => error::run(options, out),
            Study::Fig8(options) => fig8::run(options, out),
            Study::Fig9(options) => fig9::run(options, out),
            #[cfg(feature = "gpu")]
            Study::Gpu(options) => gpu::run(options, out),
            Study::Orders(options) => orders::run(options, out),
            Study::Plan(options) => plan::run(options, out),
            Study::Ranks(options) => ranks::run(options, out),
            Study::Speed(options) => speed::run(options, out),
            Study::Stability(options) => stability::run(options, out),
            Study::Vtk(options) => vtk::run(options, out),
        }
    }
}
