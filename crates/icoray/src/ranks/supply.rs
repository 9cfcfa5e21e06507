//! Selects the columns of a field that each rank writes to its node's memory, and those that it sends to other nodes.

use super::mesh::{Corner, CornerKey, NodeMesh, Numbers};
use super::node_ranks::NodeRanks;
use super::owners::OwnCorners;
use super::{RankLists, RankMessages, Ranks, bad};
use glam::DVec3;
use icoray_grid::Result;
use std::collections::HashMap;

/// Distance, in planet radii, within which two ranks' positions of a cell count as equal: tens of roundings of f32.
const POSITION: f64 = 1e-5;

/// Columns in a rank's numbering, each with its row in a node's field.
pub(super) type Rows = Vec<(u32, u32)>;

/// Columns of fields that a rank supplies, at one location.
#[derive(Debug, Clone, Default)]
pub(super) struct Supply {
    /// Number of columns of a field of this rank.
    pub count: usize,
    /// Number of rows of the node's field.
    pub rows: usize,
    /// Own columns, for this rank's node.
    pub own: Rows,
    /// Own columns for other node, by the rank that receives them there.
    pub others: HashMap<usize, Rows>,
    /// Maxima over the ranks: own columns, columns for a rank of another node, rows of a node, and ranks of other nodes
    /// that receive columns.
    pub max: [usize; 4],
}

impl Supply {
    /// The own columns of fields of `count` columns, for the `rows` rows of every node, which `partners` ranks of other
    /// nodes receive. Collective.
    pub fn of_whole(ranks: &mut Ranks, count: usize, rows: usize, own: Rows, partners: usize) -> Result<Self> {
        Supply { count, rows, own, ..Supply::default() }.with_maxima(ranks, partners)
    }

    /// The columns of fields over parts, at centres and at corners, for the nodes' meshes. Collective.
    pub fn of_parts(
        ranks: &mut Ranks,
        (numbers, lookup): (&Numbers, &ColumnLookup),
        mesh: &NodeMesh,
        node: &NodeRanks,
        own_corners: Option<&OwnCorners>,
    ) -> Result<[Self; 2]> {
        let center = lookup.cells_for(ranks, numbers, mesh, node)?;
        let corner = lookup.corners_for(ranks, mesh, node, own_corners)?;
        let grid = numbers.grid;
        let center = Supply { count: grid.cells(), rows: mesh.grid.cells(), ..center };
        let corner = Supply { count: grid.triangles(), rows: mesh.corners.len(), ..corner };
        let receivers = [&center, &corner].map(|supply| supply.others.len());
        Ok([center.with_maxima(ranks, receivers[0])?, corner.with_maxima(ranks, receivers[1])?])
    }

    /// Adds a column for the node of `rank`, which asks for it.
    fn add(&mut self, node: &NodeRanks, rank: usize, column: u32, row: u32) {
        match node.is_mate(rank) {
            true => self.own.push((column, row)),
            false => self.others.entry(rank).or_default().push((column, row)),
        }
    }

    fn with_maxima(mut self, ranks: &mut Ranks, receivers: usize) -> Result<Self> {
        let others = self.others.values().map(Vec::len).max().unwrap_or(0);
        let counts = [self.own.len(), others, self.rows, receivers];
        self.max = ranks.reduce_values(counts, |a, b| std::array::from_fn(|k| a[k].max(b[k])))?;
        self.own.shrink_to_fit();
        Ok(self)
    }

    /// Marks of the columns that this rank owns.
    pub fn owned(&self) -> Vec<bool> {
        let mut owned = vec![false; self.count];
        self.own.iter().for_each(|(column, _)| owned[*column as usize] = true);
        owned
    }
}

/// Columns of a rank's fields, by the numbers of own cells and by the keys of corners.
pub(super) struct ColumnLookup {
    rank: usize,
    cells: HashMap<u64, u32>,
    corners: HashMap<CornerKey, u32>,
}

impl ColumnLookup {
    pub fn new(numbers: &Numbers) -> Self {
        let own = (0..numbers.global.len()).filter(|cell| numbers.owns(*cell));
        let corners = (0..numbers.grid.triangles()).map(|row| (numbers.corner(row).key(), row as u32));
        ColumnLookup {
            rank: numbers.rank,
            cells: own.map(|cell| (numbers.global[cell], cell as u32)).collect(),
            corners: corners.collect(),
        }
    }

    /// The column of a corner, if this rank has it.
    pub fn corner(&self, corner: &Corner) -> Option<u32> {
        self.corners.get(&corner.key()).copied()
    }

