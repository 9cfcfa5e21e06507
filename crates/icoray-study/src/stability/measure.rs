//! One case: drawn in f64 and f32, each pixel against the exact integral along its ray.

use super::cases::Case;
use super::path::Ray;
use super::truth::{self, Truth};
use icoray::{Error, ErrorKind, Frame, Grid, Precision, Renderer, Result, Scene, Stretch, Traversal};
use rayon::prelude::*;
use std::ops::ControlFlow;

/// How each picture is asked for: precision and the scene's tolerance.
pub const RUNS: [(Precision, f64); 3] =
    [(Precision::F64, 1e-9), (Precision::F32, 1e-6), (Precision::F32, 1e-3)];

/// Errors from which on it is asked whether the ray is ill-posed, per run.
const SUSPECT: [f64; 3] = [1e-9, 1e-5, 1e-3];

/// What one of the [`RUNS`] gave.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Run {
    /// Largest error of a channel, beyond the rounding of the picture's f32.
    pub error: f64,
    /// The same without the ill-posed rays.
    pub well: f64,
    /// Ill-posed rays that are farther off than any other: their exact answer moves by half the error or more when the
    /// inputs move by the run's rounding.
    pub ill: usize,
    /// Largest error that the frame itself admits.
    pub bound: f64,
    /// Pixels with a larger error than the frame admits.
    pub over: usize,
    /// Pixels with a channel that is not finite.
    pub not_finite: usize,
}

/// What a case gave.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// As [`Case::group`].
    pub group: &'static str,
    /// As [`Case::name`].
    pub name: String,
    /// Number of rays.
    pub rays: usize,
    /// Rays among these that meet something: their exact opacity is not 0.
    pub seen: usize,
    /// One for each of [`RUNS`].
    pub run: [Run; 3],
    /// Rays that miss a part of their way through the shell.
    pub lost: usize,
}

/// How far `pixel` is from `exact`, beyond the half unit in its last place that an f32 cannot hold.
fn apart(pixel: [f32; 4], exact: &[f64; 4]) -> f64 {
    let channel = |k: usize| {
        let half = 0.5 * f64::from(pixel[k].next_up() - pixel[k]).abs();
        (f64::from(pixel[k]) - exact[k]).abs() - half
    };
    (0..4).map(channel).fold(0.0, f64::max)
}

/// The largest difference of a channel.
fn change(a: &[f64; 4], b: &[f64; 4]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
}

/// Everything that the rays of one case are checked with.
struct Check<'c> {
    case: &'c Case,
    truth: Truth<'c>,
    shell: Vec<f64>,
    traversal: Traversal<'c>,
}

/// Draws a case and checks every ray.
///
/// # Errors
/// Whatever the library says, and [`ErrorKind::Internal`] when the reference itself finds no way along a ray.
pub fn measure(renderer: &Renderer, grid: &Grid, case: &Case) -> Result<Row> {
    let field = case.field(grid)?;
    let frames = RUNS.map(|(precision, tolerance)| {
        let scene = Scene { precision, tolerance, ..case.scene.clone() };
        renderer.render(&scene, grid, &case.layers, &field)
    });
    let [a, b, c] = frames;
    let frames = [a?, b?, c?];
    let shell = case.layers.shell(case.scene.exaggeration)?;
    let truth = Truth::new(grid, &field, &shell, case.layers.is_falling(), &case.scene);
    let traversal = Traversal::new(grid, &shell)?;
    let check = Check { case, truth, shell: shell.clone(), traversal };
    let pixels = (0..case.scene.width * case.scene.height).into_par_iter();
    renderer.run(|| {
        let looks = pixels.map(|i| check.ray(&frames, i)).collect::<Result<Vec<_>>>()?;
        let [a, b, c] = [0, 1, 2].map(|k| check.sum_up(&frames[k], &looks, k));
        Ok(Row {
            group: case.group,
            name: case.name.clone(),
            rays: looks.len(),
            seen: looks.iter().filter(|look| look.exact[3] > 0.0).count(),
            run: [a?, b?, c?],
            lost: looks.iter().filter(|look| look.lost).count(),
        })
    })
}

/// What is found about one ray: the exact answer, the error in each run, whether it is lost.
struct Look {
    ray: Ray,
    exact: [f64; 4],
    error: [f64; 3],
    lost: bool,
}

/// What the reference found along a ray, or the error that it found no way.
fn found<T>(ray: &Ray, way: std::result::Result<T, f64>) -> Result<T> {
    way.map_err(|t| Error::new(ErrorKind::Internal, format!("the reference loses {ray:?} at {t}")))
}

