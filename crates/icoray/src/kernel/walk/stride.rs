//! Many columns at a time: a walk that goes ahead, so that several rays can walk side by side.
//!
//! From one triangle to the next each step waits for tables and for one vertex's side, which no machine can guess. Rays that step in turn
//! wait together. What a step leaves behind is the side that it crossed; where and how high the ray crosses it is computed of several
//! sides at a time, with the numbers that the plain walk has.

use super::{Column, Contour, End, Place, Walk, height};
use crate::grid::Grid;
use crate::kernel::plane::{Point, RayLine, Seen};
use fearless_simd::{Simd, f64x8, prelude::*};

/// Columns that are walked ahead.
pub(crate) const STEPS: usize = 8;

/// A number of each column.
type Row = [f64; STEPS];

/// A ray that is [`STEPS`] columns ahead of those that were asked for.
#[derive(Debug, Clone)]
pub(crate) struct Stride<'g, 'a> {
    grid: &'g Grid<'a>,
    line: RayLine,
    /// Where the last step led: the triangle, its cells, its side of entry and its apex.
    triangle: u32,
    cells: [u32; 3],
    /// The cell that the last step has met.
    new: u32,
    left: Seen,
    right: Seen,
    apex: Seen,
    /// Of each column: the triangle, and the cells of its side of entry and its apex.
    triangles: [u32; STEPS],
    vertices: [[u32; 3]; STEPS],
    /// The left and the right end of each column's side of exit: x, y and q.
    sides: [[Row; 3]; 2],
    /// Whether the side of exit is that on the apex's right.
    is_left: [bool; STEPS],
    /// The crossing of that side: its place between the ends, the point, and the ray there.
    w: Row,
    x: Row,
    y: Row,
    t: Row,
    rho: Row,
    /// Of each column: 1 / height at its entry, 1 / rise.
    curvature: Row,
    scale: Row,
    /// Where the first column is entered.
    entry: End,
    /// The last column's way out, where the ray ends in it.
    exit: Option<End>,
    next: usize,
    /// Columns until the ray's end.
    ready: usize,
}

impl<'g, 'a> Stride<'g, 'a> {
    /// The columns of `walk`.
    pub fn new(walk: Walk<'g, 'a>) -> Self {
        let Walk { contour, line, .. } = walk;
        let Contour { grid, triangle, cells, left, right, apex, .. } = contour;
        let none = [0.0; STEPS];
        let mut stride = Stride {
            grid,
            line,
            triangle,
            cells,
            new: 0,
            left,
            right,
            apex,
            triangles: [0; STEPS],
            vertices: [[0; 3]; STEPS],
            sides: [[none; 3]; 2],
            is_left: [false; STEPS],
            w: none,
            x: none,
            y: none,
            t: none,
            rho: none,
            curvature: none,
            scale: none,
            entry: End { t: 0.0, rho: 0.0, weight: [0.0; 2] },
            exit: None,
            next: 0,
            ready: 0,
        };
        stride.restart(walk);
        stride
    }

    /// Begins anew with the columns of `walk`, none of which is walked yet.
    pub fn restart(&mut self, walk: Walk<'g, 'a>) {
        let Walk { contour, line, from, last: (t, rho) } = walk;
        let Contour { triangle, cells, left, right, apex, .. } = contour;
        (self.line, self.triangle, self.cells) = (line, triangle, cells);
        (self.left, self.right, self.apex) = (left, right, apex);
        let Place { point, weight } = from.unwrap_or(Place { point: line.at(line.end), weight: [0.0; 2] });
        // The first column's entry lies where the columns before it would have ended.
        (self.x[STEPS - 1], self.y[STEPS - 1]) = (point.x, point.y);
        self.entry = End { t, rho, weight };
        (self.exit, self.next, self.ready) = (None, 0, 0);
    }

    /// The number of the column that comes next, if it has been walked.
    #[inline(always)]
    pub fn next(&self) -> Option<usize> {
        (self.next < self.ready).then_some(self.next % STEPS)
    }

    /// Whether no column is left.
    #[inline(always)]
    pub fn has_ended(&self) -> bool {
        self.next >= self.ready && self.exit.is_some()
    }

    /// Walks over column number `i` of the next [`STEPS`], into the triangle behind it, at which [`Self::look`] looks then.
    #[inline(always)]
    pub fn turn(&mut self, i: usize) {
        self.triangles[i] = self.triangle;
        self.vertices[i] = [self.left.cell, self.right.cell, self.apex.cell];
        let is_left = self.apex.is_left();
        let behind = if is_left { self.left.cell } else { self.right.cell };
        let sum = |cells: [u32; 3]| cells[0].wrapping_add(cells[1]).wrapping_add(cells[2]);
        let kept = sum(self.cells).wrapping_sub(behind);
        let k = usize::from(self.cells[0] != behind) + usize::from(self.cells[2] == behind);
        self.is_left[i] = is_left;
        self.triangle = self.grid.across(self.triangle, k);
        self.cells = self.grid.triangle(self.triangle);
        // The two triangles share two cells, so the sums differ by the new one.
        self.new = sum(self.cells).wrapping_sub(kept);
    }

