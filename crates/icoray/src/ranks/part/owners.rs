//! Whose each cell of a local grid is.
//!
//! Found by asking: rank `g mod ranks` keeps the entry of global number g, is told by the cell's owner, and asked by whoever
//! has the cell in its halo. So no rank ever holds numbers of the whole grid.

use super::CellsOfRanks;
use crate::error::{Error, ErrorKind, Result};
use crate::grid::Grid;
use crate::ranks::cells::{Numbered, PartCells};
use crate::ranks::words::{Reader, Words};
use crate::ranks::{Ranks, bad};
use std::collections::HashMap;

/// A part before its neighbours are known.
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
        let Numbered { global, owns_cell } = Numbered::new(cells, grid.cells(), base, None)?;
        let owner = |triangle: u32| {
            let cells = grid.triangle(triangle);
            let lowest = cells.into_iter().min_by_key(|cell| global[*cell as usize]);
            lowest.is_some_and(|cell| owns_cell[cell as usize])
        };
        let owns_triangle = (0..grid.triangles() as u32).map(|t| grid.is_triangle(t) && owner(t)).collect();
        Ok(Local { global, owns_cell, owns_triangle, ranks, base })
    }

    /// A cell's number as the model has it.
    fn number(&self, global: u64) -> i64 {
        global as i64 + self.base
    }

    /// Whom each cell belongs to. Collective.
    pub fn find_owners(&self, ranks: &mut Ranks) -> Result<Vec<u32>> {
        let mut entries = vec![Words::default(); self.ranks];
        for (global, is_own) in self.global.iter().zip(&self.owns_cell) {
            entries[(global % self.ranks as u64) as usize].put(2 * global + u64::from(*is_own));
        }
        let came = ranks.exchange(entries.into_iter().map(|words| words.0).collect())?;
        let answers = ranks.attempt(|| self.answer(&came));
        let answers = ranks.together(answers)?;
        let came = ranks.exchange(answers)?;
        let mut readers: Vec<Reader> = came.iter().map(|bytes| Reader(bytes)).collect();
        let owner = |global: &u64| readers[(global % self.ranks as u64) as usize].get();
        let owners = self.global.iter().map(owner).map(|owner| owner.map(|rank| rank as u32)).collect();
        ranks.settle(owners)
    }

    /// The owner of each cell that ranks have told of, in their order.
    fn answer(&self, came: &[Vec<u8>]) -> Result<Vec<Vec<u8>>> {
        let entries = |bytes: &Vec<u8>| -> Vec<(u64, bool)> {
            let words = bytes.as_chunks::<8>().0.iter().map(|word| u64::from_le_bytes(*word));
            words.map(|word| (word / 2, word % 2 == 1)).collect()
        };
        let came: Vec<_> = came.iter().map(entries).collect();
        let mut owner = HashMap::new();
        for (rank, entries) in came.iter().enumerate() {
            for (global, _) in entries.iter().filter(|(_, is_own)| *is_own) {
                if let Some(other) = owner.insert(*global, rank) {
                    return Err(bad(format!(
                        "cell {} is owned by ranks {other} and {rank}, expected one owner",
                        self.number(*global)
                    )));
                }
            }
        }
        let answer = |(rank, entries): (usize, &Vec<(u64, bool)>)| {
            let mut words = Words::default();
            for (global, _) in entries {
                let owner = owner.get(global).ok_or_else(|| {
                    bad(format!(
                        "cell {} is in the halo of rank {rank}, but owned by no rank",
                        self.number(*global)
                    ))
                })?;
                words.put(*owner as u64);
            }
            Ok(words.0)
        };
        came.iter().enumerate().map(answer).collect()
    }

    /// Which own cells other ranks need the values of, and which halo cells' this one needs, by rank. Collective.
    pub fn find_partners(
        &self,
        ranks: &mut Ranks,
        grid: &Grid,
        owners: &[u32],
    ) -> Result<(CellsOfRanks, CellsOfRanks)> {
        let around = triangles_around(grid);
        // Own triangles have an own cell, and so do all that the gradient at an own cell is the mean of.
        let mut is_used = vec![false; grid.cells()];
        for triangle in (0..grid.triangles() as u32).filter(|t| grid.is_triangle(*t)) {
            let cells = grid.triangle(triangle);
            if cells.iter().any(|cell| self.owns_cell[*cell as usize]) {
                cells.iter().for_each(|cell| is_used[*cell as usize] = true);
            }
        }
        let mut receives = vec![Vec::new(); self.ranks];
        let mut wishes = vec![Words::default(); self.ranks];
        let halo = (0..grid.cells()).filter(|cell| !self.owns_cell[*cell]);
        for cell in halo {
            let owner = owners[cell] as usize;
            // Also of those that are not used: the count shows whether the owner has all triangles.
            wishes[owner].put(self.global[cell]).put(u64::from(around[cell])).put(is_used[cell].into());
            if is_used[cell] {
                receives[owner].push(cell as u32);
            }
        }
        let came = ranks.exchange(wishes.into_iter().map(|words| words.0).collect())?;
        let sends = ranks.attempt(|| self.grant(&came, &around));
        Ok((ranks.together(sends)?, receives))
    }

    fn grant(&self, wishes: &[Vec<u8>], around: &[u32]) -> Result<CellsOfRanks> {
        let own = (0u32..).zip(&self.global).filter(|(cell, _)| self.owns_cell[*cell as usize]);
        let local: HashMap<u64, u32> = own.map(|(cell, global)| (*global, cell)).collect();
        let grant = |(rank, bytes): (usize, &Vec<u8>)| {
            let mut reader = Reader(bytes);
            let mut cells = Vec::new();
            while !reader.0.is_empty() {
                let (global, seen, is_used) = (reader.get()?, reader.get()?, reader.get()? == 1);
                let Some(&cell) = local.get(&global) else {
                    return Err(Error::new(ErrorKind::Internal, format!("cell {global} is not here")));
                };
                let here = u64::from(around[cell as usize]);
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
        wishes.iter().enumerate().map(grant).collect()
    }
}

/// How many triangles each cell has in this rank's grid.
fn triangles_around(grid: &Grid) -> Vec<u32> {
    let mut around = vec![0; grid.cells()];
    for triangle in (0..grid.triangles() as u32).filter(|t| grid.is_triangle(*t)) {
        grid.triangle(triangle).iter().for_each(|cell| around[*cell as usize] += 1);
    }
    around
}
