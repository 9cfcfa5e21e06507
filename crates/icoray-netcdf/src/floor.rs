//! Where the ocean is: below the sea floor, and above ice shelves, MPAS-Ocean's arrays hold what is no water.

use crate::field::FieldInfo;
use crate::mesh::Mesh;
use crate::reals::OwnedReals;
use crate::sea::void;
use crate::source::{Kind, Source};
use crate::sources::Sources;
use icoray::{ErrorKind, Location, Result, Shape};
use std::ops::Range;

/// Which layers of each column are water, counted from 0.
#[derive(Debug)]
pub(crate) struct Floor {
    cells: Vec<Range<usize>>,
    /// A corner has water where all three of its cells have: an average of corners then has none below a cell's floor, and
    /// no triangle of three wet cells lacks any.
    corners: Vec<Range<usize>>,
}

impl Floor {
    /// Reads `maxLevelCell`, and `minLevelCell` where it is there; `None` where there is no sea floor.
    pub(crate) fn read(sources: &Sources, mesh: &Mesh) -> Result<Option<Self>> {
        let Some(last) = levels(sources, mesh, "maxLevelCell")? else {
            return Ok(None);
        };
        let first = levels(sources, mesh, "minLevelCell")?.unwrap_or_else(|| vec![1; last.len()]);
        let cells: Vec<_> =
            first.iter().zip(last).map(|(first, last)| first.saturating_sub(1)..last).collect();
        let corner = |corner| {
            mesh.cells_at(corner).into_iter().fold(0..usize::MAX, |water: Range<usize>, cell| {
                let here = cell.map_or(0..0, |cell| cells[cell].clone());
                water.start.max(here.start)..water.end.min(here.end)
            })
        };
        let corners = (0..mesh.corners()).map(corner).collect();
        Ok(Some(Floor { cells, corners }))
    }

    /// Those of the first `layers` of a cell that are water.
    pub(crate) fn water(&self, cell: usize, layers: usize) -> Range<usize> {
        let Range { start, end } = self.cells[cell];
        start.min(layers)..end.min(layers)
    }

    /// Makes NaN of what is no water in `values`, which hold `layers` of the field.
    pub(crate) fn void_dry(
        &self,
        info: &FieldInfo,
        shape: &Shape,
        layers: Range<usize>,
        values: &mut OwnedReals,
    ) {
        // Interfaces are one more than layers.
        let interface = usize::from(info.layer_dimension == "nVertLevelsP1");
        let columns = match info.location {
            Location::Center => &self.cells,
            Location::Corner => &self.corners,
        };
        for (column, water) in columns.iter().enumerate() {
            let wet = match water.is_empty() {
                true => 0..0,
                // A 2D field lies on the water, beneath ice shelves too.
                false if info.is_2d() => 0..1,
                false => water.start..water.end + interface,
            };
            for (place, _) in layers.clone().enumerate().filter(|(_, layer)| !wet.contains(layer)) {
                void(shape, column, place, values);
            }
        }
    }
}

/// A number of a level for each cell, from 0 (none) to all.
fn levels(sources: &Sources, mesh: &Mesh, name: &str) -> Result<Option<Vec<usize>>> {
    let Some((source, variable)) = sources.find(name) else {
        return Ok(None);
    };
    if variable.kind != Kind::Integer || !variable.lies_over(&["nCells"]) {
        let context = format!("variable {variable}, expected {name}(nCells) of integer");
        return Err(source.error(ErrorKind::Field, context));
    }
    let most = most_levels(sources)?;
    let numbers = source.all_integers(variable)?;
    if numbers.len() != mesh.cells() {
        let context = format!("variable {variable}, expected {} cells as in the mesh", mesh.cells());
        return Err(source.error(ErrorKind::Field, context));
    }
    let checked = numbers.iter().enumerate().map(|(cell, &number)| {
        usize::try_from(number).ok().filter(|&level| level <= most).ok_or_else(|| {
            let context = format!("{name} of cell {} is {number}, expected 0 to {most}", cell + 1);
            source.error(ErrorKind::Field, context)
        })
    });
    checked.collect::<Result<_>>().map(Some)
}

fn most_levels(sources: &Sources) -> Result<usize> {
    let known = |source: &Source| source.dimension_len("nVertLevels");
    for source in sources.all() {
        if let Some(levels) = known(source)? {
            return Ok(levels);
        }
    }
    Ok(usize::MAX)
}
