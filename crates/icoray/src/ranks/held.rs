//! What each rank has of a grid that is not whole everywhere, told apart by what the model says of its cells.

use super::words::{Reader, Words};
use super::{Columns, Part, PartCells, Ranks, bad};
use crate::error::{Error, ErrorKind, Result};
use crate::field::{Field, Location};
use crate::grid::Grid;

/// What a rank has of a grid and of the fields over it, of the same kind on all ranks.
#[derive(Debug, Clone)]
pub enum Held {
    /// Tables and columns of its part: own cells and a halo.
    Part(Part),
    /// The tables of the whole grid, and columns of its own cells and perhaps others.
    Columns(Columns),
}

impl Held {
    /// Agrees with the other ranks on whose each cell is. Collective; `grid` is this rank's own.
    ///
    /// Where `cells` has a row for each cell of the grid on all ranks, the tables are those of its part, row by row. Else the
    /// tables are those of the whole grid on all ranks, and the numbers of cells are rows there.
    ///
    /// # Errors
    /// The same on all ranks: [`ErrorKind::Grid`](crate::ErrorKind::Grid) where numbers or marks do not fit the grid, a cell
    /// is owned by two ranks or by none, a halo is too narrow, or ranks that must have the whole grid have not;
    /// [`ErrorKind::Mpi`](crate::ErrorKind::Mpi) when the transport fails.
    pub fn new(ranks: &mut Ranks, grid: &Grid, cells: &PartCells) -> Result<Self> {
        let mut words = Words::default();
        words.put(cells.global.len() as u64).put(grid.cells() as u64);
        let mut said = Vec::with_capacity(ranks.size());
        for bytes in ranks.share(&words.0)? {
            let mut reader = Reader(&bytes);
            said.push((reader.get()?, reader.get()?));
        }
        // One process has all cells either way.
        let odd = said.iter().position(|(rows, cells)| rows != cells).filter(|_| said.len() > 1);
        let Some(odd) = odd else {
            return Ok(Held::Part(Part::new(ranks, grid, cells)?));
        };
        let ((rows, all), (_, first)) = (said[odd], said[0]);
        if let Some(other) = said.iter().position(|(_, cells)| *cells != first) {
            return Err(bad(format!(
                "rank {odd}: cell_global: {rows} rows, expected {all}, one per cell of its grid; or the whole grid on all \
                 ranks, which has {first} cells on rank 0 and {} on rank {other}",
                said[other].1
            )));
        }
        Ok(Held::Columns(Columns::new(ranks, grid, cells)?))
    }

    /// Tells the columns of a field that are this rank's own, of which each is one rank's only.
    ///
    /// # Errors
    /// [`ErrorKind::Field`](crate::ErrorKind::Field) where the field has other columns than this rank.
    pub(crate) fn own_columns<'s>(&'s self, field: &Field) -> Result<Box<dyn Fn(usize) -> bool + Sync + 's>> {
        let (location, columns) = (field.location(), field.shape().columns);
        let refuse_others = |expected: usize| {
            let message = format!("{columns} columns, expected {expected}, one for each cell");
            if columns == expected { Ok(()) } else { Err(Error::new(ErrorKind::Field, message)) }
        };
        match (self, location) {
            (Held::Part(part), Location::Corner) => Ok(Box::new(|column| part.has(column as u32))),
            (Held::Part(part), Location::Center) => {
                refuse_others(part.columns())?;
                Ok(Box::new(|column| part.owns(column)))
            }
            (Held::Columns(held), location) => {
                refuse_others(held.of_field_at(location)?)?;
                let owns = held.owned();
                Ok(Box::new(move |column| owns[column]))
            }
        }
    }
}
