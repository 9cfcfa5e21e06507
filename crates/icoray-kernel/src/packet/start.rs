//! The start of a ray of a packet: its first triangle, found from that of the previous ray.
//!
//! The steps are those of [`Walk::new`] with fewer of them: a walk from triangle to triangle by the side of three
//! planes that the start lies beyond. [`Walk::new`] handles the remaining cases: both find the one column of the ray's
//! great circle in which its start is bracketed, so the result does not depend on the start of the search.

use super::frame::PacketFrame;
use super::lanes::{Entries, Mesh};
use super::tables::Tables;
use crate::counts::Counts;
use crate::leap::Ahead;
use crate::piece::Radiance;
use crate::plane::{PlaneVertex, RayLine};
use crate::signature::{BoundarySignature, EyeDistance};
use crate::trace::queue::{Clip, RowHints};
use crate::trace::{PrimaryRay, Target};
use crate::walk::{Side, Walk, enter};
use glam::DVec3;
use icoray_grid::Grid;
use icoray_grid::grid::half_edges::{half_edge, place};

/// Number of triangles after which the search is left to [`Walk::new`].
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
    pub clip: Clip<'q>,
    pub hints: RowHints,
    /// The triangle of the macrocell in which something first showed to the last ray, and the one that this ray entered.
    pub last_shown: [u32; 2],
    pub entries: Entries,
}

impl Rays<'_> {
    /// The next ray that is not clipped away and on which something may show, where it enters its first column, and the
    /// distance before which it does not leap; those before it are reported without light.
    #[inline]
    pub fn next(
        &mut self,
        frame: &PacketFrame<'_>,
        tables: &Tables,
        counts: &mut Counts,
        target: &mut Target,
    ) -> Option<(Start, Side, f64)> {
        let mut without = |number: usize, light| {
            if let Target::Light(report) = target {
                report(number, light, BoundarySignature::default());
            }
        };
        for PrimaryRay { number, eye, dir, begins_row } in &mut *self.rays {
            let hint = self.hints.get(begins_row);
            let Some(line) = self.clip.line(eye, dir) else {
                self.hints.set(begins_row, hint);
                without(number, None);
                continue;
            };
            let Some((side, next_leap)) = first_column(frame.scene.grid, tables, line, hint, &mut self.last_shown)
            else {
                counts.rays += 1;
                without(number, Some(Radiance::none()));
                continue;
            };
            self.hints.set(begins_row, place(side.half_edge).0);
            let (from_eye, surfaces) = (EyeDistance::new(eye, dir), BoundarySignature::default());
            return Some((Start { number, line, dir, from_eye, surfaces }, side, next_leap));
        }
        None
    }
}

/// The entry of a ray into its first column in which something may be visible, searched from the triangle `hint`, and
/// the distance before which it does not leap. `None` if nothing is visible.
#[inline]
fn first_column(
    grid: &Grid,
    tables: &Tables,
    line: RayLine,
    hint: u32,
    last_shown: &mut [u32; 2],
) -> Option<(Side, f64)> {
    let Some(leaps) = &tables.leaps else { return Some((side(grid, &tables.mesh, line, hint), 0.0)) };
    let Ahead::Shown { at, until, near } = leaps.ahead(&line, line.start) else { return None };
    // In the macrocell of the last ray its triangle is nearer.
    let hint = if last_shown[0] == near { last_shown[1] } else { near };
    let found = side_at(&tables.mesh, line, at, hint).unwrap_or_else(|| side(grid, &tables.mesh, line, hint));
    *last_shown = [near, place(found.half_edge).0];
    Some((found, until))
}

/// The side through which a ray enters its first column, searched from the triangle `hint`.
#[inline]
fn side(grid: &Grid, mesh: &Mesh, line: RayLine, hint: u32) -> Side {
    side_at(mesh, line, line.start, hint).unwrap_or_else(|| search_whole(grid, line, hint))
}

/// The side through which a ray enters the column that contains it at distance `t`, searched from the triangle `hint`.
#[inline]
pub(super) fn side_at(mesh: &Mesh, line: RayLine, t: f64, hint: u32) -> Option<Side> {
    let triangle = search(mesh, line.position(t), hint)?;
    let (corners, half_edge) = crossed(mesh, line, triangle)?;
    enter(line, corners, half_edge, t)
}

#[cold]
#[inline(never)]
fn search_whole(grid: &Grid, line: RayLine, hint: u32) -> Side {
    Walk::new(grid, line, hint).side()
}

/// The triangle around `target`, by visibility: moves through a side that it lies beyond.
#[inline]
fn search(mesh: &Mesh, target: DVec3, hint: u32) -> Option<u32> {
    let mut triangle = hint;
    for _ in 0..MOST_STEPS {
        let [a, b, c] = {
            let [a, b, c] = mesh.half_edges(triangle).vertices();
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
        triangle = place(mesh.half_edges(triangle).beyond(farthest)).0;
    }
    None
}

/// The vertices of a triangle that the ray's great circle crosses, those of the side of entry first, and its half-edge.
#[inline]
fn crossed(mesh: &Mesh, line: RayLine, triangle: u32) -> Option<([PlaneVertex; 3], u32)> {
    let cells = mesh.half_edges(triangle).vertices();
    let see = |cell: u32| line.plane.project(cell, mesh.direction(cell));
    let seen: [PlaneVertex; 3] = [see(cells[0]), see(cells[1]), see(cells[2])];
    let k = (0..3).find(|&k| seen[k].is_left() && !seen[(k + 1) % 3].is_left())?;
    Some(([seen[k], seen[(k + 1) % 3], seen[(k + 2) % 3]], half_edge(triangle, k)))
}
