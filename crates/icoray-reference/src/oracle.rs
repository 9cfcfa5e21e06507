//! Scenes to ten digits: volumes, isosurfaces, surfaces, cuts and layers of any heights, in f64 and by other numerical
//! methods than the renderer's.
//!
//! A ray's columns and layers are found in double-double, over all triangles of a small mesh; [`picture`] takes the
//! columns of [`icoray::Traversal`] instead, which any mesh affords. Each frustum is cut at the extremum of every
//! field, at knots, bounds of cuts and surfaces; the smooth pieces between are integrated by panels of order 16. Values
//! are taken relative to a vertex of the frustum, so that errors are measured by the field's variation in a frustum,
//! not by its size.

mod blend;
mod gauss;
mod gradients;
mod interpolant;
mod prepared;
mod spans;
#[cfg(test)]
mod tests;
mod tracer;

pub(crate) use blend::{Blend, FieldInSpan, Radiance, VolumePiece};
pub(crate) use gauss::Gauss;
pub(crate) use gradients::GradientInput;
pub(crate) use interpolant::FrustumInterpolant;
pub use prepared::{Data, NamedField, Oracle};
pub(crate) use spans::{Span, Spans};

use crate::columns::columns;
use crate::job::{Job, PreparedJob};
use crate::ray::Ray;
use icoray::{Renderer, Result, Stretch};
use std::ops::ControlFlow;
use tracer::Tracer;

/// Optical depth of a panel.
pub const PANEL: f64 = 0.25;

/// All pixels of a job, row by row from the top: premultiplied linear RGBA over the background. The renderer's
/// traversal finds the frusta; the core is round, and volumes alone are shown.
///
/// Unlit pixels are right to 1e-10 for any transfer function, lit ones to 1e-8, as far as f64 defines the picture: a
/// step met by a value that is constant along the ray to rounding, or a value that turns inside a spike a millionth
/// wide, magnifies the rounding of the ray's points.
///
/// # Errors
/// As [`icoray::Plan::new`].
pub fn picture(job: &Job, renderer: &Renderer) -> Result<Vec<[f64; 4]>> {
    with(job, |oracle, prepared| prepared.pixels(renderer, |ray, hint| oracle.walked(prepared, ray, hint)))
}

/// The same as [`picture`] by intersection with all triangles, in place of the traversal; NaN where the mesh has a gap.
///
/// # Errors
/// As [`icoray::Plan::new`].
pub fn brute_force(job: &Job, renderer: &Renderer) -> Result<Vec<[f64; 4]>> {
    with(job, |oracle, prepared| prepared.pixels(renderer, |ray, _| oracle.pixel(ray).unwrap_or([f64::NAN; 4])))
}

/// Prepares a job for `work`.
pub(crate) fn with<R>(job: &Job, work: impl FnOnce(&Oracle, &PreparedJob) -> R) -> Result<R> {
    let prepared = PreparedJob::new(job)?;
    let layers = job.layers.for_field(prepared.radius.len())?;
    let fields = [NamedField { name: &job.scene.volumes[0].field, values: prepared.values() }];
    let data = Data { grid: job.grid, layers: &layers, heights: &[], fields: &fields };
    Ok(work(&Oracle::new(job.scene, data, PANEL)?, &prepared))
}

impl Oracle<'_> {
    /// Premultiplied linear RGBA along a ray, over the background; `None` where the mesh has a gap.
    pub fn pixel(&self, ray: &Ray) -> Option<[f64; 4]> {
        let mut tracer = Tracer::new(self, *ray);
        let inner = self.scene.core.map(|_| self.range[0]);
        for column in columns(self.data.grid, ray, self.range[1], inner).ok()? {
            tracer.column(&column);
            if tracer.ends() {
                break;
            }
        }
        Some(tracer.pixel())
    }

    /// The same along the traversal, below which the core is round.
    fn walked(&self, prepared: &PreparedJob, ray: &Ray, hint: &mut u32) -> [f64; 4] {
        let mut tracer = Tracer::new(self, *ray);
        prepared.traversal.ray(ray.eye, ray.dir, hint, |stretch| {
            match stretch {
                Stretch::Frustum(frustum) => tracer.stretch(frustum),
                Stretch::Core { t } => tracer.core(ray.at(*t).normalize()),
            }
            if tracer.ends() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        tracer.pixel()
    }
}
