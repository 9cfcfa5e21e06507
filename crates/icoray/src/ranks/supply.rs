//! Which columns of a field each rank writes to its node's memory, and which it sends to other nodes.

use super::mesh::{Corner, CornerKey, NodeMesh, Numbers};
use super::nodes::Nodes;
use super::words::{Reader, Words};
use super::{Ranks, bad};
use crate::error::Result;
use std::collections::HashMap;

/// Columns as a rank has them, each with its row in a node's field.
pub(super) type Rows = Vec<(u32, u32)>;

/// What a rank supplies of fields at one kind of place.
#[derive(Debug, Clone, Default)]
pub(super) struct Supply {
    /// Columns that a field of this rank has.
    pub count: usize,
    /// Rows of the node's field.
    pub rows: usize,
    /// Own columns, for this rank's node.
    pub own: Rows,
    /// By leader of each other node, own columns that its mesh has too.
    others: HashMap<usize, Rows>,
    /// Length of the longest list of own columns of any rank, of the longest one for another node, and most rows of a node.
    most: [usize; 3],
}

impl Supply {
    /// Own columns of fields of `count` columns, for the `rows` rows that every node has. Collective.
    pub fn of_whole(ranks: &mut Ranks, count: usize, rows: usize, own: Rows) -> Result<Self> {
        Supply { count, rows, own, ..Supply::default() }.with_most(ranks)
    }

    /// Of fields over parts, at centres and at corners, for the nodes' meshes. Collective.
    pub fn of_parts(
        ranks: &mut Ranks,
        numbers: &Numbers,
        mesh: &NodeMesh,
        nodes: &Nodes,
    ) -> Result<[Self; 2]> {
        let known = ranks.attempt(|| Ok(Known::new(numbers)));
        let known = ranks.together(known)?;
        let center = known.cells_for(ranks, mesh, nodes)?;
        let corner = known.corners_for(ranks, mesh, nodes)?;
        let grid = numbers.grid;
        let center = Supply { count: grid.cells(), rows: mesh.global.len(), ..center };
        let corner = Supply { count: grid.triangles(), rows: mesh.corners.len(), ..corner };
        Ok([center.with_most(ranks)?, corner.with_most(ranks)?])
    }

    /// Adds a column for the node of `rank`.
    fn add(&mut self, nodes: &Nodes, rank: usize, column: u32, row: u32) {
        match nodes.is_mate(rank) {
            true => self.own.push((column, row)),
            false => self.others.entry(nodes.leader_of(rank)).or_default().push((column, row)),
        }
    }

    fn with_most(mut self, ranks: &mut Ranks) -> Result<Self> {
        let others = self.others.values().map(Vec::len).max().unwrap_or(0);
        let mut words = Words::default();
        [self.own.len(), others, self.rows].into_iter().for_each(|count| {
            words.put(count as u64);
        });
        for bytes in ranks.share(&words.0)? {
            let mut reader = Reader(&bytes);
            for most in &mut self.most {
                *most = (*most).max(reader.get()? as usize);
            }
        }
        Ok(self)
    }

    /// What a rank that shares no memory with this one needs.
    pub fn for_rank(&self, nodes: &Nodes, rank: usize) -> &[(u32, u32)] {
        match nodes.is_mate(rank) {
            true => &self.own,
            false => self.others.get(&nodes.leader_of(rank)).map_or(&[], Vec::as_slice),
        }
    }

    /// The most columns that any rank sends another one, if ranks of a node do not share memory or if they do.
    pub fn most(&self, sends_own: bool) -> usize {
        if sends_own { self.most[0] } else { self.most[1] }
    }

    /// Rows of the node that has most.
    pub fn most_rows(&self) -> usize {
        self.most[2]
    }

    /// Of each column, whether it is this rank's own.
    pub fn owned(&self) -> Vec<bool> {
        let mut owned = vec![false; self.count];
        self.own.iter().for_each(|(column, _)| owned[*column as usize] = true);
        owned
    }
}

/// Own cells and the corners that this rank has.
struct Known {
    rank: usize,
    cells: HashMap<u64, u32>,
    corners: HashMap<CornerKey, u32>,
}

