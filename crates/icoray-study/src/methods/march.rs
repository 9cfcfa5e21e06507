//! Equal steps along a ray: the driver of all methods that sample.
//!
//! Step i reaches from `start + i h` to `start + (i + 1) h`, where the ray enters the shell at `start`; the last one is
//! cut where the shell ends, at its surface or at the core. Beyond a hollow core the count begins anew. Each point is
//! looked up in the frustum that holds it, which is found by going on through the traversal's frusta in order.

use super::Picture;
use super::transfer::Transfer;
use crate::look::{self, RayLight};
use crate::oracle::{direction_of, over};
use crate::setting::Setting;
use glam::{DVec3, Vec3};
use icoray::{Frustum, Renderer, Stretch};
use std::collections::VecDeque;
use std::ops::ControlFlow;
use std::time::Instant;

/// Rays end where less than this comes through, as the renderer's do in f32.
const DARK: f32 = 1e-6;

/// Frusta farther apart than this along the ray do not join, planet radii.
const GAP: f64 = 1e-9;

/// A way to give a value to points of a frustum.
pub(crate) trait Interpolant: Sync {
    /// What is made once per frustum in which a point lies.
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

/// What has been gathered along a ray.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Gathered {
    pub color: Vec3,
    pub through: f32,
    pub samples: u64,
}

impl Gathered {
    /// Puts a step's premultiplied colour and absorbed part behind what there is.
    #[inline]
    pub fn add(&mut self, color: Vec3, absorbed: f32) {
        self.color += self.through * color;
        self.through *= 1.0 - absorbed;
    }
}

/// The frusta that the current step reaches through, and their values once they are asked for.
pub(crate) struct Window<'w, I: Interpolant> {
    interpolant: &'w I,
    transfer: &'w Transfer,
    frusta: VecDeque<(Frustum, Option<Option<I::Cell>>)>,
}

impl<I: Interpolant> Window<'_, I> {
    /// The frustum and cell at `t`, which rises from call to call; `None` in a void.
    #[inline]
    pub fn at(&mut self, t: f64) -> Option<(&Frustum, &I::Cell)> {
        while self.frusta.len() > 1 && self.frusta[0].0.t[1] < t {
            self.frusta.pop_front();
        }
        let (frustum, cell) = self.frusta.front_mut()?;
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

/// What is done with a step.
pub(crate) trait Rule<I: Interpolant>: Sync {
    /// What is kept from step to step.
    type Memory: Default;
    /// The ray enters the shell at `t`.
    fn enter(&self, _memory: &mut Self::Memory, _window: &mut Window<'_, I>, _t: f64) {}
    /// Adds the light of the ray between two distances.
    fn step(
        &self,
        memory: &mut Self::Memory,
        window: &mut Window<'_, I>,
        range: [f64; 2],
        lamp: Option<&RayLight>,
        light: &mut Gathered,
    );
}

/// The midpoint rule: a sample in the middle of each step.
struct Midpoint<'t>(&'t Transfer);

impl<I: Interpolant> Rule<I> for Midpoint<'_> {
    type Memory = ();

    #[inline]
    fn step(
        &self,
        (): &mut (),
        window: &mut Window<'_, I>,
        [from, to]: [f64; 2],
        lamp: Option<&RayLight>,
        light: &mut Gathered,
    ) {
        light.samples += 1;
        let middle = 0.5 * (from + to);
        let interpolant = window.interpolant;
        let Some((frustum, cell)) = window.at(middle) else { return };
        let (mut color, extinction) = self.0.at(interpolant.value(cell, frustum, middle));
        if extinction <= 0.0 {
            return;
        }
        if let Some(lamp) = lamp {
            let gradient = interpolant.gradient(cell, frustum, middle);
            let (body, highlight) = lamp.shade(direction_of(gradient.as_dvec3()));
            color = color * body as f32 + highlight as f32;
        }
        let absorbed = -(-extinction * (to - from) as f32).exp_m1();
        light.add(color * absorbed, absorbed);
    }
}

