//! Columns over the tables of the whole grid, which every rank has.

use super::Columns;
use crate::ranks::Ranks;
use crate::ranks::cells::{Numbered, PartCells, PartCorners};
use crate::ranks::node_ranks::NodeRanks;
use crate::ranks::owners::find_owners;
use crate::ranks::supply::{Rows, Supply};
use icoray_grid::{ColumnCount, Grid, Location, Result};

impl Columns {
    /// Agrees with the other ranks on the owner of each cell and each corner. Collective; all have the whole grid's
    /// tables.
    ///
    /// If no rank has numbers of corners, fields at corners have a column for each corner of the grid, and a corner
    /// belongs to the owner of the first cell of its row. Else ranks without numbers have no corner.
    pub(in crate::ranks) fn of_whole(
        ranks: &mut Ranks,
        grid: &Grid,
        cells: &PartCells,
        corners: Option<&PartCorners>,
    ) -> Result<Self> {
        let node = NodeRanks::find(ranks)?;
        let partners = node.of_all(ranks)?;
        let own = own_rows(ranks, grid, Location::Center, || {
            Numbered::of_rows(Location::Center, cells.global, cells.owned, grid)
        })?;
        let has_corner_numbers = ranks.reduce_values(corners.is_some(), |a, b| a || b)?;
        let (count, own_corners) = if has_corner_numbers {
            let read = || match corners {
                Some(corners) => Numbered::of_rows(Location::Corner, corners.global, corners.owned, grid),
                None => Ok(Numbered::default()),
            };
            (corners.map_or(0, |corners| corners.global.len()), own_rows(ranks, grid, Location::Corner, read)?)
        } else {
            (grid.triangles(), corners_of_cells(grid, &own))
        };
        let corner = Supply::of_whole(ranks, count, grid.triangles(), own_corners, partners.len())?;
        let center = Supply::of_whole(ranks, cells.global.len(), grid.cells(), own, partners.len())?;
        let (cells, node_grid, halo) = (grid.cells(), None, None);
        Ok(Columns { center, corner, has_corner_numbers, cells, node, partners, node_grid, halo })
    }
}

/// This rank's own columns with their rows in the tables, each of which has one owner. Collective.
fn own_rows(
    ranks: &mut Ranks,
    grid: &Grid,
    location: Location,
    read: impl FnOnce() -> Result<Numbered>,
) -> Result<Rows> {
    let own = ranks.collective_work(|| {
        let Numbered { global, is_own } = read()?;
        let own = (0u32..).zip(global).zip(is_own).filter(|(_, is_own)| *is_own);
        Ok(own.map(|((column, row), _)| (column, row as u32)).collect::<Rows>())
    })?;
    // Each rank asks for the rows of which it keeps the owners.
    let (rows, base) = (ColumnCount::new(grid, location).columns as u64, i64::from(grid.tables().index_base));
    let each = rows.saturating_sub(1) / ranks.size() as u64 + 1;
    let first = (ranks.rank() as u64 * each).min(rows);
    let kept: Vec<u64> = (first..rows.min(first + each)).collect();
    let nobodys = |_, row| format!("{row} of the whole grid is owned by no rank, expected one owner");
    find_owners(ranks, (location, base), own.iter().map(|(_, row)| u64::from(*row)), &kept, nobodys)?;
    Ok(own)
}

/// The corners whose first cell is one of `own`: the columns of a field with all corners of the grid.
fn corners_of_cells(grid: &Grid, own: &Rows) -> Rows {
    let mut owns_cell = vec![false; grid.cells()];
    own.iter().for_each(|(_, cell)| owns_cell[*cell as usize] = true);
    let base = i64::from(grid.tables().index_base);
    let cells = base..base + grid.cells() as i64;
    let is_own = |corner: &u32| {
        let row = grid.tables().corner_cell.row::<3>(*corner as usize);
        row.into_iter().find(|cell| cells.contains(cell)).is_some_and(|cell| owns_cell[(cell - base) as usize])
    };
    (0..grid.triangles() as u32).filter(is_own).map(|corner| (corner, corner)).collect()
}
