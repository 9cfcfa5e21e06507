//! Half-edges: the sides of triangles through which a ray enters, with the sides through which it can leave.
//!
//! A ray walks along a great circle, which has a triangle's vertices on its left or on its right. It enters a triangle
//! through the side between a left and a right vertex; the third vertex, the apex, decides between the two other sides.
//!
//! Half-edge `4·t + k` enters triangle t through the side from vertex k (on the left) to vertex k + 1 (on the right),
//! the vertices in counter-clockwise order seen from outside. With the three half-edges of each triangle in one record
//! of 24 bytes, a step of a ray reads one record; the model's four tables of indices are not read.

use super::check::wound;
use super::hole_filling::HoleFilling;
use super::triangle_orientation::TriangleOrientation;
use super::{Grid, GridTables};
use crate::array::MapInline;
use crate::error::{Error, Result};
use crate::memory;
use bytemuck::{Pod, Zeroable};
use icoray_simd::Table;
use rayon::prelude::*;

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

    fn new(vertices: [u32; 3], beyond: [u32; 3]) -> Self {
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

/// # Errors
/// [`ErrorKind::Grid`](crate::ErrorKind::Grid) for more than [`HalfEdges::MAX_TRIANGLES`];
/// [`ErrorKind::Memory`](crate::ErrorKind::Memory) if they do not fit.
pub(super) fn half_edges(
    tables: &GridTables,
    orientations: &[TriangleOrientation],
    filling: &HoleFilling,
) -> Result<Vec<HalfEdges>> {
    let (rows, all) = (orientations.len(), orientations.len() + filling.void.len());
    let most = HalfEdges::MAX_TRIANGLES;
    if all > most {
        let parts = "divide the mesh with icoray_part_set";
        return Err(Error::grid(format!("corner: {rows} rows, expected at most {most} in a process; {parts}")));
    }
    let vertices = |triangle: usize| match triangle.checked_sub(rows) {
        Some(void) => filling.void[void].cells,
        None => wound(tables, orientations, triangle).map_inline(|cell| cell as u32),
    };
    let across = |triangle: usize, k: usize| match triangle.checked_sub(rows) {
        Some(void) => filling.void[void].beyond[k],
        None => across(tables, orientations, filling, triangle, k),
    };
    let record = |triangle: usize| {
        if orientations.get(triangle).is_some_and(|orientation| !orientation.is_triangle()) {
            return HalfEdges::default();
        }
        let here = vertices(triangle);
        let beyond = [0, 1, 2].map_inline(|k: usize| {
            let other = across(triangle, k);
            let there = vertices(other as usize);
            let [left, right] = [here[(k + 2) % 3], here[(k + 1) % 3]];
            let found = (0..3).find(|&k| there[k] == left && there[(k + 1) % 3] == right);
            half_edge(other, found.expect("the grid's check found neighbours of one winding"))
        });
        HalfEdges::new(here, beyond)
    };
    let mut records = memory::room_for("half-edges of the grid", all)?;
    (0..all).into_par_iter().with_min_len(1024).map(record).collect_into_vec(&mut records);
    Ok(records)
}

/// The triangle beyond the side opposite vertex `k` of a triangle of the table, counter-clockwise.
#[inline]
fn across(
    tables: &GridTables,
    orientations: &[TriangleOrientation],
    filling: &HoleFilling,
    triangle: usize,
    k: usize,
) -> u32 {
    let orientation = orientations[triangle];
    let column = if orientation.is_clockwise() { [0, 2, 1][k] } else { k };
    if orientation.is_rim(column) {
        return filling.across(triangle as u32, column);
    }
    let base = i64::from(tables.index_base);
    let edge = (tables.corner_edge.get(3 * triangle + orientation.side_opposite(column)) - base) as usize;
    let [a, b] = tables.edge_corner.row(edge).map_inline(|corner| (corner - base) as u32);
    // The side's two triangles and this one, which cancels: the other remains.
    a ^ b ^ triangle as u32
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
