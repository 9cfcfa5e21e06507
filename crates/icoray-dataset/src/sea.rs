//! The water of ocean models: arrays also hold values on land, below the sea floor and above ice shelves.

use crate::field::{Entry, FieldInfo, OwnedField};
use crate::mesh::{Mesh, MeshLayout};
use crate::source::{Kind, SourceVariable};
use crate::sources::Sources;
use icoray::{ErrorKind, Location, Result};
use std::ops::Range;

/// The water of an ocean model.
#[derive(Debug)]
pub(crate) enum Sea {
    /// The sea floor of MPAS-Ocean or FESOM.
    Floor(Floor),
    /// ICON-O's mask.
    Mask(Mask),
}

/// ICON-O's `wet_c`, 1 where a triangle's layer is water and 0 where it is land.
#[derive(Debug)]
pub(crate) struct Mask {
    columns: usize,
    layers: usize,
    /// Whether each entry is water, layer by layer.
    is_wet: Vec<bool>,
}

impl Sea {
    /// Reads the mask or sea floor; `None` if the files have neither.
    pub(crate) fn read(sources: &Sources, mesh: &Mesh) -> Result<Option<Self>> {
        if let Some(floor) = Floor::read(sources, mesh)? {
            return Ok(Some(Sea::Floor(floor)));
        }
        match mesh.layout() {
            MeshLayout::Triangles => Ok(Mask::read(sources, mesh)?.map(Sea::Mask)),
            MeshLayout::Mpas | MeshLayout::Polygons => Ok(None),
        }
    }

    /// The sea floor.
    pub(crate) fn floor(&self) -> Option<&Floor> {
        match self {
            Sea::Floor(floor) => Some(floor),
            Sea::Mask(_) => None,
        }
    }

    /// Sets values that are not water to NaN in `field`, which holds `layers` of the field `info`. A 2D field has
    /// values where a column has any water (MPAS-Ocean, FESOM) or has water in its first layer (ICON-O).
    pub(crate) fn mask_dry(&self, info: &FieldInfo, layers: Range<usize>, field: &mut OwnedField) {
        let layers = if info.is_2d() { 0..1 } else { layers };
        for column in 0..info.columns {
            for (place, layer) in layers.clone().enumerate() {
                let is_dry = match self {
                    Sea::Floor(floor) => floor.is_dry(info, column, layer),
                    Sea::Mask(mask) => mask.is_dry(info, column, layer),
                };
                if is_dry {
                    field.values.mask_at(column, place, field.fill);
                }
            }
        }
    }
}

impl Mask {
    /// Reads `wet_c` over layers and triangles, at the first time.
    fn read(sources: &Sources, mesh: &Mesh) -> Result<Option<Self>> {
        let Some(found) = sources.find("wet_c") else { return Ok(None) };
        let SourceVariable { source, variable } = found;
        let columns = mesh.corners();
        let layers = match variable.dimensions.as_slice() {
            [.., layers, cells] if variable.kind.is_number() && cells.len == columns && layers.len > 0 => layers.len,
            _ => {
                let expected = format_args!("wet_c over layers and {columns} triangles");
                return Err(found.unexpected(ErrorKind::Field, expected));
            }
        };
        let (start, mut count) = variable.whole();
        count[..variable.dimensions.len() - 2].fill(1);
        let wet = source.reals(variable, &start, &count)?;
        let is_wet = (0..layers * columns).map(|i| wet.as_reals().get(i) > 0.5).collect();
        Ok(Some(Mask { columns, layers, is_wet }))
    }

    /// An interface is water if a layer beside it is. Of a field with other layers, such as of ice, columns are dry if
    /// their first layer is. Fields at the triangles' points are not masked.
    fn is_dry(&self, info: &FieldInfo, column: usize, layer: usize) -> bool {
        let beside = info.entries(layer).find_map(|Entry { len, number, .. }| match len {
            own if own == self.layers => Some(number..=number),
            own if own == self.layers + 1 && own > 2 => Some(number.saturating_sub(1)..=number.min(self.layers - 1)),
            _ => None,
        });
        let mut beside = beside.unwrap_or(0..=0);
        info.location == Location::Corner && !beside.any(|layer| self.is_wet[layer * self.columns + column])
    }
}

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
    let max = sources.dimension_len("nVertLevels")?.or(sources.dimension_len("nz")?).unwrap_or(usize::MAX);
    let checked = found.all_integers()?.into_iter().enumerate().map(|(column, number)| {
        usize::try_from(number).ok().filter(|&level| level <= max).ok_or_else(|| {
            let context = format!("{name} of cell {} is {number}, expected 0 to {max}", column + 1);
            found.error(ErrorKind::Field, context)
        })
    });
    checked.collect::<Result<_>>().map(Some)
}
