//! The geodesic grid: the model's six tables, checked once, and two derived tables.
//!
//! Voronoi cells and Delaunay triangles are duals: triangle `t` *is* corner `t`, its vertices are the centres of
//! `corner_cell[t]`, its sides are `corner_edge[t]`, and `edge_corner` leads across a side (§3.1 of the paper). A
//! frustum is a triangle between two layers, so the whole 3-D mesh is walked with these 2-D tables alone.
//!
//! Derived and owned are a unit vector per cell (24 bytes) and the half-edges of each triangle (24 bytes,
//! `half_edges.rs`), so that rays read two tables instead of four. The model's tables are borrowed. Ranks of a node
//! share what frames read (`shared.rs`). A mesh with holes is closed with void triangles (`hole_filling.rs`), whose
//! numbers follow the last row of the table; a whole sphere has none.

mod check;
mod coarse;
mod constrained_delaunay;
mod generate;
pub mod half_edges;
mod hole_filling;
mod owned;
mod points;
mod shared;
mod table_names;
mod tables;
mod triangles;

pub use check::unit_vector;
pub use coarse::{CellsOver, CoarseGrid};
#[cfg(test)]
pub(crate) use generate::icosahedral_grid;
pub use generate::{IcosahedralMesh, MAX_LEVEL};
pub use owned::{OwnedGrid, OwnedTables};
pub use tables::{GridTables, Indices, LonLat};
pub use triangles::{Connectivity, circumcenter, cut_polygon};

use crate::array::MapInline;
use crate::error::{Error, ErrorKind, Result};
use crate::macrocells::Macrocells;
use crate::{hash, memory};
use glam::DVec3;
use half_edges::{HalfEdges, place};
use rayon::prelude::*;
use std::borrow::Cow;
use std::sync::{Arc, OnceLock, Weak};

