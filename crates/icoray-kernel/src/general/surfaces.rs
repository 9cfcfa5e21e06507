//! Surfaces that a ray may meet: coloured levels with lines on them, and surfaces of one value.

use super::source::{FieldSource, TransferMap};
use super::wedge::{Facet, Wedge};
use crate::ground::{Painter, SurfaceHit};
use crate::piece::Radiance;
use icoray_grid::Grid;
use icoray_grid::array::MapInline;

/// Colours of a surface.
#[derive(Debug)]
pub enum Material {
    /// One colour, linear RGB.
    Plain([f64; 3]),
    /// The colours of a field's values.
    By {
        /// The transfer function, of which only the colours are used.
        map: TransferMap,
        /// Whether each cell has a uniform colour.
        by_cell: bool,
    },
}

impl Material {
    /// The colour of a value of the field; `None` if it is missing.
    #[inline]
    pub(super) fn of_value(map: &TransferMap, value: f64) -> Option<[f64; 3]> {
        let color = || map.span(value).color(map.normal(value)).map_inline(|c| c.max(0.0));
        value.is_finite().then(color)
    }

    /// The colour on a facet of a layer at `u`.
    #[inline]
    pub(super) fn on_layer(
        &self,
        sources: &[FieldSource],
        grid: &Grid,
        wedge: &Wedge,
        facet: &Facet,
        u: f64,
    ) -> Option<[f64; 3]> {
        match self {
            Material::Plain(color) => Some(*color),
            Material::By { map, by_cell } => {
                let source = &sources[map.source];
                let value = match *by_cell {
                    true => source.at(wedge.cells, facet.layer)[wedge.nearest(u, |cell| grid.direction(cell))],
                    false => source.on_layer(wedge, facet, u),
                };
                Self::of_value(map, value)
            }
        }
    }
}

/// A surface on which a field has one value.
#[derive(Debug)]
pub struct Isosurface {
    /// The number of the field.
    pub source: usize,
    /// The value, in the field's units.
    pub value: f64,
    /// Its colours.
    pub material: Material,
    /// Its opacity, 0 to 1.
    pub opacity: f64,
}

/// A level with all surfaces and lines on it.
#[derive(Debug)]
pub struct SurfaceLayer {
    /// Its position.
    pub place: SurfaceHeight,
    /// Colours and opacities, the first in front.
    pub materials: Vec<(Material, f64)>,
    /// Lines, in front of all of them.
    pub painter: Option<Painter>,
}

/// The height of a surface layer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SurfaceHeight {
    /// On a layer, counted from the innermost one.
    Layer(usize),
    /// At a radius, in planet radii.
    Radius(f64),
}

impl SurfaceLayer {
    /// The light of the surface at which a ray meets it, lit by `body`: lines in front of materials, whose colours
    /// `color` returns; and the bits of the materials that are painted there.
    #[inline]
    pub(super) fn light(
        &self,
        body: f64,
        (hit, over): (&SurfaceHit, (&Grid, u32)),
        color: impl Fn(&Material) -> Option<[f64; 3]>,
    ) -> (Radiance<f64>, u32) {
        let (mut light, mut painted) = (self.lines(body, hit, over), 0);
        for (number, (material, opacity)) in (0u32..).zip(&self.materials) {
            if let Some(color) = color(material) {
                painted |= 1u32.rotate_left(number);
                light.over(&Radiance::plain(color.map_inline(|c| c * body), *opacity));
            }
        }
        (light, painted)
    }

    /// The light of the lines there.
    #[inline]
    pub(super) fn lines(&self, body: f64, hit: &SurfaceHit, over: (&Grid, u32)) -> Radiance<f64> {
        let Some(painter) = &self.painter else { return Radiance::none() };
        let [r, g, b, opacity] = painter.paint(hit, Some(over));
        Radiance { color: [r, g, b].map_inline(|c| c * body), ..Radiance::plain([0.0; 3], opacity) }
    }
}
