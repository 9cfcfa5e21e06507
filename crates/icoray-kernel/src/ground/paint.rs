//! The lines of a level, each pattern over the previous ones.

use super::line_map::LineMap;
use super::screen_jacobian::{ScreenJacobian, SurfaceHit, View};
use super::{CROWDED, graticule, mesh, region};
use icoray_grid::Grid;
use icoray_scene::{Level, Lines, Pattern, Scene};
use std::sync::Arc;

/// Draws the lines of one level of a scene.
#[derive(Debug)]
pub struct Painter {
    eye: View,
    lines: Vec<Painted>,
}

/// Lines, and the map of those that are not computed.
#[derive(Debug)]
struct Painted {
    lines: Lines,
    map: Option<Arc<LineMap>>,
}

/// Width of a pattern's lines.
#[derive(Debug, Clone, Copy)]
pub(super) struct LineStyle {
    /// Pixels.
    width: f64,
}

impl Painter {
    /// The painter of the lines of `scene` that lie on `level`; `None` if there are none.
    pub fn new(scene: &Scene, level: Level) -> Option<Self> {
        let eye = View::of(scene);
        let painted = |lines: &Lines| {
            let map = match &lines.pattern {
                Pattern::Coast => Some(LineMap::of_coasts(&eye)),
                Pattern::Borders => Some(LineMap::of_borders(&eye)),
                Pattern::Outlines(outlines) => Some(LineMap::of_outlines(outlines)),
                Pattern::Cells | Pattern::Triangles | Pattern::Graticule { .. } => None,
            };
            Painted { lines: lines.clone(), map }
        };
        let lines: Vec<_> = scene.scenery.lines.iter().filter(|lines| lines.on == level).map(painted).collect();
        (!lines.is_empty()).then_some(Painter { eye, lines })
    }

    /// The lines at a hit of the level: premultiplied linear RGB before lighting, and the fraction of the light from
    /// behind that they hide. `triangle` is that over which the place lies, void ones included; without it, cells and
    /// triangles are not drawn.
    pub fn paint(&self, hit: &SurfaceHit, triangle: Option<(&Grid, u32)>) -> [f64; 4] {
        ScreenJacobian::new(&self.eye, hit).map_or([0.0; 4], |jacobian| self.light(&jacobian, triangle))
    }

    pub(super) fn light(&self, jacobian: &ScreenJacobian, triangle: Option<(&Grid, u32)>) -> [f64; 4] {
        let mut light = [0.0; 4];
        for Painted { lines, map } in &self.lines {
            let pen = LineStyle { width: lines.width_px };
            let inside = lines.region.map_or(1.0, |limits| region::inside(&limits, jacobian, pen));
            if inside == 0.0 {
                continue;
            }
            let covered = match (&lines.pattern, triangle) {
                (Pattern::Graticule { spacing_deg }, _) => graticule::covered(*spacing_deg, jacobian, pen),
                (Pattern::Coast | Pattern::Borders | Pattern::Outlines(_), _) => {
                    map.as_ref().map_or(0.0, |map| covered(map, jacobian, pen))
                }
                (Pattern::Cells, Some((grid, triangle))) => mesh::cells(grid, triangle, jacobian, pen),
                (Pattern::Triangles, Some((grid, triangle))) => mesh::triangles(grid, triangle, jacobian, pen),
                (Pattern::Cells | Pattern::Triangles, None) => 0.0,
            };
            let part = lines.opacity * inside * covered;
            let [r, g, b] = lines.color;
            light = [0, 1, 2, 3].map(|k| part * [r, g, b, 1.0][k] + (1.0 - part) * light[k]);
        }
        light
    }
}

impl LineStyle {
    /// Pixels from a line's middle to its outer edge.
    pub fn reach(self) -> f64 {
        0.5 * self.width + 0.5
    }

    /// The fraction of a pixel that a line covers whose middle is `distance` pixels from the pixel's.
    pub fn covers(self, distance: f64) -> f64 {
        (self.reach() - distance).min(self.width).clamp(0.0, 1.0)
    }

    /// Opacity of lines that are `gap` pixels apart.
    pub fn shows(self, gap: f64) -> f64 {
        ((gap / self.width.max(1.0) - 1.0) / (CROWDED - 1.0)).clamp(0.0, 1.0)
    }
}

fn covered(map: &LineMap, jacobian: &ScreenJacobian, pen: LineStyle) -> f64 {
    /// Distance of lines in degrees at which they are worth distinguishing.
    const APART: f64 = 5.0;
    let shown = pen.shows(APART.to_radians() * jacobian.min_stretch());
    if shown == 0.0 {
        return 0.0;
    }
    // Farther lines are not shown.
    let distance = map.distance(jacobian, pen.reach(), 2.0 * APART);
    shown * distance.map_or(0.0, |distance| pen.covers(distance))
}
