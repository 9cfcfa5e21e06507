//! The studies of the program `icoray-study NAME`: errors, run times and comparisons of icoray with the references of
//! [`icoray_reference`].

mod corners;
mod error;
mod fig6;
#[cfg(feature = "gpu")]
mod gpu;
mod levels;
mod live;
mod peak;
mod picture;
mod plan;
mod plot;
mod ranks;
mod results;
mod scale;
mod scenes;
mod speed;
mod stability;
mod vtk;

use std::io::Write;

/// Measures errors and speed of icoray.
#[derive(Debug, clap::Parser)]
#[command(name = "icoray-study", version)]
pub struct CommandLine {
    /// The study.
    #[command(subcommand)]
    pub study: Study,
}

/// All studies.
#[derive(Debug, Clone, clap::Subcommand)]
pub enum Study {
    /// The paper's Figure 6: a radial field, lit, against a ground truth; writes both pictures and the difference.
    Fig6(fig6::Options),
    /// Seconds of scenes in which ray casting is easily slow, beside scenes that should cost about as much.
    Corners(corners::Options),
    /// Measures pictures on coarser grids.
    Levels(levels::Options),
    /// Error against run time of all methods on all scenes: table, plots and a verdict.
    Error(error::Options),
    /// Frames per second of the live view, and the time from a movement to its picture.
    Live(live::Options),
    /// Milliseconds of frames on a GPU, beside the CPU's and the paper's, and their share of the device's peak rates.
    #[cfg(feature = "gpu")]
    Gpu(gpu::Options),
    /// Time and bytes that each saving of the plan saves, and its cost where it saves nothing.
    Plan(plan::Options),
    /// Load balance and communication of 1 to 64 ranks, simulated in one process.
    Ranks(ranks::Options),
    /// Messages of thousands of ranks over a simulated network, and the work of nodes of large grids.
    Scale(scale::Options),
    /// Seconds per frame and frusta per second for four transfer functions.
    Speed(speed::Options),
    /// Error, bound and lost rays in some 200 hard cases, against the exact integral.
    Stability(stability::Options),
    /// Frame time, memory and error beside VTK's renderers of unstructured grids.
    Vtk(vtk::Options),
}

impl Study {
    /// Runs the study and writes its results to `out`, line by line.
    ///
    /// # Errors
    /// Those of the library, and [`icoray::ErrorKind::Io`] when `out` fails.
    pub fn run(&self, out: &mut dyn Write) -> icoray::Result<()> {
        match self {
            Study::Fig6(options) => fig6::run(options, out),
            Study::Corners(options) => corners::run(options, out),
            Study::Levels(options) => levels::run(options, out),
            Study::Error(options) => error::run(options, out),
            Study::Live(options) => live::run(options, out),
            #[cfg(feature = "gpu")]
            Study::Gpu(options) => gpu::run(options, out),
            Study::Plan(options) => plan::run(options, out),
            Study::Ranks(options) => ranks::run(options, out),
            Study::Scale(options) => scale::run(options, out),
            Study::Speed(options) => speed::run(options, out),
            Study::Stability(options) => stability::run(options, out),
            Study::Vtk(options) => vtk::run(options, out),
        }
    }
}
