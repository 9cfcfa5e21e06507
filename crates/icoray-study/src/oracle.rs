//! The picture to ten digits: the same integral with the same interpolant as the renderer's, in f64 and by other means.
//!
//! The way through the mesh is [`icoray::Traversal`]'s. Each frustum is cut where the value turns and where it meets a
//! knot of the transfer function; in between all is smooth and integrated by panels of order 16. Values are taken
//! relative to a vertex of the frustum, so that errors are measured by the field's variation in a frustum, not by its size.

mod course;
mod gauss;
mod gradients;
mod panel;
mod spans;
#[cfg(test)]
mod tests;

pub(crate) use course::{Course, Ends};
pub(crate) use gauss::Gauss;
pub(crate) use gradients::gradients;
pub(crate) use panel::{DARK, Light, Piece};
pub(crate) use spans::{Span, Spans};

use crate::look::{self, RayLight};
use crate::methods::Job;
use crate::setting::Setting;
use glam::DVec3;
use icoray::{Frustum, Renderer, Result, Stretch};
use std::ops::ControlFlow;

/// Optical depth of a panel.
const PANEL: f64 = 0.25;

/// A scene over a grid and a field, ready to be evaluated.
///
/// Unlit pixels are right to 1e-10 whatever the transfer function, lit ones to 1e-8, as far as f64 defines the picture: a
/// step met by a value that is constant along the ray to rounding, or a value that turns inside a spike a millionth wide,
/// magnifies the rounding of the ray's points.
#[derive(Debug)]
pub struct Oracle<'a> {
    setting: Setting<'a>,
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
        let setting = Setting::new(job)?;
        let lit = job.scene.lighting.is_some();
        Ok(Oracle {
            spans: Spans::new(job.scene, setting.thickness()),
            gauss: Gauss::new(),
            gradients: if lit { gradients(&setting) } else { Vec::new() },
            setting,
            panel,
        })
    }

    /// Pixel in column `x` and row `y`, counted from the upper left: premultiplied linear RGBA over the background.
    pub fn pixel(&self, x: u32, y: u32) -> [f64; 4] {
        self.hinted(x, y, &mut 0)
    }

    /// All pixels, row by row from the top.
    pub fn picture(&self, renderer: &Renderer) -> Vec<[f64; 4]> {
        self.setting.pixels(renderer, |x, y, hint| self.hinted(x, y, hint))
    }

    fn hinted(&self, x: u32, y: u32, hint: &mut u32) -> [f64; 4] {
        let (eye, dir) = self.setting.ray(x, y);
        over(self.setting.scene.background, self.ray(eye, dir, hint))
    }

    /// Light along the ray from `eye` in the unit direction `dir`, lengths in planet radii: premultiplied linear RGB and
    /// opacity, without the background. `hint` as in [`icoray::Traversal::ray`].
    pub fn ray(&self, eye: DVec3, dir: DVec3, hint: &mut u32) -> [f64; 4] {
        let mut light = Light { color: DVec3::ZERO, through: 1.0 };
        let lamp = RayLight::new(self.setting.scene, dir);
        self.setting.traversal.ray(eye, dir, hint, |stretch| {
            match stretch {
                Stretch::Frustum(frustum) => self.frustum(frustum, lamp.as_ref(), &mut light),
                Stretch::Core { t } => core(self.setting.scene, eye + *t * dir, dir, &mut light),
            }
            if light.through > DARK { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        });
        let [r, g, b] = light.color.to_array();
        [r, g, b, 1.0 - light.through]
    }

    fn frustum(&self, frustum: &Frustum, lamp: Option<&RayLight>, light: &mut Light) {
        let Some([low, high]) = self.setting.vertices(frustum) else { return };
        let ends = Ends::new(frustum, &self.setting.radius);
        let base = low[0];
        let course = ends.course(&low, &high, base);
        let along = Along { oracle: self, frustum, ends: &ends, course, base, lamp };
        match course.extremum() {
            None => along.monotone([0.0, 1.0], course.f, light),
            Some(u) => {
                let turn = course.at(u);
                along.monotone([0.0, u], [course.f[0], turn], light);
                along.monotone([u, 1.0], [turn, course.f[1]], light);
            }
        }
    }
}

/// The opaque core, if there is one, ends the light.
fn core(scene: &icoray::Scene, at: DVec3, dir: DVec3, light: &mut Light) {
    if let Some(color) = scene.core {
        light.color += light.through * look::ground(scene, DVec3::from_array(color), at.normalize(), dir);
        light.through = 0.0;
    }
}

/// Light over the background, if there is one.
pub(crate) fn over(background: Option<[f64; 3]>, [r, g, b, a]: [f64; 4]) -> [f64; 4] {
    match background {
        None => [r, g, b, a],
        Some(back) => {
            let through = 1.0 - a;
            [r + through * back[0], g + through * back[1], b + through * back[2], 1.0]
        }
    }
}

