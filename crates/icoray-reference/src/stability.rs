//! Numerical stability of the kernel in hard cases: thin shells, unusual cameras, rays at vertices, edges and facets,
//! clear and opaque cells, steps and spikes, fields of any magnitude, missing values, fine meshes.
//!
//! Every case is rendered in f64 and f32 and compared, ray by ray, with the [oracle] by
//! intersection with all triangles.

mod cases;
#[cfg(test)]
mod tests;

pub use cases::{GROUPS, LARGE_LEVELS, LEVELS};

use crate::columns::{Column, columns};
use crate::comparison::pixel_error;
use crate::double_double::Dd;
use crate::job::{Job, PreparedJob};
use crate::oracle;
use crate::ray::Ray;
use cases::{Case, CaseMesh};
use icoray::{Error, ErrorKind, Grid, IcosahedralMesh, Precision, Renderer, Result, Scene, Stretch};
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

/// Result of one of the [`RUNS`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Run {
    /// Largest error of a channel, beyond the rounding of the picture's f32.
    pub error: f64,
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

fn measure(renderer: &Renderer, grid: &Grid, case: &Case) -> Result<Row> {
    let field = case.field(grid)?;
    let job = Job { scene: &case.scene, grid, layers: &case.layers, field: &field };
    let checks = oracle::with(&job, |oracle, prepared| {
        prepared.pixels(renderer, |ray, _| {
            let gap = || Error::new(ErrorKind::Internal, format!("the reference loses {ray:?}"));
            Ok((oracle.pixel(ray).ok_or_else(gap)?, is_lost(prepared, ray)))
        })
    })?;
    let checks = checks.into_iter().collect::<Result<Vec<_>>>()?;
    let run = |(precision, tolerance)| {
        let scene = Scene { precision, tolerance, ..case.scene.clone() };
        let frame = Job { scene: &scene, ..job }.render(renderer)?;
        let errors: Vec<f64> =
            frame.pixels.iter().zip(&checks).map(|(pixel, (exact, _))| pixel_error(*pixel, exact)).collect();
        Result::Ok(Run {
            error: errors.iter().copied().fold(0.0, f64::max),
            bound: frame.error.iter().copied().fold(0.0, f32::max).into(),
            over_bound: errors.iter().zip(&frame.error).filter(|(error, bound)| **error > f64::from(**bound)).count(),
            not_finite: frame.pixels.iter().filter(|p| p.iter().any(|c| !c.is_finite())).count(),
        })
    };
    Ok(Row {
        group: case.group,
        name: case.name.clone(),
        rays: checks.len(),
        seen: checks.iter().filter(|(exact, _)| exact[3] > 0.0).count(),
        run: [run(RUNS[0])?, run(RUNS[1])?, run(RUNS[2])?],
        lost: checks.iter().filter(|(_, is_lost)| *is_lost).count(),
    })
}

/// Whether the traversal misses a part of the ray between outermost and innermost layer. Parts within rounding of the
/// shell's surfaces do not count.
fn is_lost(prepared: &PreparedJob, ray: &Ray) -> bool {
    let (walked, size) = (walked(prepared, ray), 1.0 + ray.eye.length());
    let radius = &prepared.radius;
    let [low, high] = [radius[0], radius[radius.len() - 1]];
    let inner = prepared.scene.core.map(|_| low);
    for column in columns(prepared.grid, ray, high, inner).unwrap_or_default() {
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
fn walked(prepared: &PreparedJob, ray: &Ray) -> Vec<[f64; 2]> {
    let (mut parts, mut hint) = (Vec::new(), 0);
    let solid = prepared.scene.core.is_some();
    prepared.traversal.ray(ray.eye, ray.dir, &mut hint, |stretch| match stretch {
        Stretch::Frustum(f) => {
            parts.push(f.t);
            ControlFlow::Continue(())
        }
        Stretch::Core { .. } if solid => ControlFlow::Break(()),
        Stretch::Core { .. } => ControlFlow::Continue(()),
    });
    parts
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
