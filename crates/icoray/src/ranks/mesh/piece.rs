//! The piece of a node's mesh that one rank contributes: own cells, the corners around them, and the cells of other
//! nodes there.

use crate::ranks::cells::NONE;
use crate::ranks::node_ranks::NodeRanks;
use bytemuck::{Pod, Zeroable};
use icoray_grid::Grid;
use serde::{Deserialize, Serialize};

/// A corner in the form that all ranks share.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Corner {
    /// Numbers of its cells in the whole grid, in the order of the model's table; [`NONE`] for a missing one.
    cells: [u64; 3],
    /// Longitude and latitude, radians.
    pub place: [f64; 2],
    /// Its number in the whole grid if ranks have numbered their corners, else [`NONE`].
    number: u64,
}

/// Key of a corner: its cells in rising order and, if these are not three, its position.
pub(crate) type CornerKey = ([u64; 3], [u64; 2]);

impl Corner {
    pub fn key(&self) -> CornerKey {
        let mut cells = self.cells;
        cells.sort_unstable();
        (cells, if self.is_triangle() { [0; 2] } else { self.place.map(f64::to_bits) })
    }

    pub fn is_triangle(&self) -> bool {
        !self.cells.contains(&NONE)
    }

    /// Its cells in the order of the table; `None` for a missing one.
    pub fn cells(&self) -> [Option<u64>; 3] {
        self.cells.map(|cell| (cell != NONE).then_some(cell))
    }

    /// Its number in the whole grid, if ranks have numbered their corners.
    pub fn number(&self) -> Option<u64> {
        (self.number != NONE).then_some(self.number)
    }
}

/// A rank's grid with the numbers and owners of its cells in the whole one.
#[derive(Clone, Copy)]
pub(crate) struct Numbers<'g> {
    pub grid: &'g Grid<'g>,
    /// Number of each cell in the whole grid.
    pub global: &'g [u64],
    /// Rank that owns each cell.
    pub owner: &'g [u32],
    /// Number of each corner in the whole grid, if ranks have numbered them.
    pub corner: Option<&'g [u64]>,
    pub rank: usize,
}

impl Numbers<'_> {
    pub fn owns(&self, cell: usize) -> bool {
        self.owner[cell] as usize == self.rank
    }

    /// This rank's cells at a corner.
    pub fn cells_at(&self, corner: usize) -> [Option<usize>; 3] {
        let tables = self.grid.tables();
        let base = i64::from(tables.index_base);
        let cells = base..base + self.global.len() as i64;
        tables.corner_cell.row::<3>(corner).map(|cell| cells.contains(&cell).then(|| (cell - base) as usize))
    }

    pub fn corner(&self, corner: usize) -> Corner {
        let place = self.grid.tables().corner;
        Corner {
            cells: self.cells_at(corner).map(|cell| cell.map_or(NONE, |cell| self.global[cell])),
            place: [place.lon_rad.get(corner), place.lat_rad.get(corner)],
            number: self.corner.map_or(NONE, |number| number[corner]),
        }
    }

    /// The rank of the node whose piece contains a corner: the owner of the corner's lowest cell that the node owns.
    fn reporter(&self, corner: usize, node: &NodeRanks) -> Option<usize> {
        let cells = self.cells_at(corner).into_iter().flatten();
        let own = cells.filter(|cell| node.is_mate(self.owner[*cell] as usize));
        own.min_by_key(|cell| self.global[*cell]).map(|cell| self.owner[cell] as usize)
    }

    /// The position of each corner of a cell, in the order of its row, among the corners sorted by their keys.
    fn order(&self, cell: usize) -> Vec<u8> {
        let keys: Vec<CornerKey> =
            self.grid.corners_of(cell as u32).map(|corner| self.corner(corner as usize).key()).collect();
        let place = |key: &CornerKey| keys.iter().filter(|other| *other < key).count() as u8;
        keys.iter().map(place).collect()
    }

    /// The piece that this rank contributes to its node's mesh.
    pub fn piece(&self, node: &NodeRanks) -> NodePiece {
        let place = self.grid.tables().center;
        let is_of_other_node = |cell: usize| !node.is_mate(self.owner[cell] as usize);
        let mut corners = Vec::new();
        // Each rank that has a corner with a cell of another node includes that cell.
        let mut is_included: Vec<bool> = (0..self.global.len()).map(|cell| self.owns(cell)).collect();
        for corner in (0..self.grid.triangles()).filter(|c| self.reporter(*c, node) == Some(self.rank)) {
            corners.push(self.corner(corner));
            for cell in self.cells_at(corner).into_iter().flatten() {
                is_included[cell] |= is_of_other_node(cell);
            }
        }
        let cell_row = |cell: usize| CellRow {
            global: self.global[cell],
            owner: self.owner[cell],
            place: [place.lon_rad.get(cell), place.lat_rad.get(cell)],
            order: if self.owns(cell) { self.order(cell) } else { Vec::new() },
        };
        let cells = (0..self.global.len()).filter(|cell| is_included[*cell]).map(cell_row).collect();
        let is_outer = |triangle: &u32| {
            let cells = self.grid.triangle(*triangle).map(|cell| cell as usize);
            cells.into_iter().all(|cell| is_included[cell] && is_of_other_node(cell))
        };
        let triangles = (0..self.grid.triangles() as u32).filter(|t| self.grid.is_triangle(*t));
        let outer = triangles.filter(is_outer).map(|triangle| self.corner(triangle as usize)).collect();
        NodePiece { cells, corners, outer }
    }
}

/// A cell of a piece.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct CellRow {
    pub global: u64,
    pub owner: u32,
    /// Longitude and latitude, radians.
    pub place: [f64; 2],
    /// As [`Numbers::order`]; empty for a cell of another node.
    pub order: Vec<u8>,
}

/// Contribution of one rank to the mesh of its node.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct NodePiece {
    pub cells: Vec<CellRow>,
    /// Corners with own cells of the node.
    pub corners: Vec<Corner>,
    /// Triangles all of whose cells belong to other nodes.
    pub outer: Vec<Corner>,
}