/// A checked geodesic grid over borrowed tables.
///
/// ```
/// use icoray_grid::{ErrorKind, Grid, IcosahedralMesh};
///
/// let mut mesh = IcosahedralMesh::new(3)?;
/// let grid = Grid::new(mesh.tables())?;
/// assert_eq!((grid.cells(), grid.triangles()), (642, 1280));
///
/// // Wrong tables are an error that names table, row and value.
/// mesh.corner_cell[7] = 642;
/// let error = Grid::new(mesh.tables()).unwrap_err();
/// assert_eq!(error.kind(), ErrorKind::Grid);
/// # Ok::<(), icoray_grid::Error>(())
/// ```
#[derive(Debug)]
pub struct Grid<'a> {
    tables: GridTables<'a>,
    /// Numbers of cells and of triangles, without those that fill holes.
    counts: [usize; 2],
    /// Unit vectors of the cells, followed by those of synthetic points.
    direction: Cow<'a, [[f64; 3]]>,
    /// Of void triangles too.
    half_edges: Cow<'a, [HalfEdges]>,
    /// A data triangle at which searches start.
    start: u32,
    /// Number of each cell in the whole grid, from 0; empty if it is the cell's row.
    cell_number: &'a [u64],
    /// The number of the whole grid's first cell in the model.
    number_base: i64,
    /// The result of [`Self::lowest_facet`].
    lowest_facet: OnceLock<f64>,
    /// The result of [`Self::longest_side`].
    longest_side: OnceLock<f64>,
    /// The result of [`Self::macrocells`].
    macrocells: OnceLock<Macrocells<'static>>,
    /// Macrocells that another process made.
    shared_macrocells: Option<Macrocells<'a>>,
    /// The result of [`Self::table_hashes`].
    table_hashes: OnceLock<[(&'static str, u64); 6]>,
    life: Arc<()>,
}

impl<'a> Grid<'a> {
    /// Checks all of `tables`, closes the mesh if it has holes, and derives directions and half-edges, in parallel.
    ///
    /// # Errors
    /// [`ErrorKind::Memory`] if the derived tables do not fit; [`ErrorKind::Grid`] names the table, row, value, the
    /// expected value and the likely cause (degrees, exchanged numbers of rows, the other `index_base`): sizes, index
    /// ranges, each edge's two triangles, each triangle's three edges and cells, a closed sphere (V - E + F = 2 if
    /// nothing is missing, one winding, areas summing to 4π with those of void triangles), no zero-area triangle, each
    /// cell's corners, finite coordinates.
    pub fn new(tables: GridTables<'a>) -> Result<Self> {
        check::sizes(&tables)?;
        check::edge_ends(&tables)?;
        memory::require("tables derived from the grid", setup_bytes(&tables), None)?;
        Self::of_sized(tables).map_err(|error| match (error.kind(), check::other_base(&tables)) {
            (ErrorKind::Grid, Some(hint)) => Error::grid(format!("{}{hint}", error.context())),
            _ => error,
        })
    }

    /// Makes the grid of tables whose lengths fit.
    fn of_sized(tables: GridTables<'a>) -> Result<Self> {
        let has_hole = check::has_hole(&tables)?;
        let mut direction = check::directions(&tables)?;
        check::indices(&tables, has_hole)?;
        let mut half_edges = check::triangles(&tables, &direction, has_hole)?;
        check::folds(&tables, &half_edges)?;
        check::cells(&tables)?;
        if has_hole {
            hole_filling::fill_holes(&tables, &mut direction, &mut half_edges)?;
            direction.shrink_to_fit();
            half_edges.shrink_to_fit();
        }
        check::covers(&direction, &half_edges, half_edges.len() > tables.corners())?;
        let rows = tables.corners();
        let start = half_edges[..rows].iter().position(HalfEdges::is_triangle).unwrap_or(rows) as u32;
        Ok(Self::over(tables, direction.into(), half_edges.into(), start))
    }

    /// The grid of tables and of what derives from them.
    fn over(
        tables: GridTables<'a>,
        direction: Cow<'a, [[f64; 3]]>,
        half_edges: Cow<'a, [HalfEdges]>,
        start: u32,
    ) -> Self {
        Grid {
            tables,
            counts: [tables.cells(), tables.corners()],
            direction,
            half_edges,
            start,
            cell_number: &[],
            number_base: 0,
            lowest_facet: OnceLock::new(),
            longest_side: OnceLock::new(),
            macrocells: OnceLock::new(),
            shared_macrocells: None,
            table_hashes: OnceLock::new(),
            life: Arc::default(),
        }
    }

    /// A cell's name in the model's numbering.
    pub(crate) fn cell_name(&self, cell: usize) -> String {
        let base = i64::from(self.tables.index_base);
        match self.cell_number.get(cell) {
            Some(number) => format!("cell {} of the whole grid", *number as i64 + self.number_base),
            None => format!("cell {} (counted from {base})", cell as i64 + base),
        }
    }

    /// The number of each cell in the whole grid, from 0 and rising; empty if it is the cell's row.
    pub fn cell_numbers(&self) -> &'a [u64] {
        self.cell_number
    }

    /// A cell's number in the whole grid, from 0.
    pub fn number(&self, cell: usize) -> u64 {
        self.cell_number.get(cell).copied().unwrap_or(cell as u64)
    }

    /// The tables alone, without what rays read: for a part whose triangles are in a grid of several ranks. It has
    /// numbers of cells and triangles, names and corners of cells; it cannot be drawn.
    pub fn tables_only(&self) -> Self {
        let (counts, cell_number, number_base) = (self.counts, self.cell_number, self.number_base);
        let tables = Self::over(self.tables, Cow::default(), Cow::default(), self.start);
        Grid { counts, cell_number, number_base, ..tables }
    }

    /// The tables as given.
    pub fn tables(&self) -> &GridTables<'a> {
        &self.tables
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.counts[0]
    }

    /// Number of corners: the rows of `corner_cell`, each of them a dual triangle unless it names a missing cell
    /// ([`Grid::is_triangle`]).
    pub fn triangles(&self) -> usize {
        self.counts[1]
    }

    /// Number of triangles that fill the mesh's holes, numbered from [`Grid::triangles`] on; 0 for a whole sphere. Rays
    /// walk over them without reading values.
    pub fn void_triangles(&self) -> usize {
        self.half_edges.len().saturating_sub(self.triangles())
    }

    /// A description of the holes: their number and, for the first few, their void triangles and a corner on the rim.
    /// `None` for a whole sphere.
    pub fn describe_holes(&self) -> Option<String> {
        const NAMED: usize = 3;
        let holes = self.holes();
        let plural = |count: usize| if count == 1 { "" } else { "s" };
        let text = |&(triangles, beside): &(usize, Option<u32>)| {
            let place = beside.map_or_else(String::new, |corner| {
                let (number, at) = (table_names::number_of(&self.tables, corner), self.tables.corner);
                let [lon, lat] = [at.lon_rad, at.lat_rad].map(|angle| angle.get(corner as usize).to_degrees());
                let [east, north] = [if lon < 0.0 { 'W' } else { 'E' }, if lat < 0.0 { 'S' } else { 'N' }];
                format!(" beside corner {number} at {:.2} {east} {:.2} {north}", lon.abs(), lat.abs())
            });
            format!("{triangles} void triangle{}{place}", plural(triangles))
        };
        let named: Vec<String> = holes.iter().take(NAMED).map(text).collect();
        let [cells, corners, edges] = [self.cells(), self.triangles(), self.tables.edges()];
        let small = [("cells", [cells + 1, corners, edges]), ("corners", [cells, corners + 1, edges])];
        let small = small.into_iter().find(|(_, counts)| check::is_sphere(*counts));
        let small = small.map(|(name, _)| format!("; one more of {name} makes a closed sphere: check their number"));
        let more = if holes.len() > NAMED { ", …" } else { "" };
        let text = format!("{} hole{}, closed by {}{more}", holes.len(), plural(holes.len()), named.join(", "));
        (!holes.is_empty()).then(|| text + &small.unwrap_or_default())
    }

    /// The holes: the number of void triangles in each, and the first data triangle beside it.
    fn holes(&self) -> Vec<(usize, Option<u32>)> {
        let mut is_found = vec![false; self.void_triangles()];
        let mut holes = Vec::new();
        for first in 0..self.void_triangles() {
            let (mut queue, mut triangles, mut beside) = (vec![first], 0, u32::MAX);
            while let Some(at) = queue.pop() {
                if std::mem::replace(&mut is_found[at], true) {
                    continue;
                }
                triangles += 1;
                for k in 0..3 {
                    let other = self.across((self.triangles() + at) as u32, k);
                    match (other as usize).checked_sub(self.triangles()) {
                        Some(void) => queue.push(void),
                        None => beside = beside.min(other),
                    }
                }
            }
            if triangles > 0 {
                holes.push((triangles, (beside != u32::MAX).then_some(beside)));
            }
        }
        holes
    }

    /// Whether `triangle` has data: a row of the table with three existing cells.
    #[inline]
    pub fn is_triangle(&self, triangle: u32) -> bool {
        !self.is_void(triangle) && self.half_edges[triangle as usize].is_triangle()
    }

    /// Whether `triangle` is one of those that fill holes.
    #[inline]
    pub fn is_void(&self, triangle: u32) -> bool {
        triangle as usize >= self.triangles()
    }

    /// A token that can be upgraded while this grid lives and differs ([`Weak::ptr_eq`]) from that of every other grid:
    /// with it caches check whether their grid still exists.
    pub fn lifetime_token(&self) -> Weak<()> {
        Arc::downgrade(&self.life)
    }

    /// Bytes that icoray owns for this grid beside the model's tables, or that the ranks of a node share.
    pub fn derived_bytes(&self) -> usize {
        let macrocells = self.shared_macrocells.as_ref().or(self.macrocells.get()).map_or(0, Macrocells::bytes);
        size_of_val(&*self.direction) + size_of_val(&*self.half_edges) + macrocells
    }

    /// Unit vector from the sphere's centre to the centre of `cell` (z through the north pole, x through longitude 0),
    /// or to the synthetic vertex of that number.
    #[inline]
    pub fn direction(&self, cell: u32) -> DVec3 {
        DVec3::from_array(self.direction[cell as usize])
    }

    /// The three cells of `triangle`, counter-clockwise seen from outside; for a void one, numbers from [`Grid::cells`]
    /// on are synthetic.
    ///
    /// # Panics
    /// If there is no such triangle. The result for a row that is none ([`Grid::is_triangle`]) is undefined.
    #[inline]
    pub fn triangle(&self, triangle: u32) -> [u32; 3] {
        self.half_edges[triangle as usize].vertices()
    }

    /// The triangle beyond the side of `triangle` that lies opposite its vertex `k`.
    ///
    /// # Panics
    /// When there is no such triangle.
    #[inline]
    pub fn across(&self, triangle: u32, k: usize) -> u32 {
        place(self.half_edges[triangle as usize].beyond(k)).0
    }

    /// `hint` itself if it is a triangle, data or void, and an existing one otherwise.
    #[inline]
    pub fn nearest_valid_triangle(&self, hint: u32) -> u32 {
        if self.is_triangle(hint) || self.is_void(hint) { hint } else { self.start }
    }

    /// Height of the lowest place of all triangles over a unit sphere, computed at the first call.
    pub fn lowest_facet(&self) -> f64 {
        let height = |triangle: u32| {
            let [a, b, c] = self.triangle(triangle).map_inline(|cell| self.direction(cell));
            let normal = (b - a).cross(c - a);
            a.dot(normal).abs() / normal.length()
        };
        *made(&self.lowest_facet, || {
            let triangles = (0..self.triangles() as u32).into_par_iter().filter(|t| self.is_triangle(*t));
            triangles.map(height).reduce(|| 1.0, f64::min)
        })
    }

    /// The coarse map by which rays leap over empty space, made at the first call, in parallel.
    pub fn macrocells(&self) -> &Macrocells<'_> {
        match &self.shared_macrocells {
            Some(macrocells) => macrocells,
            None => made(&self.macrocells, || Macrocells::new(self)),
        }
    }

    /// Name and hash of each table: of all positions and all numbers, except unused ones of `cell_corner`. Numbers are
    /// counted from 0, so the tables' `index_base` and the widths of their elements do not matter. Computed at the
    /// first call, in parallel.
    pub fn table_hashes(&self) -> &[(&'static str, u64); 6] {
        made(&self.table_hashes, || {
            let t = &self.tables;
            let positions = |at: &LonLat| {
                hash::of(2 * at.lon_rad.len(), |i| hash::bits([at.lon_rad, at.lat_rad][i % 2].get(i / 2)))
            };
            let number = |table: Indices, i: usize| (table.get(i) - i64::from(t.index_base)) as u64;
            let numbers = |table: Indices| hash::of(table.len(), |i| number(table, i));
            let row = t.cell_corner_row;
            let counts = |i: usize| t.cell_corner_count.is_none_or(|count| ((i % row) as i64) < count.get(i / row));
            let cell_corner = |i: usize| if counts(i) { number(t.cell_corner, i) } else { u64::MAX };
            [
                ("center", positions(&t.center)),
                ("corner", positions(&t.corner)),
                ("cell_corner", hash::of(t.cell_corner.len(), cell_corner)),
                ("corner_cell", numbers(t.corner_cell)),
                ("corner_edge", numbers(t.corner_edge)),
                ("edge_corner", numbers(t.edge_corner)),
            ]
        })
    }

    /// Unit vectors towards the cells.
    pub fn directions(&self) -> &[[f64; 3]] {
        &self.direction
    }

    /// The corners of `cell` that are in the tables, without repetition, in the table's order. Beside a hole some are
    /// not triangles.
    pub fn corners_of(&self, cell: u32) -> impl Iterator<Item = u32> + '_ {
        let table = self.tables.cell_corner;
        let row = self.tables.cell_corner_row;
        let used = self.tables.cell_corner_count.map_or(row, |count| count.get(cell as usize) as usize);
        let start = cell as usize * row;
        let base = i64::from(self.tables.index_base);
        let is_new = move |i: &usize| (start..*i).all(|j| table.get(j) != table.get(*i));
        let rows = base..base + self.triangles() as i64;
        let corners = (start..start + used).filter(is_new).map(move |i| table.get(i));
        // Others are marks of missing corners.
        corners.filter(move |corner| rows.contains(corner)).map(move |corner| (corner - base) as u32)
    }

    /// Longest side of all triangles, in radians; computed at the first call.
    pub fn longest_side(&self) -> f64 {
        let longest = |triangle: u32| {
            let [a, b, c] = self.triangle(triangle).map_inline(|cell| self.direction(cell));
            a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a))
        };
        *made(&self.longest_side, || {
            let triangles = (0..self.triangles() as u32).into_par_iter().filter(|t| self.is_triangle(*t));
            let chord = triangles.map(longest).reduce(|| 0.0, f64::max).sqrt();
            2.0 * (0.5 * chord).min(1.0).asin()
        })
    }

    /// The triangles around `cell`, void ones too, counter-clockwise from the first of its corners that is a triangle;
    /// each with the number of the cell among its vertices.
    #[inline(always)]
    fn triangles_and_places(&self, cell: u32) -> impl Iterator<Item = (u32, usize)> + '_ {
        let first = self.corners_of(cell).find(|corner| self.is_triangle(*corner));
        let at = |triangle: u32| self.triangle(triangle).iter().position(|other| *other == cell);
        let first = first.and_then(|triangle| Some((triangle, at(triangle)?)));
        std::iter::successors(first, move |&(triangle, k)| {
            // The half-edge beyond the side of this cell and the last vertex begins at the cell.
            let next = place(self.half_edges[triangle as usize].beyond((k + 1) % 3));
            (Some(next.0) != first.map(|(triangle, _)| triangle)).then_some(next)
        })
    }

    /// The triangles with data around `cell`, counter-clockwise.
    pub fn triangles_around(&self, cell: u32) -> impl Iterator<Item = u32> + '_ {
        self.triangles_and_places(cell).map(|(triangle, _)| triangle).filter(|triangle| self.is_triangle(*triangle))
    }

    /// The two other cells of each triangle with data around `cell`, counter-clockwise.
    pub(crate) fn fans(&self, cell: u32) -> impl Iterator<Item = [u32; 2]> + '_ {
        let of = |(triangle, k): (u32, usize)| [1, 2].map_inline(|next| self.triangle(triangle)[(k + next) % 3]);
        self.triangles_and_places(cell).filter(|(triangle, _)| self.is_triangle(*triangle)).map(of)
    }

    /// Writes the cells around `cell` to `ring`, counter-clockwise, and returns their number. `None` if a void triangle
    /// is among its triangles, or if there are more than `N`.
    #[inline(always)]
    pub(crate) fn ring<const N: usize>(&self, cell: u32, ring: &mut [u32; N]) -> Option<usize> {
        let mut count = 0;
        for (triangle, k) in self.triangles_and_places(cell) {
            if self.is_void(triangle) {
                return None;
            }
            *ring.get_mut(count)? = self.triangle(triangle)[(k + 1) % 3];
            count += 1;
        }
        (count > 0).then_some(count)
    }
}

/// The value of `cell`, or else that of `make`, which runs outside of the cell's lock: a thread that waits there for
/// the others of its pool may take up another task that needs the same value, and would wait for itself.
fn made<X>(cell: &OnceLock<X>, make: impl FnOnce() -> X) -> &X {
    match cell.get() {
        Some(known) => known,
        None => {
            let new = make();
            cell.get_or_init(|| new)
        }
    }
}

/// Bytes that [`Grid::new`] allocates for a sphere without holes: directions and half-edges.
fn setup_bytes(tables: &GridTables) -> u64 {
    (tables.cells() * size_of::<[f64; 3]>() + tables.corners() * size_of::<HalfEdges>()) as u64
}
