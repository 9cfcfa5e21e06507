//! What icoray claims, measured: `icoray study NAME`.
//!
//! [`fig6`] the paper's radial field against its ground truth, [`speed`] seconds per frame. [`reference`] is an
//! independent, slow evaluation of the same picture, for the tests.

pub mod fig6;
pub mod reference;
pub mod speed;
pub mod sphere;

/// The studies that there are.
#[derive(Debug, Clone, clap::Subcommand)]
pub enum Study {
    /// The paper's Figure 6: a radial field, lit, against a ground truth; writes both pictures and the difference.
    Fig6(fig6::Options),
    /// Seconds per frame and frusta per second for four transfer functions.
    Speed(speed::Options),
}

impl Study {
    /// Runs the study and prints what it finds.
    ///
    /// # Errors
    /// Whatever the library says.
    pub fn run(&self) -> icoray::Result<()> {
        match self {
            Study::Fig6(options) => fig6::run(options),
            Study::Speed(options) => speed::run(options),
        }
    }
}
