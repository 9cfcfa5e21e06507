//! Columns over the tables of the whole grid, which every rank has.

use super::Columns;
use crate::ranks::cells::{ColumnKind, Numbered, PartCells, PartCorners};
use crate::ranks::nodes::Nodes;
use crate::ranks::supply::{Rows, Supply};
use crate::ranks::wire::{decode_lists, encode_lists};
use crate::ranks::{Ranks, bad};
use icoray_grid::{Grid, Result};

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
        let own = own_rows(ranks, grid, ColumnKind::Cell, || cells.read_rows(grid))?;
        let has_corner_numbers = ranks.share_values(&corners.is_some())?.contains(&true);
        let corner = match has_corner_numbers {
            true => {
                let read = || corners.map_or_else(|| Ok(Numbered::default()), |corners| corners.read_rows(grid));
                let own = own_rows(ranks, grid, ColumnKind::Corner, read)?;
                let count = corners.map_or(0, |corners| corners.global.len());
                Supply::of_whole(ranks, count, grid.triangles(), own)?
            }
            false => Supply::of_whole(ranks, grid.triangles(), grid.triangles(), corners_of_cells(grid, &own))?,
        };
        let center = Supply::of_whole(ranks, cells.global.len(), grid.cells(), own)?;
        let nodes = Nodes::one(ranks);
        Ok(Columns { center, corner, has_corner_numbers, cells: grid.cells(), nodes, node_grid: None, halo: None })
    }
}

/// This rank's own columns with their rows in the tables, each of which has one owner. Collective.
fn own_rows(ranks: &mut Ranks, grid: &Grid, kind: ColumnKind, read: impl FnOnce() -> Result<Numbered>) -> Result<Rows> {
    let numbers = ranks.attempt(|| {
        let Numbered { global, is_own } = read()?;
        let own = (0u32..).zip(global).zip(is_own).filter(|(_, is_own)| *is_own);
        Ok(own.map(|((column, row), _)| (column, row as u32)).collect::<Rows>())
    });
    let own = ranks.collective(numbers)?;
    refuse_other_owners(ranks, grid, kind, &own)?;
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

/// Refuses rows that two ranks or no rank owns. Rank `r mod ranks` checks row r.
fn refuse_other_owners(ranks: &mut Ranks, grid: &Grid, kind: ColumnKind, own: &Rows) -> Result<()> {
    let (rank, size, rows) = (ranks.rank(), ranks.size(), kind.rows(grid));
    let (what, base) = (kind.name(), i64::from(grid.tables().index_base));
    let mut owned = vec![Vec::new(); size];
    for (_, row) in own {
        owned[*row as usize % size].push(*row);
    }
    let received = ranks.exchange(encode_lists(&owned))?;
    let checked = ranks.attempt(|| {
        let mut owners: Vec<Option<usize>> = vec![None; rows.saturating_sub(rank).div_ceil(size)];
        for (owner, rows) in decode_lists::<u32>(&received)?.into_iter().enumerate() {
            for row in rows.into_iter().map(|row| row as usize) {
                if let Some(other) = owners[row / size].replace(owner) {
                    let number = row as i64 + base;
                    let message = format!("{what} {number} is owned by ranks {other} and {owner}, expected one owner");
                    return Err(bad(message));
                }
            }
        }
        if let Some(nobodys) = owners.iter().position(Option::is_none) {
            let number = (nobodys * size + rank) as i64 + base;
            let message = format!("{what} {number} of the whole grid is owned by no rank, expected one owner");
            return Err(bad(message));
        }
        Ok(())
    });
    ranks.collective(checked)
}
