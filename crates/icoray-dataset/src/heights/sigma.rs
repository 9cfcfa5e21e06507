//! Heights of FVCOM's layers: ζ + σ (h + ζ), where σ falls from 0 at the sea surface ζ to -1 at the depth h.
//! Format: FVCOM user manual; CF conventions 1.11, appendix D, ocean sigma coordinate.

use super::MeanHeights;
use super::columns::{self, HeightStatistics};
use super::thickness::{Columns, of_cells, surface};
use crate::field::FieldInfo;
use crate::mesh::Mesh;
use crate::source::{SourceVariable, Variable};
use crate::sources::Sources;
use icoray::{ErrorKind, OwnedReals, Result, Shape};

/// σ of layers and of interfaces, over dimensions of these names and nodes.
const SIGMA: [&str; 2] = ["siglay", "siglev"];
/// Depth of the sea floor below the sphere, and height of the sea surface above it.
const DEPTH: &str = "h";
pub(super) const SURFACE: [&str; 1] = ["zeta"];

/// σ of the interfaces between a field's layers, or of these.
pub(super) fn of<'a>(sources: &'a Sources, mesh: &Mesh, info: &FieldInfo) -> Option<SourceVariable<'a>> {
    let first = SIGMA.iter().position(|name| *name == info.layer_dimension)?;
    let fits = |v: &Variable| v.kind.is_real() && matches!(v.after_time(), [_, node] if node.len == mesh.cells());
    SIGMA[first..].iter().rev().find_map(|name| sources.find(name).filter(|found| fits(found.variable)))
}

/// The heights of all columns at record `time`.
pub(super) fn of_columns(sources: &Sources, sigma: SourceVariable, time: usize) -> Result<Columns> {
    let [layers, cells] = [0, 1].map(|i| sigma.variable.after_time()[i].len);
    let depth = of_cells(sources, DEPTH, cells)?.ok_or_else(|| {
        let context = format!("{} has layers relative to the depth, and variable {DEPTH} is missing", sigma.name());
        sigma.error(ErrorKind::Layers, context)
    })?;
    let surface = surface(sources, &SURFACE, cells, time)?;
    let (start, count) = sigma.first_record()?;
    let read = sigma.decoded(&start, &count, &sources.options.missing)?;
    let mut heights = Vec::with_capacity(cells * layers);
    for (cell, (depth, surface)) in depth.iter().zip(&surface).enumerate() {
        let sigma = (0..layers).map(|layer| read.as_reals().get(layer * cells + cell));
        heights.extend(sigma.map(|sigma| surface + sigma * (depth + surface)));
    }
    Ok(Columns { heights: OwnedReals::F64(heights), shape: Shape::level_fastest(cells, layers) })
}

/// The mean heights at the first time.
pub(super) fn means(sources: &Sources, sigma: SourceVariable) -> Result<MeanHeights> {
    let Columns { heights, shape } = of_columns(sources, sigma, 0)?;
    let mut of_layers = vec![HeightStatistics::default(); shape.layers];
    for i in 0..heights.as_reals().len() {
        let height = heights.as_reals().get(i);
        if height.is_finite() {
            of_layers[i % shape.layers].add(height);
        }
    }
    Ok(columns::means(&of_layers))
}
