//! The decomposition of grid and fields over ranks, inferred from the model's description of its cells.

use super::owners::CellOwners;
use super::{Columns, PartCells, PartCorners, Ranks, bad};
use icoray_grid::{Field, Grid, Layers, Result};

/// Distribution of a grid and the fields over it; the same kind on all ranks.
#[derive(Debug, Clone)]
pub enum Decomposition {
    /// The whole grid and whole fields: there is one rank.
    Whole,
    /// Columns of fields, over the tables of the rank's part or of the whole grid.
    Columns(Box<Columns>),
}

/// A grid with layers, of which ranks may have columns each.
#[derive(Debug, Clone, Copy)]
pub struct DistributedGrid<'g> {
    /// This rank's own tables, or the whole grid.
    pub grid: &'g Grid<'g>,
    /// The distribution of columns; `None` if every rank has the whole grid and whole fields.
    pub decomposition: Option<&'g Decomposition>,
    /// The layers.
    pub layers: &'g Layers,
}

impl Decomposition {
    /// Agrees with the other ranks on the owner of each cell. Collective; `grid` is this rank's own.
    ///
    /// If `cells` has a row for each cell of the grid on all ranks, the tables are those of the rank's part, row by
    /// row. Else the tables are those of the whole grid on all ranks, and the numbers of cells are rows of these.
    ///
    /// Ranks of a node share the tables of their joined parts ([`Columns::table_bytes`]), in memory of `ranks`, which is
    /// to be dropped last.
    ///
    /// # Errors
    /// Equal on all ranks: [`ErrorKind::Grid`](icoray_grid::ErrorKind::Grid) if numbers or marks do not fit the grid,
    /// two ranks or no rank owns a cell, a halo is too narrow, parts do not fit each other, or ranks that must have the
    /// whole grid do not have it; [`ErrorKind::Mpi`](icoray_grid::ErrorKind::Mpi) when the transport fails.
    pub fn new(ranks: &mut Ranks, grid: &Grid, cells: &PartCells) -> Result<Self> {
        Self::with_corners(ranks, grid, cells, None)
    }

    /// As [`Self::new`], with the columns of fields at corners. If no rank has `corners`, such fields have a column for
    /// each corner of the rank's tables, and the column of a corner is read on the rank that owns the first cell of its
    /// row of `corner_cell`. If only some ranks have `corners`, the others have no corner.
    ///
    /// With the tables of a part, `corners` has a row for each corner of these tables and states which are own.
    ///
    /// # Errors
    /// Equal on all ranks: as [`Self::new`], and [`ErrorKind::Grid`](icoray_grid::ErrorKind::Grid) if two ranks or no
    /// rank owns a corner, or a part has other corners than its tables.
    pub fn with_corners(
        ranks: &mut Ranks,
        grid: &Grid,
        cells: &PartCells,
        corners: Option<&PartCorners>,
    ) -> Result<Self> {
        if ranks.size() == 1 {
            // These are all of its cells, in the order of its tables.
            corners.map_or(Ok(()), |corners| corners.check_all(grid))?;
            return CellOwners::agree(ranks, grid, cells).map(|_| Decomposition::Whole);
        }
        let (rank, rows, all) = (ranks.rank(), cells.global.len(), grid.cells());
        let first = ranks.hear_root(Ok(all))?;
        let mine = ((rows != all).then_some((rank, rows, all)), (all != first).then_some((rank, all)));
        let (odd, other) = ranks.reduce_values(mine, |a, b| (lowest(a.0, b.0), lowest(a.1, b.1)))?;
        let Some((odd, rows, all)) = odd else {
            let columns = Columns::of_parts(ranks, grid, cells, corners)?;
            return Ok(Decomposition::Columns(Box::new(columns)));
        };
        if let Some((other, cells)) = other {
            return Err(bad(format!(
                "rank {odd}: cell_global: {rows} rows, expected {all}, one per cell of its grid; or the whole grid on all \
                 ranks, which has {first} cells on rank 0 and {cells} on rank {other}"
            )));
        }
        Columns::of_whole(ranks, grid, cells, corners).map(|columns| Decomposition::Columns(Box::new(columns)))
    }

    /// The grid that ranks draw, given this rank's `own` grid; `None` if each node draws a part.
    pub fn drawn_grid<'g>(&'g self, own: &'g Grid<'g>) -> Option<&'g Grid<'g>> {
        match self {
            Decomposition::Whole => Some(own),
            Decomposition::Columns(columns) => columns.drawn_grid(own),
        }
    }

    /// The grid through which this rank's rays pass, given its `own` grid: that of its node if ranks have parts.
    pub fn node_grid<'g>(&'g self, own: &'g Grid<'g>) -> &'g Grid<'g> {
        match self {
            Decomposition::Whole => own,
            Decomposition::Columns(columns) => columns.node_grid(own),
        }
    }

    /// Marks of a field's columns that this rank owns; each column has one owner.
    ///
    /// # Errors
    /// [`ErrorKind::Field`](icoray_grid::ErrorKind::Field) if the field has other columns than this rank.
    pub(crate) fn own_columns(&self, field: &Field) -> Result<Vec<bool>> {
        match self {
            Decomposition::Whole => Ok(vec![true; field.shape().columns]),
            Decomposition::Columns(columns) => columns.owned(field),
        }
    }
}

/// The lower of two values, such as those of the lowest ranks that have any.
fn lowest<T: Ord>(a: Option<T>, b: Option<T>) -> Option<T> {
    a.into_iter().chain(b).min()
}
