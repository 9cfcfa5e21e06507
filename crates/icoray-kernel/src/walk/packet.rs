//! Several rays that walk together, a column each at a time: [`Walk`] in the machine's vectors, with the numbers that
//! it has.
//!
//! From one triangle to the next a ray waits for tables and for one vertex's side, which no machine can guess. Rays
//! that step together wait together.

use super::{ColumnEnd, Contour, ContourPoint, Walk, height};
use crate::plane::{Plane, PlaneVertex, Point, RayLine};
use fearless_simd::{Simd, f64x8, prelude::*};
use glam::DVec3;
use icoray_grid::Grid;

/// Rays of a packet.
pub(crate) const LANES: usize = 16;

/// Rays that one vector of f64 holds.
pub(crate) const HALF: usize = 8;

/// Something of each ray.
pub(crate) type Lanes<X> = [X; LANES];

/// The numbers of the rays whose bits are set.
#[inline(always)]
pub(crate) fn lanes(mut bits: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = (bits != 0).then_some(bits.trailing_zeros() as usize % LANES);
        bits &= bits.wrapping_sub(1);
        lane
    })
}

/// A vertex of each ray, as [`PlaneVertex`].
#[derive(Debug, Clone, Copy)]
struct Vertices {
    cell: Lanes<u32>,
    x: Lanes<f64>,
    y: Lanes<f64>,
    q: Lanes<f64>,
}

impl Vertices {
    const NONE: Self = Vertices { cell: [0; LANES], x: [0.0; LANES], y: [0.0; LANES], q: [0.0; LANES] };

    #[inline]
    fn set(&mut self, lane: usize, seen: &PlaneVertex) {
        let PlaneVertex { cell, x, y, q } = *seen;
        (self.cell[lane], self.x[lane], self.y[lane], self.q[lane]) = (cell, x, y, q);
    }
}

/// One end of each ray's way through a column, as [`ColumnEnd`].
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ends {
    pub t: Lanes<f64>,
    pub rho: Lanes<f64>,
    pub weight: [Lanes<f64>; 2],
}

impl Ends {
    const NONE: Self = Ends { t: [0.0; LANES], rho: [0.0; LANES], weight: [[0.0; LANES]; 2] };

    #[inline]
    fn set(&mut self, lane: usize, end: ColumnEnd) {
        (self.t[lane], self.rho[lane]) = (end.t, end.rho);
        (self.weight[0][lane], self.weight[1][lane]) = (end.weight[0], end.weight[1]);
    }
}

/// A column of each ray, as [`super::Column`].
#[derive(Debug, Clone, Copy)]
pub(crate) struct PacketColumns {
    pub triangles: Lanes<u32>,
    pub cells: [Lanes<u32>; 3],
    pub entry: Ends,
    pub exit: Ends,
    /// 1 / height at the entry.
    pub curvature: Lanes<f64>,
    /// 1 / rise from the entry to the exit.
    pub scale: Lanes<f64>,
    /// Bits of the rays that end in theirs.
    pub last: u32,
}

/// Rays that walk together.
#[derive(Debug)]
pub(crate) struct RayPacket<'g, 'a> {
    grid: &'g Grid<'a>,
    lines: Lanes<RayLine>,
    /// The axes x, y and q of each ray's plane, component by component; the ray's distance from the centre, and its
    /// end.
    axes: [[Lanes<f64>; 3]; 3],
    b: Lanes<f64>,
    end: Lanes<f64>,
    /// Where each ray is: the triangle, its cells, its side of entry and its apex.
    triangles: Lanes<u32>,
    cells: Lanes<[u32; 3]>,
    left: Vertices,
    right: Vertices,
    apex: Vertices,
    /// The point of entry.
    x: Lanes<f64>,
    y: Lanes<f64>,
    entry: Ends,
}

