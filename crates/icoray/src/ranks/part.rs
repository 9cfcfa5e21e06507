//! A rank's part of a grid that is spread over ranks: which cells and triangles are its own, and who has the others.
//!
//! Each rank has a grid of its own cells and a halo, with local numbers. A triangle belongs to the rank that owns its cell of
//! the lowest global number: a partition of all triangles, each of which its owner has whole where the halo is one cell wide.
//!
//! Who owns a halo cell is found by asking: rank `g mod ranks` keeps the entry of global number g, is told by the cell's
//! owner, and asked by whoever has the cell in its halo. So no rank ever holds numbers of the whole grid.

use super::Ranks;
use super::words::{Reader, Words};
use crate::error::{Error, ErrorKind, Result};
use crate::grid::{Grid, Indices};
use crate::kernel::plane::RayLine;
use glam::DVec3;
use std::collections::HashMap;
use std::f64::consts::PI;

/// Which cells of a local grid are this rank's own.
#[derive(Debug, Clone, Copy)]
pub enum Owned<'a> {
    /// The first so many, as in MPAS.
    First(usize),
    /// Those whose value is not 0; one value per cell.
    Marked(&'a [i32]),
}

/// What a model says of its part: one row for each cell of the rank's grid, read when the [`Part`] is made.
#[derive(Debug, Clone, Copy)]
pub struct PartCells<'a> {
    /// The number of each cell in the whole grid (MPAS `indexToCellID`), counted from the grid's `index_base`. Numbers need
    /// not be without gaps.
    pub global: Indices<'a>,
    /// Own cells; the others are the halo.
    pub owned: Owned<'a>,
}

/// Some cells for each rank.
type CellsOfRanks = Vec<Vec<u32>>;

/// A rank's part of a grid, agreed on by all ranks.
#[derive(Debug, Clone)]
pub struct Part {
    owns_cell: Vec<bool>,
    owns_triangle: Vec<bool>,
    /// For each rank, own cells whose values it needs.
    sends: CellsOfRanks,
    /// For each rank, halo cells whose values come from there, in the order in which they do.
    receives: CellsOfRanks,
    /// Middle of the own triangles, and the cosine of the angle to the farthest of their vertices.
    cap: Option<(DVec3, f64)>,
    lowest_facet: f64,
    covered: f64,
    cells: u64,
    ranks: usize,
}

/// What is carried from rank to rank.
pub(crate) trait Carried: Sized {
    fn put(&self, words: &mut Words);
    fn get(reader: &mut Reader) -> Result<Self>;
}

impl Carried for f32 {
    fn put(&self, words: &mut Words) {
        words.put_f32(*self);
    }

    fn get(reader: &mut Reader) -> Result<Self> {
        reader.get_f32()
    }
}

impl Carried for f64 {
    fn put(&self, words: &mut Words) {
        words.put_f64(*self);
    }

    fn get(reader: &mut Reader) -> Result<Self> {
        reader.get_f64()
    }
}

impl Carried for [f32; 3] {
    fn put(&self, words: &mut Words) {
        self.iter().for_each(|value| value.put(words));
    }

    fn get(reader: &mut Reader) -> Result<Self> {
        Ok([f32::get(reader)?, f32::get(reader)?, f32::get(reader)?])
    }
}

/// What ranks add up of their parts.
struct Extent {
    lowest_facet: f64,
    area: f64,
    cells: u64,
}

impl Part {
    /// Agrees with the other ranks on whose each cell is. Collective; `grid` is this rank's own.
    ///
    /// # Errors
    /// The same on all ranks: [`ErrorKind::Grid`] where numbers or marks do not fit the grid, a cell is owned by two ranks or
    /// by none, or a halo is too narrow; [`ErrorKind::Mpi`] when the transport fails.
    pub fn new(ranks: &mut Ranks, grid: &Grid, cells: &PartCells) -> Result<Self> {
        let local = ranks.attempt(|| Local::new(grid, cells, ranks.size()));
        let local = ranks.together(local)?;
        let owners = local.find_owners(ranks)?;
        let (sends, receives) = local.find_partners(ranks, grid, &owners)?;
        let mut part = Part {
            cap: cap(grid, &local.owns_triangle),
            owns_cell: local.owns_cell,
            owns_triangle: local.owns_triangle,
            sends,
            receives,
            lowest_facet: 1.0,
            covered: 0.0,
            cells: 0,
            ranks: ranks.size(),
        };
        part.add_up(ranks, grid)?;
        Ok(part)
    }

