//! The water of MPAS-Ocean: arrays also hold values below the sea floor and above ice shelves.

use crate::field::FieldInfo;
use crate::mesh::Mesh;
use crate::source::{Kind, Source};
use crate::sources::Sources;
use icoray::{ErrorKind, Location, Result};
use std::ops::Range;

/// The layers of each column that are water, counted from 0.
#[derive(Debug)]
pub(crate) struct Floor {
    cells: Vec<Range<usize>>,
    /// A corner has water where all three of its cells have: an average of corners then has none below a cell's floor,
    /// and no triangle of three wet cells lacks any.
    corners: Vec<Range<usize>>,
}

impl Floor {
    /// Reads `maxLevelCell` and, if present, `minLevelCell`; `None` if there is no sea floor.
    pub(crate) fn read(sources: &Sources, mesh: &Mesh) -> Result<Option<Self>> {
        let Some(last) = levels(sources, mesh, "maxLevelCell")? else {
            return Ok(None);
        };
        let first = levels(sources, mesh, "minLevelCell")?.unwrap_or_else(|| vec![1; last.len()]);
        let cells: Vec<_> = first.iter().zip(last).map(|(first, last)| first.saturating_sub(1)..last).collect();
        let corner = |corner| {
            mesh.cells_at(corner).into_iter().fold(0..usize::MAX, |water: Range<usize>, cell| {
                let here = cell.map_or(0..0, |cell| cells[cell].clone());
                water.start.max(here.start)..water.end.min(here.end)
            })
        };
        let corners = (0..mesh.corners()).map(corner).collect();
        Ok(Some(Floor { cells, corners }))
    }

    /// The layers of a cell that are water, of the first `layers`.
    pub(crate) fn water(&self, cell: usize, layers: usize) -> Range<usize> {
        let Range { start, end } = self.cells[cell];
        start.min(layers)..end.min(layers)
    }

    /// Whether a field's layer is not water.
    pub(crate) fn is_dry(&self, info: &FieldInfo, column: usize, layer: usize) -> bool {
        let water = match info.location {
            Location::Center => &self.cells[column],
            Location::Corner => &self.corners[column],
        };
        // Interfaces are one more than layers. A 2D field lies on the water, beneath ice shelves too.
        let interface = usize::from(info.layer_dimension == "nVertLevelsP1");
        let wet = if info.is_2d() { 0..1 } else { water.start..water.end + interface };
        water.is_empty() || !wet.contains(&layer)
    }
}

/// A level number for each cell, from 0 (none).
fn levels(sources: &Sources, mesh: &Mesh, name: &str) -> Result<Option<Vec<usize>>> {
    let Some((source, variable)) = sources.find(name) else {
        return Ok(None);
    };
    if variable.kind != Kind::Integer || !variable.lies_at_times_over(&["nCells"]) {
        let context = format!("variable {variable}, expected {name}(nCells) of integer");
        return Err(source.error(ErrorKind::Field, context));
    }
    let max = most_levels(sources)?;
    let numbers = source.all_integers(variable)?;
    if numbers.len() != mesh.cells() {
        let context = format!("variable {variable}, expected {} cells as in the mesh", mesh.cells());
        return Err(source.error(ErrorKind::Field, context));
    }
    let checked = numbers.iter().enumerate().map(|(cell, &number)| {
        usize::try_from(number).ok().filter(|&level| level <= max).ok_or_else(|| {
            let context = format!("{name} of cell {} is {number}, expected 0 to {max}", cell + 1);
            source.error(ErrorKind::Field, context)
        })
    });
    checked.collect::<Result<_>>().map(Some)
}

fn most_levels(sources: &Sources) -> Result<usize> {
    let known = |source: &dyn Source| source.dimension_len("nVertLevels");
    for source in sources.all() {
        if let Some(levels) = known(source)? {
            return Ok(levels);
        }
    }
    Ok(usize::MAX)
}
