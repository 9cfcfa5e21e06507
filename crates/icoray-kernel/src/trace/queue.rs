//! The queue of rays to be traced.

use crate::plane::RayLine;
use crate::walk::Walk;
use glam::DVec3;
use icoray_grid::Grid;

/// A ray to be traced.
#[derive(Debug, Clone, Copy)]
pub struct PrimaryRay {
    /// Number of the ray, by which its light is reported.
    pub number: usize,
    /// The eye, in planet radii from the planet's centre.
    pub eye: DVec3,
    /// Unit direction.
    pub dir: DVec3,
    /// Whether the ray begins a row of pixels: its first triangle is searched from that of the row before.
    pub begins_row: bool,
}

/// Rays, each with a walk whose first triangle is searched from that of the ray before it.
pub(crate) struct Queue<'q, 'g, 'a> {
    grid: &'g Grid<'a>,
    /// Radius of the sphere to which rays are clipped.
    outer: f64,
    rays: &'q mut dyn Iterator<Item = PrimaryRay>,
    /// The first triangle of the last ray, and of the first ray of its row.
    hint: u32,
    row_hint: u32,
}

impl<'q, 'g, 'a> Queue<'q, 'g, 'a> {
    #[inline]
    pub fn new(grid: &'g Grid<'a>, outer: f64, rays: &'q mut dyn Iterator<Item = PrimaryRay>) -> Self {
        Queue { grid, outer, rays, hint: 0, row_hint: 0 }
    }

    /// The next ray that meets the sphere; `misses` receives the numbers of those before it that do not.
    #[inline]
    pub fn next(&mut self, mut misses: impl FnMut(usize)) -> Option<(PrimaryRay, RayLine, Walk<'g, 'a>)> {
        for start in &mut *self.rays {
            let from = if start.begins_row { self.row_hint } else { self.hint };
            let line = RayLine::new(start.eye, start.dir, self.outer);
            let walk = line.map(|line| (line, Walk::new(self.grid, line, from)));
            self.hint = walk.as_ref().map_or(from, |(_, walk)| walk.triangle());
            if start.begins_row {
                self.row_hint = self.hint;
            }
            match walk {
                Some((line, walk)) => return Some((start, line, walk)),
                None => misses(start.number),
            }
        }
        None
    }
}
