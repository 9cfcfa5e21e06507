//! A grid together with the tables that it borrows.

use super::{Connectivity, Grid, GridTables, LonLat};
use crate::error::Result;
use self_cell::self_cell;
use std::fmt;

/// The six tables, owned; numbered from 0.
#[derive(Debug, Default)]
pub struct OwnedTables {
    /// Longitude and latitude of cells and of corners, radians.
    pub center: [Vec<f64>; 2],
    /// Longitude and latitude of corners, radians.
    pub corner: [Vec<f64>; 2],
    /// The cells around each corner, three by three; -1 for a missing one.
    pub corner_cell: Vec<i32>,
    /// Cells and corners around each cell, and edges.
    pub connectivity: Connectivity,
    /// The number of each cell in the whole grid, from 0; empty if that is its row.
    pub cell_number: Vec<u64>,
    /// The number of the whole grid's first cell in the model.
    pub number_base: i64,
}

impl OwnedTables {
    /// The tables, borrowed.
    pub fn tables(&self) -> GridTables<'_> {
        let of = &self.connectivity;
        GridTables {
            index_base: 0,
            center: LonLat::of(&self.center[0], &self.center[1]),
            corner: LonLat::of(&self.corner[0], &self.corner[1]),
            cell_corner: of.cell_corner.as_slice().into(),
            cell_corner_row: of.cell_corner_row,
            cell_corner_count: Some(of.cell_corner_count.as_slice().into()),
            corner_cell: self.corner_cell.as_slice().into(),
            corner_edge: of.corner_edge.as_slice().into(),
            edge_corner: of.edge_corner.as_slice().into(),
        }
    }

    fn bytes(&self) -> usize {
        let of = &self.connectivity;
        let indices = [&self.corner_cell, &of.cell_corner, &of.cell_corner_count, &of.corner_edge, &of.edge_corner];
        let indices: usize = indices.into_iter().map(|table| size_of_val(table.as_slice())).sum();
        let places: usize = self.center.iter().chain(&self.corner).map(|v| size_of_val(v.as_slice())).sum();
        indices + places + size_of_val(self.cell_number.as_slice())
    }
}

self_cell!(
    struct TablesAndGrid {
        owner: OwnedTables,
        #[covariant]
        dependent: Grid,
    }
);

/// A checked grid with the tables that it borrows.
pub struct OwnedGrid(TablesAndGrid);

impl OwnedGrid {
    /// Checks the tables.
    ///
    /// # Errors
    /// As [`Grid::new`].
    pub fn new(tables: OwnedTables) -> Result<Self> {
        let grid = TablesAndGrid::try_new(tables, |tables| {
            let OwnedTables { cell_number, number_base, .. } = tables;
            Ok(Grid { cell_number, number_base: *number_base, ..Grid::new(tables.tables())? })
        });
        grid.map(OwnedGrid)
    }

    /// The grid of the tables.
    pub fn grid(&self) -> &Grid<'_> {
        self.0.borrow_dependent()
    }

    pub(super) fn tables(&self) -> &OwnedTables {
        self.0.borrow_owner()
    }

    /// Bytes of the tables and of those derived from them.
    pub fn bytes(&self) -> usize {
        self.tables().bytes() + self.grid().derived_bytes()
    }
}

impl fmt::Debug for OwnedGrid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "grid of {} cells", self.grid().cells())
    }
}