impl Check<'_> {
    fn ray(&self, frames: &[Frame; 3], i: u32) -> Result<Look> {
        let (scene, index) = (&self.case.scene, i as usize);
        let dir = scene.camera.direction(i % scene.width, i / scene.width, scene.width, scene.height);
        let ray = Ray { eye: scene.camera.eye().into(), dir: dir.into() };
        let way = found(&ray, self.truth.stretches(&ray))?;
        let exact = self.truth.light(&way);
        let error = [0, 1, 2].map(|k: usize| apart(frames[k].pixels[index], &exact));
        Ok(Look { ray, exact, error, lost: self.is_lost(&ray, &way) })
    }

    /// The run's worst ray, and its worst one that is not ill-posed.
    fn sum_up(&self, frame: &Frame, looks: &[Look], k: usize) -> Result<Run> {
        let mut worst: Vec<&Look> = looks.iter().collect();
        worst.sort_by(|a, b| b.error[k].total_cmp(&a.error[k]));
        let mut run = Run {
            error: worst[0].error[k],
            well: 0.0,
            ill: 0,
            bound: frame.error.iter().copied().fold(0.0, f32::max).into(),
            over: looks.iter().zip(&frame.error).filter(|(l, e)| l.error[k] > f64::from(**e)).count(),
            not_finite: frame.pixels.iter().filter(|p| p.iter().any(|c| !c.is_finite())).count(),
        };
        for look in worst {
            let error = look.error[k];
            if error > SUSPECT[k] && self.sway(&look.ray, &look.exact, RUNS[k].0)? > 0.5 * error {
                run.ill += 1;
            } else {
                run.well = error;
                break;
            }
        }
        Ok(run)
    }

    /// How far the exact answer moves when the eye moves by four units in the last place and, in f32, when the values
    /// move by one, relative to the range of the transfer function.
    fn sway(&self, ray: &Ray, exact: &[f64; 4], precision: Precision) -> Result<f64> {
        let step = 4.0 * f64::EPSILON * ray.eye.length().max(1.0);
        let (x, y) = ray.dir.any_orthonormal_pair();
        let mut most = 0.0f64;
        for aside in [x, -x, y, -y, x + y, x - y, y - x, -x - y] {
            let near = Ray { eye: ray.eye + step * aside, dir: ray.dir };
            most = most.max(change(&found(&near, self.truth.trace(&near))?, exact));
        }
        if precision == Precision::F32 {
            for by in [-f64::from(f32::EPSILON), f64::from(f32::EPSILON)] {
                most = most.max(change(&found(ray, self.truth.shifted(by).trace(ray))?, exact));
            }
        }
        Ok(most)
    }

    /// Whether the walk leaves out a part of the ray's way between the outermost and the innermost layer. Parts that
    /// come no nearer to the inside of the shell than rounding do not count.
    fn is_lost(&self, ray: &Ray, way: &[truth::Stretch]) -> bool {
        let walked = self.walked(ray);
        let size = 1.0 + ray.eye.length();
        let (low, high) = (self.shell[0], self.shell[self.shell.len() - 1]);
        for stretch in way.iter().filter(|s| s.layer.is_some()) {
            let [from, to] = stretch.t.map(|t| t.to_f64());
            let mut at = from;
            for [start, end] in walked.iter().filter(|w| w[1] > from && w[0] < to) {
                if *start > at + 1e-12 * size && self.is_inside(stretch, 0.5 * (at + start), [low, high]) {
                    return true;
                }
                at = at.max(*end);
            }
            if to > at + 1e-12 * size && self.is_inside(stretch, 0.5 * (at + to), [low, high]) {
                return true;
            }
        }
        false
    }

    /// Whether the ray's point at `t` lies clearly inside the shell.
    fn is_inside(&self, stretch: &truth::Stretch, t: f64, [low, high]: [f64; 2]) -> bool {
        let height = stretch.column.height(t.into()).to_f64();
        (height - low).min(high - height) > 1e-11
    }

    /// The parts of the ray that the walk passes between layers.
    fn walked(&self, ray: &Ray) -> Vec<[f64; 2]> {
        let (mut parts, mut hint) = (Vec::new(), 0);
        let solid = self.case.scene.core.is_some();
        self.traversal.ray(ray.eye, ray.dir, &mut hint, |stretch| match stretch {
            Stretch::Frustum(f) => {
                parts.push(f.t);
                ControlFlow::Continue(())
            }
            Stretch::Core { .. } if solid => ControlFlow::Break(()),
            Stretch::Core { .. } => ControlFlow::Continue(()),
        });
        parts
    }
}
