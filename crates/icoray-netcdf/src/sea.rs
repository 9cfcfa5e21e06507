//! Which values of an ocean model are water: the others hold what is none.

use crate::field::FieldInfo;
use crate::floor::Floor;
use crate::mesh::{Convention, Mesh};
use crate::reals::OwnedReals;
use crate::source::Kind;
use crate::sources::Sources;
use icoray::{ErrorKind, Location, Result, Shape};
use std::ops::Range;

/// The water of an ocean model.
#[derive(Debug)]
pub(crate) enum Sea {
    /// MPAS-Ocean's sea floor.
    Floor(Floor),
    /// ICON-O's mask.
    Mask(Mask),
}

/// ICON-O's `wet_c`, 1 where a triangle's layer is water and 0 where it is land.
#[derive(Debug)]
pub(crate) struct Mask {
    columns: usize,
    layers: usize,
    /// Whether each is water, layer by layer.
    is_wet: Vec<bool>,
}

impl Sea {
    /// Reads what the files have of it; `None` where they tell of no sea.
    pub(crate) fn read(sources: &Sources, mesh: &Mesh) -> Result<Option<Self>> {
        match mesh.convention() {
            Convention::Mpas => Ok(Floor::read(sources, mesh)?.map(Sea::Floor)),
            Convention::Icon => Ok(Mask::read(sources, mesh)?.map(Sea::Mask)),
            Convention::Cf => Ok(None),
        }
    }

    /// The sea floor, where that is what is known.
    pub(crate) fn floor(&self) -> Option<&Floor> {
        match self {
            Sea::Floor(floor) => Some(floor),
            Sea::Mask(_) => None,
        }
    }

    /// Makes NaN of what is no water in `values`, which hold `layers` of the field. A 2D field has values where a column has
    /// any water (MPAS-Ocean), or has some in its first layer (ICON-O).
    pub(crate) fn void_dry(
        &self,
        info: &FieldInfo,
        shape: &Shape,
        layers: Range<usize>,
        values: &mut OwnedReals,
    ) {
        let layers = if info.is_2d() { 0..1 } else { layers };
        match self {
            Sea::Floor(floor) => floor.void_dry(info, shape, layers, values),
            Sea::Mask(mask) => mask.void_dry(info, shape, layers, values),
        }
    }
}

/// Makes NaN of a column's value in the layer at `place` of those that are there.
pub(crate) fn void(shape: &Shape, column: usize, place: usize, values: &mut OwnedReals) {
    let at =
        shape.offset as isize + column as isize * shape.column_stride + place as isize * shape.layer_stride;
    values.void_at(at as usize);
}

impl Mask {
    /// Reads `wet_c` over layers and triangles, of the first time where it has times.
    fn read(sources: &Sources, mesh: &Mesh) -> Result<Option<Self>> {
        let Some((source, variable)) = sources.find("wet_c") else { return Ok(None) };
        let columns = mesh.corners();
        let is_number = matches!(variable.kind, Kind::F32 | Kind::F64 | Kind::Integer);
        let layers = match variable.dimensions.as_slice() {
            [.., layers, cells] if is_number && cells.len == columns && layers.len > 0 => layers.len,
            _ => {
                let context =
                    format!("variable {variable}, expected wet_c over layers and {columns} triangles");
                return Err(source.error(ErrorKind::Field, context));
            }
        };
        let before = variable.dimensions.len() - 2;
        let (mut start, mut count) = (vec![0; before], vec![1; before]);
        start.extend([0, 0]);
        count.extend([layers, columns]);
        let wet = source.reals(variable, &start, &count)?;
        let is_wet = (0..layers * columns).map(|i| wet.as_reals().get(i) > 0.5).collect();
        Ok(Some(Mask { columns, layers, is_wet }))
    }

    fn is_wet(&self, column: usize, layer: usize) -> bool {
        self.is_wet[layer * self.columns + column]
    }

    /// An interface is water where a layer beside it is. Of a field with other layers, as of ice, columns are dry whose first
    /// layer is. Fields at the triangles' points are left as they are.
    fn void_dry(&self, info: &FieldInfo, shape: &Shape, layers: Range<usize>, values: &mut OwnedReals) {
        if info.location != Location::Corner {
            return;
        }
        let is_dry = |column: usize, layer: usize| match info.layers {
            own if own == self.layers => !self.is_wet(column, layer),
            own if own == self.layers + 1 && own > 2 => !(layer.saturating_sub(1)
                ..=layer.min(self.layers - 1))
                .any(|beside| self.is_wet(column, beside)),
            _ => !self.is_wet(column, 0),
        };
        for column in 0..self.columns {
            for (place, _) in layers.clone().enumerate().filter(|(_, layer)| is_dry(column, *layer)) {
                void(shape, column, place, values);
            }
        }
    }
}
