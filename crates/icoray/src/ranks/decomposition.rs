//! The decomposition of grid and fields over ranks, inferred from the model's description of its cells.

use super::part::Agreed;
use super::{Columns, PartCells, PartCorners, Ranks, bad};
use icoray_grid::Field;
use icoray_grid::Grid;
use icoray_grid::Result;

/// Distribution of a grid and the fields over it; the same kind on all ranks.
#[derive(Debug, Clone)]
pub enum Decomposition {
    /// The whole grid, and whole fields: there is one rank.
    Whole,
    /// Columns of fields, over the tables of its part or over those of the whole grid.
    Columns(Box<Columns>),
}

impl Decomposition {
    /// Agrees with the other ranks on whose each cell is. Collective; `grid` is this rank's own.
    ///
    /// Where `cells` has a row for each cell of the grid on all ranks, the tables are those of its part, row by row.
    /// Else the tables are those of the whole grid on all ranks, and the numbers of cells are rows there.
    ///
    /// Ranks of a node put the tables of their parts together, each in memory of its own ([`Columns::table_bytes`]).
    ///
    /// # Errors
    /// The same on all ranks: [`ErrorKind::Grid`](icoray_grid::ErrorKind::Grid) where numbers or marks do not fit the
    /// grid, a cell is owned by two ranks or by none, a halo is too narrow, parts do not fit each other, or ranks
    /// that must have the whole grid have not; [`ErrorKind::Mpi`](icoray_grid::ErrorKind::Mpi) when the transport
    /// fails.
    pub fn new(ranks: &mut Ranks, grid: &Grid, cells: &PartCells) -> Result<Self> {
        Self::with_corners(ranks, grid, cells, None)
    }

    /// The same with the columns of fields at corners. Where no rank has `corners`, such fields have a column for each
    /// corner of the rank's tables, and that of a corner is read on the rank that owns the first cell of its row of
    /// `corner_cell`. A rank without corners beside others has none.
    ///
    /// Over the tables of a part there is a row for each corner of these tables, and `corners` states which are own.
    ///
    /// # Errors
    /// The same on all ranks: as [`Self::new`], and [`ErrorKind::Grid`](icoray_grid::ErrorKind::Grid) where a corner is
    /// owned by two ranks or by none, or a part has other corners than its tables.
    pub fn with_corners(
        ranks: &mut Ranks,
        grid: &Grid,
        cells: &PartCells,
        corners: Option<&PartCorners>,
    ) -> Result<Self> {
        if ranks.size() == 1 {
            // Its cells are all there are, in the order of its tables.
            corners.map_or(Ok(()), |corners| corners.check_all(grid))?;
            return Agreed::new(ranks, grid, cells).map(|_| Decomposition::Whole);
        }
        let sizes: Vec<(usize, usize)> = ranks.share_values(&(cells.global.len(), grid.cells()))?;
        let Some(odd) = sizes.iter().position(|(rows, cells)| rows != cells) else {
            let columns = Columns::of_parts(ranks, grid, cells, corners)?;
            return Ok(Decomposition::Columns(Box::new(columns)));
        };
        let ((rows, all), (_, first)) = (sizes[odd], sizes[0]);
        if let Some(other) = sizes.iter().position(|(_, cells)| *cells != first) {
            return Err(bad(format!(
                "rank {odd}: cell_global: {rows} rows, expected {all}, one per cell of its grid; or the whole grid on all \
                 ranks, which has {first} cells on rank 0 and {} on rank {other}",
                sizes[other].1
            )));
        }
        Columns::of_whole(ranks, grid, cells, corners).map(|columns| Decomposition::Columns(Box::new(columns)))
    }

    /// The grid that ranks draw, whose own one is `own`: none where each node draws a part of it.
    pub fn drawn_grid<'g>(&'g self, own: &'g Grid<'g>) -> Option<&'g Grid<'g>> {
        match self {
            Decomposition::Whole => Some(own),
            Decomposition::Columns(columns) => columns.drawn_grid(own),
        }
    }

    /// Marks of a field's columns that this rank owns; each column has one owner.
    ///
    /// # Errors
    /// [`ErrorKind::Field`](icoray_grid::ErrorKind::Field) where the field has other columns than this rank.
    pub(crate) fn own_columns(&self, field: &Field) -> Result<Vec<bool>> {
        match self {
            Decomposition::Whole => Ok(vec![true; field.shape().columns]),
            Decomposition::Columns(columns) => columns.owned(field),
        }
    }
}
