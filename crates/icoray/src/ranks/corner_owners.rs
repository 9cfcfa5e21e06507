//! Finds the owner of each corner of parts whose corners have numbers in the whole grid (ICON's triangles).

use super::cells::{ColumnKind, Numbered, PartCorners};
use super::owners::find_owners;
use super::{Ranks, bad};
use icoray_grid::{Grid, Result};

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
    /// Equal on all ranks: [`ErrorKind::Grid`](icoray_grid::ErrorKind::Grid) if two ranks own a corner, or none owns
    /// one that is wanted.
    pub fn find_owners(&self, ranks: &mut Ranks, wanted: &[u64]) -> Result<Vec<u32>> {
        let marked = self.numbered.global.iter().zip(&self.numbered.is_own);
        let own = marked.filter(|(_, is_own)| **is_own).map(|(number, _)| *number);
        let nobodys = |_, corner| format!("{corner} is owned by no rank, expected one owner");
        find_owners(ranks, (ColumnKind::Corner, self.base), own, wanted, nobodys)
    }
}