    /// The share of this rank in a grid that every rank has whole: rows from one to the next.
    ///
    /// # Errors
    /// As [`Part::new`].
    pub fn of_whole(ranks: &mut Ranks, grid: &Grid) -> Result<Self> {
        let (rank, size, base) = (ranks.rank(), ranks.size(), i64::from(grid.tables().index_base));
        let global: Vec<i64> = (base..).take(grid.cells()).collect();
        let is_own = |cell: usize| cell * size / grid.cells() == rank;
        let marks: Vec<i32> = (0..grid.cells()).map(|cell| is_own(cell).into()).collect();
        let cells = PartCells { global: global.as_slice().into(), owned: Owned::Marked(&marks) };
        Part::new(ranks, grid, &cells)
    }

    /// Number of own cells, of all ranks together.
    pub fn cells(&self) -> u64 {
        self.cells
    }

    /// The part of the sphere that the triangles of all ranks cover: 1 where the mesh has no hole.
    pub fn covered(&self) -> f64 {
        self.covered
    }

    /// Ranks that agreed on it.
    pub fn ranks(&self) -> usize {
        self.ranks
    }

    /// Whether a cell is this rank's own.
    pub fn owns(&self, cell: usize) -> bool {
        self.owns_cell[cell]
    }

    /// Whether a triangle is this rank's own; any number will do.
    #[inline]
    pub(crate) fn has(&self, triangle: u32) -> bool {
        self.owns_triangle.get(triangle as usize).is_some_and(|is_own| *is_own)
    }

    /// Own triangles.
    pub fn triangles(&self) -> usize {
        self.owns_triangle.iter().filter(|is_own| **is_own).count()
    }

    /// Height of the lowest place of any rank's facets over a unit sphere.
    pub(crate) fn lowest_facet(&self) -> f64 {
        self.lowest_facet
    }

    /// Whether a line may meet own columns between the radii `inner` and `outer`.
    pub(crate) fn is_near(&self, line: &RayLine, inner: f64, outer: f64) -> bool {
        let Some((axis, cos)) = self.cap else { return false };
        if cos <= 0.1 {
            return true;
        }
        // Columns go down to the facets below the inner radius, at worst to the chord of the cap.
        let low = inner * cos;
        // A ball around the rim's disc at the outer radius has the cap in it, and the rim of its bottom.
        let middle = outer * cos * axis;
        let reach = |r: f64| r * r - 2.0 * r * outer * cos * cos + outer * outer * cos * cos;
        let radius = reach(low).max(reach(outer));
        let (x, q) = (middle.dot(line.plane.x) - line.b, middle.dot(line.plane.q));
        x * x + q * q <= radius * (1.0 + 1e-9)
    }

    /// Replaces the rows of halo cells beside own ones by those of their owners; `row_of` finds a cell's row.
    /// Collective.
    pub(crate) fn fill_halo<V: Carried>(
        &self,
        ranks: &mut Ranks,
        values: &mut [V],
        row_of: impl Fn(&mut [V], u32) -> &mut [V],
    ) -> Result<()> {
        let mut messages = Vec::with_capacity(self.sends.len());
        for cells in &self.sends {
            let mut words = Words::default();
            cells
                .iter()
                .for_each(|cell| row_of(values, *cell).iter().for_each(|value| value.put(&mut words)));
            messages.push(words.0);
        }
        let came = ranks.exchange(messages)?;
        let mut take = || -> Result<()> {
            for (bytes, cells) in came.iter().zip(&self.receives) {
                let mut reader = Reader(bytes);
                for cell in cells {
                    for value in row_of(values, *cell) {
                        *value = V::get(&mut reader)?;
                    }
                }
            }
            Ok(())
        };
        let taken = take();
        ranks.together(taken)
    }

