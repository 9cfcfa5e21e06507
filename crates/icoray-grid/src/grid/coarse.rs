//! Levels of detail: a coarser grid over some of a grid's cells.
//!
//! Cells are chosen in the order of their numbers, each unless a chosen cell adjoins it: of a mesh that was made by
//! bisection, in whose tables the cells of the coarser mesh come first, these are the cells of that mesh. Every other
//! cell belongs to the nearest chosen cell among its neighbours. Where the three cells of a triangle belong to
//! different chosen cells, these are a triangle of the coarser grid: the dual of a discrete Voronoi diagram. At the
//! rim of a hole all cells are chosen, so that holes stay as they are.

use super::triangles::{Connectivity, circumcenter};
use super::{Grid, OwnedGrid, OwnedTables};
use crate::array::MapInline;
use crate::error::{Error, Result};
use glam::DVec3;
use rayon::prelude::*;

/// Attempts to mend triangles of the wrong winding, each of which chooses more cells around them.
const ATTEMPTS: usize = 8;
/// Cells per parallel task.
const CHUNK: usize = 4096;
/// Marks a cell that belongs to no chosen cell.
const NONE: u32 = u32::MAX;

/// A grid over some of the cells of a finer one.
#[derive(Debug)]
pub struct CoarseGrid {
    grid: OwnedGrid,
    cells: Vec<u32>,
}

impl CoarseGrid {
    /// A grid of about a quarter of the cells of `below`; always the same for the same tables.
    ///
    /// # Errors
    /// [`ErrorKind::Grid`](crate::ErrorKind::Grid) if no valid mesh was found, as for cells of very different sizes
    /// side by side; [`ErrorKind::Memory`](crate::ErrorKind::Memory) if its tables do not fit.
    pub fn new(below: &Grid) -> Result<Self> {
        let mut chosen = at_rims(below);
        for _ in 0..ATTEMPTS {
            let owner = owners(below, &choose(below, &chosen));
            let (triangles, folded) = triangles(below, &owner);
            if folded.is_empty() {
                return Self::of(below, &owner, triangles);
            }
            for triangle in folded {
                below.triangle(triangle).into_iter().for_each(|cell| chosen[cell as usize] = true);
            }
        }
        Err(Error::grid("no coarser mesh without folded triangles was found"))
    }

    fn of(below: &Grid, owner: &[u32], triangles: Vec<[u32; 3]>) -> Result<Self> {
        let mut number = vec![NONE; below.cells()];
        let is_chosen = |cell: &u32| owner[*cell as usize] == *cell;
        let cells: Vec<u32> = (0..below.cells() as u32).filter(is_chosen).collect();
        (0..).zip(&cells).for_each(|(new, cell)| number[*cell as usize] = new);
        let place = |row: &[u32; 3]| {
            let [x, y, z] = circumcenter(row.map(|cell| below.directions()[cell as usize]));
            (y.atan2(x), z.atan2(x.hypot(y)))
        };
        let (lon, lat) = triangles.par_iter().map(place).unzip();
        let corner_cell: Vec<i32> =
            triangles.into_iter().flat_map(|row| row.map(|cell| number[cell as usize] as i32)).collect();
        let at = &below.tables().center;
        let center = [at.lon_rad, at.lat_rad].map(|angle| cells.iter().map(|cell| angle.get(*cell as usize)).collect());
        let connectivity = Connectivity::new(&corner_cell, cells.len())?;
        let tables = OwnedTables { center, corner: [lon, lat], corner_cell, connectivity, ..OwnedTables::default() };
        Ok(CoarseGrid { grid: OwnedGrid::new(tables)?, cells })
    }

    /// The grid.
    pub fn grid(&self) -> &Grid<'_> {
        self.grid.grid()
    }

    /// The number of each cell in the grid below, rising.
    pub fn cells(&self) -> &[u32] {
        &self.cells
    }

    /// The same with numbers of the grid from which the one below was made, whose cells have these numbers there.
    #[must_use]
    pub fn over(self, below: &[u32]) -> Self {
        CoarseGrid { cells: self.cells.into_iter().map(|cell| below[cell as usize]).collect(), ..self }
    }

    /// Bytes of the tables.
    pub fn bytes(&self) -> usize {
        self.grid.bytes() + size_of_val(self.cells.as_slice())
    }
}

