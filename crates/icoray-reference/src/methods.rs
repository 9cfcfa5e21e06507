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

use crate::comparison::median;
use crate::job::{Job, PreparedJob};
use icoray::{Renderer, Result, Scene};
use march::midpoints;
use mean_value::MeanValue;
use nearest::Nearest;
use preintegrated::Table;
use tetrahedra::Tetrahedra;
use transfer::Transfer;
use wedge::Wedge;

/// A rendering method. Steps are distances along the ray in planet radii, from where it enters the shell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Method {
    /// The renderer's `exact`, to the given tolerance.
    Exact {
        /// Largest error of a channel.
        tolerance: f64,
    },
    /// The renderer's `paper`: piecewise linear between extrema and knots (§3.4).
    Paper,
    /// Samples at equal distances of the wedge interpolant (§3.3), opacity `1 - exp(-κh)`: §3.4's conventional way, the
    /// midpoint rule, of second order where the transfer function has no kinks. The only one here that knows light.
    Uniform {
        /// Length of a step.
        step: f64,
    },
    /// Each frustum as three tetrahedra, linear in each, sampled as [`Method::Uniform`] (Weiler et al. 2003; §4.2). Its
    /// limit for small steps is another picture than the wedge's.
    Tetrahedra {
        /// Length of a step.
        step: f64,
    },
    /// Mean value coordinates over each frustum's eight triangles (Ju, Schaefer and Warren 2005; §4.2), sampled as
    /// [`Method::Uniform`]. Its limit for small steps is another picture than the wedge's.
    MeanValue {
        /// Length of a step.
        step: f64,
    },
    /// The value of the nearest cell centre on the nearest layer (§3.3's piecewise-constant sampling), sampled as
    /// [`Method::Uniform`]: first order in the mesh.
    Constant {
        /// Length of a step.
        step: f64,
    },
    /// Steps of the wedge interpolant through a pre-integrated table (Röttger et al. 2000, Engel et al. 2001): second
    /// order in the step with attenuation inside a step, first order without.
    PreIntegrated {
        /// Length of a step.
        step: f64,
        /// Values along each side of the table, at least 4.
        table: usize,
        /// Whether a step absorbs its own light.
        attenuated: bool,
    },
}

impl Method {
    /// Renders on the renderer's threads. Of the methods that sample, only [`Method::Uniform`] heeds the scene's light.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn render(&self, job: &Job, renderer: &Renderer) -> Result<Picture> {
        match *self {
            Method::Exact { tolerance } => shipped(job, renderer, icoray::Method::Exact, tolerance),
            Method::Paper => shipped(job, renderer, icoray::Method::Paper, job.scene.tolerance),
            _ => self.sampled(job, renderer),
        }
    }

    /// The picture with the median seconds of so many runs, at least one.
    ///
    /// # Errors
    /// As [`Self::render`].
    pub fn timed(&self, job: &Job, renderer: &Renderer, repeats: usize) -> Result<Picture> {
        let picture = self.render(job, renderer)?;
        let again = (1..repeats).map(|_| Ok(self.render(job, renderer)?.seconds));
        let seconds = again.chain([Ok(picture.seconds)]).collect::<Result<_>>()?;
        Ok(Picture { seconds: median(seconds), ..picture })
    }

    fn sampled(&self, job: &Job, renderer: &Renderer) -> Result<Picture> {
        let unlit = Scene { lighting: None, ..job.scene.clone() };
        let is_uniform = matches!(self, Method::Uniform { .. });
        let prepared = PreparedJob::new(&Job { scene: if is_uniform { job.scene } else { &unlit }, ..*job })?;
        Ok(match *self {
            Method::Tetrahedra { step } => midpoints(&prepared, renderer, step, &Tetrahedra(&prepared)),
            Method::MeanValue { step } => midpoints(&prepared, renderer, step, &MeanValue(&prepared)),
            Method::Constant { step } => midpoints(&prepared, renderer, step, &Nearest(&prepared)),
            Method::PreIntegrated { step, table, attenuated } => {
                let transfer = Transfer::new(prepared.scene, prepared.thickness());
                let table = renderer.run(|| Table::new(&prepared, step, table, attenuated));
                march::render(&prepared, renderer, step, &Wedge::new(&prepared), &transfer, &table)
            }
            Method::Uniform { step } => {
                let wedge = renderer.run(|| Wedge::new(&prepared));
                midpoints(&prepared, renderer, step, &wedge)
            }
            Method::Exact { .. } | Method::Paper => unreachable!("the renderer's own"),
        })
    }
}

/// A picture by the renderer itself.
fn shipped(job: &Job, renderer: &Renderer, method: icoray::Method, tolerance: f64) -> Result<Picture> {
    let scene = Scene { method, tolerance, ..job.scene.clone() };
    let frame = renderer.render(&scene, job.grid, job.layers, job.field)?;
    let (seconds, samples) = (frame.report.timing.render_s, frame.report.counts.frusta);
    Ok(Picture { pixels: frame.pixels, seconds, samples, bound: Some(frame.error) })
}