    /// Sees the vertex that is new behind column number `i`.
    #[inline(always)]
    pub fn look(&mut self, i: usize) {
        let is_left = self.is_left[i];
        self.left = if is_left { self.apex } else { self.left };
        self.right = if is_left { self.right } else { self.apex };
        for (side, Seen { x, y, q, .. }) in self.sides.iter_mut().zip([self.left, self.right]) {
            (side[0][i], side[1][i], side[2][i]) = (x, y, q);
        }
        self.apex = self.line.plane.see(self.new, self.grid.direction(self.new));
    }

    /// When [`STEPS`] columns have been walked over: where the sides are crossed, until the ray's end.
    #[inline(always)]
    pub fn measure<V: Simd>(&mut self, simd: V) {
        if self.ready > 0 {
            self.entry = self.way_out(STEPS - 1);
        }
        let before =
            Place { point: Point::new(self.x[STEPS - 1], self.y[STEPS - 1]), weight: self.entry.weight };
        let line = self.line;
        let load = |row: &Row| f64x8::from_slice(simd, row);
        let all = |number: f64| f64x8::splat(simd, number);
        let [[left_x, left_y, left_q], [right_x, right_y, right_q]] = &self.sides;
        let w = load(left_q) / (load(left_q) - load(right_q));
        let x = load(left_x) + w * (load(right_x) - load(left_x));
        let y = load(left_y) + w * (load(right_y) - load(left_y));
        let is_behind = (all(line.b) * y - all(line.end) * x).simd_ge(all(0.0)).to_bitmask();
        (all(line.b) * y / x).store_slice(&mut self.t);
        self.order();
        let rho = (all(line.b) * x + load(&self.t) * y) / (x * x + y * y);
        w.store_slice(&mut self.w);
        x.store_slice(&mut self.x);
        y.store_slice(&mut self.y);
        rho.store_slice(&mut self.rho);
        let mut entry = [self.entry.rho; STEPS];
        entry[1..].copy_from_slice(&self.rho[..STEPS - 1]);
        (all(1.0) / load(&entry)).store_slice(&mut self.curvature);
        (all(1.0) / (rho - load(&entry))).store_slice(&mut self.scale);
        (self.next, self.ready, self.exit) = (0, STEPS, None);
        if is_behind != 0 {
            self.end(is_behind.trailing_zeros() as usize, before);
        }
    }

    /// Distances do not fall.
    #[inline(always)]
    fn order(&mut self) {
        let mut before = self.entry.t;
        let mut is_ordered = true;
        for t in &self.t {
            is_ordered &= (*t >= before) & (*t <= self.line.end);
            before = *t;
        }
        if !is_ordered {
            before = self.entry.t;
            for t in &mut self.t {
                // max and min let a NaN of 0/0 (a ray through the centre) pass by.
                *t = t.max(before).min(self.line.end);
                before = *t;
            }
        }
    }

    /// The ray ends in column `i`; `before` is where the first column was entered.
    #[inline(never)]
    fn end(&mut self, i: usize, before: Place) {
        let place = |i: usize, weight| Place { point: Point::new(self.x[i], self.y[i]), weight };
        let entry = if i == 0 { before } else { place(i - 1, [self.w[i - 1], 0.0]) };
        let end = self.line.at(self.line.end);
        let Place { point, weight } = entry.clip(place(i, self.weight_out(i)), end);
        let exit = End { t: self.line.end, rho: height(end, point), weight };
        self.rho[i] = exit.rho;
        (self.exit, self.ready) = (Some(exit), i + 1);
    }

    #[inline(always)]
    fn weight_out(&self, i: usize) -> [f64; 2] {
        let w = self.w[i];
        if self.is_left[i] { [w, 1.0 - w] } else { [0.0, w] }
    }

    /// The end of column `i` as the next one's entry.
    #[inline(always)]
    fn way_out(&self, i: usize) -> End {
        End { t: self.t[i], rho: self.rho[i], weight: [self.w[i], 0.0] }
    }

    /// The triangles of the columns.
    #[inline(always)]
    pub fn triangles(&self) -> [u32; STEPS] {
        self.triangles
    }

    /// The height at which the first column is entered.
    #[inline(always)]
    pub fn height_in(&self) -> f64 {
        self.entry.rho
    }

    /// The heights at which the columns are left.
    #[inline(always)]
    pub fn heights_out(&self) -> &[f64; STEPS] {
        &self.rho
    }

    /// The column that comes next, as [`Walk::next_column`] has it.
    #[inline(always)]
    pub fn column(&self) -> Column {
        let i = self.next % STEPS;
        let entry = if i == 0 { self.entry } else { self.way_out(i - 1) };
        match self.exit {
            Some(exit) if self.next + 1 == self.ready => Column::new(self.vertices[i], entry, exit),
            _ => Column {
                cells: self.vertices[i],
                entry,
                exit: End { weight: self.weight_out(i), ..self.way_out(i) },
                curvature: self.curvature[i],
                scale: self.scale[i],
            },
        }
    }

    /// Goes on to the next column.
    #[inline(always)]
    pub fn pass(&mut self) {
        self.next += 1;
    }
}
