//! The queue of rays to be traced.

use crate::owned_region::OwnedRegion;
use crate::plane::RayLine;
use crate::walk::Walk;
use glam::DVec3;
use icoray_grid::Grid;

/// A ray to be traced.
#[derive(Debug, Clone, Copy)]
pub struct PrimaryRay {
    /// Number of the ray in the report of its light.
    pub number: usize,
    /// The eye, in planet radii from the planet's centre.
    pub eye: DVec3,
    /// Unit direction.
    pub dir: DVec3,
    /// Whether the ray begins a row of pixels: its first triangle is searched from that of the row before.
    pub begins_row: bool,
}

/// The part of space in which rays are traced.
#[derive(Clone, Copy)]
pub(crate) struct Clip<'o> {
    /// Radius of the sphere to which rays are clipped.
    pub outer: f64,
    /// A region that rays must approach, and the inner radius of its columns.
    pub region: Option<(&'o OwnedRegion<'o>, f64)>,
}

impl Clip<'_> {
    /// The ray from `eye` along `dir`, if it passes through this space.
    #[inline]
    pub fn line(&self, eye: DVec3, dir: DVec3) -> Option<RayLine> {
        let is_near = |line: &RayLine| self.region.is_none_or(|(own, inner)| own.is_near(line, inner, self.outer));
        RayLine::new(eye, dir, self.outer).filter(is_near)
    }
}

/// The triangles from which the first triangles of rays are searched: that of the last ray, and that of the first ray
/// of its row.
pub(crate) struct RowHints {
    last: u32,
    row: u32,
}

impl RowHints {
    #[inline]
    pub fn new(grid: &Grid) -> Self {
        let start = grid.nearest_valid_triangle(0);
        RowHints { last: start, row: start }
    }

    /// The triangle from which the first triangle of a ray is searched.
    #[inline]
    pub fn get(&self, begins_row: bool) -> u32 {
        if begins_row { self.row } else { self.last }
    }

    /// Sets the first triangle of a ray; for one that is clipped away, [`Self::get`].
    #[inline]
    pub fn set(&mut self, begins_row: bool, triangle: u32) {
        self.last = triangle;
        if begins_row {
            self.row = triangle;
        }
    }
}

/// Rays, each with a walk whose first triangle is searched from that of the ray before it.
pub(crate) struct Queue<'q, 'g, 'a> {
    grid: &'g Grid<'a>,
    clip: Clip<'q>,
    rays: &'q mut dyn Iterator<Item = PrimaryRay>,
    hints: RowHints,
}

impl<'q, 'g, 'a> Queue<'q, 'g, 'a> {
    #[inline]
    pub fn new(grid: &'g Grid<'a>, clip: Clip<'q>, rays: &'q mut dyn Iterator<Item = PrimaryRay>) -> Self {
        Queue { grid, clip, rays, hints: RowHints::new(grid) }
    }

    /// The next ray that is not clipped away; `misses` receives the numbers of those before it that are.
    #[inline]
    pub fn next(&mut self, mut misses: impl FnMut(usize)) -> Option<(PrimaryRay, RayLine, Walk<'g, 'a>)> {
        for start in &mut *self.rays {
            let from = self.hints.get(start.begins_row);
            let line = self.clip.line(start.eye, start.dir);
            let walk = line.map(|line| (line, Walk::new(self.grid, line, from)));
            self.hints.set(start.begins_row, walk.as_ref().map_or(from, |(_, walk)| walk.triangle()));
            match walk {
                Some((line, walk)) => return Some((start, line, walk)),
                None => misses(start.number),
            }
        }
        None
    }
}
