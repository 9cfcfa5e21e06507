//! Half-edges: the sides of triangles through which a ray enters, with the sides through which it can leave.
//!
//! A ray walks along a great circle, which has a triangle's vertices on its left or on its right. It enters a triangle
//! through the side between a left and a right vertex; the third vertex, the apex, decides between the two other sides.

use super::{Grid, made};
use crate::array::MapInline;
use crate::error::Result;
use crate::memory;
use rayon::prelude::*;

/// A side of a triangle through which a ray enters.
///
/// Half-edge `3·t + k` enters triangle t through the side from vertex k (on the left) to vertex k + 1 (on the right),
/// the vertices in counter-clockwise order seen from outside; [`Grid::counterclockwise`] gives that order.
pub type HalfEdge = [u32; 4];

/// Elements of a [`HalfEdge`].
pub mod half_edge {
    /// The half-edge that is entered next if the apex lies on the left; the element after it, if the apex lies on the
    /// right.
    pub const NEXT: usize = 0;
    /// The vertex opposite the side.
    pub const APEX: usize = 2;
    /// The triangle.
    pub const TRIANGLE: usize = 3;
}

impl Grid<'_> {
    /// All half-edges, three per triangle, void ones included; made at the first call, in parallel. Those of a row that
    /// is no triangle are undefined. Empty for a grid with more half-edges than 32 bits can number.
    ///
    /// # Panics
    /// If they do not fit into memory; [`Self::make_half_edges`] returns an error instead.
    pub fn half_edges(&self) -> &[HalfEdge] {
        match &self.shared {
            Some((half_edges, _)) => half_edges,
            None => made(&self.half_edges, || self.all_sides().unwrap_or_else(|error| panic!("{error}"))).as_slice(),
        }
    }

    /// Makes the half-edges unless they exist, in parallel.
    ///
    /// # Errors
    /// [`ErrorKind::Memory`](crate::error::ErrorKind::Memory) if they do not fit.
    pub fn make_half_edges(&self) -> Result<()> {
        if self.shared.is_none() && self.half_edges.get().is_none() {
            let new = self.all_sides()?;
            self.half_edges.get_or_init(|| new);
        }
        Ok(())
    }

    /// Bytes of the half-edges, and whether they have been made.
    pub fn half_edge_bytes(&self) -> (u64, bool) {
        let bytes = if self.can_number_sides() { self.beyond.len() * size_of::<[HalfEdge; 3]>() } else { 0 };
        (bytes as u64, self.shared.is_some() || self.half_edges.get().is_some())
    }

    fn can_number_sides(&self) -> bool {
        self.beyond.len() <= u32::MAX as usize / 3
    }

    fn all_sides(&self) -> Result<Vec<HalfEdge>> {
        if !self.can_number_sides() {
            return Ok(Vec::new());
        }
        let mut all: Vec<[HalfEdge; 3]> = memory::room_for("half-edges of the grid", self.beyond.len())?;
        let triangles = (0..self.beyond.len()).into_par_iter().with_min_len(1024);
        let sides = |triangle: usize| match triangle as u32 {
            triangle if self.is_triangle(triangle) || self.is_void(triangle) => self.sides(triangle),
            _ => [[0; 4]; 3],
        };
        triangles.map(sides).collect_into_vec(&mut all);
        Ok(all.into_flattened())
    }

    /// The vertices of a triangle, counter-clockwise seen from outside, and the triangles beyond the sides opposite
    /// each.
    #[inline]
    pub fn counterclockwise(&self, triangle: u32) -> ([u32; 3], [u32; 3]) {
        let (mut cells, mut beyond) = (self.triangle(triangle), self.beyond[triangle as usize]);
        if self.is_clockwise(triangle) {
            cells.swap(1, 2);
            beyond.swap(1, 2);
        }
        (cells, beyond)
    }

    /// The half-edges of a triangle.
    fn sides(&self, triangle: u32) -> [HalfEdge; 3] {
        let (cells, beyond) = self.counterclockwise(triangle);
        [0, 1, 2].map_inline(|k| {
            let [left, right, apex] = [cells[k], cells[(k + 1) % 3], cells[(k + 2) % 3]];
            let on_left = self.half_edge(beyond[k], apex, right);
            let on_right = self.half_edge(beyond[(k + 1) % 3], left, apex);
            [on_left, on_right, apex, triangle]
        })
    }

    /// The half-edge of `triangle` from vertex `left` to vertex `right`.
    #[inline]
    pub fn half_edge(&self, triangle: u32, left: u32, right: u32) -> u32 {
        let (cells, _) = self.counterclockwise(triangle);
        let k = (0..3).find(|&k| cells[k] == left && cells[(k + 1) % 3] == right);
        3 * triangle + k.expect("the grid's check found neighbours of one winding") as u32
    }
}

#[cfg(test)]
mod tests {
    use super::half_edge::{APEX, NEXT, TRIANGLE};
    use crate::grid::icosahedral_grid;

    /// Each half-edge leads to the triangle beyond, into which it enters between the same vertices.
    #[test]
    fn half_edges_lead_through_the_sides_of_triangles() {
        let grid = icosahedral_grid(2);
        let all = grid.half_edges();
        assert_eq!(all.len(), 3 * grid.triangles());
        for (number, side) in all.iter().enumerate() {
            let (triangle, k) = (number / 3, number % 3);
            let (cells, beyond) = grid.counterclockwise(triangle as u32);
            assert_eq!((side[TRIANGLE] as usize, side[APEX]), (triangle, cells[(k + 2) % 3]));
            for (turn, [left, right], beyond) in
                [(0, [side[APEX], cells[(k + 1) % 3]], beyond[k]), (1, [cells[k], side[APEX]], beyond[(k + 1) % 3])]
            {
                let next = side[NEXT + turn];
                let (there, _) = grid.counterclockwise(next / 3);
                let k = next as usize % 3;
                assert_eq!((next / 3, [there[k], there[(k + 1) % 3]]), (beyond, [left, right]));
            }
        }
    }
}