/// Renders with a sample in the middle of each step of the given length.
pub(crate) fn midpoints<I: Interpolant>(
    setting: &Setting,
    renderer: &Renderer,
    step: f64,
    interpolant: &I,
) -> Picture {
    let transfer = Transfer::new(setting.scene, setting.thickness());
    render(setting, renderer, step, interpolant, &transfer, &Midpoint(&transfer))
}

/// Renders by steps of the given length.
pub(crate) fn render<I: Interpolant, R: Rule<I>>(
    setting: &Setting,
    renderer: &Renderer,
    step: f64,
    interpolant: &I,
    transfer: &Transfer,
    rule: &R,
) -> Picture {
    assert!(step > 0.0, "a step of {step}: expected a positive length");
    let start = Instant::now();
    let pixels = setting.pixels(renderer, |x, y, hint| {
        let (eye, dir) = setting.ray(x, y);
        let window = Window { interpolant, transfer, frusta: VecDeque::new() };
        let lamp = RayLight::new(setting.scene, dir);
        let light = Gathered { color: Vec3::ZERO, through: 1.0, samples: 0 };
        let mut march =
            March { rule, memory: R::Memory::default(), window, lamp, light, step, run: None, done: 0 };
        setting.traversal.ray(eye, dir, hint, |stretch| march.meet(setting, eye, dir, stretch));
        march.finish();
        let light = march.light;
        let [r, g, b] = light.color.to_array().map(f64::from);
        let pixel = over(setting.scene.background, [r, g, b, 1.0 - f64::from(light.through)]);
        (pixel.map(|c| c as f32), light.samples)
    });
    let seconds = start.elapsed().as_secs_f64();
    let samples = pixels.iter().map(|p| p.1).sum();
    Picture { pixels: pixels.into_iter().map(|p| p.0).collect(), seconds, samples, bound: None }
}

/// One ray under way.
struct March<'m, I: Interpolant, R: Rule<I>> {
    rule: &'m R,
    memory: R::Memory,
    window: Window<'m, I>,
    lamp: Option<RayLight>,
    light: Gathered,
    step: f64,
    /// Where the ray entered the shell, and up to where its frusta are known.
    run: Option<[f64; 2]>,
    /// Whole steps taken since.
    done: u64,
}

impl<I: Interpolant, R: Rule<I>> March<'_, I, R> {
    fn meet(&mut self, setting: &Setting, eye: DVec3, dir: DVec3, stretch: &Stretch) -> ControlFlow<()> {
        match stretch {
            Stretch::Frustum(frustum) => self.frustum(frustum),
            Stretch::Core { t } => {
                self.finish();
                if let Some(core) = setting.scene.core {
                    let normal = (eye + *t * dir).normalize();
                    let color = look::ground(setting.scene, DVec3::from_array(core), normal, dir);
                    self.light.add(color.as_vec3(), 1.0);
                }
            }
        }
        if self.light.through > DARK { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    }

    fn frustum(&mut self, frustum: &Frustum) {
        if self.run.is_some_and(|run| frustum.t[0] > run[1] + GAP) {
            self.finish();
        }
        self.window.frusta.push_back((*frustum, None));
        let start = match &mut self.run {
            Some(run) => {
                run[1] = frustum.t[1];
                run[0]
            }
            none => {
                *none = Some(frustum.t);
                self.rule.enter(&mut self.memory, &mut self.window, frustum.t[0]);
                frustum.t[0]
            }
        };
        loop {
            let range = [0, 1].map(|i| start + (self.done + i) as f64 * self.step);
            if range[1] > frustum.t[1] || self.light.through <= DARK {
                return;
            }
            self.advance(range);
            self.done += 1;
        }
    }

    fn advance(&mut self, range: [f64; 2]) {
        self.rule.step(&mut self.memory, &mut self.window, range, self.lamp.as_ref(), &mut self.light);
    }

    /// The shell ends: the rest of the step.
    fn finish(&mut self) {
        if let Some([start, end]) = self.run.take() {
            let from = start + self.done as f64 * self.step;
            if from < end && self.light.through > DARK {
                self.advance([from, end]);
            }
        }
        self.window.frusta.clear();
        self.done = 0;
    }
}
