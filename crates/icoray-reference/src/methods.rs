//! The rendering methods that the paper compares with, on the rays and the traversal of the renderer.
//!
//! Geometry is in f64; values, samples and compositing are in f32, as in the renderer.

mod march;
mod mean_value;
mod nearest;
mod preintegrated;
#[cfg(test)]
mod tests;
mod tetrahedra;
mod transfer;
mod wedge;

pub use march::Picture;

use crate::job::{Job, PreparedJob};
use icoray::{Renderer, Result, Scene};
use march::midpoints;
use mean_value::MeanValue;
use nearest::Nearest;
use preintegrated::Table;
use tetrahedra::Tetrahedra;
use transfer::Transfer;
use wedge::Wedge;

/// A rendering method.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Method {
    /// The renderer's `exact`.
    Exact {
        /// Largest error of a channel.
        tolerance: f64,
    },
    /// The renderer's `paper`: piecewise linear between extrema and knots (§3.4).
    Paper,
    /// Samples at equal distances.
    Sampled {
        /// The values and their integration.
        sampling: Sampling,
        /// Distance along the ray in planet radii, from where it enters the shell.
        step: f64,
    },
}

/// Interpolation and integration of samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Sampling {
    /// The wedge interpolant (§3.3), opacity `1 - exp(-κh)`: §3.4's conventional way, the midpoint rule, of second
    /// order where the transfer function has no kinks. The only one here with light.
    Uniform,
    /// Each frustum as three tetrahedra, linear in each, sampled as [`Sampling::Uniform`] (Weiler et al. 2003; §4.2).
    /// Its limit for small steps is another picture than the wedge's.
    Tetrahedra,
    /// Mean value coordinates over each frustum's eight triangles (Ju, Schaefer and Warren 2005; §4.2), sampled as
    /// [`Sampling::Uniform`]. Its limit for small steps is another picture than the wedge's.
    MeanValue,
    /// The value of the nearest cell centre on the nearest layer (§3.3's piecewise-constant sampling), sampled as
    /// [`Sampling::Uniform`]: first order in the mesh.
    Constant,
    /// Steps of the wedge interpolant through a pre-integrated table (Röttger et al. 2000, Engel et al. 2001): second
    /// order in the step with attenuation inside a step, first order without.
    PreIntegrated {
        /// Values along each side of the table, at least 4.
        table: usize,
        /// Whether a step absorbs its own light.
        attenuated: bool,
    },
}

impl Sampling {
    /// All, with tables of `table` values along each side.
    pub fn all(table: usize) -> [Self; 6] {
        let [pre_integrated, unattenuated] =
            [true, false].map(|attenuated| Sampling::PreIntegrated { table, attenuated });
        use Sampling::{Constant, MeanValue, Tetrahedra, Uniform};
        [Uniform, pre_integrated, unattenuated, Constant, Tetrahedra, MeanValue]
    }

    /// The name in tables and plots.
    pub fn name(self) -> &'static str {
        match self {
            Sampling::Uniform => "uniform",
            Sampling::Tetrahedra => "tetrahedra",
            Sampling::MeanValue => "mean value",
            Sampling::Constant => "constant",
            Sampling::PreIntegrated { attenuated: true, .. } => "pre-integrated",
            Sampling::PreIntegrated { attenuated: false, .. } => "pre-integrated, no attenuation",
        }
    }

    /// The method at a step.
    pub fn at(self, step: f64) -> Method {
        Method::Sampled { sampling: self, step }
    }
}

impl Method {
    /// Renders on the renderer's threads. Of the methods that sample, only [`Sampling::Uniform`] lights the scene.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn render(&self, job: &Job, renderer: &Renderer) -> Result<Picture> {
        match *self {
            Method::Exact { tolerance } => shipped(job, renderer, icoray::Method::Exact, tolerance),
            Method::Paper => shipped(job, renderer, icoray::Method::Paper, job.scene.tolerance),
            Method::Sampled { sampling, step } => sampled(job, renderer, sampling, step),
        }
    }
}

fn sampled(job: &Job, renderer: &Renderer, sampling: Sampling, step: f64) -> Result<Picture> {
    let unlit = Scene { lighting: None, ..job.scene.clone() };
    let scene = if sampling == Sampling::Uniform { job.scene } else { &unlit };
    let prepared = PreparedJob::new(&Job { scene, ..*job })?;
    Ok(match sampling {
        Sampling::Tetrahedra => midpoints(&prepared, renderer, step, &Tetrahedra(&prepared)),
        Sampling::MeanValue => midpoints(&prepared, renderer, step, &MeanValue(&prepared)),
        Sampling::Constant => midpoints(&prepared, renderer, step, &Nearest(&prepared)),
        Sampling::PreIntegrated { table, attenuated } => {
            let transfer = Transfer::new(prepared.scene, prepared.thickness());
            let table = renderer.run(|| Table::new(&prepared, step, table, attenuated));
            march::render(&prepared, renderer, step, &Wedge::new(&prepared), &transfer, &table)
        }
        Sampling::Uniform => {
            let wedge = renderer.run(|| Wedge::new(&prepared));
            midpoints(&prepared, renderer, step, &wedge)
        }
    })
}

/// A picture by the renderer itself.
fn shipped(job: &Job, renderer: &Renderer, method: icoray::Method, tolerance: f64) -> Result<Picture> {
    let scene = Scene { method, tolerance, ..job.scene.clone() };
    let frame = Job { scene: &scene, ..*job }.render(renderer)?;
    let (seconds, samples) = (frame.report.timing.render_s, frame.report.counts.frusta);
    Ok(Picture { pixels: frame.pixels, seconds, samples, bound: Some(frame.error) })
}
