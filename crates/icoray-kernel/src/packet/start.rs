//! Where a ray of a packet begins: its first triangle, found from that of the ray before.
//!
//! The steps are those of [`Walk::new`] with fewer of them: a walk from triangle to triangle by the side of three planes
//! that the start lies beyond. What that does not settle, [`Walk::new`] does: both find the one column of the ray's
//! great circle in which its start is bracketed, so that it does not matter from where it was searched.

use super::lanes::{Entries, Mesh};
use crate::plane::{PlaneVertex, RayLine};
use crate::signature::{BoundarySignature, EyeDistance};
use crate::single_volume::SingleVolumeTracer;
use crate::trace::queue::RowHints;
use crate::trace::{PrimaryRay, Report};
use crate::walk::{Side, Walk, enter};
use glam::DVec3;
use icoray_grid::Grid;
use icoray_grid::grid::half_edges::half_edge::{APEX, NEXT};

/// Triangles after which the search is left to [`Walk::new`].
const MOST_STEPS: usize = 40;

/// The ray in a lane.
#[derive(Clone, Copy)]
pub(super) struct Start {
    pub number: usize,
    pub line: RayLine,
    pub dir: DVec3,
    pub from_eye: EyeDistance,
    /// The surfaces that the ray has met.
    pub surfaces: BoundarySignature,
}

/// Rays that are still to be traced.
pub(super) struct Rays<'q> {
    pub rays: &'q mut dyn Iterator<Item = PrimaryRay>,
    pub hints: RowHints,
    pub entries: Entries,
}

impl Rays<'_> {
    /// The next ray that meets the shell; those before it are reported without light.
    #[inline]
    pub fn next(
        &mut self,
        tracer: &SingleVolumeTracer<'_, f32>,
        mesh: &Mesh,
        report: &mut Report,
    ) -> Option<(Start, Side)> {
        for PrimaryRay { number, eye, dir, begins_row } in &mut *self.rays {
            let hint = self.hints.get(begins_row);
            let Some(line) = RayLine::new(eye, dir, tracer.outer) else {
                self.hints.set(begins_row, hint);
                report(number, None, BoundarySignature::default());
                continue;
            };
            let side = side(tracer.grid, mesh, line, hint);
            self.hints.set(begins_row, side.half_edge / 3);
            let (from_eye, surfaces) = (EyeDistance::new(eye, dir), BoundarySignature::default());
            return Some((Start { number, line, dir, from_eye, surfaces }, side));
        }
        None
    }
}

/// The side through which a ray enters its first column, which is searched from the triangle `hint`.
#[inline]
fn side(grid: &Grid, mesh: &Mesh, line: RayLine, hint: u32) -> Side {
    let found = search(mesh, line.position(line.start), hint);
    let side = found.and_then(|found| bracketed(mesh, line, found));
    side.unwrap_or_else(|| search_whole(grid, line, hint))
}

#[cold]
#[inline(never)]
fn search_whole(grid: &Grid, line: RayLine, hint: u32) -> Side {
    Walk::new(grid, line, hint).side()
}

/// The cells of a triangle, counter-clockwise.
#[inline(always)]
fn cells_of(mesh: &Mesh, triangle: u32) -> [u32; 3] {
    let apex = |k: u32| mesh.half_edge(3 * triangle + k)[APEX];
    [apex(1), apex(2), apex(0)]
}

/// The triangle around `target`, by visibility: through a side that it lies beyond.
#[inline]
fn search(mesh: &Mesh, target: DVec3, hint: u32) -> Option<u32> {
    let mut triangle = hint;
    for _ in 0..MOST_STEPS {
        let [a, b, c] = {
            let [a, b, c] = cells_of(mesh, triangle);
            [mesh.direction(a), mesh.direction(b), mesh.direction(c)]
        };
        let sides = [b.cross(c).dot(target), c.cross(a).dot(target), a.cross(b).dot(target)];
        let mut farthest = 0;
        for k in 1..3 {
            if sides[k] < sides[farthest] {
                farthest = k;
            }
        }
        if sides[farthest] >= 0.0 {
            return Some(triangle);
        }
        // The half-edge that begins at a vertex leads, on its left, through the side opposite that vertex.
        triangle = mesh.half_edge(3 * triangle + farthest as u32)[NEXT] / 3;
    }
    None
}

/// The ray's entry into the column over `triangle`, if it begins there.
#[inline]
fn bracketed(mesh: &Mesh, line: RayLine, triangle: u32) -> Option<Side> {
    let cells = cells_of(mesh, triangle);
    let see = |cell: u32| line.plane.project(cell, mesh.direction(cell));
    let seen: [PlaneVertex; 3] = [see(cells[0]), see(cells[1]), see(cells[2])];
    let k = (0..3).find(|&k| seen[k].is_left() && !seen[(k + 1) % 3].is_left())?;
    let corners = [seen[k], seen[(k + 1) % 3], seen[(k + 2) % 3]];
    enter(line, corners, 3 * triangle + k as u32)
}
