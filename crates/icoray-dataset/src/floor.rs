//! The water of MPAS-Ocean and FESOM: arrays also hold values below the sea floor and above ice shelves.

use crate::field::FieldInfo;
use crate::mesh::Mesh;
use crate::source::Kind;
use crate::sources::Sources;
use icoray::{ErrorKind, Location, Result};
use std::ops::Range;

/// Variables with the last and the first layer of each column that is water, counted from 1.
struct Levels {
    /// Names for cells.
    cells: [&'static str; 2],
    /// Names for corners; `None` if the model has none.
    corners: Option<[&'static str; 2]>,
    /// Whether the last level is an interface, one more than the last layer.
    ends_at_interface: bool,
}

const LEVELS: [Levels; 2] = [
    Levels { cells: ["maxLevelCell", "minLevelCell"], corners: None, ends_at_interface: false },
    Levels {
        cells: ["nlevels_nod2D", "ulevels_nod2D"],
        corners: Some(["nlevels", "ulevels"]),
        ends_at_interface: true,
    },
];

/// The layers of each column that are water, counted from 0.
#[derive(Debug)]
pub(crate) struct Floor {
    cells: Vec<Range<usize>>,
    /// If no file has them, a corner has water where all three of its cells have: then no average of corners has values
    /// below a cell's floor, and no triangle of three wet cells lacks any.
    corners: Vec<Range<usize>>,
}

impl Floor {
    /// Reads the levels of the sea floor and, if present, those of ice shelves; `None` if there is no sea floor.
    pub(crate) fn read(sources: &Sources, mesh: &Mesh) -> Result<Option<Self>> {
        for of in LEVELS {
            if let Some(cells) = water(sources, of.cells, mesh.cells(), of.ends_at_interface)? {
                let corners = match of.corners {
                    Some(names) => water(sources, names, mesh.corners(), of.ends_at_interface)?,
                    None => None,
                };
                let corners = corners.unwrap_or_else(|| corners_of(mesh, &cells));
                return Ok(Some(Floor { cells, corners }));
            }
        }
        Ok(None)
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
        // Interfaces are one more than layers. A 2D field lies on the water, beneath ice shelves too, and so do layers
        // that are not those of the water, such as categories of ice.
        let mut entries = info.entries(layer);
        let is_wet = entries.all(|entry| match entry.dimension {
            "nVertLevels" | "nz1" => water.contains(&entry.number),
            "nVertLevelsP1" | "nz" => (water.start..=water.end).contains(&entry.number),
            _ => true,
        });
        water.is_empty() || !is_wet
    }
}

/// The layers of each of `columns` that are water, by the variables with the last and the first; `None` if no file has
/// the last.
fn water(
    sources: &Sources,
    [last, first]: [&str; 2],
    columns: usize,
    ends_at_interface: bool,
) -> Result<Option<Vec<Range<usize>>>> {
    let Some(last) = levels(sources, last, columns)? else { return Ok(None) };
    let first = levels(sources, first, columns)?.unwrap_or_else(|| vec![1; columns]);
    let end = |last: usize| if ends_at_interface { last.saturating_sub(1) } else { last };
    Ok(Some(first.iter().zip(last).map(|(first, last)| first.saturating_sub(1)..end(last)).collect()))
}

fn corners_of(mesh: &Mesh, cells: &[Range<usize>]) -> Vec<Range<usize>> {
    let corner = |corner| {
        mesh.cells_at(corner).into_iter().fold(0..usize::MAX, |water: Range<usize>, cell| {
            let here = cell.map_or(0..0, |cell| cells[cell].clone());
            water.start.max(here.start)..water.end.min(here.end)
        })
    };
    (0..mesh.corners()).map(corner).collect()
}

/// A level number for each column, from 0 (none).
fn levels(sources: &Sources, name: &str, columns: usize) -> Result<Option<Vec<usize>>> {
    let Some(found) = sources.find(name) else { return Ok(None) };
    let variable = found.variable;
    if variable.kind != Kind::Integer || !matches!(variable.after_time(), [only] if only.len == columns) {
        let expected = format_args!("{name} of integer over the {columns} columns of the mesh");
        return Err(found.unexpected(ErrorKind::Field, expected));
    }
    let max = max_levels(sources)?;
    let checked = found.all_integers()?.into_iter().enumerate().map(|(column, number)| {
        usize::try_from(number).ok().filter(|&level| level <= max).ok_or_else(|| {
            let context = format!("{name} of cell {} is {number}, expected 0 to {max}", column + 1);
            found.error(ErrorKind::Field, context)
        })
    });
    checked.collect::<Result<_>>().map(Some)
}

/// The maximum number of levels of a column.
fn max_levels(sources: &Sources) -> Result<usize> {
    let levels = sources.dimension_len("nVertLevels")?.or(sources.dimension_len("nz")?);
    Ok(levels.unwrap_or(usize::MAX))
}
