//! All that a field's values colour in a scene, in one order: volumes, then surfaces, then isosurfaces.

use crate::coloring::{ColorRange, Coloring};
use crate::scene::Scene;
use crate::scenery::{Isosurface, Opacity, Paint};
use crate::transfer::TransferFunction;
use icoray_grid::Result;

/// Something that a field's values colour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Painting<'s> {
    /// Name of the field.
    pub field: &'s str,
    /// From values to colours.
    pub transfer: &'s TransferFunction,
    /// Colour map and opacities of the transfer function; `None` if its knots are given.
    pub coloring: Option<&'s Coloring>,
    /// The source of the opacity.
    pub opacity: OpacityOf<'s>,
    /// Whether the field has one value wherever it colours: on its own isosurface.
    pub has_one_value: bool,
}

/// The source of opacity of a coloured volume or surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum OpacityOf<'s> {
    /// The transfer function.
    Itself,
    /// Another field.
    Other(&'s Opacity),
    /// A number for all of a surface.
    Surface,
}

impl Scene {
    /// All that is coloured by a field's values, the first volume first.
    pub fn paintings(&self) -> Vec<Painting<'_>> {
        let volumes = self.volumes.iter().map(|volume| Painting {
            field: &volume.field,
            transfer: &volume.transfer,
            coloring: volume.coloring.as_ref(),
            opacity: volume.opacity.as_ref().map_or(OpacityOf::Itself, OpacityOf::Other),
            has_one_value: false,
        });
        let isosurfaces = self.scenery.isosurfaces.iter().map(|surface| (&surface.paint, Some(surface.field.as_str())));
        let surfaces = self.scenery.surfaces.iter().map(|surface| (&surface.paint, None));
        let paints = surfaces.chain(isosurfaces).filter_map(|(paint, isosurface_of)| match paint {
            Paint::Plain(_) => None,
            Paint::Field { field, transfer, coloring, by_cell: _ } => Some(Painting {
                field,
                transfer,
                coloring: coloring.as_ref(),
                opacity: OpacityOf::Surface,
                has_one_value: isosurface_of == Some(field),
            }),
        });
        volumes.chain(paints).collect()
    }

    /// The colour maps and isosurfaces that lie off the values of their field, of which `values` has the least and the
    /// greatest by name, as sentences.
    pub fn off_values(&self, values: &[(String, [f64; 2])]) -> Vec<String> {
        let of = |field: &str| values.iter().find(|(known, _)| known == field).map(|(_, range)| *range);
        // Rounded to f32, which sentences show with fewer digits.
        let lies_outside = |field: &str, [from, to]: [f64; 2]| {
            of(field).filter(|[low, high]| to < *low || *high < from).map(|range| range.map(|end| end as f32))
        };
        let maps = self.paintings().into_iter().filter_map(|Painting { field, transfer, coloring, .. }| {
            let ends @ [from, to] = coloring.and_then(Coloring::fixed).unwrap_or(transfer.range());
            let [low, high] =
                lies_outside(field, ends).filter(|_| transfer.knots.iter().any(|k| k.extinction > 0.0))?;
            Some(format!("{field} is {low} to {high}: colours from {from} to {to} show no difference of it"))
        });
        let surfaces = self.scenery.isosurfaces.iter().filter_map(|Isosurface { field, value, .. }| {
            let [low, high] = lies_outside(field, [*value; 2])?;
            Some(format!("{field} is {low} to {high}: it has no isosurface of {value}"))
        });
        maps.chain(surfaces).collect()
    }

    /// The scene with each of its colour maps over the range that `find` gives for it and its field, whose ends the
    /// map's scale admits, the lower first; `None` where it gives none for any.
    ///
    /// # Errors
    /// The first of `find`'s.
    pub fn over_each(&self, mut find: impl FnMut(&str, &Coloring) -> Result<Option<[f64; 2]>>) -> Result<Option<Self>> {
        let paintings = self.paintings();
        let ranges = paintings.iter().map(|p| p.coloring.map_or(Ok(None), |coloring| find(p.field, coloring)));
        let ranges = ranges.collect::<Result<Vec<_>>>()?;
        if ranges.iter().all(Option::is_none) {
            return Ok(None);
        }
        let mut scene = self.clone();
        let volumes = scene.volumes.iter_mut().map(|volume| (&mut volume.transfer, &mut volume.coloring));
        let paints = scene.scenery.paints_mut().filter_map(|paint| match paint {
            Paint::Plain(_) => None,
            Paint::Field { transfer, coloring, .. } => Some((transfer, coloring)),
        });
        for ((transfer, coloring), range) in volumes.chain(paints).zip(ranges) {
            if let (Some(range), Some(coloring)) = (range, coloring) {
                *transfer = coloring.transfer(range);
                coloring.range = ColorRange::Fixed(range);
                coloring.center = None;
            }
        }
        Ok(Some(scene))
    }
}
