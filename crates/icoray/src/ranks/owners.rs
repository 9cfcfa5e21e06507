//! Finds the owners of cells and corners that have numbers in the whole grid.
//!
//! A distributed directory: each rank stores the owners of a range of numbers, which the owners register and ranks with
//! the cell or corner in their halo look up. So no rank ever stores numbers of the whole grid, and ranks whose cells have
//! close numbers, as models give them, exchange few messages.

use super::cells::{NONE, Numbered, PartCells, PartCorners, names};
use super::{RankLists, Ranks, bad};
use icoray_grid::{Error, ErrorKind, Grid, Location, Result};
use std::collections::{BTreeMap, HashMap};

/// The ownership of cells that ranks with parts have agreed on.
pub(super) struct CellOwners {
    /// Number of each cell in the whole grid, from 0.
    pub global: Vec<u64>,
    /// Rank that owns each cell.
    pub owner: Vec<u32>,
}

impl CellOwners {
    /// Agrees on the owner of each cell, which has all triangles around it. Collective; `grid` is this rank's own.
    pub fn agree(ranks: &mut Ranks, grid: &Grid, cells: &PartCells) -> Result<Self> {
        let (rows, base) = (0..grid.cells(), i64::from(grid.tables().index_base));
        let numbered = ranks.collective_work(|| {
            let numbered = Numbered::of_part(Location::Center, cells.global, cells.owned, grid)?;
            let is_missing = |cell: &u32| numbered.global[*cell as usize] == NONE;
            let Some(cell) = triangles(grid).flatten().find(is_missing) else { return Ok(numbered) };
            let (row, none) = (i64::from(cell) + base, base - 1);
            Err(bad(format!("cell_global row {row}: {none}, expected a number, as a triangle has this cell")))
        })?;
        let own = rows.clone().filter(|cell| numbered.is_own[*cell]).map(|cell| numbered.global[cell]);
        let wanted: Vec<usize> = rows.filter(|cell| numbered.global[*cell] != NONE).collect();
        let numbers: Vec<u64> = wanted.iter().map(|cell| numbered.global[*cell]).collect();
        let nobodys = |rank, cell| format!("{cell} is in the halo of rank {rank}, but owned by no rank");
        let found = find_owners(ranks, (Location::Center, base), own, &numbers, nobodys)?;
        let mut owner = vec![u32::MAX; grid.cells()];
        wanted.into_iter().zip(found).for_each(|(cell, found)| owner[cell] = found);
        check_halos(ranks, grid, &numbered, &owner)?;
        Ok(CellOwners { global: numbered.global, owner })
    }
}

/// The numbers of the corners of this rank's tables, and marks of its own ones.
pub(super) struct OwnCorners {
    numbered: Numbered,
    base: i64,
}

impl OwnCorners {
    /// Reads `corners`, a row for each corner of `grid`; `None` where no rank has numbered its corners. Collective.
    pub fn read(ranks: &mut Ranks, grid: &Grid, corners: Option<&PartCorners>) -> Result<Option<Self>> {
        if !ranks.reduce_values(corners.is_some(), |a, b| a || b)? {
            return Ok(None);
        }
        let numbered = ranks.collective_work(|| match corners {
            Some(corners) => Numbered::of_part(Location::Corner, corners.global, corners.owned, grid),
            None if grid.triangles() == 0 => Ok(Numbered::default()),
            None => Err(bad("corner_global: missing here and given on other ranks, expected on all or none".into())),
        })?;
        Ok(Some(OwnCorners { numbered, base: i64::from(grid.tables().index_base) }))
    }

    /// The number of each corner, counted from 0.
    pub fn numbers(&self) -> &[u64] {
        &self.numbered.global
    }

    /// The owner of each of the `wanted` corners. Collective.
    ///
    /// # Errors
    /// Equal on all ranks: [`ErrorKind::Grid`] if two ranks own a corner, or none owns
    /// one that is wanted.
    pub fn find_owners(&self, ranks: &mut Ranks, wanted: &[u64]) -> Result<Vec<u32>> {
        let marked = self.numbered.global.iter().zip(&self.numbered.is_own);
        let own = marked.filter(|(_, is_own)| **is_own).map(|(number, _)| *number);
        let nobodys = |_, corner| format!("{corner} is owned by no rank, expected one owner");
        find_owners(ranks, (Location::Corner, self.base), own, wanted, nobodys)
    }
}

/// The cells of each triangle.
fn triangles(grid: &Grid) -> impl Iterator<Item = [u32; 3]> {
    (0..grid.triangles() as u32).filter(|t| grid.is_triangle(*t)).map(|t| grid.triangle(t))
}

