//! Macrocells: a coarse map of the sphere, by which rays leap over invisible columns.
//!
//! The six faces of a cube around the sphere are divided into squares, each the base of a pyramid from the centre. A
//! ray leaves a pyramid through one of four planes through the centre, so its path over the map is found without the
//! mesh. Each triangle belongs to all macrocells that it overlaps, with a margin that exceeds all rounding. An empty
//! group of 8 by 8 macrocells, or an empty face of a coarse map, is passed in one step.

use crate::array::MapInline;
use crate::grid::Grid;
use glam::DVec3;
use rayon::prelude::*;
use std::borrow::Cow;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// Mean number of triangles per macrocell.
const TRIANGLES: f64 = 24.0;
/// Macrocells along a side of a group, if a face has room for at least two.
const GROUP: u32 = 8;
/// Maximum number of macrocells along a side of a face.
const MAX_SIDE: u32 = 4096;
/// Fraction of a macrocell by which triangles are widened.
const MARGIN: f64 = 1e-3;
/// Triangles with a longer side (radians) belong to all macrocells.
const LONGEST: f64 = 0.3;
/// Triangles per parallel task.
const CHUNK: usize = 4096;

/// A division of the sphere.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CubeMap {
    /// Macrocells along a side of a face.
    side: u32,
}

/// A macrocell's position: its face, and its column and row there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Macrocell {
    /// Twice the number of the axis (x, y, z) through the face, plus one for its negative half.
    pub face: u32,
    /// Column and row on the face.
    pub at: [u32; 2],
}

impl CubeMap {
    /// The division for this number of triangles.
    #[inline]
    pub fn new(triangles: usize) -> Self {
        let side = (triangles as f64 / (6.0 * TRIANGLES)).sqrt();
        let side = (side as u32).clamp(1, MAX_SIDE);
        CubeMap { side: if side < 2 * GROUP { side } else { side - side % GROUP } }
    }

    /// The division into groups of macrocells: whole faces if these are few.
    #[inline]
    pub fn groups(&self) -> CubeMap {
        CubeMap { side: if self.side < 2 * GROUP { 1 } else { self.side / GROUP } }
    }

    /// The position of a macrocell's group.
    #[inline]
    pub fn group_of(&self, cell: Macrocell) -> Macrocell {
        let shift = if self.side < 2 * GROUP { u32::BITS - 1 } else { GROUP.ilog2() };
        Macrocell { at: cell.at.map_inline(|index| index >> shift), ..cell }
    }

    /// The position of the macrocell with this number.
    #[inline]
    fn place(&self, number: u32) -> Macrocell {
        let (row, column) = (number / self.side, number % self.side);
        Macrocell { face: row / self.side, at: [column, row % self.side] }
    }

    /// Number of macrocells.
    #[inline]
    pub fn count(&self) -> usize {
        6 * (self.side * self.side) as usize
    }

    /// Width of a macrocell in gnomonic coordinates, in which a face reaches from -1 to 1.
    #[inline]
    pub fn width(&self) -> f64 {
        2.0 / f64::from(self.side)
    }

    /// The number of a macrocell.
    #[inline]
    pub fn number(&self, Macrocell { face, at: [column, row] }: Macrocell) -> u32 {
        (face * self.side + row) * self.side + column
    }

