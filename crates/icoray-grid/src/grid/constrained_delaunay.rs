//! A triangulation of the whole sphere into which points and sides are inserted, by exact predicates.
//!
//! It starts as a bisected icosahedron, turned so that its points meet no others, or as a tetrahedron. A point is
//! located by walking, splits its triangle, and sides are flipped until all are Delaunay again (Lawson 1977): this
//! takes few steps if neighbouring points follow each other. For a required side, flips remove the sides that cross it
//! (Sloan 1993, doi:10.1016/0045-7949(93)90239-A).
//!
//! There are only two predicates: the side of the plane through two points and the sphere's centre on which a third one
//! lies, and whether a fourth lies above the plane of three. Both are signs of determinants, exact by Shewchuk's
//! adaptive arithmetic (1997, doi:10.1007/PL00009321; crate `robust`). A triangle is made only if its determinant is
//! positive, so at every moment the triangles' cones cover space once and none contains the centre.

use super::generate::IcosahedralMesh;
use crate::error::Result;
use glam::{DMat3, DVec3};
use robust::{Coord3D, orient3d};
use std::collections::{HashMap, HashSet};

/// Components below this are taken as 0: smaller ones would underflow in exact products. It makes no difference to any
/// walk.
const NOTHING: f64 = 1e-60;
pub(super) const CENTER: Coord3D<f64> = Coord3D { x: 0.0, y: 0.0, z: 0.0 };

/// A triangle, counter-clockwise from outside.
#[derive(Debug, Clone, Copy)]
pub(super) struct Face {
    pub vertices: [u32; 3],
    /// The face beyond the side opposite each vertex.
    pub beyond: [u32; 3],
}

/// The reason why a point or a side cannot be inserted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ConstraintError {
    /// There is a vertex at this place already, or a side would run through it.
    Vertex(u32),
    /// A required side lies across.
    Side(u32, u32),
    /// Flips do not end. No input is known that causes this.
    Endless,
}

#[derive(Debug)]
pub(super) struct ConstrainedDelaunay {
    points: Vec<Coord3D<f64>>,
    pub faces: Vec<Face>,
    /// A face at each vertex.
    around: Vec<u32>,
    /// Required sides, from the smaller vertex to the larger.
    fixed: HashSet<(u32, u32)>,
    last: u32,
    /// Square of the distance within which a point counts as a vertex.
    pub same_squared: f64,
}

/// The index of a face's corner, `by` steps after corner `k`.
fn turn(k: usize, by: usize) -> usize {
    (k + by) % 3
}

pub(super) fn coord(p: DVec3) -> Coord3D<f64> {
    let [x, y, z] = p.to_array().map(|c| if c.abs() < NOTHING { 0.0 } else { c });
    Coord3D { x, y, z }
}

impl ConstrainedDelaunay {
    /// The icosahedron bisected `level` times, turned by `rotation`.
    pub fn new(level: u32, rotation: DMat3) -> Result<Self> {
        let mesh = IcosahedralMesh::new(level)?;
        let places = mesh.lon_center_rad.iter().zip(&mesh.lat_center_rad);
        let points = places.map(|(lon, lat)| coord(rotation * super::unit_vector(*lon, *lat))).collect();
        let triangle = |row: &[i32]| [row[0] as u32, row[1] as u32, row[2] as u32];
        Ok(Self::of_faces(points, &mesh.corner_cell.chunks_exact(3).map(triangle).collect::<Vec<_>>()))
    }

