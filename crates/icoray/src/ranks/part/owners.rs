//! Finds the owner of each cell of a local grid.
//!
//! A distributed directory: rank `g mod ranks` stores the entry of global number g, which the owner of the cell
//! registers and ranks with the cell in their halo look up. So no rank ever stores numbers of the whole grid.

use super::CellsOfRanks;
use crate::ranks::cells::{NONE, Numbered, PartCells};
use crate::ranks::wire::{decode_lists, encode_lists};
use crate::ranks::{Ranks, bad};
use icoray_grid::{Error, ErrorKind, Grid, Result};
use std::collections::HashMap;

/// A part before its neighbours are found.
pub(super) struct Local {
    /// Counted from 0.
    pub global: Vec<u64>,
    pub owns_cell: Vec<bool>,
    pub owns_triangle: Vec<bool>,
    ranks: usize,
    base: i64,
}

impl Local {
    pub fn new(grid: &Grid, cells: &PartCells, ranks: usize) -> Result<Self> {
        let base = i64::from(grid.tables().index_base);
        let Numbered { global, is_own: owns_cell } = cells.read(grid.cells(), base)?;
        let mut triangles = (0..grid.triangles() as u32).filter(|t| grid.is_triangle(*t)).map(|t| grid.triangle(t));
        if let Some(cell) = triangles.find_map(|cells| cells.into_iter().find(|cell| global[*cell as usize] == NONE)) {
            let (row, none) = (i64::from(cell) + base, base - 1);
            return Err(bad(format!("cell_global row {row}: {none}, expected a number, as a triangle has this cell")));
        }
        let owner = |triangle: u32| {
            let cells = grid.triangle(triangle);
            let lowest = cells.into_iter().min_by_key(|cell| global[*cell as usize]);
            lowest.is_some_and(|cell| owns_cell[cell as usize])
        };
        let owns_triangle = (0..grid.triangles() as u32).map(|t| grid.is_triangle(t) && owner(t)).collect();
        Ok(Local { global, owns_cell, owns_triangle, ranks, base })
    }

    /// A cell's number in the model's counting.
    fn number(&self, global: u64) -> i64 {
        global as i64 + self.base
    }

    /// The owner of each cell. Collective.
    pub fn find_owners(&self, ranks: &mut Ranks) -> Result<Vec<u32>> {
        let keeper = |global: u64| (global % self.ranks as u64) as usize;
        let mut entries = vec![Vec::new(); self.ranks];
        for (global, is_own) in self.global.iter().zip(&self.owns_cell).filter(|(global, _)| **global != NONE) {
            entries[keeper(*global)].push((*global, *is_own));
        }
        let received = ranks.exchange(encode_lists(&entries))?;
        let answers = ranks.attempt(|| self.answer(&decode_lists(&received)?));
        let answers = ranks.collective(answers)?;
        let received = ranks.exchange(encode_lists(&answers))?;
        let owners = ranks.attempt(|| {
            let mut answers: Vec<_> = decode_lists::<u32>(&received)?.into_iter().map(Vec::into_iter).collect();
            let cut = || Error::new(ErrorKind::Mpi, "owners of cells are cut short");
            let owner = |global: &u64| match *global {
                NONE => Ok(u32::MAX),
                global => answers[keeper(global)].next().ok_or_else(cut),
            };
            self.global.iter().map(owner).collect()
        });
        ranks.settle(owners)
    }

    /// The owner of each cell in the entries of each rank: the cell's number and whether the rank owns it.
    fn answer(&self, entries: &[Vec<(u64, bool)>]) -> Result<Vec<Vec<u32>>> {
        let mut owner = HashMap::new();
        for (rank, entries) in entries.iter().enumerate() {
            for (global, _) in entries.iter().filter(|(_, is_own)| *is_own) {
                if let Some(other) = owner.insert(*global, rank) {
                    return Err(bad(format!(
                        "cell {} is owned by ranks {other} and {rank}, expected one owner",
                        self.number(*global)
                    )));
                }
            }
        }
        let owner_of = |rank: usize, global: &u64| {
            let owner = owner.get(global).map(|owner| *owner as u32);
            owner.ok_or_else(|| {
                let cell = self.number(*global);
                bad(format!("cell {cell} is in the halo of rank {rank}, but owned by no rank"))
            })
        };
        let of_rank = |(rank, entries): (usize, &Vec<(u64, bool)>)| {
            entries.iter().map(|(global, _)| owner_of(rank, global)).collect()
        };
        entries.iter().enumerate().map(of_rank).collect()
    }

    /// The own cells whose values other ranks need, and the halo cells whose values this one needs, by rank.
    /// Collective.
    pub fn find_partners(
        &self,
        ranks: &mut Ranks,
        grid: &Grid,
        owners: &[u32],
    ) -> Result<(CellsOfRanks, CellsOfRanks)> {
        let around = triangles_around(grid);
        // Every own triangle has an own cell, and so has every triangle that enters the gradient at an own cell.
        let mut is_used = vec![false; grid.cells()];
        for triangle in (0..grid.triangles() as u32).filter(|t| grid.is_triangle(*t)) {
            let cells = grid.triangle(triangle);
            if cells.iter().any(|cell| self.owns_cell[*cell as usize]) {
                cells.iter().for_each(|cell| is_used[*cell as usize] = true);
            }
        }
        let mut receives = vec![Vec::new(); self.ranks];
        let mut requests = vec![Vec::new(); self.ranks];
        let halo = (0..grid.cells()).filter(|cell| !self.owns_cell[*cell] && self.global[*cell] != NONE);
        for cell in halo {
            let owner = owners[cell] as usize;
            // Includes unused cells: the owner checks that this rank has all triangles around them.
            requests[owner].push((self.global[cell], around[cell], is_used[cell]));
            if is_used[cell] {
                receives[owner].push(cell as u32);
            }
        }
        let received = ranks.exchange(encode_lists(&requests))?;
        let sends = ranks.attempt(|| self.grant(&decode_lists(&received)?, &around));
        Ok((ranks.collective(sends)?, receives))
    }

    /// The own cells whose values each rank requests. A request is a cell's number, the number of triangles around it
    /// in the halo of that rank, and whether the rank uses its values.
    fn grant(&self, requests: &[Vec<(u64, u32, bool)>], around: &[u32]) -> Result<CellsOfRanks> {
        let own = (0u32..).zip(&self.global).filter(|(cell, _)| self.owns_cell[*cell as usize]);
        let local: HashMap<u64, u32> = own.map(|(cell, global)| (*global, cell)).collect();
        let grant = |(rank, requests): (usize, &Vec<(u64, u32, bool)>)| {
            let mut cells = Vec::new();
            for &(global, seen, is_used) in requests {
                let Some(&cell) = local.get(&global) else {
                    return Err(Error::new(ErrorKind::Internal, format!("cell {global} is not here")));
                };
                let here = around[cell as usize];
                if here < seen {
                    return Err(bad(format!(
                        "own cell {} has {here} triangles here and {seen} in the halo of rank {rank}, expected all of \
                         them: a halo at least one cell wide",
                        self.number(global)
                    )));
                }
                if is_used {
                    cells.push(cell);
                }
            }
            Ok(cells)
        };
        requests.iter().enumerate().map(grant).collect()
    }
}

/// Number of triangles around each cell in this rank's grid.
fn triangles_around(grid: &Grid) -> Vec<u32> {
    let mut around = vec![0; grid.cells()];
    for triangle in (0..grid.triangles() as u32).filter(|t| grid.is_triangle(*t)) {
        grid.triangle(triangle).iter().for_each(|cell| around[*cell as usize] += 1);
    }
    around
}