    /// The macrocell in the direction of `place`, which is not the centre.
    #[inline]
    pub fn find(&self, place: DVec3) -> Macrocell {
        let size = place.abs();
        let axis = if size.x >= size.y && size.x >= size.z {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        let [m, u, v] = components(place, axis);
        let inverse = 1.0 / m.abs();
        let index = |u: f64| (((u * inverse + 1.0) * (0.5 * f64::from(self.side))) as u32).min(self.side - 1);
        Macrocell { face: 2 * axis + u32::from(m < 0.0), at: [index(u), index(v)] }
    }

    /// The t at which the line `from + t·along`, `t >= start`, leaves the pyramid of a macrocell; infinity if it never
    /// does.
    #[inline]
    pub fn exit(&self, cell: Macrocell, from: DVec3, along: DVec3, start: f64) -> f64 {
        let sign = if cell.face.is_multiple_of(2) { 1.0 } else { -1.0 };
        let [m0, u0, v0] = components(from, cell.face / 2);
        let [m1, u1, v1] = components(along, cell.face / 2);
        let (m0, m1, width) = (sign * m0, sign * m1, self.width());
        // The distances from the planes, d0 + t·d1, are positive inside.
        let place = |index: u32, end: f64| (f64::from(index) + end) * width - 1.0;
        let [u, v] = cell.at.map_inline(|index| [place(index, 0.0), place(index, 1.0)]);
        let d0 = [u0 - u[0] * m0, u[1] * m0 - u0, v0 - v[0] * m0, v[1] * m0 - v0];
        let d1 = [u1 - u[0] * m1, u[1] * m1 - u1, v1 - v[0] * m1, v[1] * m1 - v1];
        let mut exit = f64::INFINITY;
        for k in 0..4 {
            let t = if d1[k] < 0.0 { d0[k] / -d1[k] } else { f64::INFINITY };
            exit = if t < exit { t } else { exit };
        }
        exit.max(start)
    }

    /// The columns and rows of macrocells on a face that a triangle overlaps, first and last.
    #[inline]
    fn overlap(&self, face: u32, corners: &[DVec3; 3]) -> Option<[[u32; 2]; 2]> {
        let sign = if face.is_multiple_of(2) { 1.0 } else { -1.0 };
        let mut ends = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        for corner in corners {
            let [m, u, v] = components(*corner, face / 2);
            // A face reaches down to 1/sqrt(3), and no side is longer than LONGEST.
            if sign * m < 0.2 {
                return None;
            }
            let inverse = sign / m;
            for (ends, p) in ends.iter_mut().zip([u * inverse, v * inverse]) {
                *ends = [ends[0].min(p), ends[1].max(p)];
            }
        }
        let margin = MARGIN * self.width();
        let is_beside = ends.iter().any(|[low, high]| *high < -1.0 - margin || *low > 1.0 + margin);
        let index = |p: f64| (((p + 1.0) * (0.5 * f64::from(self.side))).max(0.0) as u32).min(self.side - 1);
        (!is_beside).then(|| ends.map_inline(|[low, high]| [index(low - margin), index(high + margin)]))
    }

    /// Calls `see` with the number of each macrocell that the triangle between these unit vectors overlaps.
    fn each(&self, corners: &[DVec3; 3], mut see: impl FnMut(u32)) {
        let [a, b, c] = *corners;
        if a.distance(b).max(b.distance(c)).max(c.distance(a)) > LONGEST {
            return (0..self.count() as u32).for_each(see);
        }
        for face in 0..6 {
            let Some([columns, rows]) = self.overlap(face, corners) else { continue };
            for row in rows[0]..=rows[1] {
                for column in columns[0]..=columns[1] {
                    see(self.number(Macrocell { face, at: [column, row] }));
                }
            }
        }
    }
}

/// The component along an axis, and the two others.
#[inline(always)]
fn components(place: DVec3, axis: u32) -> [f64; 3] {
    match axis {
        0 => [place.x, place.y, place.z],
        1 => [place.y, place.z, place.x],
        _ => [place.z, place.x, place.y],
    }
}

/// The macrocells of a grid, with those that each triangle overlaps.
#[derive(Debug)]
pub struct Macrocells<'a> {
    /// The division of the sphere.
    pub map: CubeMap,
    /// Its division into groups.
    pub groups: CubeMap,
    /// For each triangle the number of the first macrocell that it overlaps, shifted by two bits that mark whether it
    /// overlaps the next column and the next row; [`MANY`] if it overlaps others.
    of_triangle: Cow<'a, [u32]>,
    /// A triangle in each macrocell, at which searches start.
    triangle_in: Cow<'a, [u32]>,
    /// [`Grid::lowest_facet`].
    pub lowest_facet: f64,
}

/// The joined bits of all triangles that overlap a macrocell, and of those that overlap a group of them.
#[derive(Debug, Default)]
pub struct JoinedBits {
    macrocells: Vec<AtomicU32>,
    groups: Vec<u32>,
}

impl JoinedBits {
    /// Whether there are no bits.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.macrocells.is_empty()
    }

    /// Number of macrocells.
    #[inline]
    pub fn len(&self) -> usize {
        self.macrocells.len()
    }

    /// The bits of a macrocell.
    #[inline]
    pub fn of_macrocell(&self, number: u32) -> u32 {
        self.macrocells[number as usize].load(Relaxed)
    }

    /// The bits of a group of macrocells.
    #[inline]
    pub fn of_group(&self, number: u32) -> u32 {
        self.groups[number as usize]
    }

    /// Removes all, and keeps the memory.
    #[inline]
    pub fn clear(&mut self) {
        self.macrocells.clear();
        self.groups.clear();
    }

    /// Bytes of memory.
    #[inline]
    pub fn bytes(&self) -> usize {
        4 * (self.macrocells.capacity() + self.groups.capacity())
    }
}

