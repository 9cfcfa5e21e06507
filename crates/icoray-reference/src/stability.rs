//! Numerical stability of the kernel in hard cases: thin shells, unusual cameras, rays at vertices, edges and facets,
//! clear and opaque cells, steps and spikes, fields of any magnitude, missing values, fine meshes.
//!
//! Every case is rendered in f64 and f32 and compared, ray by ray, with the [oracle](crate::oracle) by
//! intersection with all triangles.

mod cases;
mod measure;
#[cfg(test)]
mod tests;

pub use cases::{GROUPS, LARGE_LEVELS, LEVELS};
pub use measure::{RUNS, Row, Run};

use cases::CaseMesh;
use icoray::{Grid, IcosahedralMesh, Renderer, Result};

/// Measures all cases on the mesh of `level` bisections whose group or name contains `only`.
///
/// # Errors
/// As [`Renderer::render`]; [`icoray::ErrorKind::Internal`] where the reference finds a gap in the mesh.
pub fn measure_level(renderer: &Renderer, level: u32, only: &str) -> Result<Vec<Row>> {
    let mesh = IcosahedralMesh::new(level)?;
    let grid = renderer.run(|| Grid::new(mesh.tables()))?;
    let cases = cases::on(&CaseMesh { level, grid: &grid })?;
    let selected = cases.iter().filter(|case| case.group.contains(only) || case.name.contains(only));
    selected.map(|case| measure::measure(renderer, &grid, case)).collect()
}
