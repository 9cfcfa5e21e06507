//! Numerical stability of the kernel in hard cases: thin shells, unusual cameras, rays at vertices, edges and facets,
//! clear and opaque cells, steps and spikes, fields of any magnitude, missing values, fine meshes.
//!
//! Every case is rendered in f64 and f32 and compared, ray by ray, with the exact integral, which [`truth`] computes in
//! double-double by other methods.

mod cases;
pub(crate) mod dd;
pub(crate) mod gauss;
mod measure;
pub mod path;
mod radiance;
mod table;
pub mod truth;

#[cfg(test)]
mod tests;

use crate::results::{progress, say, write_file};
use cases::CaseMesh;
use icoray::{Grid, IcosahedralMesh, Renderer, Result};
use measure::Row;
use std::io::Write;
use std::path::PathBuf;

/// What to check.
#[derive(Debug, Clone, clap::Args)]
pub struct Options {
    /// Meshes of up to 2.6 million cells too.
    #[arg(long)]
    pub large: bool,
    /// Only cases with this in their group or name.
    #[arg(long)]
    pub only: Option<String>,
    /// Threads, or as many as there are processors when 0.
    #[arg(long, default_value_t = 0)]
    pub threads: usize,
    /// Directory for STABILITY.md and stability.csv, if they are wanted.
    #[arg(long)]
    pub out: Option<PathBuf>,
}

/// Measures all cases on the meshes of `levels` whose group or name contains `only`.
pub(crate) fn suite(renderer: &Renderer, levels: &[u32], only: &str) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for &level in levels {
        let mesh = IcosahedralMesh::new(level)?;
        let grid = renderer.run(|| Grid::new(mesh.tables()))?;
        for case in cases::on(&CaseMesh { level, grid: &grid })? {
            if case.group.contains(only) || case.name.contains(only) {
                rows.push(measure::measure(renderer, &grid, &case)?);
            }
        }
    }
    Ok(rows)
}

/// Measures, prints the page and writes it.
pub(crate) fn run(options: &Options, out: &mut dyn Write) -> Result<()> {
    let renderer = Renderer::new(options.threads)?;
    let mut levels = cases::LEVELS.to_vec();
    if options.large {
        levels.extend(cases::LARGE_LEVELS);
    }
    let only = options.only.as_deref().unwrap_or("");
    let mut rows = Vec::new();
    let bar = progress(levels.len(), "stability");
    for level in levels {
        bar.set_message(format!("n = {level}"));
        let more = suite(&renderer, &[level], only)?;
        bar.suspend(|| say!(out, "n = {level}: {} cases", more.len()))?;
        bar.inc(1);
        rows.extend(more);
    }
    bar.finish_and_clear();
    let page = table::page(&rows);
    say!(out, "\n{page}")?;
    let Some(directory) = &options.out else { return Ok(()) };
    table::write_csv(directory.join("stability.csv"), &rows)?;
    write_file(&directory.join("STABILITY.md"), &page)?;
    say!(out, "STABILITY.md and stability.csv in {}", directory.display())
}
