//! Surfaces that a ray may meet: coloured levels with lines on them, and surfaces of one value.

use super::source::{Map, Source};
use super::wedge::{Facet, Wedge};
use crate::array::MapInline;
use crate::grid::Grid;
use crate::ground::{Painter, Sight};
use crate::kernel::piece::Light;

/// Colours of a surface.
#[derive(Debug)]
pub(crate) enum Coat {
    Plain([f64; 3]),
    By { map: Map, by_cell: bool },
}

impl Coat {
    /// The colour of a value of the field that it shows; `None` where that is missing.
    #[inline]
    pub(super) fn of_value(map: &Map, value: f64) -> Option<[f64; 3]> {
        let color = || map.span(value).color(map.normal(value)).map_inline(|c| c.max(0.0));
        value.is_finite().then(color)
    }

    /// The colour on a facet of a layer at `u`.
    #[inline]
    pub(super) fn on_layer(
        &self,
        sources: &[Source],
        grid: &Grid,
        wedge: &Wedge,
        (layer, facet): (usize, &Facet),
        u: f64,
    ) -> Option<[f64; 3]> {
        match self {
            Coat::Plain(color) => Some(*color),
            Coat::By { map, by_cell } => {
                let g = sources[map.source].at(wedge.cells, layer);
                let value = if *by_cell {
                    g[wedge.nearest(u, |cell| grid.direction(cell))]
                } else {
                    let [b, c] = facet.weights(wedge, u);
                    g[0] + (b * (g[1] - g[0]) + c * (g[2] - g[0]))
                };
                Self::of_value(map, value)
            }
        }
    }
}

/// A surface on which a field has one value.
#[derive(Debug)]
pub(crate) struct Isosurface {
    /// The number of the field.
    pub source: usize,
    pub value: f64,
    pub coat: Coat,
    pub opacity: f64,
}

/// A level with all that lies on it.
#[derive(Debug)]
pub(crate) struct Sheet {
    pub place: SheetPlace,
    /// Colours and opacities, the first in front.
    pub coats: Vec<(Coat, f64)>,
    /// Lines, in front of all of them.
    pub painter: Option<Painter>,
}

/// Where a sheet lies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum SheetPlace {
    Layer(usize),
    /// At a radius, in planet radii.
    Radius(f64),
}

impl Sheet {
    /// The light of the sheet where a ray meets it, lit by `body`: of lines, then of coats, whose colours `color` gives; and the
    /// bits of the coats that are painted there.
    #[inline]
    pub(super) fn light(
        &self,
        body: f64,
        (sight, over): (&Sight, (&Grid, u32)),
        color: impl Fn(&Coat) -> Option<[f64; 3]>,
    ) -> (Light<f64>, u32) {
        let (mut light, mut painted) = (Light::none(), 0);
        if let Some(painter) = &self.painter {
            let [r, g, b, opacity] = painter.paint(sight, Some(over));
            light.over(&Light {
                color: [r, g, b].map_inline(|c| c * body),
                ..Light::plain([0.0; 3], opacity)
            });
        }
        for (number, (coat, opacity)) in (0u32..).zip(&self.coats) {
            if let Some(color) = color(coat) {
                painted |= 1u32.rotate_left(number);
                light.over(&Light::plain(color.map_inline(|c| c * body), *opacity));
            }
        }
        (light, painted)
    }
}