    /// The range of all parts' values and how many are missing, of this part's. Collective.
    pub(crate) fn whole_range(
        ranks: &mut Ranks,
        (range, missing): (Option<[f64; 2]>, u64),
    ) -> Result<(Option<[f64; 2]>, u64)> {
        let [low, high] = range.unwrap_or([f64::INFINITY, f64::NEG_INFINITY]);
        let mut words = Words::default();
        words.put_f64(low).put_f64(high).put(missing);
        let (mut low, mut high, mut missing) = (f64::INFINITY, f64::NEG_INFINITY, 0);
        for bytes in ranks.share(&words.0)? {
            let mut reader = Reader(&bytes);
            (low, high) = (low.min(reader.get_f64()?), high.max(reader.get_f64()?));
            missing += reader.get()?;
        }
        Ok(((low <= high).then_some([low, high]), missing))
    }

    fn add_up(&mut self, ranks: &mut Ranks, grid: &Grid) -> Result<()> {
        let mine = self.extent(grid);
        let mut words = Words::default();
        words.put_f64(mine.lowest_facet).put_f64(mine.area).put(mine.cells);
        let mut area = 0.0;
        for bytes in ranks.share(&words.0)? {
            let mut reader = Reader(&bytes);
            self.lowest_facet = self.lowest_facet.min(reader.get_f64()?);
            area += reader.get_f64()?;
            self.cells += reader.get()?;
        }
        self.covered = area / (4.0 * PI);
        Ok(())
    }

    fn extent(&self, grid: &Grid) -> Extent {
        let cells = self.owns_cell.iter().filter(|is_own| **is_own).count() as u64;
        let mut extent = Extent { lowest_facet: 1.0, area: 0.0, cells };
        for triangle in (0..grid.triangles() as u32).filter(|t| self.has(*t)) {
            let [a, b, c] = grid.triangle(triangle).map(|cell| grid.direction(cell));
            let normal = (b - a).cross(c - a);
            let volume = a.dot(normal).abs();
            extent.lowest_facet = extent.lowest_facet.min(volume / normal.length());
            extent.area += 2.0 * volume.atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a));
        }
        extent
    }
}

/// The cap around own triangles.
fn cap(grid: &Grid, owns_triangle: &[bool]) -> Option<(DVec3, f64)> {
    let own = || (0u32..).zip(owns_triangle).filter(|(_, is_own)| **is_own);
    let vertices = || own().flat_map(|(t, _)| grid.triangle(t)).map(|cell| grid.direction(cell));
    let axis = vertices().sum::<DVec3>().try_normalize();
    let axis = axis.or_else(|| vertices().next())?;
    Some((axis, vertices().fold(1.0, |least: f64, v| least.min(v.dot(axis)))))
}

/// A part before its neighbours are known.
struct Local {
    /// Counted from 0.
    global: Vec<u64>,
    owns_cell: Vec<bool>,
    owns_triangle: Vec<bool>,
    ranks: usize,
    base: i64,
}

impl Local {
    fn new(grid: &Grid, cells: &PartCells, ranks: usize) -> Result<Self> {
        let base = i64::from(grid.tables().index_base);
        let count = |name: &str, len: usize| {
            let message = format!("{name}: {len} rows, expected {}, one per cell", grid.cells());
            if len == grid.cells() { Ok(()) } else { Err(bad(message)) }
        };
        count("cell_global", cells.global.len())?;
        let owns_cell: Vec<bool> = match cells.owned {
            Owned::First(owned) if owned > grid.cells() => {
                return Err(bad(format!("{owned} own cells, expected at most {}, the grid's", grid.cells())));
            }
            Owned::First(owned) => (0..grid.cells()).map(|cell| cell < owned).collect(),
            Owned::Marked(marks) => {
                count("is_owned", marks.len())?;
                marks.iter().map(|mark| *mark != 0).collect()
            }
        };
        // Twice a number must still be one.
        let known = base..i64::MAX / 2;
        let row = |cell: usize| cell as i64 + base;
        let mut global = Vec::with_capacity(grid.cells());
        for (cell, number) in cells.global.iter().enumerate() {
            if !known.contains(&number) {
                return Err(bad(format!("cell_global row {}: {number}, expected {base} or more", row(cell))));
            }
            global.push((number - base) as u64);
        }
        let mut order: Vec<u32> = (0..grid.cells() as u32).collect();
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
    fn find_owners(&self, ranks: &mut Ranks) -> Result<Vec<u32>> {
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
    fn find_partners(
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

fn bad(message: String) -> Error {
    Error::new(ErrorKind::Grid, message)
}
