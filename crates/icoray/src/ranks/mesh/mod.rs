//! The mesh that the ranks of a node have together: their own cells and, around them, cells of other nodes.
//!
//! The leader of a node joins it from the pieces that the ranks send of their parts, and writes it to memory that they
//! share; where they cannot, each joins it. Cells are in the order of their numbers in the whole grid, and rows of
//! tables have the order of the rank that owns the cell: sums over them equal those over the whole grid to the bit.

mod piece;

use super::node_ranks::NodeRanks;
use super::part::marks;
use super::wire::{decode, encode};
use super::{NodeMemory, Part, RankMessages, Ranks, bad};
use icoray_grid::grid::{OwnedGrid, OwnedTables};
use icoray_grid::marks::Marks;
use icoray_grid::threads::Threads;
use icoray_grid::{Connectivity, Error, ErrorKind, Grid, Result, block};
use piece::{CellRow, NodePiece};
pub(super) use piece::{Corner, CornerKey, Numbers};
use self_cell::self_cell;
use std::fmt;

/// Entry for a missing neighbour, in tables that count from 0.
const MISSING: i32 = -1;

/// A node's mesh.
pub(super) struct NodeMesh<'n> {
    /// Its cells have numbers in the whole grid.
    pub grid: &'n Grid<'n>,
    /// Rank that owns each cell.
    pub owner: &'n [u32],
    /// Key of each corner, equal on all ranks.
    pub corners: &'n [Corner],
    /// The rank whose piece contains each of the first corners, which are those with own cells of the node.
    pub reporter: &'n [u32],
}

impl<'n> NodeMesh<'n> {
    /// The mesh of a grid and the `numbers` beside it.
    pub fn new(grid: &'n Grid<'n>, numbers: &'n NodeMemory) -> Result<Self> {
        let numbers = numbers.bytes();
        let (owner, corners) = (block::array(numbers, 0)?, block::array(numbers, 1)?);
        Ok(NodeMesh { grid, owner, corners, reporter: block::array(numbers, 2)? })
    }

    /// The row of a cell of the whole grid.
    pub fn row(&self, global: u64) -> Option<u32> {
        self.grid.cell_numbers().binary_search(&global).ok().map(|row| row as u32)
    }
}

/// The grid that the ranks of a node have together, in memory that they share. The leader joins the parts.
#[derive(Debug)]
pub(crate) struct NodeGrid {
    tables: SharedTables,
    /// Bytes of its tables and of those derived from them, if this rank wrote them.
    pub bytes: usize,
    /// Whether some ranks have their own memory although they should share it.
    pub is_refused: bool,
}

impl NodeGrid {
    /// Joins the parts of this rank's node; also returns memory of the arrays of [`NodeMesh`] beside the grid, in their
    /// order. Collective.
    pub(super) fn join(ranks: &mut Ranks, numbers: &Numbers, node: &NodeRanks) -> Result<(Self, NodeMemory)> {
        let piece = ranks.collective_work(|| Ok(encode(&numbers.piece(node))))?;
        let base = i64::from(numbers.grid.tables().index_base);
        let mut joined = JoinedMesh::at(ranks, node, &[node.leader()], &piece, base)?;
        let mine = joined.as_ref().map_or([0; 2], |mesh| mesh.lengths);
        let most = ranks.reduce_values(mine, |a, b| std::array::from_fn(|k| a[k].max(b[k])))?;
        let (mut numbers, mut tables) = (ranks.take_node(most[0])?, ranks.take_node(most[1])?);
        let is_refused = numbers.is_refused || tables.is_refused;
        if is_refused {
            joined = JoinedMesh::at(ranks, node, node.mates(), &piece, base)?;
        }
        let mut bytes = 0;
        let rank = ranks.rank();
        let writes_numbers = numbers.leader == rank;
        numbers.write(ranks, |put| {
            joined
                .iter()
                .filter(|_| writes_numbers)
                .for_each(|mesh| block::write(&mesh.numbers(), &mut |at: usize, bytes: &[u8]| put(at, bytes)));
            Ok(())
        })?;
        let writes_tables = tables.leader == rank;
        tables.write(ranks, |put| {
            let Some(mesh) = joined.as_ref().filter(|_| writes_tables) else { return Ok(()) };
            bytes = mesh.lengths[1];
            mesh.with_tables(|arrays| block::write(arrays, &mut |at: usize, bytes: &[u8]| put(at, bytes)));
            Ok(())
        })?;
        drop(joined);
        let tables = SharedTables::try_new(tables, |memory| Tables::read(ranks, memory, &numbers, node))?;
        Ok((NodeGrid { tables, bytes, is_refused }, numbers))
    }

