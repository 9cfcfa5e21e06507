//! Renders to ten digits: the renderer's integral and interpolant, in f64, by other numerical methods.
//!
//! [`icoray::Traversal`] gives the frusta along a ray. Each is cut at the extremum of the value and at knots of the
//! transfer function; the smooth pieces are integrated by panels of order 16. Values are taken
//! relative to a vertex of the frustum, so that errors are measured by the field's variation in a frustum, not by its
//! size.

mod blend;
mod gauss;
mod gradients;
mod interpolant;
mod panel;
mod spans;
#[cfg(test)]
mod tests;
mod way;
mod whole;

use blend::{Blend, Course, Part};
pub(crate) use gauss::Gauss;
pub(crate) use gradients::gradients;
pub(crate) use interpolant::{FrustumGeometry, FrustumInterpolant};
pub(crate) use panel::{MIN_TRANSMITTANCE, Piece, Radiance};
pub(crate) use spans::{Span, Spans};
pub(crate) use whole::{Data, WholeScene};

use crate::job::{Job, PreparedJob};
use crate::shading::{self, RayLighting};
use glam::DVec3;
use icoray::{Frustum, Renderer, Result, Stretch};
use std::ops::ControlFlow;

/// Optical depth of a panel.
const PANEL: f64 = 0.25;

/// A scene over a grid and a field, to be evaluated.
///
/// Unlit pixels are right to 1e-10 whatever the transfer function, lit ones to 1e-8, as far as f64 defines the picture:
/// a step met by a value that is constant along the ray to rounding, or a value that turns inside a spike a millionth
/// wide, magnifies the rounding of the ray's points.
#[derive(Debug)]
pub struct Oracle<'a> {
    prepared: PreparedJob<'a>,
    spans: Spans,
    gauss: Gauss,
    gradients: Vec<DVec3>,
    panel: f64,
}

impl<'a> Oracle<'a> {
    /// Prepares the job: the transfer function, corner fields averaged, vertex gradients when it is lit.
    ///
    /// # Errors
    /// As [`icoray::Plan::new`].
    pub fn new(job: &Job<'a>) -> Result<Self> {
        Self::with_panel(job, PANEL)
    }

    /// With panels of another optical depth.
    pub(crate) fn with_panel(job: &Job<'a>, panel: f64) -> Result<Self> {
        let prepared = PreparedJob::new(job)?;
        let lit = job.scene.lighting.is_some();
        Ok(Oracle {
            spans: Spans::new(&job.scene.volumes[0].transfer, prepared.thickness()),
            gauss: Gauss::new(),
            gradients: if lit { gradients(&prepared) } else { Vec::new() },
            prepared,
            panel,
        })
    }

    /// All pixels, row by row from the top: premultiplied linear RGBA over the background.
    pub fn picture(&self, renderer: &Renderer) -> Vec<[f64; 4]> {
        self.prepared.pixels(renderer, |x, y, hint| {
            let (eye, dir) = self.prepared.ray(x, y);
            over(self.prepared.scene.background, self.ray(eye, dir, hint))
        })
    }

