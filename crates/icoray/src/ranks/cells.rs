//! The model's description of a rank's cells and corners: their ownership and their numbers in the whole grid.

use icoray_grid::{ColumnCount, Error, ErrorKind, Grid, Indices, Location, Result};

/// Marks the number of a missing cell.
pub(super) const NONE: u64 = u64::MAX;

/// Marks of a rank's own cells or corners.
#[derive(Debug, Clone, Copy)]
pub enum Owned<'a> {
    /// Number of own cells or corners, which come first, as in MPAS.
    First(usize),
    /// Those with a value other than 0 are own; one value per cell or corner.
    Marked(&'a [i32]),
}

/// The model's description of a rank's part: one row per cell, read by
/// [`Decomposition::new`](super::Decomposition::new).
#[derive(Debug, Clone, Copy)]
pub struct PartCells<'a> {
    /// The number of each cell in the whole grid (MPAS `indexToCellID`), counted from the grid's `index_base`. Numbers
    /// may have gaps, unless they are rows of whole tables. `index_base - 1` marks a column that is no cell of this
    /// rank, such as NICAM's copies of cells in halos: it is not own, and no triangle contains it.
    pub global: Indices<'a>,
    /// Own cells; the others are the halo.
    pub owned: Owned<'a>,
}

/// The columns of a rank's fields at corners, read by
/// [`Decomposition::with_corners`](super::Decomposition::with_corners).
#[derive(Debug, Clone, Copy)]
pub struct PartCorners<'a> {
    /// The number of each column's corner in the whole grid, counted from the grid's `index_base` (ICON: the global
    /// index of a triangle). With the tables of the whole grid it is a row of these; with those of a part numbers may
    /// have gaps.
    pub global: Indices<'a>,
    /// Own corners; the others are the halo.
    pub owned: Owned<'a>,
}

/// Names of a cell or a corner, of the table of numbers and of that of marks.
pub(super) fn names(location: Location) -> [&'static str; 3] {
    match location {
        Location::Center => ["cell", "cell_global", "is_owned"],
        Location::Corner => ["corner", "corner_global", "is_corner_owned"],
    }
}

/// Numbers and marks, read and checked.
#[derive(Debug, Default)]
pub(super) struct Numbered {
    /// Counted from 0; [`NONE`] for a column that is no cell.
    pub global: Vec<u64>,
    pub is_own: Vec<bool>,
}

impl PartCorners<'_> {
    /// Checks that these are all corners of `grid`, all own and in the order of its tables.
    pub(super) fn check_all(&self, grid: &Grid) -> Result<()> {
        let base = i64::from(grid.tables().index_base);
        let Numbered { global, is_own } = Numbered::of_part(Location::Corner, self.global, self.owned, grid)?;
        let number = |corner: u64| corner as i64 + base;
        if let Some((row, other)) = (0u64..).zip(&global).find(|(row, corner)| row != *corner) {
            let (row, other) = (number(row), number(*other));
            let message =
                format!("corner_global row {row}: {other}, expected {row}: one rank has corners in the tables' order");
            return Err(bad(message));
        }
        match (0u64..).zip(is_own).find(|(_, is_own)| !is_own) {
            Some((corner, _)) => Err(bad(format!("corner {} is owned by no rank, expected one owner", number(corner)))),
            None => Ok(()),
        }
    }
}

impl Numbered {
    /// Reads a row for each cell or corner of `grid`, the tables of a part.
    pub fn of_part(location: Location, global: Indices, owned: Owned, grid: &Grid) -> Result<Self> {
        let base = i64::from(grid.tables().index_base);
        Numbered::new(location, (global, owned), ColumnCount::new(grid, location).columns, base, None)
    }

    /// Reads all rows, whose numbers are rows of the tables of `grid`.
    pub fn of_rows(location: Location, global: Indices, owned: Owned, grid: &Grid) -> Result<Self> {
        let (base, rows) = (i64::from(grid.tables().index_base), ColumnCount::new(grid, location).columns);
        Numbered::new(location, (global, owned), global.len(), base, Some(base + rows as i64 - 1))
    }

    /// Reads `rows` rows with distinct numbers from `base` to `last`, or without an upper bound.
    fn new(
        location: Location,
        (global, owned): (Indices, Owned),
        rows: usize,
        base: i64,
        last: Option<i64>,
    ) -> Result<Self> {
        let [what, numbers, marks] = names(location);
        let count = |name: &str, len: usize| {
            let message = format!("{name}: {len} rows, expected {rows}, one per {what}");
            if len == rows { Ok(()) } else { Err(bad(message)) }
        };
        count(numbers, global.len())?;
        let is_own: Vec<bool> = match owned {
            Owned::First(owned) if owned > rows => {
                return Err(bad(format!("{owned} own {what}s, expected at most {rows}, which this rank has")));
            }
            Owned::First(owned) => (0..rows).map(|row| row < owned).collect(),
            Owned::Marked(given) => {
                count(marks, given.len())?;
                given.iter().map(|mark| *mark != 0).collect()
            }
        };
        let row = |row: usize| row as i64 + base;
        // Twice a number must fit into 64 bits.
        let known = base..=last.unwrap_or(i64::MAX / 2);
        let mut read = Vec::with_capacity(rows);
        for (at, number) in global.iter().enumerate() {
            if location == Location::Center && last.is_none() && number == base - 1 && !is_own[at] {
                read.push(NONE);
                continue;
            }
            if !known.contains(&number) {
                let expected = last.map_or("or more".into(), |last| format!("to {last}, a row of the grid's tables"));
                return Err(bad(format!("{numbers} row {}: {number}, expected {base} {expected}", row(at))));
            }
            read.push((number - base) as u64);
        }
        let mut order: Vec<u32> = (0..rows as u32).filter(|at| read[*at as usize] != NONE).collect();
        order.sort_unstable_by_key(|at| (read[*at as usize], *at));
        let twice = order.windows(2).find(|pair| read[pair[0] as usize] == read[pair[1] as usize]);
        if let Some(&[a, b]) = twice {
            return Err(bad(format!(
                "{numbers} rows {} and {}: both {}, expected different numbers",
                row(a as usize),
                row(b as usize),
                row(read[a as usize] as usize)
            )));
        }
        Ok(Numbered { global: read, is_own })
    }
}

pub(super) fn bad(message: String) -> Error {
    Error::new(ErrorKind::Grid, message)
}
