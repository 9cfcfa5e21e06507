//! Many columns at a time: a [`Walk`] that goes ahead, so that several rays can walk side by side.
//!
//! From one triangle to the next each step waits for tables and for one vertex's side, which no machine can guess. Rays that step in turn
//! wait together. What a step leaves behind is where the sides are: places, heights and weights are computed of that, with
//! the numbers that the plain walk has, and only where somebody asks.

use super::{Column, Contour, Crossing, End, Place, Walk, height};
use crate::grid::Grid;
use crate::kernel::plane::{Point, RayLine, Seen};

/// Columns that are walked ahead.
pub(crate) const STEPS: usize = 16;

/// A ray that is [`STEPS`] columns ahead of those that were asked for.
#[derive(Debug, Clone)]
pub(crate) struct Stride<'g, 'a> {
    walk: Walk<'g, 'a>,
    /// The triangle behind the last step, its cells, and where in `seen` the ends of its side of entry are.
    triangle: u32,
    cells: [u32; 3],
    left: usize,
    right: usize,
    /// The vertices met: the first side's, and each column's apex.
    seen: [Seen; STEPS + 3],
    /// Of each column.
    triangles: [u32; STEPS],
    /// The ends of each column's side of entry, and of the last one's side of exit.
    sides: [[u8; 2]; STEPS + 1],
    next: usize,
}

impl<'g, 'a> Stride<'g, 'a> {
    /// The columns of `walk`.
    pub fn new(walk: Walk<'g, 'a>) -> Self {
        let none = Seen { cell: 0, x: 0.0, y: 0.0, q: 0.0 };
        let mut stride = Stride {
            triangle: 0,
            cells: [0; 3],
            left: 0,
            right: 1,
            seen: [none; STEPS + 3],
            triangles: [0; STEPS],
            sides: [[0; 2]; STEPS + 1],
            next: 0,
            walk: walk.clone(),
        };
        stride.restart(walk);
        stride
    }

    /// Begins anew with the columns of `walk`.
    pub fn restart(&mut self, walk: Walk<'g, 'a>) {
        let Contour { triangle, cells, left, right, apex, .. } = walk.contour;
        (self.triangle, self.cells) = (triangle, cells);
        (self.left, self.right) = (0, 1);
        (self.seen[0], self.seen[1], self.seen[STEPS + 2]) = (left, right, apex);
        self.next = STEPS;
        self.walk = walk;
    }

    /// Makes ready for [`STEPS`] calls of [`Self::step`].
    pub fn begin(&mut self) {
        let [left, right, apex] = [self.left, self.right, STEPS + 2].map(|i| self.seen[i]);
        (self.seen[0], self.seen[1], self.seen[2]) = (left, right, apex);
        (self.left, self.right) = (0, 1);
        self.sides[0] = [0, 1];
        self.next = 0;
    }

    /// Walks over column number `i` of the next [`STEPS`].
    #[inline(always)]
    pub fn step(&mut self, i: usize) {
        let grid: &'g Grid<'a> = self.walk.contour.grid;
        let apex = i + 2;
        self.triangles[i] = self.triangle;
        let is_left = self.seen[apex].is_left();
        let behind = self.seen[if is_left { self.left } else { self.right }].cell;
        let sum = |cells: [u32; 3]| cells[0].wrapping_add(cells[1]).wrapping_add(cells[2]);
        let kept = sum(self.cells).wrapping_sub(behind);
        let k = usize::from(self.cells[0] != behind) + usize::from(self.cells[2] == behind);
        self.triangle = grid.across(self.triangle, k);
        self.cells = grid.triangle(self.triangle);
        let new = sum(self.cells).wrapping_sub(kept);
        self.seen[apex + 1] = self.walk.contour.plane.see(new, grid.direction(new));
        self.left = if is_left { apex } else { self.left };
        self.right = if is_left { self.right } else { apex };
        self.sides[i + 1] = [self.left as u8, self.right as u8];
    }

    /// The triangles of the columns that are still to be asked for.
    #[inline(always)]
    pub fn ahead(&self) -> &[u32] {
        &self.triangles[self.next.min(STEPS)..]
    }

    #[inline(always)]
    fn crossing(&self, i: usize) -> Crossing {
        let [left, right] = self.sides[i].map(|end| &self.seen[end as usize]);
        Crossing::between(left, right)
    }

    /// The next column, as [`Walk::next_column`] has it; `None` behind the ray's end.
    #[inline(always)]
    pub fn next_column(&mut self) -> Option<Column> {
        let entry = self.walk.from.take()?;
        let (line, i) = (&self.walk.line, self.next);
        let [left, right] = self.sides[i].map(|end| self.seen[end as usize].cell);
        let apex = &self.seen[i + 2];
        let Crossing { point, w } = self.crossing(i + 1);
        let weight = if apex.is_left() { [w, 1.0 - w] } else { [0.0, w] };
        let mut exit = Place { point, weight };
        let end = line.at(line.end);
        let is_last = end.cross(point) >= 0.0;
        if is_last {
            exit = self.walk.clip(entry, exit, end);
        }
        let (t0, rho0) = self.walk.last;
        let t1 = if is_last { line.end } else { distance(line, exit.point, t0) };
        let rho1 = height(line.at(t1), exit.point);
        let cells = [left, right, apex.cell];
        self.walk.last = (t1, rho1);
        if !is_last {
            self.walk.from = Some(Place { point, weight: [w, 0.0] });
        }
        self.next = i + 1;
        let (entry, exit) =
            (End { t: t0, rho: rho0, weight: entry.weight }, End { t: t1, rho: rho1, weight: exit.weight });
        Some(Column { cells, entry, exit })
    }

    /// The way over the next `columns`, unless the ray ends there.
    #[inline(always)]
    pub fn way(&self, columns: usize) -> Option<Way> {
        let line = &self.walk.line;
        let Crossing { point, w } = self.crossing(self.next + columns);
        if self.walk.from.is_none() || line.at(line.end).cross(point) >= 0.0 {
            return None;
        }
        let t0 = self.walk.last.0;
        let t1 = distance(line, point, t0);
        let square = |t: f64| line.b * line.b + t * t;
        let lowest = square(0.0f64.clamp(t0, t1)).sqrt() * (1.0 - SLACK);
        let highest = square(t0).max(square(t1)).sqrt() * (1.0 + SLACK);
        Some(Way { columns, place: Place { point, weight: [w, 0.0] }, t: t1, lowest, highest })
    }

    /// Passes columns without looking at them; gives the height behind them.
    #[inline(always)]
    pub fn leap(&mut self, way: &Way) -> f64 {
        let rho = height(self.walk.line.at(way.t), way.place.point);
        self.walk.last = (way.t, rho);
        self.walk.from = Some(way.place);
        self.next += way.columns;
        rho
    }
}

/// A ray's way over some columns.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Way {
    pub columns: usize,
    /// Its end, on the contour and along the ray.
    place: Place,
    t: f64,
    /// How near to the centre it comes and how far from it.
    pub lowest: f64,
    pub highest: f64,
}

/// More than rounding does to a height.
const SLACK: f64 = 1e-9;

/// How far along the line the direction of `point` is met, not before `t0`: max and min let a NaN of 0/0 (a ray through the
/// centre) pass by.
#[inline(always)]
fn distance(line: &RayLine, point: Point, t0: f64) -> f64 {
    (line.b * point.y / point.x).max(t0).min(line.end)
}
