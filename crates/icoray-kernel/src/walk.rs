//! From triangle to triangle along a great circle: Algorithms 1 and 2 of the paper without their face tests.
//!
//! The side of a vertex is the sign of V·q, a pure function of the plane and the vertex. So every triangle has either
//! no side or exactly two sides whose ends lie on different sides of the circle, and the triangles that the circle
//! crosses form closed loops that never branch: the walk ends after finitely many steps and cannot get lost, for any
//! rounding, without any epsilon and without special cases at vertices and edges. All of that holds over void triangles
//! too, which close a mesh with holes: they are walked like others, and `Walk::is_void` distinguishes them.

use super::plane::{Plane, PlaneVertex, Point, RayLine};
use glam::DVec3;
use icoray_grid::Grid;
use icoray_grid::grid::half_edges::{half_edge, place};
use std::collections::HashSet;

/// A triangle with the two sides through which a great circle passes: in between `left` and `right`, out between one
/// of them and `apex`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Contour<'g, 'a> {
    grid: &'g Grid<'a>,
    plane: Plane,
    /// The half-edge of the side of entry.
    half_edge: u32,
    left: PlaneVertex,
    right: PlaneVertex,
    apex: PlaneVertex,
}

/// The point at which the circle crosses a side: `point = (1 - w)·left + w·right`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Crossing {
    pub point: Point,
    pub w: f64,
}

impl Crossing {
    #[inline]
    fn between(left: &PlaneVertex, right: &PlaneVertex) -> Self {
        // left.q >= 0 > right.q, so the denominator is positive and w lies in [0, 1).
        let w = left.q / (left.q - right.q);
        Crossing { point: Point::new(left.x, left.y).lerp(Point::new(right.x, right.y), w), w }
    }
}

impl<'g, 'a> Contour<'g, 'a> {
    /// The circle inside `triangle`, or `None` if all three vertices lie on one side of it.
    #[inline]
    fn inside(grid: &'g Grid<'a>, plane: Plane, triangle: u32) -> Option<Self> {
        let [a, b, c] = grid.triangle(triangle);
        let see = |cell| plane.project(cell, grid.direction(cell));
        let seen = [see(a), see(b), see(c)];
        // Counter-clockwise from outside, the side of entry leads from left to right.
        let k = (0..3).find(|&k| seen[k].is_left() && !seen[(k + 1) % 3].is_left())?;
        let (left, right, apex) = (seen[k], seen[(k + 1) % 3], seen[(k + 2) % 3]);
        Some(Contour { grid, plane, half_edge: half_edge(triangle, k), left, right, apex })
    }

    /// The circle at `triangle` or, if rounding puts it just outside, in the nearest adjacent triangle.
    #[inline]
    fn near(grid: &'g Grid<'a>, plane: Plane, triangle: u32) -> Self {
        if let Some(contour) = Self::inside(grid, plane, triangle) {
            return contour;
        }
        let mut queue = vec![triangle];
        let mut seen: HashSet<u32> = HashSet::from([triangle]);
        let mut next = 0;
        while let Some(&t) = queue.get(next) {
            next += 1;
            for beyond in (0..3).map(|k| grid.across(t, k)) {
                if let Some(contour) = Self::inside(grid, plane, beyond) {
                    return contour;
                }
                if seen.insert(beyond) {
                    queue.push(beyond);
                }
            }
        }
        unreachable!("a closed surface around the centre has vertices on both sides of every plane through it")
    }

    #[inline]
    fn entry(&self) -> Crossing {
        Crossing::between(&self.left, &self.right)
    }

    /// The ends of the side of exit, left and right.
    #[inline]
    fn exit_side(&self) -> (&PlaneVertex, &PlaneVertex) {
        if self.apex.is_left() { (&self.apex, &self.right) } else { (&self.left, &self.apex) }
    }

    #[inline]
    fn exit(&self) -> Crossing {
        let (left, right) = self.exit_side();
        Crossing::between(left, right)
    }

    /// Crosses the side opposite the vertex that is `turn` places behind the start of the side of entry. Returns the
    /// half-edge of that side in the next triangle, and the vertex opposite it.
    #[inline]
    fn cross(&self, turn: usize) -> (u32, PlaneVertex) {
        let (triangle, begins) = place(self.half_edge);
        let half_edge = self.grid.half_edges()[triangle as usize].beyond((begins + turn) % 3);
        let (triangle, begins) = place(half_edge);
        let new = self.grid.triangle(triangle)[(begins + 2) % 3];
        (half_edge, self.plane.project(new, self.grid.direction(new)))
    }