    /// A tetrahedron; `None` unless the centre lies in it and its first three points are counter-clockwise from outside.
    pub fn of_tetrahedron(points: [DVec3; 4]) -> Option<Self> {
        const FACES: [[u32; 3]; 4] = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]];
        let made = Self::of_faces(points.map(coord).to_vec(), &FACES);
        let is_around = FACES.iter().all(|[a, b, c]| made.side(*a, *b, made.at(*c)) > 0.0);
        is_around.then_some(made)
    }

    fn of_faces(points: Vec<Coord3D<f64>>, faces: &[[u32; 3]]) -> Self {
        let mut sides = HashMap::new();
        let mut around = vec![0; points.len()];
        for (f, v) in (0u32..).zip(faces) {
            for k in 0..3 {
                sides.insert((v[turn(k, 1)], v[turn(k, 2)]), f);
                around[v[k] as usize] = f;
            }
        }
        let beyond = |v: &[u32; 3]| [0, 1, 2].map(|k| sides[&(v[turn(k, 2)], v[turn(k, 1)])]);
        let faces = faces.iter().map(|v| Face { vertices: *v, beyond: beyond(v) }).collect();
        ConstrainedDelaunay { points, faces, around, fixed: HashSet::new(), last: 0, same_squared: 0.0 }
    }

    pub fn vertices(&self) -> usize {
        self.points.len()
    }

    pub fn point(&self, vertex: u32) -> DVec3 {
        let p = &self.points[vertex as usize];
        DVec3::new(p.x, p.y, p.z)
    }

    fn at(&self, vertex: u32) -> Coord3D<f64> {
        self.points[vertex as usize]
    }

    /// Positive if `c` lies left of the great circle from `a` to `b`, 0 if it lies on it; the sign is exact.
    fn side(&self, a: u32, b: u32, c: Coord3D<f64>) -> f64 {
        orient3d(self.at(a), self.at(b), c, CENTER)
    }

    /// The index of the vertex of `face` opposite the side to `other`.
    pub fn place_of(&self, face: u32, other: u32) -> usize {
        let beyond = self.faces[face as usize].beyond;
        beyond.iter().position(|&f| f == other).expect("faces know each other")
    }

    /// Makes face `now` the neighbour of `outer` in place of `was`. Two faces may share two sides only if a vertex has
    /// two faces, which no closed cone has.
    fn relink(&mut self, outer: u32, was: u32, now: u32) {
        let k = self.place_of(outer, was);
        self.faces[outer as usize].beyond[k] = now;
    }

    /// Adds a point.
    pub fn insert(&mut self, point: DVec3) -> std::result::Result<u32, ConstraintError> {
        let p = coord(point);
        let face = self.locate(p);
        let vertices = self.faces[face as usize].vertices;
        if let Some(same) = vertices.into_iter().find(|v| self.point(*v).distance_squared(point) <= self.same_squared) {
            return Err(ConstraintError::Vertex(same));
        }
        let [a, b, c] = vertices;
        let on = [self.side(b, c, p), self.side(c, a, p), self.side(a, b, p)].map(|s| s == 0.0);
        if let Some(k) = (0..3).find(|&k| on[turn(k, 1)] && on[turn(k, 2)]) {
            return Err(ConstraintError::Vertex(self.faces[face as usize].vertices[k]));
        }
        let new = self.points.len() as u32;
        self.points.push(p);
        self.around.push(face);
        let beyond = self.faces[face as usize].beyond;
        let [f0, f1, f2] = [face, self.faces.len() as u32, self.faces.len() as u32 + 1];
        self.faces[f0 as usize] = Face { vertices: [new, b, c], beyond: [beyond[0], f1, f2] };
        self.faces.push(Face { vertices: [new, c, a], beyond: [beyond[1], f2, f0] });
        self.faces.push(Face { vertices: [new, a, b], beyond: [beyond[2], f0, f1] });
        for (was, now) in [(1, f1), (2, f2)] {
            self.relink(beyond[was], face, now);
        }
        self.around[a as usize] = f1;
        self.around[b as usize] = f2;
        self.around[c as usize] = f0;
        self.last = face;
        // On a side, one of the three has no area: its flip gives the two that belong there.
        let mut suspects = vec![f0, f1, f2];
        if let Some(k) = on.iter().position(|&on| on) {
            let flat = [f0, f1, f2][k];
            suspects.push(self.faces[flat as usize].beyond[0]);
            self.flip(flat, 0);
        }
        while let Some(face) = suspects.pop() {
            let k = self.faces[face as usize].vertices.iter().position(|&v| v == new);
            let Some(k) = k else { continue };
            let other = self.faces[face as usize].beyond[k];
            if self.is_above(face, other) && self.can_flip(face, k) {
                self.flip(face, k);
                suspects.extend([face, other]);
            }
        }
        Ok(new)
    }

    /// A face whose cone contains `p`.
    fn locate(&self, p: Coord3D<f64>) -> u32 {
        let outside = |face: u32| {
            let v = self.faces[face as usize].vertices;
            (0..3).find(|&k| self.side(v[turn(k, 1)], v[turn(k, 2)], p) < 0.0)
        };
        let mut face = self.last;
        for _ in 0..self.faces.len() {
            match outside(face) {
                None => return face,
                Some(k) => face = self.faces[face as usize].beyond[k],
            }
        }
        // A walk may turn in circles if the triangulation is not Delaunay; testing all faces cannot.
        let all = 0..self.faces.len() as u32;
        all.into_iter().find(|&f| outside(f).is_none()).expect("the cones cover space")
    }

    /// Whether the two triangles on both sides of a side form a strictly convex quadrilateral.
    fn can_flip(&self, face: u32, k: usize) -> bool {
        let Face { vertices: v, beyond } = self.faces[face as usize];
        let other = beyond[k];
        let far = self.at(self.faces[other as usize].vertices[self.place_of(other, face)]);
        self.side(v[k], v[turn(k, 1)], far) > 0.0 && self.side(v[turn(k, 2)], v[k], far) > 0.0
    }

    /// Replaces the side opposite vertex `k` of `face` by the other diagonal.
    fn flip(&mut self, face: u32, k: usize) {
        let f = self.faces[face as usize];
        let other = f.beyond[k];
        let j = self.place_of(other, face);
        let g = self.faces[other as usize];
        let (p, a, b, d) = (f.vertices[k], f.vertices[turn(k, 1)], f.vertices[turn(k, 2)], g.vertices[j]);
        // Seen from d, the other face runs d, b, a.
        let (beyond_ad, beyond_db) = (g.beyond[turn(j, 1)], g.beyond[turn(j, 2)]);
        let (beyond_bp, beyond_pa) = (f.beyond[turn(k, 1)], f.beyond[turn(k, 2)]);
        self.relink(beyond_ad, other, face);
        self.relink(beyond_bp, face, other);
        self.faces[face as usize] = Face { vertices: [p, a, d], beyond: [beyond_ad, other, beyond_pa] };
        self.faces[other as usize] = Face { vertices: [p, d, b], beyond: [beyond_db, beyond_bp, face] };
        for (vertex, at) in [(p, face), (a, face), (d, face), (b, other)] {
            self.around[vertex as usize] = at;
        }
    }

    /// The faces around a vertex, counter-clockwise, each with the vertex's index in it.
    pub fn ring(&self, vertex: u32) -> impl Iterator<Item = (u32, usize)> + '_ {
        let place = move |face: u32| {
            let v = self.faces[face as usize].vertices;
            v.iter().position(|&v| v == vertex).expect("a ring's faces share its vertex")
        };
        let start = self.around[vertex as usize];
        let mut next = Some(start);
        std::iter::from_fn(move || {
            let face = next?;
            let k = place(face);
            let beyond = self.faces[face as usize].beyond[turn(k, 1)];
            next = (beyond != start).then_some(beyond);
            Some((face, k))
        })
    }

    /// The face that has the side from `a` to `b`, counter-clockwise, and the index of its third vertex.
    pub fn left_of(&self, a: u32, b: u32) -> Option<(u32, usize)> {
        let (face, k) = self.ring(a).find(|&(f, k)| self.faces[f as usize].vertices[turn(k, 1)] == b)?;
        Some((face, turn(k, 2)))
    }

    /// Makes the arc from `a` to `b` a required side.
    pub fn insert_constraint(&mut self, a: u32, b: u32) -> std::result::Result<(), ConstraintError> {
        let touched = if self.left_of(a, b).is_none() { self.clear(a, b)? } else { Vec::new() };
        self.fixed.insert((a.min(b), a.max(b)));
        self.restore_delaunay(touched);
        Ok(())
    }

    /// Flips sides that may be flipped until those around `suspects` are Delaunay again: clearing an arc leaves
    /// slivers, three vertices in one plane with the centre, over which a ray in that plane would step back.
    fn restore_delaunay(&mut self, mut suspects: Vec<u32>) {
        // Each flip adds volume under the facets, so this ends.
        while let Some(face) = suspects.pop() {
            let Face { vertices: v, beyond } = self.faces[face as usize];
            for k in 0..3 {
                let (a, b, other) = (v[turn(k, 1)], v[turn(k, 2)], beyond[k]);
                if !self.fixed.contains(&(a.min(b), a.max(b))) && self.is_above(face, other) && self.can_flip(face, k) {
                    self.flip(face, k);
                    suspects.extend([face, other]);
                    break;
                }
            }
        }
    }

    /// Whether the vertex of `other` that is not in `face` lies above the plane of `face`, its neighbour.
    fn is_above(&self, face: u32, other: u32) -> bool {
        let [a, b, c] = self.faces[face as usize].vertices.map(|v| self.at(v));
        let far = self.faces[other as usize].vertices[self.place_of(other, face)];
        orient3d(a, b, c, self.at(far)) < 0.0
    }

    /// The sides that the arc from `a` to `b` crosses, each from right to left.
    fn crossed(&self, a: u32, b: u32) -> std::result::Result<Vec<[u32; 2]>, ConstraintError> {
        let goal = self.at(b);
        let wedge = self.ring(a).find_map(|(face, k)| {
            let v = self.faces[face as usize].vertices;
            let (right, left) = (v[turn(k, 1)], v[turn(k, 2)]);
            let is_inside = self.side(a, right, goal) >= 0.0 && self.side(a, left, goal) < 0.0;
            is_inside.then_some((face, k, right, left))
        });
        let Some((mut face, mut k, mut right, mut left)) = wedge else {
            return Err(ConstraintError::Endless);
        };
        if self.side(a, right, goal) == 0.0 {
            return Err(ConstraintError::Vertex(right));
        }
        let mut crossed = Vec::new();
        for _ in 0..self.faces.len() {
            if self.fixed.contains(&(left.min(right), left.max(right))) {
                return Err(ConstraintError::Side(right, left));
            }
            crossed.push([right, left]);
            let other = self.faces[face as usize].beyond[k];
            let j = self.place_of(other, face);
            let apex = self.faces[other as usize].vertices[j];
            if apex == b {
                return Ok(crossed);
            }
            let side = self.side(a, b, self.at(apex));
            if side == 0.0 {
                return Err(ConstraintError::Vertex(apex));
            }
            // The other face runs apex, left, right. The way out lies opposite the vertex that is left behind.
            face = other;
            if side > 0.0 {
                k = turn(j, 1);
                left = apex;
            } else {
                k = turn(j, 2);
                right = apex;
            }
        }
        Err(ConstraintError::Endless)
    }

    /// Flips away all sides that cross the arc from `a` to `b` and returns the new faces.
    fn clear(&mut self, a: u32, b: u32) -> std::result::Result<Vec<u32>, ConstraintError> {
        let mut crossed = std::collections::VecDeque::from(self.crossed(a, b)?);
        let mut touched = Vec::new();
        let mut tries = 64 + 8 * crossed.len() * crossed.len();
        while let Some([right, left]) = crossed.pop_front() {
            if tries == 0 {
                return Err(ConstraintError::Endless);
            }
            tries -= 1;
            let Some((face, k)) = self.left_of(right, left) else { return Err(ConstraintError::Endless) };
            if !self.can_flip(face, k) {
                crossed.push_back([right, left]);
                continue;
            }
            touched.extend([face, self.faces[face as usize].beyond[k]]);
            self.flip(face, k);
            let [p, _, d] = self.faces[face as usize].vertices;
            if [p, d].iter().any(|&v| v == a || v == b) {
                continue;
            }
            let [p_side, d_side] = [p, d].map(|v| self.side(a, b, self.at(v)) > 0.0);
            match (p_side, d_side) {
                (true, false) => crossed.push_back([d, p]),
                (false, true) => crossed.push_back([p, d]),
                _ => {}
            }
        }
        if self.left_of(a, b).is_some() { Ok(touched) } else { Err(ConstraintError::Endless) }
    }
}

#[cfg(test)]
mod tests;
