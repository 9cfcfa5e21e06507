//! The six tables as the model holds them: borrowed, never copied, never written.

/// A borrowed array of real numbers in either precision.
#[derive(Debug, Clone, Copy)]
pub enum Reals<'a> {
    /// Single precision.
    F32(&'a [f32]),
    /// Double precision.
    F64(&'a [f64]),
}

impl Reals<'_> {
    /// Number of elements.
    pub fn len(&self) -> usize {
        match self {
            Reals::F32(v) => v.len(),
            Reals::F64(v) => v.len(),
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
    #[inline]
    pub fn get(&self, i: usize) -> f64 {
        match self {
            Reals::F32(v) => f64::from(v[i]),
            Reals::F64(v) => v[i],
        }
    }
}

impl<'a> From<&'a [f32]> for Reals<'a> {
    fn from(v: &'a [f32]) -> Self {
        Reals::F32(v)
    }
}

impl<'a> From<&'a [f64]> for Reals<'a> {
    fn from(v: &'a [f64]) -> Self {
        Reals::F64(v)
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

/// The six tables of a geodesic grid (§3.1 of the paper), borrowed from the model.
///
/// Index tables are row-major and number cells, corners and edges from `index_base`. No orientation is relied on:
/// rows of `corner_cell` and `corner_edge` may be in any order, as they are in real MPAS files.
#[derive(Debug, Clone, Copy)]
pub struct GridTables<'a> {
    /// 0 (C) or 1 (Fortran): the number that the first cell, corner and edge bear.
    pub index_base: i32,
    /// Cell centres, where data live (MPAS `lonCell`, `latCell`); `cells` rows.
    pub center: LonLat<'a>,
    /// Cell corners (MPAS `lonVertex`, `latVertex`); `corners` rows.
    pub corner: LonLat<'a>,
    /// The corners of each cell (MPAS `verticesOnCell`); `cells` rows of `cell_corner_row` entries. A cell with fewer
    /// corners repeats one of them, unless `cell_corner_count` says how many entries count.
    pub cell_corner: &'a [i32],
    /// Row length of `cell_corner`: 6 in the paper, `maxEdges` in MPAS.
    pub cell_corner_row: usize,
    /// How many entries of each `cell_corner` row count (MPAS `nEdgesOnCell`); entries beyond are never read.
    pub cell_corner_count: Option<&'a [i32]>,
    /// The 3 cells that share a corner: the vertices of its dual triangle (MPAS `cellsOnVertex`).
    pub corner_cell: &'a [i32],
    /// The 3 edges that meet at a corner: the sides of its dual triangle (MPAS `edgesOnVertex`).
    pub corner_edge: &'a [i32],
    /// The 2 corners at the ends of an edge: the triangles on its two sides (MPAS `verticesOnEdge`).
    pub edge_corner: &'a [i32],
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
