//! What a rank tells the others of its node of its part: own cells, the corners around them, and the cells of other nodes there.

use crate::error::Result;
use crate::grid::Grid;
use crate::ranks::nodes::Nodes;
use crate::ranks::words::{Reader, Words};

/// In place of the number of a cell that is missing.
const NONE: u64 = u64::MAX;

/// A corner as all ranks know it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Corner {
    /// Numbers of its cells in the whole grid, in the order of the model's table; [`NONE`] where one is missing.
    cells: [u64; 3],
    /// Longitude and latitude, radians.
    pub place: [f64; 2],
}

/// What tells corners apart: their cells in rising order and, where these are not three, their places.
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

    pub fn put(&self, words: &mut Words) {
        self.cells.into_iter().for_each(|cell| {
            words.put(cell);
        });
        words.put_f64(self.place[0]).put_f64(self.place[1]);
    }

    pub fn get(reader: &mut Reader) -> Result<Self> {
        let cells = [reader.get()?, reader.get()?, reader.get()?];
        Ok(Corner { cells, place: [reader.get_f64()?, reader.get_f64()?] })
    }

    /// In the order of the table; `None` for one that is missing.
    pub fn cells(&self) -> [Option<u64>; 3] {
        self.cells.map(|cell| (cell != NONE).then_some(cell))
    }

    /// The first cell of its row that is there: whose owner has the values of fields at corners.
    pub fn first(&self) -> Option<u64> {
        self.cells().into_iter().flatten().next()
    }
}

/// A rank's grid with the numbers and owners of its cells in the whole one.
#[derive(Clone, Copy)]
pub(crate) struct Numbers<'g> {
    pub grid: &'g Grid<'g>,
    /// Of each cell, its number in the whole grid.
    pub global: &'g [u64],
    /// Of each cell, the rank that owns it.
    pub owner: &'g [u32],
    pub rank: usize,
}

impl Numbers<'_> {
    pub fn owns(&self, cell: usize) -> bool {
        self.owner[cell] as usize == self.rank
    }

    /// This rank's cells at a corner.
    fn cells_at(&self, corner: usize) -> [Option<usize>; 3] {
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
        }
    }

    /// The rank that tells its node of a corner: the owner of its lowest cell that the node owns.
    fn teller(&self, corner: usize, nodes: &Nodes) -> Option<usize> {
        let cells = self.cells_at(corner).into_iter().flatten();
        let own = cells.filter(|cell| nodes.is_mate(self.owner[*cell] as usize));
        own.min_by_key(|cell| self.global[*cell]).map(|cell| self.owner[cell] as usize)
    }

    /// The place of each corner of a cell, in the order of its row, among the corners in order of their keys.
    fn order(&self, cell: usize) -> Vec<u8> {
        let keys: Vec<CornerKey> =
            self.grid.corners_of(cell as u32).map(|corner| self.corner(corner as usize).key()).collect();
        let place = |key: &CornerKey| keys.iter().filter(|other| *other < key).count() as u8;
        keys.iter().map(place).collect()
    }

    /// What this rank tells its node, as bytes.
    pub fn tell(&self, nodes: &Nodes) -> Vec<u8> {
        let place = self.grid.tables().center;
        let mut corners = Words::default();
        // Cells of other nodes are told by each rank that has a corner with them.
        let mut is_told: Vec<bool> = (0..self.global.len()).map(|cell| self.owns(cell)).collect();
        for corner in (0..self.grid.triangles()).filter(|c| self.teller(*c, nodes) == Some(self.rank)) {
            self.corner(corner).put(&mut corners);
            for cell in self.cells_at(corner).into_iter().flatten() {
                is_told[cell] |= !nodes.is_mate(self.owner[cell] as usize);
            }
        }
        let mut words = Words::default();
        words.put(is_told.iter().filter(|is_told| **is_told).count() as u64);
        for cell in (0..self.global.len()).filter(|cell| is_told[*cell]) {
            words.put(self.global[cell]).put(self.owner[cell].into());
            words.put_f64(place.lon_rad.get(cell)).put_f64(place.lat_rad.get(cell));
            let order = if self.owns(cell) { self.order(cell) } else { Vec::new() };
            words.put_bytes(&order);
        }
        words.put_bytes(&corners.0);
        self.tell_beyond(nodes, &is_told, &mut words);
        words.0
    }

    /// Triangles of told cells that are all of other nodes.
    fn tell_beyond(&self, nodes: &Nodes, is_told: &[bool], words: &mut Words) {
        for triangle in (0..self.grid.triangles() as u32).filter(|t| self.grid.is_triangle(*t)) {
            let cells = self.grid.triangle(triangle).map(|cell| cell as usize);
            if cells.iter().all(|cell| is_told[*cell] && !nodes.is_mate(self.owner[*cell] as usize)) {
                self.corner(triangle as usize).put(words);
            }
        }
    }
}

/// A cell as a rank has told of it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ToldCell<'b> {
    pub global: u64,
    pub owner: u32,
    /// Longitude and latitude, radians.
    pub place: [f64; 2],
    /// As [`Numbers::order`]; empty for a cell of another node.
    pub order: &'b [u8],
}

/// What the ranks of a node have told.
#[derive(Debug, Default)]
pub(crate) struct Told<'b> {
    pub cells: Vec<ToldCell<'b>>,
    /// Corners with own cells of the node, each with the rank that told of it.
    pub corners: Vec<(Corner, u32)>,
    /// Triangles of other nodes' cells.
    pub beyond: Vec<Corner>,
}

/// Reads what `rank` has told.
pub(crate) fn read<'b>(rank: usize, bytes: &'b [u8], told: &mut Told<'b>) -> Result<()> {
    let mut reader = Reader(bytes);
    for _ in 0..reader.get()? {
        told.cells.push(ToldCell {
            global: reader.get()?,
            owner: reader.get()? as u32,
            place: [reader.get_f64()?, reader.get_f64()?],
            order: reader.get_bytes()?,
        });
    }
    let mut corners = Reader(reader.get_bytes()?);
    while !corners.0.is_empty() {
        told.corners.push((Corner::get(&mut corners)?, rank as u32));
    }
    while !reader.0.is_empty() {
        told.beyond.push(Corner::get(&mut reader)?);
    }
    Ok(())
}