impl<'g, 'a> RayPacket<'g, 'a> {
    /// A packet without rays.
    #[inline]
    pub fn new(grid: &'g Grid<'a>) -> Self {
        let plane = Plane { x: DVec3::X, y: DVec3::Y, q: DVec3::Z };
        let zero = [0.0; LANES];
        RayPacket {
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
    #[inline]
    pub fn set(&mut self, lane: usize, walk: &Walk) {
        let Walk { contour: Contour { triangle, cells, left, right, apex, .. }, line, from, last: (t, rho) } = walk;
        let Plane { x, y, q } = line.plane;
        for (axis, rows) in [x, y, q].iter().zip(&mut self.axes) {
            rows.iter_mut().zip(axis.to_array()).for_each(|(row, component)| row[lane] = component);
        }
        (self.lines[lane], self.b[lane], self.end[lane]) = (*line, line.b, line.end);
        (self.triangles[lane], self.cells[lane]) = (*triangle, *cells);
        self.left.set(lane, left);
        self.right.set(lane, right);
        self.apex.set(lane, apex);
        let ContourPoint { point, weight } =
            from.unwrap_or(ContourPoint { point: line.at(line.end), weight: [0.0; 2] });
        (self.x[lane], self.y[lane]) = (point.x, point.y);
        self.entry.set(lane, ColumnEnd { t: *t, rho: *rho, weight });
    }

    /// The ray in a lane.
    #[inline]
    pub fn line(&self, lane: usize) -> &RayLine {
        &self.lines[lane]
    }

    /// The height at which the ray in a lane enters its next column.
    #[inline]
    pub fn height(&self, lane: usize) -> f64 {
        self.entry.rho[lane]
    }

    /// Takes those rays whose bits are in `walking` over their next columns. Of others, columns mean nothing.
    #[inline(always)]
    pub fn step<V: Simd>(&mut self, simd: V, walking: u32) -> PacketColumns {
        let mut columns = PacketColumns {
            triangles: self.triangles,
            cells: [self.left.cell, self.right.cell, self.apex.cell],
            entry: self.entry,
            exit: Ends::NONE,
            curvature: [0.0; LANES],
            scale: [0.0; LANES],
            last: 0,
        };
        let before = [self.x, self.y];
        let (mut on_left, mut last) = (0, 0);
        for half in [0, HALF] {
            let (left, behind_end) = self.leave(simd, half, &mut columns);
            on_left |= left << half;
            last |= behind_end << half;
        }
        columns.last = last & walking;
        for lane in lanes(columns.last) {
            let end = self.last_exit(lane, before, &columns);
            columns.exit.set(lane, end);
        }
        for half in [0, HALF] {
            let all = |number| f64x8::splat(simd, number);
            let load = |row: &Lanes<f64>| f64x8::from_slice(simd, &row[half..half + HALF]);
            let (entry, exit) = (load(&columns.entry.rho), load(&columns.exit.rho));
            (all(1.0) / entry).store_slice(&mut columns.curvature[half..half + HALF]);
            (all(1.0) / (exit - entry)).store_slice(&mut columns.scale[half..half + HALF]);
        }
        let direction = self.turn(walking & !columns.last, on_left);
        for half in [0, HALF] {
            let load = |row: &Lanes<f64>| f64x8::from_slice(simd, &row[half..half + HALF]);
            let [x, y, z] = [load(&direction[0]), load(&direction[1]), load(&direction[2])];
            let dot = |axis: &[Lanes<f64>; 3]| x * load(&axis[0]) + y * load(&axis[1]) + z * load(&axis[2]);
            dot(&self.axes[0]).store_slice(&mut self.apex.x[half..half + HALF]);
            dot(&self.axes[1]).store_slice(&mut self.apex.y[half..half + HALF]);
            dot(&self.axes[2]).store_slice(&mut self.apex.q[half..half + HALF]);
        }
        columns
    }

    /// Where half of the rays leave their columns, which becomes where they enter the next ones: the bits of those that
    /// have the apex on their left, which takes the place of that end of the side, and of those that are behind
    /// their end there.
    #[inline(always)]
    fn leave<V: Simd>(&mut self, simd: V, half: usize, columns: &mut PacketColumns) -> (u32, u32) {
        let of = half..half + HALF;
        let load = |row: &Lanes<f64>| f64x8::from_slice(simd, &row[of.clone()]);
        let put = |numbers: f64x8<V>, row: &mut Lanes<f64>| numbers.store_slice(&mut row[of.clone()]);
        let (zero, one) = (f64x8::splat(simd, 0.0), f64x8::splat(simd, 1.0));
        let (ax, ay, aq) = (load(&self.apex.x), load(&self.apex.y), load(&self.apex.q));
        let on_left = aq.simd_ge(zero);
        let lx = on_left.select(ax, load(&self.left.x));
        let ly = on_left.select(ay, load(&self.left.y));
        let lq = on_left.select(aq, load(&self.left.q));
        let rx = on_left.select(load(&self.right.x), ax);
        let ry = on_left.select(load(&self.right.y), ay);
        let rq = on_left.select(load(&self.right.q), aq);
        let w = lq / (lq - rq);
        let (x, y) = (lx + w * (rx - lx), ly + w * (ry - ly));
        let (b, end) = (load(&self.b), load(&self.end));
        let is_last = (b * y - end * x).simd_ge(zero);
        // A NaN of 0/0 (a ray through the centre) becomes the distance of the entry.
        let (t, before) = (b * y / x, load(&self.entry.t));
        let t = t.simd_gt(before).select(t, before);
        let t = t.simd_lt(end).select(t, end);
        let rho = (b * x + t * y) / (x * x + y * y);
        put(t, &mut columns.exit.t);
        put(rho, &mut columns.exit.rho);
        put(on_left.select(w, zero), &mut columns.exit.weight[0]);
        put(on_left.select(one - w, w), &mut columns.exit.weight[1]);
        let (left, right, entry) = (&mut self.left, &mut self.right, &mut self.entry);
        let [weight, no_weight] = &mut entry.weight;
        for (numbers, row) in [
            (lx, &mut left.x),
            (ly, &mut left.y),
            (lq, &mut left.q),
            (rx, &mut right.x),
            (ry, &mut right.y),
            (rq, &mut right.q),
            (x, &mut self.x),
            (y, &mut self.y),
            (t, &mut entry.t),
            (rho, &mut entry.rho),
            (w, weight),
            (zero, no_weight),
        ] {
            put(numbers, row);
        }
        (on_left.to_bitmask() as u32, is_last.to_bitmask() as u32)
    }

    /// Where a ray ends in its column, which it has entered at `x`, `y` and would leave where the next one is entered.
    #[cold]
    fn last_exit(&self, lane: usize, [x, y]: [Lanes<f64>; 2], columns: &PacketColumns) -> ColumnEnd {
        let weight = |ends: &Ends| [ends.weight[0][lane], ends.weight[1][lane]];
        let entry = ContourPoint { point: Point::new(x[lane], y[lane]), weight: weight(&columns.entry) };
        let out = Point::new(self.x[lane], self.y[lane]);
        let line = &self.lines[lane];
        let end = line.at(line.end);
        let ContourPoint { point, weight } =
            entry.clip(ContourPoint { point: out, weight: weight(&columns.exit) }, end);
        ColumnEnd { t: line.end, rho: height(end, point), weight }
    }

    /// Into the next triangles; gives the directions of the cells that are new there. In two goes, each short enough
    /// for the machine to wait for several rays' tables at a time.
    #[inline(always)]
    fn turn(&mut self, walking: u32, on_left: u32) -> [Lanes<f64>; 3] {
        for lane in lanes(walking) {
            let (left, right) = (&mut self.left.cell[lane], &mut self.right.cell[lane]);
            let behind = std::mem::replace(if on_left >> lane & 1 != 0 { left } else { right }, self.apex.cell[lane]);
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
        direction
    }
}