impl Known {
    fn new(numbers: &Numbers) -> Self {
        let own = (0..numbers.global.len()).filter(|cell| numbers.owns(*cell));
        let corners = (0..numbers.grid.triangles()).map(|row| (numbers.corner(row).key(), row as u32));
        Known {
            rank: numbers.rank,
            cells: own.map(|cell| (numbers.global[cell], cell as u32)).collect(),
            corners: corners.collect(),
        }
    }

    /// Which own cells are supplied: to its node, and what leaders of other nodes ask for. Collective.
    fn cells_for(&self, ranks: &mut Ranks, mesh: &NodeMesh, nodes: &Nodes) -> Result<Supply> {
        let mut wishes = vec![Words::default(); ranks.size()];
        let mut supply = Supply::default();
        for (row, (cell, owner)) in (0u32..).zip(mesh.global.iter().zip(&mesh.owner)) {
            if let Some(column) = self.cells.get(cell) {
                supply.own.push((*column, row));
            } else if nodes.is_leader() && !nodes.is_mate(*owner as usize) {
                wishes[*owner as usize].put(*cell).put(row.into());
            }
        }
        let came = ranks.exchange(wishes.into_iter().map(|words| words.0).collect())?;
        let mut grant = || {
            for (rank, bytes) in came.iter().enumerate() {
                let mut reader = Reader(bytes);
                while !reader.0.is_empty() {
                    let (cell, row) = (reader.get()?, reader.get()? as u32);
                    let column = self.cells.get(&cell);
                    let column = column.ok_or_else(|| bad(format!("cell {cell} is another rank's")))?;
                    supply.add(nodes, rank, *column, row);
                }
            }
            Ok(())
        };
        let granted = grant();
        ranks.together(granted)?;
        Ok(supply)
    }

    /// Which corners are supplied. Who told of a corner asks the owner of its first cell, and supplies it where that rank does
    /// not have it: tables may leave out corners that are no triangles. Collective.
    fn corners_for(&self, ranks: &mut Ranks, mesh: &NodeMesh, nodes: &Nodes) -> Result<Supply> {
        let mut wishes = vec![Words::default(); ranks.size()];
        let mut asked = vec![Vec::new(); ranks.size()];
        for (row, corner) in mesh.corners.iter().enumerate() {
            // Those of other nodes' cells are told of by several ranks.
            let is_told = mesh.teller.get(row).map_or(nodes.is_leader(), |rank| *rank as usize == self.rank);
            if let Some(rank) = mesh.supplier(corner).filter(|_| is_told) {
                corner.put(wishes[rank].put(row as u64));
                asked[rank].push(row as u32);
            }
        }
        let came = ranks.exchange(wishes.into_iter().map(|words| words.0).collect())?;
        let mut supply = Supply::default();
        let answers = self.grant_corners(nodes, &came, &mut supply);
        let answers = ranks.together(answers)?;
        for (rows, answers) in asked.iter().zip(ranks.exchange(answers)?) {
            for (row, _) in rows.iter().zip(answers).filter(|(_, has)| *has == 0) {
                if let Some(column) = self.corners.get(&mesh.corners[*row as usize].key()) {
                    supply.own.push((*column, *row));
                }
            }
        }
        Ok(supply)
    }

    /// Whether this rank has each of the corners that it is asked for, and will supply it.
    fn grant_corners(&self, nodes: &Nodes, came: &[Vec<u8>], supply: &mut Supply) -> Result<Vec<Vec<u8>>> {
        let mut answers = vec![Vec::new(); came.len()];
        for (rank, bytes) in came.iter().enumerate() {
            let mut reader = Reader(bytes);
            while !reader.0.is_empty() {
                let row = reader.get()? as u32;
                let column = self.corners.get(&Corner::get(&mut reader)?.key());
                answers[rank].push(u8::from(column.is_some()));
                if let Some(column) = column {
                    supply.add(nodes, rank, *column, row);
                }
            }
        }
        Ok(answers)
    }
}
