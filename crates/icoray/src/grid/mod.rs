//! The geodesic grid: the model's six tables, checked once, and the little that is derived from them.
//!
//! Voronoi cells and Delaunay triangles are duals: triangle `t` *is* corner `t`, its vertices are the centres of
//! `corner_cell[t]`, its sides are `corner_edge[t]`, and `edge_corner` leads across a side (§3.1 of the paper). A frustum
//! is a triangle between two layers, so the whole 3-D mesh is walked with these 2-D tables alone.
//!
//! Derived and owned: a unit vector per cell (24 bytes) and one byte per triangle, its [`Seats`], that says which side lies
//! opposite which vertex and how the row winds. The tables themselves stay the model's.

mod check;
mod generate;
mod seats;
mod tables;

pub(crate) use check::unit_vector;
pub use generate::{IcosahedralMesh, MAX_LEVEL};
pub use tables::{GridTables, Indices, LonLat, Reals};

use crate::error::Result;
use glam::DVec3;
use seats::Seats;

/// A checked geodesic grid over borrowed tables.
#[derive(Debug)]
pub struct Grid<'a> {
    tables: GridTables<'a>,
    direction: Vec<[f64; 3]>,
    seats: Vec<Seats>,
}

impl<'a> Grid<'a> {
    /// Checks `tables` whole and derives directions and seats, in parallel.
    ///
    /// # Errors
    /// [`ErrorKind::Grid`](crate::ErrorKind::Grid) names the table, row, value and what was expected: sizes, index
    /// ranges, each edge's two triangles, each triangle's three edges and cells, a closed sphere (V - E + F = 2, one
    /// winding, areas summing to 4π), no zero-area triangle, each cell's corners, finite coordinates.
    /// [`ErrorKind::Unsupported`](crate::ErrorKind::Unsupported): the mesh has a hole.
    pub fn new(tables: GridTables<'a>) -> Result<Self> {
        check::sizes(&tables)?;
        let direction = check::directions(&tables)?;
        check::corner_positions(&tables)?;
        check::indices(&tables)?;
        let seats = check::triangles(&tables, &direction)?;
        check::closed(&tables, &direction, &seats)?;
        check::cells(&tables)?;
        Ok(Grid { tables, direction, seats })
    }

    /// The tables as given.
    pub fn tables(&self) -> &GridTables<'a> {
        &self.tables
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.direction.len()
    }

    /// Number of dual triangles, which is the number of corners.
    pub fn triangles(&self) -> usize {
        self.seats.len()
    }

    /// Bytes that icoray owns for this grid beside the model's tables.
    pub fn derived_bytes(&self) -> usize {
        size_of_val(self.direction.as_slice()) + size_of_val(self.seats.as_slice())
    }

    /// Unit vector from the sphere's centre to the centre of `cell` (z through the north pole, x through longitude 0).
    #[inline]
    pub fn direction(&self, cell: u32) -> DVec3 {
        DVec3::from_array(self.direction[cell as usize])
    }

    /// The three cells of `triangle`, in the table's order.
    #[inline]
    pub fn triangle(&self, triangle: u32) -> [u32; 3] {
        let base = i64::from(self.tables.index_base);
        // The check found every entry within the table's rows, which 32 bits can number.
        self.tables.corner_cell.row(triangle as usize).map(|cell| (cell - base) as u32)
    }

    /// The triangle beyond the side of `triangle` that lies opposite its vertex `k`.
    #[inline]
    pub fn across(&self, triangle: u32, k: usize) -> u32 {
        let base = i64::from(self.tables.index_base);
        let column = self.seats[triangle as usize].side_opposite(k);
        let edge = (self.tables.corner_edge.get(3 * triangle as usize + column) - base) as usize;
        let [a, b] = self.tables.edge_corner.row(edge).map(|corner| (corner - base) as u32);
        // The side's two triangles and this one, of which one stands twice: what is left is the other.
        a ^ b ^ triangle
    }

    /// Whether the table's order of the vertices of `triangle` runs clockwise seen from outside.
    #[inline]
    pub fn is_clockwise(&self, triangle: u32) -> bool {
        self.seats[triangle as usize].is_clockwise()
    }

    /// The corners of `cell` without repetition, in the table's order.
    pub fn corners_of(&self, cell: u32) -> impl Iterator<Item = u32> + '_ {
        let table = self.tables.cell_corner;
        let row = self.tables.cell_corner_row;
        let used = self.tables.cell_corner_count.map_or(row, |count| count.get(cell as usize) as usize);
        let start = cell as usize * row;
        let base = i64::from(self.tables.index_base);
        let is_new = move |i: &usize| (start..*i).all(|j| table.get(j) != table.get(*i));
        (start..start + used).filter(is_new).map(move |i| (table.get(i) - base) as u32)
    }
}
