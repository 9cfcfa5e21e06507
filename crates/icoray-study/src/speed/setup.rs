//! Cost of a grid before the first frame: checked and derived tables.

use super::options::cores;
use crate::peak::PeakMemory;
use icoray::{Grid, IcosahedralMesh, Renderer, Result};
use std::time::Instant;

/// Cost of checking a grid's tables.
#[derive(Debug, Clone)]
pub(super) struct Setup {
    pub level: u32,
    pub cells: usize,
    pub triangles: usize,
    /// Numbers of threads, and the minimum seconds of each.
    pub threads: Vec<usize>,
    pub seconds: Vec<f64>,
    /// Memory of the grid beside the model's tables, as it reports.
    pub derived_bytes: usize,
    /// Peak memory of the process beyond those tables during the check.
    pub peak_bytes: u64,
}

impl Setup {
    pub fn of(level: u32, mesh: &IcosahedralMesh, renderers: &[Renderer], times: usize) -> Result<Self> {
        let threads = renderers.iter().map(Renderer::threads).collect();
        let mut seconds = vec![f64::INFINITY; renderers.len()];
        let mut derived_bytes = 0;
        let peak = PeakMemory::start()?;
        for _ in 0..times.max(1) {
            for (renderer, min) in renderers.iter().zip(&mut seconds) {
                let start = Instant::now();
                let grid = renderer.run(|| Grid::new(mesh.tables()))?;
                *min = min.min(start.elapsed().as_secs_f64());
                derived_bytes = grid.derived_bytes();
            }
        }
        let (cells, triangles) = (mesh.cells(), mesh.tables().corners());
        Ok(Setup { level, cells, triangles, threads, seconds, derived_bytes, peak_bytes: peak.bytes()? })
    }

    /// Seconds, one number of threads after the other.
    pub fn times(&self) -> String {
        let times: Vec<_> = self.seconds.iter().map(|min| format!("{min:.3}")).collect();
        times.join(", ")
    }

    pub fn line(&self) -> String {
        format!(
            "\nn = {}: {} cells, {} triangles; tables checked and derived in {} s on {}; {} bytes derived, {:.1} per cell, {:.1} \
             per triangle; at most {:.1} MiB more than the tables meanwhile",
            self.level,
            self.cells,
            self.triangles,
            self.times(),
            cores(&self.threads),
            self.derived_bytes,
            self.per_cell(),
            self.per_triangle(),
            self.peak_bytes as f64 / f64::from(1 << 20),
        )
    }

    pub fn per_triangle(&self) -> f64 {
        self.derived_bytes as f64 / self.triangles as f64
    }

    pub fn per_cell(&self) -> f64 {
        self.derived_bytes as f64 / self.cells as f64
    }
}