    pub fn grid(&self) -> &Grid<'_> {
        &self.tables.borrow_dependent().grid
    }

    /// The node's own part of the grid, if there are other nodes.
    pub fn part(&self) -> Option<&Part<'_>> {
        self.tables.borrow_dependent().part.as_ref()
    }
}

/// What the ranks of a node read in its memory.
struct Tables<'m> {
    grid: Grid<'m>,
    part: Option<Part<'m>>,
}

impl<'m> Tables<'m> {
    /// The grid and, if there are other nodes, the node's part of it. Collective.
    fn read(ranks: &mut Ranks, memory: &'m NodeMemory, numbers: &NodeMemory, node: &NodeRanks) -> Result<Self> {
        let words = |number: usize| block::array(memory.bytes(), OwnedGrid::ARRAYS + number).map(Marks::of_words);
        let (grid, marks) = ranks.collective_work(|| Ok((Grid::of_block(memory.bytes())?, [words(0)?, words(1)?])))?;
        if node.mates().len() == ranks.size() {
            return Ok(Tables { grid, part: None });
        }
        let mesh = ranks.collective(NodeMesh::new(&grid, numbers))?;
        let part = Some(Part::of_node(ranks, &mesh, marks, node)?);
        Ok(Tables { grid, part })
    }
}

self_cell!(
    /// A grid and its part in the memory of a node.
    struct SharedTables {
        owner: NodeMemory,
        #[covariant]
        dependent: Tables,
    }
);

impl fmt::Debug for SharedTables {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "grid of {} cells in a node's memory", self.borrow_dependent().grid.cells())
    }
}

/// A node's mesh in memory of the rank that joined it.
struct JoinedMesh {
    grid: OwnedGrid,
    owner: Vec<u32>,
    corners: Vec<Corner>,
    reporter: Vec<u32>,
    /// Of the node's own cells and triangles.
    marks: [Marks<'static>; 2],
    /// Lengths of the blocks of [`Self::numbers`] and of [`Self::with_tables`].
    lengths: [usize; 2],
}

impl JoinedMesh {
    /// Sends this rank's `piece` to the ranks `to`, and joins those that it receives. Collective.
    fn at(ranks: &mut Ranks, node: &NodeRanks, to: &[usize], piece: &[u8], base: i64) -> Result<Option<Self>> {
        let received = ranks.exchange(to.iter().map(|rank| (*rank, piece.to_vec())).collect())?;
        ranks.collective_work(|| (!received.is_empty()).then(|| Self::of(&received, node, base)).transpose())
    }

    fn of(received: &RankMessages, node: &NodeRanks, base: i64) -> Result<Self> {
        let (mut cells, mut corners, mut reporter, mut outer) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for (rank, bytes) in received {
            let piece: NodePiece = decode(bytes)?;
            reporter.resize(reporter.len() + piece.corners.len(), *rank as u32);
            cells.extend(piece.cells);
            corners.extend(piece.corners);
            outer.extend(piece.outer);
        }
        cells.sort_by_key(|cell| cell.global);
        // Cells and triangles of other nodes are in the pieces of several ranks.
        cells.dedup_by_key(|cell| cell.global);
        outer.sort_by_key(Corner::key);
        outer.dedup_by_key(|corner| corner.key());
        corners.append(&mut outer);
        let cell_number: Vec<u64> = cells.iter().map(|cell| cell.global).collect();
        let tables = tables(&cells, &cell_number, &corners)?;
        let tables = OwnedTables { cell_number, number_base: base, ..tables };
        let owner: Vec<u32> = cells.iter().map(|cell| cell.owner).collect();
        // A thread of its own: neither uses the caller's threads nor starts the process-wide pool.
        Threads::new(1)?.run(|| {
            let grid = OwnedGrid::new(tables)?;
            let marks = marks(grid.grid(), |cell| node.is_mate(owner[cell] as usize));
            let mut mesh = JoinedMesh { grid, owner, corners, reporter, marks, lengths: [0; 2] };
            mesh.lengths = [block::length(&mesh.numbers()), mesh.with_tables(block::length)];
            Ok(mesh)
        })
    }