/// A ray inside one frustum.
struct Along<'o, 'a> {
    oracle: &'o Oracle<'a>,
    frustum: &'o Frustum,
    ends: &'o Ends,
    course: Course,
    base: f64,
    lamp: Option<&'o RayLight>,
}

impl Along<'_, '_> {
    /// Cuts a monotone part, `range` of the frustum with the values `f` at its ends, at the knots that it meets. The span
    /// is carried from piece to piece: no value is looked up on a knot.
    fn monotone(&self, range: [f64; 2], f: [f64; 2], light: &mut Light) {
        let spans = &self.oracle.spans;
        let falls = f[1] < f[0];
        let mut k = spans.find(self.base, f[0], falls);
        let mut at = (range[0], f[0]);
        loop {
            let span = &spans.spans[k];
            let knot = if falls { span.low } else { span.high } - self.base;
            let is_last = if falls { f[1] >= knot } else { f[1] <= knot };
            let next =
                if is_last { (range[1], f[1]) } else { (self.course.meets(knot, at.0, range[1]), knot) };
            if next.0 > at.0 && !span.is_clear {
                self.piece([at.0, next.0], [at.1, next.1], span, light);
            }
            if is_last || light.through <= DARK {
                return;
            }
            at = next;
            k = if falls { k - 1 } else { k + 1 };
        }
    }

    fn piece(&self, range: [f64; 2], f: [f64; 2], span: &Span, light: &mut Light) {
        let (gauss, limit) = (&self.oracle.gauss, self.oracle.panel);
        let length = self.frustum.t[1] - self.frustum.t[0];
        let piece = |range: [f64; 2], f: [f64; 2]| Piece {
            course: self.course.part(range, f),
            base: self.base,
            span,
            length: length * (range[1] - range[0]),
        };
        let Some(lamp) = self.lamp else {
            piece(range, f).plain(gauss, limit, light);
            return;
        };
        let normal = self.normal();
        let kinks = [lamp.towards, lamp.halfway].map(|v| zeros(&component(&normal, v)));
        let mut cuts: Vec<f64> = kinks.into_iter().flatten().flatten().collect();
        cuts.retain(|u| range[0] < *u && *u < range[1]);
        cuts.push(range[1]);
        cuts.sort_by(f64::total_cmp);
        let mut at = (range[0], f[0]);
        for u in cuts {
            let next = (u, if u == range[1] { f[1] } else { self.course.at(u) });
            let shade = |s: f64| {
                let u = at.0 + s * (next.0 - at.0);
                let gradient = DVec3::new(normal[0].at(u), normal[1].at(u), normal[2].at(u));
                lamp.shade(direction_of(gradient))
            };
            if next.0 > at.0 {
                piece([at.0, next.0], [at.1, next.1]).lit(gauss, limit, light, &shade);
            }
            at = next;
        }
    }

    /// The gradient's three components along the frustum.
    fn normal(&self) -> [Course; 3] {
        let layers = self.oracle.setting.radius.len();
        let at =
            |k: usize, layer: usize| self.oracle.gradients[self.frustum.cells[k] as usize * layers + layer];
        let on = |layer| [at(0, layer), at(1, layer), at(2, layer)];
        let (low, high) = (on(self.frustum.layer), on(self.frustum.layer + 1));
        [0, 1, 2].map(|i| self.ends.course(&low.map(|g| g[i]), &high.map(|g| g[i]), 0.0))
    }
}

/// Unit vector of a gradient of any size; zero for none.
pub(crate) fn direction_of(gradient: DVec3) -> DVec3 {
    let largest = gradient.abs().max_element();
    if largest > 0.0 && largest.is_finite() { (gradient / largest).normalize() } else { DVec3::ZERO }
}

/// The component along `v` of a vector whose components run along the same stretch.
fn component(of: &[Course; 3], v: DVec3) -> Course {
    let dot = |get: &dyn Fn(&Course) -> f64| v.dot(DVec3::new(get(&of[0]), get(&of[1]), get(&of[2])));
    Course { f: [dot(&|c| c.f[0]), dot(&|c| c.f[1])], bend: dot(&|c| c.bend), eps: of[0].eps }
}

/// Where a course is zero, at most twice.
fn zeros(course: &Course) -> [Option<f64>; 2] {
    let turn = course.extremum();
    let parts = match turn {
        None => [Some([0.0, 1.0]), None],
        Some(u) => [Some([0.0, u]), Some([u, 1.0])],
    };
    parts.map(|part| {
        let [a, b] = part?;
        (course.at(a) * course.at(b) < 0.0).then(|| course.meets(0.0, a, b))
    })
}
