//! Marches rays by equal steps, for all sampling methods.
//!
//! Step i reaches from `start + i h` to `start + (i + 1) h`, where the ray enters the shell at `start`; the last one is
//! cut where the shell ends, at its surface or at the core. Beyond a hollow core the count begins anew. Each point is
//! looked up in its frustum: the traversal's frusta follow in order.

use super::transfer::Transfer;
use crate::job::PreparedJob;
use crate::ray::Ray;
use crate::shading::{self, RayLighting, direction_of, over};
use glam::{DVec3, Vec3};
use icoray::{Frustum, Renderer, Stretch};
use std::collections::VecDeque;
use std::ops::ControlFlow;
use std::time::Instant;

/// Transmittance at which rays end, as in the renderer in f32.
const MIN_TRANSMITTANCE: f32 = 1e-6;

/// Frusta farther apart than this along the ray do not join, planet radii.
const GAP: f64 = 1e-9;

/// A picture and its cost.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Premultiplied linear RGBA over the background, rows from the top.
    pub pixels: Vec<[f32; 4]>,
    /// Seconds in the rays, without set-up.
    pub seconds: f64,
    /// Samples taken; frusta passed for the renderer's own methods.
    pub samples: u64,
    /// For the renderer's own methods, the reported error of each pixel.
    pub bound: Option<Vec<f32>>,
}

/// A way to give a value to points of a frustum.
pub(crate) trait Interpolant: Sync {
    /// Data that are made once per frustum with points in it.
    type Cell;
    /// Reads a frustum's values; `None` when one is missing.
    fn cell(&self, transfer: &Transfer, frustum: &Frustum) -> Option<Self::Cell>;
    /// The normalised value at the distance `t` from the eye.
    fn value(&self, cell: &Self::Cell, frustum: &Frustum, t: f64) -> f32;
    /// The gradient there, of any length; for lit scenes.
    fn gradient(&self, _cell: &Self::Cell, _frustum: &Frustum, _t: f64) -> Vec3 {
        Vec3::ZERO
    }
}

/// Coordinates in the frustum's three directions of the ray's point at distance `t` from the eye.
#[inline]
pub(crate) fn along(frustum: &Frustum, t: f64) -> [f64; 3] {
    let length = frustum.t[1] - frustum.t[0];
    let u = if length > 0.0 { ((t - frustum.t[0]) / length).clamp(0.0, 1.0) } else { 0.0 };
    let [from, to] = &frustum.alpha;
    [0, 1, 2].map(|k| from[k] + u * (to[k] - from[k]))
}

/// Accumulated colour and transmittance of a ray.
pub(crate) struct Accumulated {
    pub color: Vec3,
    pub transmittance: f32,
    pub samples: u64,
}

impl Accumulated {
    /// Composites a step's premultiplied colour and opacity behind the accumulated ones.
    #[inline]
    pub fn add(&mut self, color: Vec3, alpha: f32) {
        self.color += self.transmittance * color;
        self.transmittance *= 1.0 - alpha;
    }
}

/// The frusta of the current step, with values that are read on demand.
pub(crate) struct FrustumWindow<'w, I: Interpolant> {
    interpolant: &'w I,
    transfer: &'w Transfer,
    frusta: VecDeque<Passed<I::Cell>>,
}

/// A frustum on the ray, and its values once they are read; `None` within where one is missing.
struct Passed<C> {
    frustum: Frustum,
    cell: Option<Option<C>>,
}

impl<I: Interpolant> FrustumWindow<'_, I> {
    /// The frustum and cell at `t`, which rises from call to call; `None` in a void.
    #[inline]
    pub fn at(&mut self, t: f64) -> Option<(&Frustum, &I::Cell)> {
        while self.frusta.len() > 1 && self.frusta[0].frustum.t[1] < t {
            self.frusta.pop_front();
        }
        let Passed { frustum, cell } = self.frusta.front_mut()?;
        let cell = cell.get_or_insert_with(|| self.interpolant.cell(self.transfer, frustum));
        Some((frustum, cell.as_ref()?))
    }

    /// The value at `t`.
    #[inline]
    pub fn value(&mut self, t: f64) -> Option<f32> {
        let interpolant = self.interpolant;
        self.at(t).map(|(frustum, cell)| interpolant.value(cell, frustum, t))
    }
}

/// Integration of a step.
pub(crate) trait StepRule<I: Interpolant>: Sync {
    /// State from step to step.
    type State: Default;
    /// The ray enters the shell at `t`.
    fn enter(&self, _memory: &mut Self::State, _window: &mut FrustumWindow<'_, I>, _t: f64) {}
    /// Adds the light of the ray between two distances.
    fn step(
        &self,
        state: &mut Self::State,
        window: &mut FrustumWindow<'_, I>,
        range: [f64; 2],
        lighting: Option<&RayLighting>,
        radiance: &mut Accumulated,
    );
}

/// The midpoint rule: a sample in the middle of each step.
struct Midpoint<'t>(&'t Transfer);