    /// Radiance along the ray from `eye` in the unit direction `dir`, lengths in planet radii: premultiplied linear RGB
    /// and opacity, without the background. `hint` as in [`icoray::Traversal::ray`].
    pub fn ray(&self, eye: DVec3, dir: DVec3, hint: &mut u32) -> [f64; 4] {
        let mut radiance = Radiance { color: DVec3::ZERO, transmittance: 1.0 };
        let lighting = RayLighting::new(self.prepared.scene, dir);
        self.prepared.traversal.ray(eye, dir, hint, |stretch| {
            match stretch {
                Stretch::Frustum(frustum) => self.frustum(frustum, lighting.as_ref(), &mut radiance),
                Stretch::Core { t } => core(self.prepared.scene, eye + *t * dir, dir, &mut radiance),
            }
            if radiance.transmittance > MIN_TRANSMITTANCE { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        });
        let [r, g, b] = radiance.color.to_array();
        [r, g, b, 1.0 - radiance.transmittance]
    }

    fn frustum(&self, frustum: &Frustum, lighting: Option<&RayLighting>, radiance: &mut Radiance) {
        let Some([low, high]) = self.prepared.vertices(frustum) else { return };
        let geometry = FrustumGeometry::new(frustum, &self.prepared.radius);
        let base = low[0];
        let interpolant = geometry.interpolant(&low, &high, base);
        let along = RayInFrustum { oracle: self, frustum, geometry: &geometry, interpolant, base, lighting };
        match interpolant.extremum() {
            None => along.monotone([0.0, 1.0], interpolant.f, radiance),
            Some(u) => {
                let turn = interpolant.at(u);
                along.monotone([0.0, u], [interpolant.f[0], turn], radiance);
                along.monotone([u, 1.0], [turn, interpolant.f[1]], radiance);
            }
        }
    }
}

/// Adds the opaque core, if there is one.
fn core(scene: &icoray::Scene, at: DVec3, dir: DVec3, radiance: &mut Radiance) {
    if let Some(color) = scene.core {
        radiance.color +=
            radiance.transmittance * shading::ground(scene, DVec3::from_array(color), at.normalize(), dir);
        radiance.transmittance = 0.0;
    }
}

/// Composites over the background, if there is one.
pub(crate) fn over(background: Option<[f64; 3]>, [r, g, b, a]: [f64; 4]) -> [f64; 4] {
    match background {
        None => [r, g, b, a],
        Some(back) => {
            let transmittance = 1.0 - a;
            [r + transmittance * back[0], g + transmittance * back[1], b + transmittance * back[2], 1.0]
        }
    }
}

/// A ray inside one frustum.
struct RayInFrustum<'o, 'a> {
    oracle: &'o Oracle<'a>,
    frustum: &'o Frustum,
    geometry: &'o FrustumGeometry,
    interpolant: FrustumInterpolant,
    base: f64,
    lighting: Option<&'o RayLighting>,
}

impl RayInFrustum<'_, '_> {
    /// Cuts a monotone part (`range` of the frustum, with values `f` at its ends) at knots.
    fn monotone(&self, range: [f64; 2], f: [f64; 2], radiance: &mut Radiance) {
        let mut at = (range[0], f[0]);
        self.oracle.spans.cut(self.base, f, |span, value, is_last| {
            let u = if is_last { range[1] } else { self.interpolant.meets(value, at.0, range[1]) };
            if u > at.0 && !span.is_clear {
                self.piece([at.0, u], [at.1, value], span, radiance);
            }
            at = (u, value);
            radiance.transmittance > MIN_TRANSMITTANCE
        });
    }

    fn piece(&self, range: [f64; 2], f: [f64; 2], span: &Span, radiance: &mut Radiance) {
        let (gauss, limit) = (&self.oracle.gauss, self.oracle.panel);
        let length = self.frustum.t[1] - self.frustum.t[0];
        if self.lighting.is_none() {
            let length = length * (range[1] - range[0]);
            let piece = Piece { interpolant: self.interpolant.part(range, f), base: self.base, span, length };
            piece.plain(gauss, limit, radiance);
            return;
        }
        let course = Course { base: self.base, f: self.interpolant };
        let part = Part { color: (course, span), extinction: (course, span), normal: Some(self.normal()) };
        let (lighting, eps) = (self.lighting, self.interpolant.eps);
        Blend { gauss, parts: vec![part], length, eps, lighting, limit }.add(range, radiance);
    }

    /// The gradient's three components along the frustum.
    fn normal(&self) -> [FrustumInterpolant; 3] {
        let layers = self.oracle.prepared.radius.len();
        let at = |k: usize, layer: usize| self.oracle.gradients[self.frustum.cells[k] as usize * layers + layer];
        let on = |layer| [at(0, layer), at(1, layer), at(2, layer)];
        let (low, high) = (on(self.frustum.layer), on(self.frustum.layer + 1));
        [0, 1, 2].map(|i| self.geometry.interpolant(&low.map(|g| g[i]), &high.map(|g| g[i]), 0.0))
    }
}

/// Unit vector of a gradient of any size; zero for none.
pub(crate) fn direction_of(gradient: DVec3) -> DVec3 {
    let largest = gradient.abs().max_element();
    if largest > 0.0 && largest.is_finite() { (gradient / largest).normalize() } else { DVec3::ZERO }
}

/// The component along `v` of a vector whose components run along the same stretch.
fn component(of: &[FrustumInterpolant; 3], v: DVec3) -> FrustumInterpolant {
    let dot = |get: &dyn Fn(&FrustumInterpolant) -> f64| v.dot(DVec3::new(get(&of[0]), get(&of[1]), get(&of[2])));
    FrustumInterpolant { f: [dot(&|c| c.f[0]), dot(&|c| c.f[1])], bend: dot(&|c| c.bend), eps: of[0].eps }
}

/// Where a course is zero, at most twice.
fn zeros(interpolant: &FrustumInterpolant) -> [Option<f64>; 2] {
    let turn = interpolant.extremum();
    let parts = match turn {
        None => [Some([0.0, 1.0]), None],
        Some(u) => [Some([0.0, u]), Some([u, 1.0])],
    };
    parts.map(|part| {
        let [a, b] = part?;
        (interpolant.at(a) * interpolant.at(b) < 0.0).then(|| interpolant.meets(0.0, a, b))
    })
}
