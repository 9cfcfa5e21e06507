//! Several rays that walk together, a column each at a time: [`Walk`] in the machine's vectors, with the numbers that it has.
//!
//! From one triangle to the next a ray waits for tables and for one vertex's side, which no machine can guess. Rays that step
//! together wait together.

use super::{Contour, End, Place, Walk, height};
use crate::grid::Grid;
use crate::kernel::plane::{Plane, Point, RayLine, Seen};
use glam::DVec3;

/// Rays of a pack.
pub(crate) const LANES: usize = 16;

/// Something of each ray.
pub(crate) type Row<X> = [X; LANES];

/// The numbers of the rays whose bits are set.
#[inline(always)]
pub(crate) fn lanes(mut bits: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = (bits != 0).then_some(bits.trailing_zeros() as usize % LANES);
        bits &= bits.wrapping_sub(1);
        lane
    })
}

/// A vertex of each ray, as [`Seen`].
#[derive(Debug, Clone, Copy)]
struct Vertices {
    cell: Row<u32>,
    x: Row<f64>,
    y: Row<f64>,
    q: Row<f64>,
}

impl Vertices {
    const NONE: Self = Vertices { cell: [0; LANES], x: [0.0; LANES], y: [0.0; LANES], q: [0.0; LANES] };

    fn set(&mut self, lane: usize, seen: &Seen) {
        let Seen { cell, x, y, q } = *seen;
        (self.cell[lane], self.x[lane], self.y[lane], self.q[lane]) = (cell, x, y, q);
    }

    /// These of `self` where `takes` is set, those of `other` where it is not.
    #[inline(always)]
    fn or(&self, other: &Self, takes: &Row<bool>) -> Self {
        let mut all = *other;
        for i in 0..LANES {
            all.cell[i] = if takes[i] { self.cell[i] } else { other.cell[i] };
            all.x[i] = if takes[i] { self.x[i] } else { other.x[i] };
            all.y[i] = if takes[i] { self.y[i] } else { other.y[i] };
            all.q[i] = if takes[i] { self.q[i] } else { other.q[i] };
        }
        all
    }
}

/// One end of each ray's way through a column, as [`End`].
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ends {
    pub t: Row<f64>,
    pub rho: Row<f64>,
    pub weight: [Row<f64>; 2],
}

impl Ends {
    const NONE: Self = Ends { t: [0.0; LANES], rho: [0.0; LANES], weight: [[0.0; LANES]; 2] };

    fn set(&mut self, lane: usize, end: End) {
        (self.t[lane], self.rho[lane]) = (end.t, end.rho);
        (self.weight[0][lane], self.weight[1][lane]) = (end.weight[0], end.weight[1]);
    }
}

/// A column of each ray, as [`super::Column`].
#[derive(Debug, Clone, Copy)]
pub(crate) struct Columns {
    pub triangles: Row<u32>,
    pub cells: [Row<u32>; 3],
    pub entry: Ends,
    pub exit: Ends,
    /// 1 / height at the entry.
    pub curvature: Row<f64>,
    /// 1 / rise from the entry to the exit.
    pub scale: Row<f64>,
    /// Bits of the rays that end in theirs.
    pub last: u32,
}

/// Rays that walk together.
#[derive(Debug)]
pub(crate) struct Pack<'g, 'a> {
    grid: &'g Grid<'a>,
    lines: Row<RayLine>,
    /// The axes x, y and q of each ray's plane, component by component; the ray's distance from the centre, and its end.
    axes: [[Row<f64>; 3]; 3],
    b: Row<f64>,
    end: Row<f64>,
    /// Where each ray is: the triangle, its cells, its side of entry and its apex.
    triangles: Row<u32>,
    cells: Row<[u32; 3]>,
    left: Vertices,
    right: Vertices,
    apex: Vertices,
    /// The point of entry.
    x: Row<f64>,
    y: Row<f64>,
    entry: Ends,
}

impl<'g, 'a> Pack<'g, 'a> {
    /// A pack without rays.
    pub fn new(grid: &'g Grid<'a>) -> Self {
        let plane = Plane { x: DVec3::X, y: DVec3::Y, q: DVec3::Z };
        let zero = [0.0; LANES];
        Pack {
            grid,
            lines: [RayLine { plane, b: 0.0, start: 0.0, end: 0.0 }; LANES],
            axes: [[zero; 3]; 3],
            b: zero,
            end: zero,
            triangles: [0; LANES],
            cells: [[0; 3]; LANES],
            left: Vertices::NONE,
            right: Vertices::NONE,
            apex: Vertices::NONE,
            x: zero,
            y: zero,
            entry: Ends::NONE,
        }
    }

    /// Puts the ray of `walk` into a lane.
    pub fn set(&mut self, lane: usize, walk: &Walk) {
        let Walk { contour: Contour { triangle, cells, left, right, apex, .. }, line, from, last: (t, rho) } =
            walk;
        let Plane { x, y, q } = line.plane;
        for (axis, rows) in [x, y, q].iter().zip(&mut self.axes) {
            rows.iter_mut().zip(axis.to_array()).for_each(|(row, component)| row[lane] = component);
        }
        (self.lines[lane], self.b[lane], self.end[lane]) = (*line, line.b, line.end);
        (self.triangles[lane], self.cells[lane]) = (*triangle, *cells);
        self.left.set(lane, left);
        self.right.set(lane, right);
        self.apex.set(lane, apex);
        let Place { point, weight } = from.unwrap_or(Place { point: line.at(line.end), weight: [0.0; 2] });
        (self.x[lane], self.y[lane]) = (point.x, point.y);
        self.entry.set(lane, End { t: *t, rho: *rho, weight });
    }