impl<I: Interpolant> StepRule<I> for Midpoint<'_> {
    type State = ();

    #[inline]
    fn step(
        &self,
        (): &mut (),
        window: &mut FrustumWindow<'_, I>,
        [from, to]: [f64; 2],
        lighting: Option<&RayLighting>,
        radiance: &mut Accumulated,
    ) {
        radiance.samples += 1;
        let middle = 0.5 * (from + to);
        let interpolant = window.interpolant;
        let Some((frustum, cell)) = window.at(middle) else { return };
        let (mut color, extinction) = self.0.at(interpolant.value(cell, frustum, middle));
        if extinction <= 0.0 {
            return;
        }
        if let Some(lighting) = lighting {
            let gradient = interpolant.gradient(cell, frustum, middle);
            let shade = lighting.shade(direction_of(gradient.as_dvec3()));
            color = color * shade.body as f32 + shade.highlight as f32;
        }
        let alpha = -(-extinction * (to - from) as f32).exp_m1();
        radiance.add(color * alpha, alpha);
    }
}

/// Renders with a sample in the middle of each step of the given length.
pub(crate) fn midpoints<I: Interpolant>(
    prepared: &PreparedJob,
    renderer: &Renderer,
    step: f64,
    interpolant: &I,
) -> Picture {
    let transfer = Transfer::new(prepared.scene, prepared.thickness());
    render(prepared, renderer, step, interpolant, &transfer, &Midpoint(&transfer))
}

/// Renders by steps of the given length.
pub(crate) fn render<I: Interpolant, R: StepRule<I>>(
    prepared: &PreparedJob,
    renderer: &Renderer,
    step: f64,
    interpolant: &I,
    transfer: &Transfer,
    rule: &R,
) -> Picture {
    assert!(step > 0.0, "a step of {step}: expected a positive length");
    let start = Instant::now();
    let pixels = prepared.pixels(renderer, |ray, hint| {
        let window = FrustumWindow { interpolant, transfer, frusta: VecDeque::new() };
        let lighting = RayLighting::new(prepared.scene, ray.dir);
        let radiance = Accumulated { color: Vec3::ZERO, transmittance: 1.0, samples: 0 };
        let (state, run) = (R::State::default(), None);
        let mut march = RayMarch { rule, state, window, lighting, radiance, step, run, done: 0 };
        prepared.traversal.ray(ray.eye, ray.dir, hint, |stretch| march.meet(prepared, ray, stretch));
        march.finish();
        let radiance = march.radiance;
        let [r, g, b] = radiance.color.to_array().map(f64::from);
        let pixel = over(prepared.scene.background, [r, g, b, 1.0 - f64::from(radiance.transmittance)]);
        (pixel.map(|c| c as f32), radiance.samples)
    });
    let seconds = start.elapsed().as_secs_f64();
    let samples = pixels.iter().map(|p| p.1).sum();
    Picture { pixels: pixels.into_iter().map(|p| p.0).collect(), seconds, samples, bound: None }
}

struct RayMarch<'m, I: Interpolant, R: StepRule<I>> {
    rule: &'m R,
    state: R::State,
    window: FrustumWindow<'m, I>,
    lighting: Option<RayLighting>,
    radiance: Accumulated,
    step: f64,
    /// Where the ray entered the shell, and up to where its frusta are known.
    run: Option<[f64; 2]>,
    /// Whole steps taken since.
    done: u64,
}

impl<I: Interpolant, R: StepRule<I>> RayMarch<'_, I, R> {
    fn meet(&mut self, prepared: &PreparedJob, ray: &Ray, stretch: &Stretch) -> ControlFlow<()> {
        match stretch {
            Stretch::Frustum(frustum) => self.frustum(frustum),
            Stretch::Core { t } => {
                self.finish();
                if let Some(core) = prepared.scene.core {
                    let normal = ray.at(*t).normalize();
                    let color = shading::ground(prepared.scene, DVec3::from_array(core), normal, ray.dir);
                    self.radiance.add(color.as_vec3(), 1.0);
                }
            }
        }
        if self.radiance.transmittance > MIN_TRANSMITTANCE { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    }

    fn frustum(&mut self, frustum: &Frustum) {
        if self.run.is_some_and(|run| frustum.t[0] > run[1] + GAP) {
            self.finish();
        }
        self.window.frusta.push_back(Passed { frustum: *frustum, cell: None });
        let start = match &mut self.run {
            Some(run) => {
                run[1] = frustum.t[1];
                run[0]
            }
            none => {
                *none = Some(frustum.t);
                self.rule.enter(&mut self.state, &mut self.window, frustum.t[0]);
                frustum.t[0]
            }
        };
        loop {
            let range = [0, 1].map(|i| start + (self.done + i) as f64 * self.step);
            if range[1] > frustum.t[1] || self.radiance.transmittance <= MIN_TRANSMITTANCE {
                return;
            }
            self.advance(range);
            self.done += 1;
        }
    }

    fn advance(&mut self, range: [f64; 2]) {
        self.rule.step(&mut self.state, &mut self.window, range, self.lighting.as_ref(), &mut self.radiance);
    }

    /// Integrates the rest of the last step, where the shell ends.
    fn finish(&mut self) {
        if let Some([start, end]) = self.run.take() {
            let from = start + self.done as f64 * self.step;
            if from < end && self.radiance.transmittance > MIN_TRANSMITTANCE {
                self.advance([from, end]);
            }
        }
        self.window.frusta.clear();
        self.done = 0;
    }
}