    /// Calls `write` with the arrays of the grid and the words of its marks.
    fn with_tables<R>(&self, write: impl FnOnce(&[&[u8]]) -> R) -> R {
        let marks = self.marks.each_ref().map(|marks| bytemuck::cast_slice(marks.words()));
        self.grid.with_arrays(|arrays| write(&[&arrays[..], &marks].concat()))
    }

    fn numbers(&self) -> [&[u8]; 3] {
        [bytemuck::cast_slice(&self.owner), bytemuck::cast_slice(&self.corners), bytemuck::cast_slice(&self.reporter)]
    }
}

fn tables(cells: &[CellRow], global: &[u64], corners: &[Corner]) -> Result<OwnedTables> {
    let row = |cell: u64| {
        let row = global.binary_search(&cell);
        row.map_err(|_| Error::new(ErrorKind::Mpi, format!("cell {cell} of a corner is in no piece")))
    };
    let mut corner_cell = Vec::with_capacity(3 * corners.len());
    for corner in corners {
        for cell in corner.cells() {
            corner_cell.push(cell.map(row).transpose()?.map_or(MISSING, |row| row as i32));
        }
    }
    if i32::try_from(global.len().max(corner_cell.len())).is_err() {
        return Err(bad(format!("{} cells on one node, expected fewer than 2^31 sides of triangles", global.len())));
    }
    let mut connectivity = connect(&corner_cell, corners, global.len())?;
    set_corners(&mut connectivity, &corner_cell, cells, corners);
    let places = |k: usize| cells.iter().map(|cell| cell.place[k]).collect();
    let corner_places = |k: usize| corners.iter().map(|corner| corner.place[k]).collect();
    Ok(OwnedTables {
        center: [places(0), places(1)],
        corner: [corner_places(0), corner_places(1)],
        corner_cell,
        connectivity,
        ..OwnedTables::default()
    })
}

/// Joins the corners that are triangles.
fn connect(corner_cell: &[i32], corners: &[Corner], cells: usize) -> Result<Connectivity> {
    let rows: Vec<usize> = (0..corners.len()).filter(|row| corners[*row].is_triangle()).collect();
    let triangles: Vec<i32> = rows.iter().flat_map(|row| &corner_cell[3 * row..3 * row + 3]).copied().collect();
    let mut of = Connectivity::new(&triangles, cells)?;
    let mut corner_edge = vec![MISSING; corner_cell.len()];
    for (row, edges) in rows.iter().zip(of.corner_edge.chunks_exact(3)) {
        corner_edge[3 * row..3 * row + 3].copy_from_slice(edges);
    }
    of.corner_edge = corner_edge;
    of.edge_corner.iter_mut().filter(|t| **t != MISSING).for_each(|t| *t = rows[*t as usize] as i32);
    Ok(of)
}

/// Gives each cell all of its corners, in the order of its owner.
fn set_corners(to: &mut Connectivity, corner_cell: &[i32], cells: &[CellRow], corners: &[Corner]) {
    let mut around = vec![Vec::new(); cells.len()];
    for (i, cell) in corner_cell.iter().enumerate().filter(|(_, cell)| **cell != MISSING) {
        around[*cell as usize].push((i / 3) as i32);
    }
    let row = around.iter().map(Vec::len).max().unwrap_or(0).max(3);
    let mut table = vec![MISSING; row * cells.len()];
    for ((cell, around), place) in cells.iter().zip(&mut around).zip(table.chunks_exact_mut(row)) {
        around.sort_by_key(|corner| corners[*corner as usize].key());
        for (k, place) in place.iter_mut().enumerate() {
            // A longer row repeats the last corner.
            let k = k.min(around.len().saturating_sub(1));
            // Cells of other nodes have only some of their corners here, in any order.
            let at = cell.order.get(k).filter(|_| cell.order.len() == around.len()).map_or(k, |at| usize::from(*at));
            *place = around.get(at).copied().unwrap_or(MISSING);
        }
    }
    to.cell_corner_count = vec![row as i32; cells.len()];
    (to.cell_corner, to.cell_corner_row) = (table, row);
}