/// The cells that surround a cell, some of them twice.
fn around<'g>(grid: &'g Grid<'_>, cell: u32) -> impl Iterator<Item = u32> + 'g {
    grid.triangles_around(cell).flat_map(|triangle| grid.triangle(triangle)).filter(move |other| *other != cell)
}

/// The cells at the rims of holes.
fn at_rims(grid: &Grid) -> Vec<bool> {
    let mut found = vec![false; grid.cells()];
    for triangle in (0..grid.triangles() as u32).filter(|t| grid.void_triangles() > 0 && grid.is_triangle(*t)) {
        for k in (0..3).filter(|k| grid.is_void(grid.across(triangle, *k))) {
            let cells = grid.triangle(triangle);
            [1, 2].into_iter().for_each(|next| found[cells[(k + next) % 3] as usize] = true);
        }
    }
    found
}

/// The chosen cells: those of `first`, and others that none of them adjoins. Cells without triangles are not chosen.
fn choose(grid: &Grid, first: &[bool]) -> Vec<bool> {
    let (mut chosen, mut taken) = (first.to_vec(), first.to_vec());
    for cell in (0..grid.cells() as u32).filter(|cell| first[*cell as usize]) {
        around(grid, cell).for_each(|other| taken[other as usize] = true);
    }
    for cell in 0..grid.cells() as u32 {
        if taken[cell as usize] || around(grid, cell).next().is_none() {
            continue;
        }
        (chosen[cell as usize], taken[cell as usize]) = (true, true);
        around(grid, cell).for_each(|other| taken[other as usize] = true);
    }
    chosen
}

/// The chosen cell to which each cell belongs.
fn owners(grid: &Grid, chosen: &[bool]) -> Vec<u32> {
    let owner = |cell: u32| {
        if chosen[cell as usize] {
            return cell;
        }
        let here = grid.direction(cell);
        let near = around(grid, cell).filter(|other| chosen[*other as usize]);
        let distance = |other: u32| grid.direction(other).distance_squared(here);
        near.min_by(|a, b| distance(*a).total_cmp(&distance(*b)).then(a.cmp(b))).unwrap_or(NONE)
    };
    (0..grid.cells() as u32).into_par_iter().map(owner).collect()
}

/// The triangles of chosen cells, counter-clockwise from outside, and the triangles below at which one is folded.
fn triangles(below: &Grid, owner: &[u32]) -> (Vec<[u32; 3]>, Vec<u32>) {
    let of = |triangle: u32| {
        let owners = below.triangle(triangle).map_inline(|cell| owner[cell as usize]);
        let [a, b, c] = owners;
        (a != b && b != c && c != a && !owners.contains(&NONE)).then_some((triangle, owners))
    };
    let all = (0..below.triangles() as u32).into_par_iter().with_min_len(CHUNK);
    let found: Vec<(u32, [u32; 3])> = all.filter(|t| below.is_triangle(*t)).filter_map(of).collect();
    let is_folded = |cells: [u32; 3]| {
        let [a, b, c] = cells.map_inline(|cell| below.direction(cell));
        (b - a).cross(c - a).dot(a) <= 1e-3 * (b - a).cross(c - a).length()
    };
    let folded = found.iter().filter(|(_, cells)| is_folded(*cells)).map(|(triangle, _)| *triangle).collect();
    (found.into_iter().map(|(_, cells)| cells).collect(), folded)
}

/// For each triangle of a coarser grid the cells of the finest one at whose triangles it has a part: all values of the
/// finest grid over the triangle are interpolated between these cells.
#[derive(Debug)]
pub struct CellsOver {
    /// The place in `cells` at which those of each triangle begin, and the end of the last.
    starts: Vec<u32>,
    cells: Vec<u32>,
}