/// The owners of the `wanted` numbers of cells or corners, of which each rank registers its `own` ones. `base` is the
/// first number in the model's counting; `nobodys` is the message of a number that a rank wants and none owns, from
/// that rank and from the number's name. Collective.
///
/// # Errors
/// Equal on all ranks: [`ErrorKind::Grid`] if two ranks own a number, or none owns one that is wanted.
pub(super) fn find_owners(
    ranks: &mut Ranks,
    (location, base): (Location, i64),
    own: impl Iterator<Item = u64>,
    wanted: &[u64],
    nobodys: impl Fn(usize, String) -> String,
) -> Result<Vec<u32>> {
    let [what, ..] = names(location);
    let own: Vec<u64> = own.collect();
    let range = own.iter().copied().min().zip(own.iter().copied().max());
    let range = ranks.reduce_values(range, |a, b| match (a, b) {
        (Some((low, high)), Some((l, h))) => Some((low.min(l), high.max(h))),
        (a, b) => a.or(b),
    })?;
    let (first, last) = range.unwrap_or((0, 0));
    let (size, kept) = (ranks.size() as u64, (last - first) / ranks.size() as u64 + 1);
    // Numbers that no rank owns may be outside of the range.
    let keeper = |number: u64| (number.saturating_sub(first) / kept).min(size - 1) as usize;
    let (mut registered, mut requested) = (RankLists::<u64>::new(), RankLists::<u64>::new());
    own.into_iter().for_each(|number| registered.entry(keeper(number)).or_default().push(number));
    wanted.iter().for_each(|number| requested.entry(keeper(*number)).or_default().push(*number));
    let registered = ranks.exchange_lists(&registered)?;
    let requested = ranks.exchange_lists(&requested)?;
    let name = |number: u64| format!("{what} {}", number as i64 + base);
    let answers = ranks.collective_work(|| {
        let mut owner = HashMap::new();
        for (rank, numbers) in registered {
            for number in numbers {
                if let Some(other) = owner.insert(number, rank as u32) {
                    let number = name(number);
                    return Err(bad(format!("{number} is owned by ranks {other} and {rank}, expected one owner")));
                }
            }
        }
        let owner_of =
            |rank: usize, number: u64| owner.get(&number).copied().ok_or_else(|| bad(nobodys(rank, name(number))));
        let of_rank = |(rank, numbers): (usize, Vec<u64>)| {
            Ok((rank, numbers.into_iter().map(|number| owner_of(rank, number)).collect::<Result<_>>()?))
        };
        requested.into_iter().map(of_rank).collect::<Result<RankLists<u32>>>()
    })?;
    let received = ranks.exchange_lists(&answers)?;
    ranks.collective_work(|| {
        let mut answers: BTreeMap<_, _> =
            received.into_iter().map(|(rank, owners)| (rank, owners.into_iter())).collect();
        let cut = || Error::new(ErrorKind::Mpi, format!("owners of {what}s are cut short"));
        let mut next = |rank| answers.get_mut(&rank).and_then(Iterator::next).ok_or_else(cut);
        wanted.iter().map(|number| next(keeper(*number))).collect()
    })
}

/// Checks that each owner has all triangles around its cells that other ranks have in their halos. Collective.
fn check_halos(ranks: &mut Ranks, grid: &Grid, Numbered { global, is_own }: &Numbered, owner: &[u32]) -> Result<()> {
    let mut around = vec![0u32; grid.cells()];
    triangles(grid).flatten().for_each(|cell| around[cell as usize] += 1);
    let mut halo = RankLists::new();
    for cell in (0..grid.cells()).filter(|cell| !is_own[*cell] && global[*cell] != NONE) {
        halo.entry(owner[cell] as usize).or_default().push((global[cell], around[cell]));
    }
    let received = ranks.exchange_lists(&halo)?;
    ranks.collective_work(|| {
        let own = (0..grid.cells()).filter(|cell| is_own[*cell]).map(|cell| (global[cell], around[cell]));
        let own: HashMap<u64, u32> = own.collect();
        for (rank, halo) in received {
            for (number, seen) in halo {
                let here = own.get(&number).copied();
                let here = here.ok_or_else(|| Error::new(ErrorKind::Internal, format!("cell {number} is not here")))?;
                if here < seen {
                    let number = number as i64 + i64::from(grid.tables().index_base);
                    return Err(bad(format!(
                        "own cell {number} has {here} triangles here and {seen} in the halo of rank {rank}, expected \
                         all of them: a halo at least one cell wide"
                    )));
                }
            }
        }
        Ok(())
    })
}