    #[inline]
    fn forward(&mut self) {
        let is_left = self.apex.is_left();
        let (half_edge, new) = self.cross(usize::from(!is_left));
        self.half_edge = half_edge;
        *(if is_left { &mut self.left } else { &mut self.right }) = std::mem::replace(&mut self.apex, new);
    }

    #[inline]
    fn backward(&mut self) {
        let (crossed, new) = self.cross(2);
        let (triangle, begins) = place(crossed);
        // Of the side that was crossed, which runs from right to left here, the new vertex replaces one end.
        let is_left = new.is_left();
        self.half_edge = half_edge(triangle, (begins + if is_left { 2 } else { 1 }) % 3);
        self.apex = std::mem::replace(if is_left { &mut self.left } else { &mut self.right }, new);
    }

    #[inline]
    fn triangle(&self) -> u32 {
        place(self.half_edge).0
    }
}

/// The triangle that contains `target`, found by walking the great circle from the middle of the triangle `from`.
///
/// Any number is valid for `from`, also that of a row that is no triangle.
#[inline]
pub fn locate(grid: &Grid, from: u32, target: DVec3) -> u32 {
    let middle = |t: u32| grid.triangle(t).iter().map(|&c| grid.direction(c)).sum::<DVec3>().normalize();
    let mut from = grid.nearest_valid_triangle(from);
    let mut start = middle(from);
    if start.dot(target) < -0.5 {
        // Half a turn leaves the direction open; stop over at a right angle. Once: if triangles are as large as the
        // sphere, the next one's middle may be no nearer.
        let aside = target.any_orthonormal_vector();
        let aside = if aside.dot(start) < 0.0 { -aside } else { aside };
        from = locate_short(grid, from, start, aside);
        start = middle(from);
    }
    locate_short(grid, from, start, target)
}

#[inline]
fn locate_short(grid: &Grid, from: u32, middle: DVec3, target: DVec3) -> u32 {
    let Some(plane) = Plane::through(middle, target) else {
        return from;
    };
    let goal = plane.point(target);
    let mut contour = Contour::near(grid, plane, from);
    while goal.cross(contour.exit().point) <= 0.0 {
        contour.forward();
    }
    contour.triangle()
}

/// One end of a ray's path through a column.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ColumnEnd {
    /// Distance along the ray from its point closest to the centre, planet radii.
    pub t: f64,
    /// Height in the column: a layer facet of radius R lies at `rho = R`.
    pub rho: f64,
    /// Weights of the column's second and third vertex; the first has the rest.
    pub weight: [f64; 2],
}

/// The path of a ray over one triangle: `rho` is linear in t between the ends.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Column {
    pub cells: [u32; 3],
    pub entry: ColumnEnd,
    pub exit: ColumnEnd,
}

/// A ray walking over the mesh, column by column, from its start to its end without a gap.
#[derive(Debug, Clone)]
pub(crate) struct Walk<'g, 'a> {
    contour: Contour<'g, 'a>,
    line: RayLine,
    from: Option<ContourPoint>,
    last: (f64, f64),
}

/// The start of a ray: on the way from a side into its triangle.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Side {
    pub line: RayLine,
    /// The ends of the side, and its half-edge.
    pub left: PlaneVertex,
    pub right: PlaneVertex,
    pub half_edge: u32,
    /// The start's place on the unit facet, its weights as in [`ColumnEnd`], its height, and its distance.
    pub point: Point,
    pub weight: [f64; 2],
    pub height: f64,
    pub t: f64,
}

/// The side through which a walk enters the column in which the ray is at distance `t`, if that is the column over the
/// triangle of `half_edge`, whose left, right and third vertex are `corners`: the same as that of a walk from the ray's
/// start, to the bit.
#[inline]
pub(crate) fn enter(line: RayLine, corners: [PlaneVertex; 3], half_edge: u32, t: f64) -> Option<Side> {
    let [left, right, apex] = corners;
    let (at, start) = (line.at(t), line.at(line.start));
    let entry = Crossing::between(&left, &right);
    let exit = if apex.is_left() { Crossing::between(&apex, &right) } else { Crossing::between(&left, &apex) };
    if at.cross(entry.point) > 0.0 || at.cross(exit.point) <= 0.0 {
        return None;
    }
    let mut place = ContourPoint { point: entry.point, weight: [entry.w, 0.0] };
    let t = if start.cross(entry.point) <= 0.0 {
        // The ray begins in the column.
        let weight = if apex.is_left() { [exit.w, 1.0 - exit.w] } else { [0.0, exit.w] };
        place = place.clip(ContourPoint { point: exit.point, weight }, start);
        line.start
    } else {
        (line.b * place.point.y / place.point.x).max(line.start).min(line.end)
    };
    let ContourPoint { point, weight } = place;
    Some(Side { line, left, right, half_edge, point, weight, height: height(line.at(t), point), t })
}