    /// The ray in a lane.
    pub fn line(&self, lane: usize) -> &RayLine {
        &self.lines[lane]
    }

    /// The height at which the ray in a lane enters its next column.
    pub fn height(&self, lane: usize) -> f64 {
        self.entry.rho[lane]
    }

    /// Takes those rays whose bits are in `walking` over their next columns. Of others, columns mean nothing.
    #[inline(always)]
    pub fn step(&mut self, walking: u32) -> Columns {
        let mut is_left = [false; LANES];
        for i in 0..LANES {
            is_left[i] = self.apex.q[i] >= 0.0;
        }
        let left = self.apex.or(&self.left, &is_left);
        let right = self.right.or(&self.apex, &is_left);
        let (mut exit, mut x, mut y) = (Ends::NONE, [0.0; LANES], [0.0; LANES]);
        let mut is_last = [false; LANES];
        for i in 0..LANES {
            let w = left.q[i] / (left.q[i] - right.q[i]);
            x[i] = left.x[i] + w * (right.x[i] - left.x[i]);
            y[i] = left.y[i] + w * (right.y[i] - left.y[i]);
            is_last[i] = self.b[i] * y[i] - self.end[i] * x[i] >= 0.0;
            // max and min let a NaN of 0/0 (a ray through the centre) pass by.
            exit.t[i] = (self.b[i] * y[i] / x[i]).max(self.entry.t[i]).min(self.end[i]);
            exit.rho[i] = (self.b[i] * x[i] + exit.t[i] * y[i]) / (x[i] * x[i] + y[i] * y[i]);
            exit.weight[0][i] = if is_left[i] { w } else { 0.0 };
            exit.weight[1][i] = if is_left[i] { 1.0 - w } else { w };
        }
        let mut last = 0;
        for i in 0..LANES {
            last |= u32::from(is_last[i]) << i;
        }
        last &= walking;
        let mut columns = Columns {
            triangles: self.triangles,
            cells: [self.left.cell, self.right.cell, self.apex.cell],
            entry: self.entry,
            exit,
            curvature: [0.0; LANES],
            scale: [0.0; LANES],
            last,
        };
        for lane in lanes(last) {
            let end = self.last_exit(lane, Point::new(x[lane], y[lane]), &columns.exit);
            columns.exit.set(lane, end);
        }
        for i in 0..LANES {
            columns.curvature[i] = 1.0 / columns.entry.rho[i];
            columns.scale[i] = 1.0 / (columns.exit.rho[i] - columns.entry.rho[i]);
        }
        self.turn(walking & !last, &is_left);
        for i in 0..LANES {
            // Whichever of the two ends the apex took the place of, the other one's weight is w.
            self.entry.weight[0][i] = if is_left[i] { exit.weight[0][i] } else { exit.weight[1][i] };
            self.entry.weight[1][i] = 0.0;
        }
        (self.left, self.right, self.x, self.y) = (left, right, x, y);
        (self.entry.t, self.entry.rho) = (exit.t, exit.rho);
        columns
    }

    /// Where a ray ends in its column, of which it would leave the side of exit at `out`.
    #[cold]
    fn last_exit(&self, lane: usize, out: Point, exit: &Ends) -> End {
        let weight = |ends: &Ends| [ends.weight[0][lane], ends.weight[1][lane]];
        let entry = Place { point: Point::new(self.x[lane], self.y[lane]), weight: weight(&self.entry) };
        let line = &self.lines[lane];
        let end = line.at(line.end);
        let Place { point, weight } = entry.clip(Place { point: out, weight: weight(exit) }, end);
        End { t: line.end, rho: height(end, point), weight }
    }

    /// Into the next triangles. In two goes, each short enough for the machine to wait for several rays' tables at a time.
    #[inline(always)]
    fn turn(&mut self, walking: u32, is_left: &Row<bool>) {
        for lane in lanes(walking) {
            let behind = if is_left[lane] { self.left.cell[lane] } else { self.right.cell[lane] };
            let sum = |cells: [u32; 3]| cells[0].wrapping_add(cells[1]).wrapping_add(cells[2]);
            let cells = self.cells[lane];
            let kept = sum(cells).wrapping_sub(behind);
            let k = usize::from(cells[0] != behind) + usize::from(cells[2] == behind);
            let triangle = self.grid.across(self.triangles[lane], k);
            let cells = self.grid.triangle(triangle);
            (self.triangles[lane], self.cells[lane]) = (triangle, cells);
            // The two triangles share two cells, so the sums differ by the new one.
            self.apex.cell[lane] = sum(cells).wrapping_sub(kept);
        }
        let mut direction = [[0.0; LANES]; 3];
        for lane in lanes(walking) {
            let [x, y, z] = self.grid.direction(self.apex.cell[lane]).to_array();
            (direction[0][lane], direction[1][lane], direction[2][lane]) = (x, y, z);
        }
        let [x, y, z] = &direction;
        for ([ax, ay, az], seen) in
            self.axes.iter().zip([&mut self.apex.x, &mut self.apex.y, &mut self.apex.q])
        {
            for i in 0..LANES {
                seen[i] = x[i] * ax[i] + y[i] * ay[i] + z[i] * az[i];
            }
        }
    }
}