/// Marks that a triangle's macrocells are found from its vertices.
const MANY: u32 = u32::MAX;

impl<'a> Macrocells<'a> {
    /// The macrocells of a grid, in parallel.
    pub(crate) fn new(grid: &Grid) -> Macrocells<'static> {
        let map = CubeMap::new(grid.triangles());
        let triangle_in: Vec<AtomicU32> = (0..map.count()).map(|_| AtomicU32::new(u32::MAX)).collect();
        let of = |triangle: u32| {
            if !grid.is_triangle(triangle) {
                return MANY;
            }
            map.each(&corners(grid, triangle), |cell| {
                triangle_in[cell as usize].fetch_min(triangle, Relaxed);
            });
            code(&map, &corners(grid, triangle))
        };
        let of_triangle: Vec<u32> = (0..grid.triangles() as u32).into_par_iter().with_min_len(CHUNK).map(of).collect();
        let triangle_in = triangle_in.into_iter().map(AtomicU32::into_inner);
        let triangle_in =
            triangle_in.map(|triangle| grid.nearest_valid_triangle(triangle.min(grid.triangles() as u32)));
        let triangle_in: Vec<u32> = triangle_in.collect();
        Self::of_arrays(grid.lowest_facet(), of_triangle.into(), triangle_in.into())
    }

    /// The macrocells with these [arrays](Self::arrays).
    pub(crate) fn of_arrays<'s>(
        lowest_facet: f64,
        of_triangle: Cow<'s, [u32]>,
        triangle_in: Cow<'s, [u32]>,
    ) -> Macrocells<'s> {
        let map = CubeMap::new(of_triangle.len());
        Macrocells { map, groups: map.groups(), of_triangle, triangle_in, lowest_facet }
    }

    /// The macrocells of each triangle, and a triangle in each macrocell.
    pub(crate) fn arrays(&self) -> [&[u32]; 2] {
        [&self.of_triangle, &self.triangle_in]
    }

    /// A triangle in or near a macrocell.
    #[inline]
    pub fn triangle_in(&self, cell: u32) -> u32 {
        self.triangle_in[cell as usize]
    }

    /// Joins the bits of the triangles that overlap each macrocell, in `joined`, whose memory is reused; returns the
    /// number of bits that are set in macrocells.
    pub fn join(&self, grid: &Grid, bits: &[u32], joined: &mut JoinedBits) -> u64 {
        joined.clear();
        joined.macrocells.resize_with(self.map.count(), || AtomicU32::new(0));
        joined.groups.resize(self.groups.count(), 0);
        let all = joined.macrocells.as_slice();
        (0..bits.len()).into_par_iter().with_min_len(CHUNK).for_each(|triangle| {
            let own = bits[triangle];
            let add = |cell: u32| {
                let cell = &all[cell as usize];
                if cell.load(Relaxed) & own != own {
                    cell.fetch_or(own, Relaxed);
                }
            };
            if own != 0 {
                self.each(grid, triangle as u32, add);
            }
        });
        let mut set = 0;
        for (number, bits) in (0..).zip(all) {
            let bits = bits.load(Relaxed);
            let group = self.map.group_of(self.map.place(number));
            joined.groups[self.groups.number(group) as usize] |= bits;
            set += u64::from(bits.count_ones());
        }
        set
    }

    #[inline]
    fn each(&self, grid: &Grid, triangle: u32, mut see: impl FnMut(u32)) {
        let code = self.of_triangle[triangle as usize];
        if code == MANY {
            return self.map.each(&corners(grid, triangle), see);
        }
        let first = code >> 2;
        for row in 0..=(code >> 1 & 1) {
            for column in 0..=(code & 1) {
                see(first + row * self.map.side + column);
            }
        }
    }

    /// Bytes of memory.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.of_triangle) + size_of_val(&*self.triangle_in)
    }
}

/// The unit vectors of a triangle's vertices.
#[inline]
fn corners(grid: &Grid, triangle: u32) -> [DVec3; 3] {
    grid.triangle(triangle).map_inline(|cell| grid.direction(cell))
}

