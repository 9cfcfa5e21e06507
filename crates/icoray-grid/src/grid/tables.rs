//! The six tables in the model's memory: borrowed, never copied, never written.

use crate::reals::Reals;

/// A borrowed array of row numbers in either width. Tables of one grid need not agree.
#[derive(Debug, Clone, Copy)]
pub enum Indices<'a> {
    /// 32 bits, as most models have them.
    I32(&'a [i32]),
    /// 64 bits, as with Fortran's `-i8`.
    I64(&'a [i64]),
}

impl<'a> Indices<'a> {
    /// Number of elements.
    pub fn len(&self) -> usize {
        match self {
            Indices::I32(v) => v.len(),
            Indices::I64(v) => v.len(),
        }
    }

    /// Whether there is no element.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Element `i`, widened.
    ///
    /// # Panics
    /// When `i` is out of range.
    #[inline(always)]
    pub fn get(&self, i: usize) -> i64 {
        match self {
            Indices::I32(v) => i64::from(v[i]),
            Indices::I64(v) => v[i],
        }
    }

    /// All elements, widened.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = i64> + use<'a> {
        let all = *self;
        (0..all.len()).map(move |i| all.get(i))
    }

    /// Row `r` of a table with `N` columns.
    ///
    /// # Panics
    /// When the table has no such row.
    #[inline(always)]
    pub fn row<const N: usize>(&self, r: usize) -> [i64; N] {
        self.find_row(r).expect("the table has the row")
    }

    /// Row `r` of a table with `N` columns, if it exists.
    #[inline(always)]
    pub(crate) fn find_row<const N: usize>(&self, r: usize) -> Option<[i64; N]> {
        // Loops: `array::from_fn` and zipped iterators are compiled apart from their callers in some builds.
        let mut found = [0; N];
        match self {
            Indices::I32(v) => {
                let row = v.get(N * r..N * r + N)?;
                for k in 0..N {
                    found[k] = i64::from(row[k]);
                }
            }
            Indices::I64(v) => found.copy_from_slice(v.get(N * r..N * r + N)?),
        }
        Some(found)
    }
}

impl<'a> From<&'a [i32]> for Indices<'a> {
    fn from(v: &'a [i32]) -> Self {
        Indices::I32(v)
    }
}

impl<'a> From<&'a [i64]> for Indices<'a> {
    fn from(v: &'a [i64]) -> Self {
        Indices::I64(v)
    }
}

/// Positions on the sphere: longitude and latitude of each row.
///
/// # Units
/// Radians. Latitude in [-π/2, π/2], longitude in [-2π, 2π]; both are checked.
#[derive(Debug, Clone, Copy)]
pub struct LonLat<'a> {
    /// Longitude, one per row.
    pub lon_rad: Reals<'a>,
    /// Latitude, one per row.
    pub lat_rad: Reals<'a>,
}

impl<'a> LonLat<'a> {
    /// Positions in double precision.
    pub fn of(lon_rad: &'a [f64], lat_rad: &'a [f64]) -> Self {
        LonLat { lon_rad: lon_rad.into(), lat_rad: lat_rad.into() }
    }
}

/// The six tables of a geodesic grid (§3.1 of the paper), borrowed from the model.
///
/// ```
/// use icoray_grid::{Grid, GridTables, IcosahedralMesh, LonLat};
///
/// // A model has these arrays already; here a generated mesh lends its own.
/// let mesh = IcosahedralMesh::new(2)?;
/// let tables = GridTables {
///     index_base: 0,
///     center: LonLat::of(&mesh.lon_center_rad, &mesh.lat_center_rad),
///     corner: LonLat::of(&mesh.lon_corner_rad, &mesh.lat_corner_rad),
///     cell_corner: mesh.cell_corner[..].into(),
///     cell_corner_row: 6,
///     cell_corner_count: None,
///     corner_cell: mesh.corner_cell[..].into(),
///     corner_edge: mesh.corner_edge[..].into(),
///     edge_corner: mesh.edge_corner[..].into(),
/// };
/// assert_eq!((tables.cells(), tables.corners(), tables.edges()), (162, 320, 480));
/// assert_eq!(Grid::new(tables)?.void_triangles(), 0);
/// # Ok::<(), icoray_grid::Error>(())
/// ```
///
/// Index tables are row-major, in 32 or 64 bits, and number cells, corners and edges from `index_base`. No orientation
/// is required: rows of `corner_cell` and `corner_edge` may be in any order, as they are in real MPAS files.
///
/// The mesh may have holes or be a part of the sphere. A missing neighbour is marked by the number before the first (0
/// in tables that count from 1), by -1, or by the number behind the last: cells in `corner_cell`, whose row is no
/// triangle then; edges in such a row of `corner_edge`; corners in `edge_corner` and `cell_corner`. Corners beside a
/// hole may be left out of the tables or, as in MPAS, be included with the cells that they have.
#[derive(Debug, Clone, Copy)]
pub struct GridTables<'a> {
    /// 0 (C) or 1 (Fortran): the number of the first cell, corner and edge.
    pub index_base: i32,
    /// Cell centres, where data live (MPAS `lonCell`, `latCell`); `cells` rows.
    pub center: LonLat<'a>,
    /// Cell corners (MPAS `lonVertex`, `latVertex`); `corners` rows.
    pub corner: LonLat<'a>,
    /// The corners of each cell (MPAS `verticesOnCell`); `cells` rows of `cell_corner_row` entries. A cell with fewer
    /// corners repeats one of them, unless `cell_corner_count` gives the number of entries that count.
    pub cell_corner: Indices<'a>,
    /// Row length of `cell_corner`: 6 in the paper, `maxEdges` in MPAS.
    pub cell_corner_row: usize,
    /// The number of entries of each `cell_corner` row that count (MPAS `nEdgesOnCell`); entries beyond are never read.
    pub cell_corner_count: Option<Indices<'a>>,
    /// The 3 cells that share a corner: the vertices of its dual triangle (MPAS `cellsOnVertex`).
    pub corner_cell: Indices<'a>,
    /// The 3 edges that meet at a corner: the sides of its dual triangle (MPAS `edgesOnVertex`).
    pub corner_edge: Indices<'a>,
    /// The 2 corners at the ends of an edge: the triangles on its two sides (MPAS `verticesOnEdge`).
    pub edge_corner: Indices<'a>,
}

impl GridTables<'_> {
    /// Number of cells: the rows of `center`.
    pub fn cells(&self) -> usize {
        self.center.lon_rad.len()
    }

    /// Number of corners, which is the number of dual triangles: the rows of `corner`.
    pub fn corners(&self) -> usize {
        self.corner.lon_rad.len()
    }

    /// Number of edges: the rows of `edge_corner`.
    pub fn edges(&self) -> usize {
        self.edge_corner.len() / 2
    }
}
