//! Numerical stability of the kernel in hard cases: thin shells, unusual cameras, rays at vertices, edges and facets,
//! clear and opaque cells, steps and spikes, fields of any magnitude, missing values, fine meshes.
//!
//! Every case is rendered in f64 and f32 and compared, ray by ray, with the [oracle](crate::oracle) by
//! intersection with all triangles.

mod cases;
#[cfg(test)]
mod tests;

pub use cases::{GROUPS, LARGE_LEVELS, LEVELS};

use crate::columns::{Column, columns};
use crate::comparison::pixel_error;
use crate::double_double::Dd;
use crate::job::{Job, PreparedJob};
use crate::oracle::{Data, NamedField, Oracle, PANEL};
use crate::ray::Ray;
use cases::{Case, CaseMesh};
use icoray::{Error, ErrorKind, Frame, Grid, IcosahedralMesh, Precision, Renderer, Result, Scene, Stretch};
use rayon::prelude::*;
use std::ops::ControlFlow;

/// Measures all cases on the mesh of `level` bisections whose group or name contains `only`.
///
/// # Errors
/// As [`Renderer::render`]; [`icoray::ErrorKind::Internal`] where the reference finds a gap in the mesh.
pub fn measure_level(renderer: &Renderer, level: u32, only: &str) -> Result<Vec<Row>> {
    let mesh = IcosahedralMesh::new(level)?;
    let grid = renderer.run(|| Grid::new(mesh.tables()))?;
    let cases = cases::on(&CaseMesh { level, grid: &grid })?;
    let selected = cases.iter().filter(|case| case.group.contains(only) || case.name.contains(only));
    selected.map(|case| measure(renderer, &grid, case)).collect()
}

/// Precision and tolerance of each picture.
pub const RUNS: [(Precision, f64); 3] = [(Precision::F64, 1e-9), (Precision::F32, 1e-6), (Precision::F32, 1e-3)];

/// Errors above which a ray is tested for ill-posedness, per run.
const SUSPECT: [f64; 3] = [1e-9, 1e-5, 1e-3];

/// Result of one of the [`RUNS`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Run {
    /// Largest error of a channel, beyond the rounding of the picture's f32.
    pub error: f64,
    /// The same without the ill-posed rays.
    pub well_posed_error: f64,
    /// Ill-posed rays with larger errors than all others: their exact colour moves by half the error or more when the
    /// inputs move by the run's rounding.
    pub ill_posed: usize,
    /// Largest error that the frame reports.
    pub bound: f64,
    /// Pixels with a larger error than the frame reports.
    pub over_bound: usize,
    /// Pixels with a channel that is not finite.
    pub not_finite: usize,
}

/// Result of a case.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// One of [`GROUPS`].
    pub group: &'static str,
    /// The case, unique in its group.
    pub name: String,
    /// Number of rays.
    pub rays: usize,
    /// Rays among these that meet something: their exact opacity is not 0.
    pub seen: usize,
    /// One for each of [`RUNS`].
    pub run: [Run; 3],
    /// Rays whose traversal misses a part of the shell.
    pub lost: usize,
}

fn max_difference(a: &[f64; 4], b: &[f64; 4]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
}

/// Data for checking the rays of one case.
struct CaseCheck<'c> {
    prepared: &'c PreparedJob<'c>,
    oracle: Oracle<'c>,
    /// The same with each value one unit in the last place of f32 lower, or higher, relative to the transfer function's
    /// range.
    moved: [Oracle<'c>; 2],
}

fn measure(renderer: &Renderer, grid: &Grid, case: &Case) -> Result<Row> {
    let field = case.field(grid)?;
    let frame = |(precision, tolerance)| {
        let scene = Scene { precision, tolerance, ..case.scene.clone() };
        renderer.render(&scene, grid, &case.layers, &field)
    };
    let frames = [frame(RUNS[0])?, frame(RUNS[1])?, frame(RUNS[2])?];
    let job = Job { scene: &case.scene, grid, layers: &case.layers, field: &field };
    let prepared = &PreparedJob::new(&job)?;
    let volume = &case.scene.volumes[0];
    let [low, high] = volume.transfer.range();
    let unit = f64::from(f32::EPSILON) * if high > low { high - low } else { 1.0 };
    let fields = [0.0, -unit, unit].map(|by| {
        let values = prepared.values().into_iter().map(|value| value + by).collect();
        [NamedField { name: &volume.field, values }]
    });
    let oracle = |k: usize| {
        let data = Data { grid, layers: &case.layers, heights: &[], fields: &fields[k] };
        Oracle::new(&case.scene, data, PANEL)
    };
    let checker = CaseCheck { prepared, oracle: oracle(0)?, moved: [oracle(1)?, oracle(2)?] };
    let pixels = (0..case.scene.width * case.scene.height).into_par_iter();
    renderer.run(|| {
        let checks = pixels.map(|i| checker.ray(&frames, i)).collect::<Result<Vec<_>>>()?;
        let run = |k: usize| checker.summary(&frames[k], &checks, k);
        Ok(Row {
            group: case.group,
            name: case.name.clone(),
            rays: checks.len(),
            seen: checks.iter().filter(|check| check.exact[3] > 0.0).count(),
            run: [run(0)?, run(1)?, run(2)?],
            lost: checks.iter().filter(|check| check.lost).count(),
        })
    })
}

