//! Half-edges: the sides of triangles through which a ray enters, with the sides through which it can leave.
//!
//! A ray walks along a great circle, which has a triangle's vertices on its left or on its right. It enters a triangle
//! through the side between a left and a right vertex; the third vertex, the apex, decides between the two other sides.
//!
//! Half-edge `4·t + k` enters triangle t through the side from vertex k (on the left) to vertex k + 1 (on the right),
//! the vertices in counter-clockwise order seen from outside. With the three half-edges of each triangle in one record
//! of 24 bytes, a step of a ray reads one record; the model's four tables of indices are not read.

use super::Grid;
use bytemuck::{Pod, Zeroable};
use icoray_simd::Table;

/// The half-edges of a triangle; all 0 for a row of the table that is no triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Pod, Zeroable)]
#[repr(C)]
pub struct HalfEdges {
    /// The half-edge beyond the side opposite each vertex.
    beyond: [u32; 3],
    /// The apex of each half-edge: the third vertex, the first, and the second.
    apex: [u32; 3],
}

impl HalfEdges {
    /// Words of a record.
    pub const WORDS: u32 = (size_of::<Self>() / size_of::<u32>()) as u32;
    /// Largest number of triangles: gathers reach all words of their records.
    pub const MAX_TRIANGLES: usize = Table::<u32>::MAX / Self::WORDS as usize;
    /// In place of the half-edge beyond a side at which the mesh ends, until its holes are filled.
    pub(super) const RIM: u32 = u32::MAX;

    pub(super) fn new(vertices: [u32; 3], beyond: [u32; 3]) -> Self {
        let [a, b, c] = vertices;
        HalfEdges { beyond, apex: [c, a, b] }
    }

    /// The vertices, counter-clockwise seen from outside.
    #[inline]
    pub fn vertices(&self) -> [u32; 3] {
        let [c, a, b] = self.apex;
        [a, b, c]
    }

    /// The half-edge beyond the side opposite vertex `k`.
    #[inline]
    pub fn beyond(&self, k: usize) -> u32 {
        self.beyond[k]
    }

    /// Whether no triangle lies beyond the side opposite vertex `k`.
    #[inline]
    pub(super) fn is_rim(&self, k: usize) -> bool {
        self.beyond[k] == Self::RIM
    }

    /// Sets the half-edge beyond the side opposite vertex `k`.
    pub(super) fn set_beyond(&mut self, k: usize, half_edge: u32) {
        self.beyond[k] = half_edge;
    }

    #[inline]
    pub(super) fn is_triangle(&self) -> bool {
        self.apex[0] != self.apex[1]
    }
}

/// The half-edge of a triangle that begins at its vertex `k`.
#[inline]
pub fn half_edge(triangle: u32, k: usize) -> u32 {
    4 * triangle + k as u32
}

/// The triangle of a half-edge, and the vertex at which it begins.
#[inline]
pub fn place(half_edge: u32) -> (u32, usize) {
    (half_edge >> 2, (half_edge & 3) as usize)
}

impl Grid<'_> {
    /// The half-edges of all triangles, void ones behind those of the tables.
    #[inline]
    pub fn half_edges(&self) -> &[HalfEdges] {
        &self.half_edges
    }

    /// The words of their records: from `6·t` on the half-edges beyond the sides opposite the vertices of triangle t,
    /// and the apexes of its half-edges.
    #[inline]
    pub fn half_edge_words(&self) -> &[u32] {
        bytemuck::cast_slice(&self.half_edges)
    }
}

#[cfg(test)]
mod tests {
    use super::{half_edge, place};
    use crate::grid::icosahedral_grid;

    /// Each half-edge leads to the triangle beyond, into which it enters between the same vertices.
    #[test]
    fn half_edges_lead_through_the_sides_of_triangles() {
        let grid = icosahedral_grid(2);
        assert_eq!(grid.half_edges().len(), grid.triangles());
        for (triangle, sides) in (0u32..).zip(grid.half_edges()) {
            let here = grid.triangle(triangle);
            assert_eq!(sides.vertices(), here);
            for k in 0..3 {
                let (other, j) = place(sides.beyond(k));
                let there = grid.triangle(other);
                assert_eq!([there[j], there[(j + 1) % 3]], [here[(k + 2) % 3], here[(k + 1) % 3]]);
                let back = grid.half_edges()[other as usize].beyond((j + 2) % 3);
                assert_eq!(back, half_edge(triangle, (k + 1) % 3));
            }
        }
    }
}