    /// The own cells that this rank supplies to its node and, as requested by ranks of them, to other node, on which
    /// their positions must be the same as here. Collective.
    fn cells_for(&self, ranks: &mut Ranks, numbers: &Numbers, mesh: &NodeMesh, node: &NodeRanks) -> Result<Supply> {
        let mut requests = RankLists::new();
        let mut supply = Supply::default();
        for (row, (cell, owner)) in (0u32..).zip(mesh.grid.cell_numbers().iter().zip(mesh.owner)) {
            if let Some(column) = self.cells.get(cell) {
                supply.own.push((*column, row));
            } else if node.has_share(*owner as usize) && !node.is_mate(*owner as usize) {
                requests.entry(*owner as usize).or_default().push((*cell, row, mesh.grid.directions()[row as usize]));
            }
        }
        let received = ranks.exchange_lists::<(u64, u32, [f64; 3])>(&requests)?;
        let grant = || {
            for (rank, requests) in received {
                for (cell, row, theirs) in requests {
                    let column = self.cells.get(&cell);
                    let column = column.ok_or_else(|| bad(format!("cell {cell} is another rank's")))?;
                    let [mine, theirs] = [numbers.grid.direction(*column), theirs.into()];
                    if mine.distance(theirs) > POSITION {
                        let lon_lat = |at: DVec3| [at.y.atan2(at.x), at.z.atan2(at.x.hypot(at.y))].map(f64::to_degrees);
                        let [mine, theirs] = [mine, theirs].map(lon_lat);
                        let number = cell as i64 + i64::from(numbers.grid.tables().index_base);
                        return Err(bad(format!(
                            "cell {number}: longitude and latitude {theirs:.3?} degrees in the halo of rank {rank}'s \
                             node, expected {mine:.3?} as on rank {}, which owns the cell; give all ranks the same positions",
                            self.rank
                        )));
                    }
                    supply.add(node, rank, *column, row);
                }
            }
            Ok(())
        };
        ranks.collective_work(grant)?;
        Ok(supply)
    }

    /// The corners that this rank supplies. The rank whose piece contains a corner requests it from the corner's owner
    /// or, if ranks have not numbered their corners, from the owner of its first cell, and supplies it itself if that
    /// rank does not have it: tables may omit corners that are no triangles. Collective.
    fn corners_for(
        &self,
        ranks: &mut Ranks,
        mesh: &NodeMesh,
        node: &NodeRanks,
        own_corners: Option<&OwnCorners>,
    ) -> Result<Supply> {
        // Corners between cells of other nodes are in several pieces: the leader requests them.
        let is_reporter =
            |row: usize| mesh.reporter.get(row).map_or(node.is_leader(), |rank| *rank as usize == self.rank);
        let listed = mesh.corners.iter().enumerate().filter(|(row, _)| is_reporter(*row));
        let rows: Vec<(u32, Corner)> = listed.map(|(row, corner)| (row as u32, *corner)).collect();
        let owners: Vec<Option<u32>> = match own_corners {
            None => {
                let first = |corner: &Corner| corner.cells().into_iter().flatten().next();
                let owner = |(_, corner): &(u32, Corner)| Some(mesh.owner[mesh.row(first(corner)?)? as usize]);
                rows.iter().map(owner).collect()
            }
            Some(own) => {
                let wanted: Vec<u64> = rows.iter().filter_map(|(_, corner)| corner.number()).collect();
                own.find_owners(ranks, &wanted)?.into_iter().map(Some).collect()
            }
        };
        let suppliers = rows.into_iter().zip(owners);
        let suppliers = suppliers.filter_map(|((row, corner), owner)| Some((row, corner, owner? as usize)));
        let mut requests = RankLists::new();
        for (row, corner, rank) in suppliers {
            requests.entry(rank).or_default().push((row, corner));
        }
        // The answer to each request is a byte, 1 if this rank has the corner.
        let (mut supply, mut answers) = (Supply::default(), RankMessages::new());
        for (rank, requests) in ranks.exchange_lists(&requests)? {
            for (row, corner) in requests {
                let column = self.corner(&corner);
                answers.entry(rank).or_default().push(u8::from(column.is_some()));
                if let Some(column) = column {
                    supply.add(node, rank, column, row);
                }
            }
        }
        for (rank, answers) in ranks.exchange(answers)? {
            let requests = requests.get(&rank).into_iter().flatten();
            for ((row, corner), _) in requests.zip(answers).filter(|(_, has)| *has == 0) {
                if let Some(column) = self.corner(corner) {
                    supply.own.push((column, *row));
                }
            }
        }
        Ok(supply)
    }
}