/// Result of one ray: the exact colour, the error in each run, whether the traversal loses it.
struct RayCheck {
    ray: Ray,
    exact: [f64; 4],
    error: [f64; 3],
    lost: bool,
}

/// The pixel of a ray; an error where the mesh has a gap.
fn exact(oracle: &Oracle, ray: &Ray) -> Result<[f64; 4]> {
    oracle.pixel(ray).ok_or_else(|| Error::new(ErrorKind::Internal, format!("the reference loses {ray:?}")))
}

impl CaseCheck<'_> {
    fn ray(&self, frames: &[Frame; 3], i: u32) -> Result<RayCheck> {
        let ray = Ray::of_pixel(self.prepared.scene, i);
        let exact = exact(&self.oracle, &ray)?;
        let error = [0, 1, 2].map(|k: usize| pixel_error(frames[k].pixels[i as usize], &exact));
        Ok(RayCheck { ray, exact, error, lost: self.is_lost(&ray) })
    }

    /// Largest errors of a run, of all rays and of well-posed ones.
    fn summary(&self, frame: &Frame, checks: &[RayCheck], k: usize) -> Result<Run> {
        let mut worst: Vec<&RayCheck> = checks.iter().collect();
        worst.sort_by(|a, b| b.error[k].total_cmp(&a.error[k]));
        let mut run = Run {
            error: worst[0].error[k],
            well_posed_error: 0.0,
            ill_posed: 0,
            bound: frame.error.iter().copied().fold(0.0, f32::max).into(),
            over_bound: checks.iter().zip(&frame.error).filter(|(l, e)| l.error[k] > f64::from(**e)).count(),
            not_finite: frame.pixels.iter().filter(|p| p.iter().any(|c| !c.is_finite())).count(),
        };
        for check in worst {
            let error = check.error[k];
            if error > SUSPECT[k] && self.sensitivity(&check.ray, &check.exact, RUNS[k].0)? > 0.5 * error {
                run.ill_posed += 1;
            } else {
                run.well_posed_error = error;
                break;
            }
        }
        Ok(run)
    }

    /// Change of the exact colour if the eye moves by four units in the last place and, in f32, if values change by
    /// one, relative to the range of the transfer function.
    fn sensitivity(&self, ray: &Ray, exact: &[f64; 4], precision: Precision) -> Result<f64> {
        let step = 4.0 * f64::EPSILON * ray.eye.length().max(1.0);
        let (x, y) = ray.dir.any_orthonormal_pair();
        let mut max = 0.0f64;
        for aside in [x, -x, y, -y, x + y, x - y, y - x, -x - y] {
            let near = Ray { eye: ray.eye + step * aside, dir: ray.dir };
            max = max.max(max_difference(&self::exact(&self.oracle, &near)?, exact));
        }
        if precision == Precision::F32 {
            for moved in &self.moved {
                max = max.max(max_difference(&self::exact(moved, ray)?, exact));
            }
        }
        Ok(max)
    }

    /// Whether the traversal misses a part of the ray between outermost and innermost layer. Parts within rounding of
    /// the shell's surfaces do not count.
    fn is_lost(&self, ray: &Ray) -> bool {
        let (walked, size) = (self.walked(ray), 1.0 + ray.eye.length());
        let radius = &self.prepared.radius;
        let [low, high] = [radius[0], radius[radius.len() - 1]];
        let inner = self.prepared.scene.core.map(|_| low);
        for column in columns(self.prepared.grid, ray, high, inner).unwrap_or_default() {
            let is_inside = |t: f64| {
                let height = column.height(t.into()).to_f64();
                (height - low).min(high - height) > 1e-11
            };
            let reach = if column.is_void { None } else { part_between(&column, [low, high]) };
            if let Some([from, to]) = reach {
                let mut at = from;
                for [start, end] in walked.iter().filter(|w| w[1] > from && w[0] < to) {
                    if *start > at + 1e-12 * size && is_inside(0.5 * (at + start)) {
                        return true;
                    }
                    at = at.max(*end);
                }
                if to > at + 1e-12 * size && is_inside(0.5 * (at + to)) {
                    return true;
                }
            }
            // An opaque core ends the ray.
            let [start, end] = column.t.map(|t| column.height(t).to_f64());
            if inner.is_some() && start.min(end) < low {
                return false;
            }
        }
        false
    }

    /// The parts of the ray in the traversal's frusta.
    fn walked(&self, ray: &Ray) -> Vec<[f64; 2]> {
        let (mut parts, mut hint) = (Vec::new(), 0);
        let solid = self.prepared.scene.core.is_some();
        self.prepared.traversal.ray(ray.eye, ray.dir, &mut hint, |stretch| match stretch {
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

/// The distances between which a column lies between two radii: its height is linear along the ray.
fn part_between(column: &Column, radii: [f64; 2]) -> Option<[f64; 2]> {
    let [from, to] = column.t.map(Dd::to_f64);
    let [a, b] = match radii.map(|radius| column.reaches(radius)) {
        [Some(low), Some(high)] => [low.to_f64(), high.to_f64()],
        _ => [from, to],
    };
    let [start, end] = [from.max(a.min(b)), to.min(a.max(b))];
    (start < end).then_some([start, end])
}