impl CellsOver {
    /// The cells of `fine` over the triangles of `coarse`, which covers the same part of the sphere.
    pub fn new(fine: &Grid, coarse: &Grid) -> Self {
        let all = (0..(coarse.triangles() + coarse.void_triangles()) as u32).into_par_iter();
        let sides: Vec<_> = all.map(|triangle| sides(coarse, triangle)).collect();
        let first: Vec<u32> = (0..fine.cells() as u32).step_by(CHUNK).collect();
        let pairs = first.into_par_iter().flat_map_iter(|first| {
            let (at, star, found) = (coarse.nearest_valid_triangle(0), Vec::new(), Vec::new());
            let mut search = Search { fine, coarse, sides: &sides, at, star, found };
            let mut pairs = Vec::new();
            for cell in first..(first + CHUNK as u32).min(fine.cells() as u32) {
                search.triangles_around(cell);
                pairs.extend(search.found.iter().map(|triangle| [*triangle, cell]));
            }
            pairs
        });
        let mut pairs: Vec<[u32; 2]> = pairs.collect();
        pairs.par_sort_unstable();
        let mut starts = vec![0u32; coarse.triangles() + 1];
        pairs.iter().for_each(|[triangle, _]| starts[*triangle as usize + 1] += 1);
        let mut sum = 0;
        starts.iter_mut().for_each(|start| {
            sum += *start;
            *start = sum;
        });
        CellsOver { starts, cells: pairs.into_iter().map(|[_, cell]| cell).collect() }
    }

    /// The cells over a triangle, rising.
    pub fn of(&self, triangle: u32) -> &[u32] {
        let [start, end] = [0, 1].map_inline(|k| self.starts[triangle as usize + k] as usize);
        &self.cells[start..end]
    }

    /// Bytes of memory.
    pub fn bytes(&self) -> usize {
        size_of_val(self.starts.as_slice()) + size_of_val(self.cells.as_slice())
    }
}

/// Finds the triangles of a coarser grid that the triangles around a cell overlap.
struct Search<'g> {
    fine: &'g Grid<'g>,
    coarse: &'g Grid<'g>,
    /// Those of each triangle of the coarser grid.
    sides: &'g [[(DVec3, u32); 3]],
    /// The triangle with the last cell.
    at: u32,
    /// The cells around it, and the cell.
    star: Vec<DVec3>,
    found: Vec<u32>,
}

/// Inward normals of a triangle's sides opposite its vertices, and the triangles beyond.
fn sides(grid: &Grid, triangle: u32) -> [(DVec3, u32); 3] {
    let at = grid.triangle(triangle).map_inline(|cell| grid.direction(cell));
    [0, 1, 2].map_inline(|k: usize| (at[(k + 1) % 3].cross(at[(k + 2) % 3]), grid.across(triangle, k)))
}

impl Search<'_> {
    /// Moves to the triangle of a direction.
    fn locate(&mut self, direction: DVec3) {
        let macrocells = self.coarse.macrocells();
        let near = macrocells.triangle_in(macrocells.map.number(macrocells.map.find(direction)));
        self.at = self.coarse.nearest_valid_triangle(near);
        for _ in 0..self.sides.len() {
            let sides = self.sides[self.at as usize];
            let outermost = sides.into_iter().min_by(|a, b| a.0.dot(direction).total_cmp(&b.0.dot(direction)));
            match outermost {
                Some((normal, beyond)) if is_beyond(direction, normal) => self.at = beyond,
                _ => return,
            }
        }
    }

    /// Collects the triangles that those around a cell overlap.
    fn triangles_around(&mut self, cell: u32) {
        self.found.clear();
        self.star.clear();
        self.star.extend(around(self.fine, cell).map(|other| self.fine.direction(other)));
        if self.star.is_empty() {
            return;
        }
        self.star.push(self.fine.direction(cell));
        self.locate(self.fine.direction(cell));
        self.found.push(self.at);
        let mut next = 0;
        while next < self.found.len() {
            for (normal, beyond) in self.sides[self.found[next] as usize] {
                let overlaps = self.star.iter().any(|point| is_beyond(*point, normal));
                if overlaps && !self.found.contains(&beyond) && self.coarse.is_triangle(beyond) {
                    self.found.push(beyond);
                }
            }
            next += 1;
        }
        self.found.retain(|triangle| self.coarse.is_triangle(*triangle));
    }
}

/// Whether a direction lies beyond the side with this inward normal, by more than rounding.
fn is_beyond(direction: DVec3, normal: DVec3) -> bool {
    /// Part of a side's length.
    const ROUNDING: f64 = 1e-9;
    direction.dot(normal) < -ROUNDING * normal.length_squared()
}
