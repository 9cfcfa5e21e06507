//! Finds the owner of each corner of parts whose corners have numbers in the whole grid (ICON's triangles).
//!
//! A distributed directory like that of cells: rank `g mod ranks` stores the owner of corner g.

use super::cells::{Numbered, PartCorners};
use super::wire::{decode_lists, encode_lists};
use super::{Ranks, bad};
use icoray_grid::{Error, ErrorKind, Grid, Result};
use std::collections::HashMap;

/// The numbers of the corners of this rank's tables, and marks of its own ones.
pub(super) struct OwnCorners {
    numbered: Numbered,
    base: i64,
}

impl OwnCorners {
    /// Reads `corners`, a row for each corner of `grid`; `None` where no rank has numbered its corners. Collective.
    pub fn read(ranks: &mut Ranks, grid: &Grid, corners: Option<&PartCorners>) -> Result<Option<Self>> {
        if !ranks.share_values(&corners.is_some())?.contains(&true) {
            return Ok(None);
        }
        let read = ranks.attempt(|| match corners {
            Some(corners) => corners.read_part(grid),
            None if grid.triangles() == 0 => Ok(Numbered::default()),
            None => Err(bad("corner_global: missing here and given on other ranks, expected on all or none".into())),
        });
        let numbered = ranks.collective(read)?;
        Ok(Some(OwnCorners { numbered, base: i64::from(grid.tables().index_base) }))
    }

    /// The number of each corner, counted from 0.
    pub fn numbers(&self) -> &[u64] {
        &self.numbered.global
    }

    /// The owner of each of the `wanted` corners. Collective.
    ///
    /// # Errors
    /// Equal on all ranks: [`ErrorKind::Grid`] if two ranks own a corner, or none owns one that is wanted.
    pub fn find_owners(&self, ranks: &mut Ranks, wanted: &[u64]) -> Result<Vec<u32>> {
        let size = ranks.size();
        let keeper = |number: u64| (number % size as u64) as usize;
        let mut own = vec![Vec::new(); size];
        let marked = self.numbered.global.iter().zip(&self.numbered.is_own);
        marked.filter(|(_, is_own)| **is_own).for_each(|(number, _)| own[keeper(*number)].push(*number));
        let mut asked = vec![Vec::new(); size];
        wanted.iter().for_each(|number| asked[keeper(*number)].push(*number));
        let registered = ranks.exchange(encode_lists(&own))?;
        let requested = ranks.exchange(encode_lists(&asked))?;
        let answers = ranks.attempt(|| self.answer(&decode_lists(&registered)?, &decode_lists(&requested)?));
        let answers = ranks.collective(answers)?;
        let received = ranks.exchange(encode_lists(&answers))?;
        let owners = ranks.attempt(|| {
            let mut answers: Vec<_> = decode_lists::<u32>(&received)?.into_iter().map(Vec::into_iter).collect();
            let cut = || Error::new(ErrorKind::Mpi, "owners of corners are cut short");
            wanted.iter().map(|number| answers[keeper(*number)].next().ok_or_else(cut)).collect()
        });
        ranks.collective(owners)
    }

    /// The owner of each requested corner, from the registrations of the ranks.
    fn answer(&self, registered: &[Vec<u64>], asked: &[Vec<u64>]) -> Result<Vec<Vec<u32>>> {
        let name = |number: u64| number as i64 + self.base;
        let mut owner = HashMap::new();
        for (rank, numbers) in registered.iter().enumerate() {
            for number in numbers {
                if let Some(other) = owner.insert(*number, rank as u32) {
                    let corner = name(*number);
                    let message = format!("corner {corner} is owned by ranks {other} and {rank}, expected one owner");
                    return Err(bad(message));
                }
            }
        }
        let owner_of = |number: &u64| {
            let nobodys = || bad(format!("corner {} is owned by no rank, expected one owner", name(*number)));
            owner.get(number).copied().ok_or_else(nobodys)
        };
        asked.iter().map(|numbers| numbers.iter().map(owner_of).collect()).collect()
    }
}
