//! The model's description of a rank's cells: their ownership and their numbers in the whole grid.

use icoray_grid::Indices;
use icoray_grid::{Error, ErrorKind, Result};

/// Which cells of a rank are its own.
#[derive(Debug, Clone, Copy)]
pub enum Owned<'a> {
    /// The first so many, as in MPAS.
    First(usize),
    /// Those whose value is not 0; one value per cell.
    Marked(&'a [i32]),
}

/// The model's description of a rank's part: one row per cell, read by
/// [`Decomposition::new`](super::Decomposition::new).
#[derive(Debug, Clone, Copy)]
pub struct PartCells<'a> {
    /// The number of each cell in the whole grid (MPAS `indexToCellID`), counted from the grid's `index_base`. Numbers
    /// need not be without gaps, unless they are rows of whole tables.
    pub global: Indices<'a>,
    /// Own cells; the others are the halo.
    pub owned: Owned<'a>,
}

/// The same, read and checked.
pub(super) struct Numbered {
    /// Counted from 0.
    pub global: Vec<u64>,
    pub owns_cell: Vec<bool>,
}

impl Numbered {
    /// Reads `rows` rows, whose numbers are different ones from `base` to `last`, or without an end.
    pub fn new(cells: &PartCells, rows: usize, base: i64, last: Option<i64>) -> Result<Self> {
        let count = |name: &str, len: usize| {
            let message = format!("{name}: {len} rows, expected {rows}, one per cell");
            if len == rows { Ok(()) } else { Err(bad(message)) }
        };
        count("cell_global", cells.global.len())?;
        let owns_cell: Vec<bool> = match cells.owned {
            Owned::First(owned) if owned > rows => {
                return Err(bad(format!("{owned} own cells, expected at most {rows}, which this rank has")));
            }
            Owned::First(owned) => (0..rows).map(|cell| cell < owned).collect(),
            Owned::Marked(marks) => {
                count("is_owned", marks.len())?;
                marks.iter().map(|mark| *mark != 0).collect()
            }
        };
        let row = |cell: usize| cell as i64 + base;
        // Twice a number must still be one.
        let known = base..=last.unwrap_or(i64::MAX / 2);
        let mut global = Vec::with_capacity(rows);
        for (cell, number) in cells.global.iter().enumerate() {
            if !known.contains(&number) {
                let expected = last.map_or("or more".into(), |last| format!("to {last}, a row of the grid's tables"));
                return Err(bad(format!("cell_global row {}: {number}, expected {base} {expected}", row(cell))));
            }
            global.push((number - base) as u64);
        }
        let mut order: Vec<u32> = (0..rows as u32).collect();
        order.sort_unstable_by_key(|cell| (global[*cell as usize], *cell));
        let twice = order.windows(2).find(|pair| global[pair[0] as usize] == global[pair[1] as usize]);
        if let Some(&[a, b]) = twice {
            return Err(bad(format!(
                "cell_global rows {} and {}: both {}, expected different numbers",
                row(a as usize),
                row(b as usize),
                row(global[a as usize] as usize)
            )));
        }
        Ok(Numbered { global, owns_cell })
    }
}

pub(super) fn bad(message: String) -> Error {
    Error::new(ErrorKind::Grid, message)
}
