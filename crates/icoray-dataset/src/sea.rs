//! Masks values of ocean models that are not water.

use crate::field::{Entry, FieldInfo, OwnedField};
use crate::floor::Floor;
use crate::mesh::{Mesh, MeshLayout};
use crate::source::SourceVariable;
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