/// [`Macrocells::of_triangle`] of the triangle between these unit vectors.
fn code(map: &CubeMap, corners: &[DVec3; 3]) -> u32 {
    let (mut first, mut count, mut code) = (0, 0, 0);
    map.each(corners, |cell| {
        if count == 0 {
            first = cell;
        }
        count += 1;
        match cell - first {
            0 => {}
            1 => code |= 1,
            up if up == map.side => code |= 2,
            up if up == map.side + 1 && count == 4 => {}
            _ => count = 5,
        }
    });
    let is_block = count == [1, 2, 2, 4][code as usize] && first < MANY >> 2;
    if is_block { first << 2 | code } else { MANY }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::icosahedral_grid;
    use icoray_test_support::Random;
    use std::collections::HashSet;

    /// Places in all triangles, at their vertices and sides too.
    #[test]
    fn triangles_belong_to_the_macrocells_of_all_their_places() {
        for level in [1, 3, 5, 6] {
            let grid = icosahedral_grid(level);
            let cells = grid.macrocells();
            let mut random = Random::new(7);
            let mut joined = JoinedBits::default();
            for triangle in 0..grid.triangles() as u32 {
                let mut own = HashSet::new();
                cells.each(&grid, triangle, |cell| assert!(own.insert(cell), "once each"));
                let [a, b, c] = corners(&grid, triangle);
                for k in 0..12 {
                    let (u, v) = (random.unit(), random.unit());
                    let [u, v] = if k < 3 { [f64::from(k & 1), f64::from(k >> 1)] } else { [u, v * (1.0 - u)] };
                    let cell = cells.map.number(cells.map.find(a + u * (b - a) + v * (c - a)));
                    assert!(own.contains(&cell), "level {level}, triangle {triangle}: {cell} of {own:?}");
                }
                assert!(level < 5 || own.len() <= 12, "{} macrocells", own.len());
            }
            let bits: Vec<u32> = (0..grid.triangles() as u32).map(|t| 1 << (t % 32)).collect();
            cells.join(&grid, &bits, &mut joined);
            let mut wanted = vec![0; cells.map.count()];
            (0..grid.triangles() as u32)
                .for_each(|t| cells.each(&grid, t, |cell| wanted[cell as usize] |= 1 << (t % 32)));
            let numbers = 0..cells.map.count() as u32;
            assert_eq!(numbers.clone().map(|number| joined.of_macrocell(number)).collect::<Vec<_>>(), wanted);
            let mut of_groups = vec![0; cells.groups.count()];
            for number in numbers {
                let place = cells.map.place(number);
                assert_eq!(cells.map.number(place), number);
                let group = cells.groups.number(cells.map.group_of(place));
                of_groups[group as usize] |= wanted[number as usize];
            }
            let numbers = 0..cells.groups.count() as u32;
            assert_eq!(numbers.map(|number| joined.of_group(number)).collect::<Vec<_>>(), of_groups);
            for cell in 0..cells.map.count() as u32 {
                let mut is_near = false;
                cells.each(&grid, cells.triangle_in(cell), |other| is_near |= other == cell);
                assert!(is_near, "level {level}: a triangle in each macrocell");
            }
        }
    }

    /// Lines through the sphere: up to its exit a macrocell is that of all places on them.
    #[test]
    fn lines_leave_macrocells_at_their_exits() {
        let fine = CubeMap::new(50_000);
        let mut random = Random::new(3);
        let mut vector = || DVec3::from_array([(); 3].map(|()| 2.0 * random.unit() - 1.0));
        let mut passed = [0; 2];
        for k in 0..600 {
            let (from, along) = (vector(), vector().normalize());
            let is_fine = k % 2 == 0;
            let map = if is_fine { fine } else { fine.groups() };
            let find = |place| if is_fine { fine.find(place) } else { fine.group_of(fine.find(place)) };
            let mut t = -2.0;
            while t < 2.0 {
                let cell = find(from + t * along);
                let exit = map.exit(cell, from, along, t);
                for k in 1..8 {
                    let at = t + (exit.min(2.0) - t) * f64::from(k) / 8.0;
                    assert_eq!(find(from + at * along), cell);
                }
                assert!(exit >= t);
                passed[k % 2] += 1;
                t = exit + 1e-9;
                assert!(t > 2.0 || find(from + t * along) != cell, "the exit is no later than the border");
            }
        }
        assert!(passed[0] > 5_000 && passed[1] > 600 && 3 * passed[1] < passed[0], "{passed:?}");
    }
}
