//! The ways to render a geodesic grid that the paper compares with, all on the same rays and the same walk.
//!
//! Geometry is in f64, values, samples and compositing in f32, as in the renderer. Nothing of this is shipped.

mod march;
mod mean_value;
mod nearest;
mod preintegrated;
#[cfg(test)]
mod tests;
mod tetrahedra;
mod transfer;
mod wedge;

use crate::setting::Setting;
use icoray::{Field, Grid, Layers, Renderer, Result, Scene};
use march::midpoints;
use mean_value::MeanValue;
use nearest::Nearest;
use preintegrated::Table;
use tetrahedra::Tetrahedra;
use transfer::Transfer;
use wedge::Wedge;

/// A scene over a grid and field, ready for any method.
#[derive(Debug, Clone, Copy)]
pub struct Job<'a> {
    /// What to draw.
    pub scene: &'a Scene,
    /// The mesh.
    pub grid: &'a Grid<'a>,
    /// The layers' radii.
    pub layers: &'a Layers,
    /// The values.
    pub field: &'a Field<'a>,
}

/// A way to render. Steps are in planet radii, along the ray from where it enters the shell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Method {
    /// The renderer's `exact`, to the given tolerance.
    Exact {
        /// Largest error allowed in a channel, see [`Scene::tolerance`].
        tolerance: f64,
    },
    /// The renderer's `paper`: piecewise linear between extrema and knots (§3.4).
    Paper,
    /// Samples at equal distances of the wedge interpolant (§3.3), opacity `1 - exp(-κh)`: §3.4's conventional way, the
    /// midpoint rule, of second order where the transfer function has no kinks. The only one here that knows light.
    Uniform {
        /// Distance of samples, planet radii.
        step: f64,
    },
    /// Each frustum as three tetrahedra, linear in each, sampled as [`Method::Uniform`] (Weiler et al. 2003; §4.2). Its
    /// limit for small steps is another picture than the wedge's.
    Tetrahedra {
        /// Distance of samples, planet radii.
        step: f64,
    },
    /// Mean value coordinates over each frustum's eight triangles (Ju, Schaefer and Warren 2005; §4.2), sampled as
    /// [`Method::Uniform`]. Its limit for small steps is another picture than the wedge's.
    MeanValue {
        /// Distance of samples, planet radii.
        step: f64,
    },
    /// The value of the nearest cell centre on the nearest layer (§3.3's piecewise-constant sampling), sampled as
    /// [`Method::Uniform`]: first order in the mesh.
    Constant {
        /// Distance of samples, planet radii.
        step: f64,
    },
    /// Steps of the wedge interpolant through a pre-integrated table (Röttger et al. 2000, Engel et al. 2001): second
    /// order in the step with attenuation inside a step, first order without.
    PreIntegrated {
        /// Length of a step, planet radii.
        step: f64,
        /// Values along each side of the table, at least 4.
        table: usize,
        /// Whether a step absorbs its own light.
        attenuated: bool,
    },
}

/// A picture and what it cost.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Premultiplied linear RGBA over the background, rows from the top.
    pub pixels: Vec<[f32; 4]>,
    /// Seconds in the rays, without set-up.
    pub seconds: f64,
    /// Samples taken; frusta passed for the renderer's own methods.
    pub samples: u64,
    /// For the renderer's own methods, how far it says each pixel may be from the exact integral.
    pub bound: Option<Vec<f32>>,
}

impl Method {
    /// Name and step in a few words, without blanks.
    pub fn name(&self) -> String {
        match self {
            Method::Exact { tolerance } => format!("exact-{tolerance:e}"),
            Method::Paper => "paper".into(),
            Method::Uniform { step } => format!("uniform-{step:e}"),
            Method::Tetrahedra { step } => format!("tetrahedra-{step:e}"),
            Method::MeanValue { step } => format!("mean-value-{step:e}"),
            Method::Constant { step } => format!("constant-{step:e}"),
            Method::PreIntegrated { step, table, attenuated } => {
                let kind = if *attenuated { "" } else { "-unattenuated" };
                format!("pre-integrated{kind}-{table}-{step:e}")
            }
        }
    }

    /// Renders on the renderer's threads. Of the methods that sample, only [`Method::Uniform`] heeds the scene's light.
    ///
    /// # Errors
    /// As [`icoray::Plan::new`].
    ///
    /// # Panics
    /// When a step is not positive or a table has fewer than 4 values.
    pub fn render(&self, job: &Job, renderer: &Renderer) -> Result<Picture> {
        match *self {
            Method::Exact { tolerance } => shipped(job, renderer, icoray::Method::Exact, tolerance),
            Method::Paper => shipped(job, renderer, icoray::Method::Paper, job.scene.tolerance),
            _ => self.sampled(job, renderer),
        }
    }

    fn sampled(&self, job: &Job, renderer: &Renderer) -> Result<Picture> {
        let unlit = Scene { lighting: None, ..job.scene.clone() };
        let is_uniform = matches!(self, Method::Uniform { .. });
        let setting = Setting::new(&Job { scene: if is_uniform { job.scene } else { &unlit }, ..*job })?;
        Ok(match *self {
            Method::Tetrahedra { step } => midpoints(&setting, renderer, step, &Tetrahedra(&setting)),
            Method::MeanValue { step } => midpoints(&setting, renderer, step, &MeanValue(&setting)),
            Method::Constant { step } => midpoints(&setting, renderer, step, &Nearest(&setting)),
            Method::PreIntegrated { step, table, attenuated } => {
                let transfer = Transfer::new(setting.scene, setting.thickness());
                let table = renderer.run(|| Table::new(&setting, step, table, attenuated));
                march::render(&setting, renderer, step, &Wedge::new(&setting), &transfer, &table)
            }
            Method::Uniform { step } => {
                let wedge = renderer.run(|| Wedge::new(&setting));
                midpoints(&setting, renderer, step, &wedge)
            }
            Method::Exact { .. } | Method::Paper => unreachable!("the renderer's own"),
        })
    }
}

/// A picture by the renderer itself.
fn shipped(job: &Job, renderer: &Renderer, method: icoray::Method, tolerance: f64) -> Result<Picture> {
    let scene = Scene { method, tolerance, ..job.scene.clone() };
    let frame = renderer.render(&scene, job.grid, job.layers, job.field)?;
    let (seconds, samples) = (frame.report.render_s, frame.report.counts.frusta);
    Ok(Picture { pixels: frame.pixels, seconds, samples, bound: Some(frame.error) })
}