/// A point on the contour inside the current triangle.
#[derive(Debug, Clone, Copy)]
struct ContourPoint {
    point: Point,
    weight: [f64; 2],
}

impl ContourPoint {
    /// The point between this point and `other` that lies in the direction of `to`.
    #[inline]
    fn clip(self, other: ContourPoint, to: Point) -> ContourPoint {
        let (before, after) = (to.cross(self.point), to.cross(other.point));
        let whole = before - after;
        let w = if whole < 0.0 { (before / whole).clamp(0.0, 1.0) } else { 0.0 };
        let mix = |k: usize| self.weight[k] + w * (other.weight[k] - self.weight[k]);
        ContourPoint { point: self.point.lerp(other.point, w), weight: [mix(0), mix(1)] }
    }
}

impl<'g, 'a> Walk<'g, 'a> {
    /// Finds the ray's first column, searching from the triangle `hint`. Any hint is valid; a near one is faster.
    #[inline]
    pub fn new(grid: &'g Grid<'a>, line: RayLine, hint: u32) -> Self {
        let triangle = locate(grid, hint, line.position(line.start).normalize());
        let mut contour = Contour::near(grid, line.plane, triangle);
        // Locating and the ray's own plane round differently: slide until the start is bracketed.
        let start = line.at(line.start);
        while start.cross(contour.entry().point) > 0.0 {
            contour.backward();
        }
        while start.cross(contour.exit().point) <= 0.0 {
            contour.forward();
        }
        let mut walk = Walk { contour, line, from: None, last: (line.start, 0.0) };
        let place = walk.entry_place().clip(walk.exit_place(walk.contour.exit()), start);
        walk.last.1 = height(start, place.point);
        walk.from = Some(place);
        walk
    }

    /// The side through which the ray enters its first column, for packets.
    #[inline]
    pub fn side(&self) -> Side {
        let Contour { half_edge, left, right, .. } = self.contour;
        let end = ContourPoint { point: self.line.at(self.line.end), weight: [0.0; 2] };
        let ContourPoint { point, weight } = self.from.unwrap_or(end);
        Side { line: self.line, left, right, half_edge, point, weight, height: self.last.1, t: self.last.0 }
    }

    /// The triangle below the next column.
    #[inline]
    pub fn triangle(&self) -> u32 {
        self.contour.triangle()
    }

    /// Whether that triangle fills a hole: its cells have no values.
    #[inline]
    pub fn is_void(&self) -> bool {
        self.contour.grid.is_void(self.triangle())
    }

    #[inline]
    fn entry_place(&self) -> ContourPoint {
        let Crossing { point, w } = self.contour.entry();
        ContourPoint { point, weight: [w, 0.0] }
    }

    #[inline]
    fn exit_place(&self, Crossing { point, w }: Crossing) -> ContourPoint {
        let weight = if self.contour.apex.is_left() { [w, 1.0 - w] } else { [0.0, w] };
        ContourPoint { point, weight }
    }

    /// The next column, or `None` behind the ray's end.
    #[inline(always)]
    pub fn next_column(&mut self) -> Option<Column> {
        let entry_place = self.from.take()?;
        let crossing = self.contour.exit();
        let mut exit_place = self.exit_place(crossing);
        let end = self.line.at(self.line.end);
        let is_last = end.cross(exit_place.point) >= 0.0;
        if is_last {
            exit_place = entry_place.clip(exit_place, end);
        }
        let cells = [self.contour.left.cell, self.contour.right.cell, self.contour.apex.cell];
        let (t0, rho0) = self.last;
        let t1 = if is_last {
            self.line.end
        } else {
            // max and min let a NaN of 0/0 (a ray through the centre) pass by.
            (self.line.b * exit_place.point.y / exit_place.point.x).max(t0).min(self.line.end)
        };
        let rho1 = height(self.line.at(t1), exit_place.point);
        let entry = ColumnEnd { t: t0, rho: rho0, weight: entry_place.weight };
        let exit = ColumnEnd { t: t1, rho: rho1, weight: exit_place.weight };
        self.last = (t1, rho1);
        if !is_last {
            self.contour.forward();
            self.from = Some(ContourPoint { point: crossing.point, weight: [crossing.w, 0.0] });
        }
        Some(Column { cells, entry, exit })
    }
}

/// The height at which the point `at` of the ray lies above the unit facet's point `on` in the same direction.
///
/// `b / on.x` is equal in exact arithmetic, but is noise if the ray passes the centre closely.
#[inline]
fn height(at: Point, on: Point) -> f64 {
    at.dot(on) / on.dot(on)
}

#[cfg(test)]
pub(crate) mod tests;
