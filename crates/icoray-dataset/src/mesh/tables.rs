//! The tables of a mesh, owned.

use super::polygons::Polygons;
use crate::source::{Kind, Source, Variable};
use crate::sources::IN_ANOTHER_FILE;
use icoray::{Error, ErrorKind, Grid, GridTables, LonLat, OwnedReals, Result};
use std::fmt;
use std::path::{Path, PathBuf};

/// The model whose conventions a file follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Convention {
    /// MPAS: hexagons with their tables; fields at cells or corners.
    Mpas,
    /// ICON, and UGRID of triangles: triangles, which are the corners of the hexagons around their points; fields at
    /// corners or, rarely, at cells.
    Icon,
    /// Polygons: with their bounds over one dimension, as the CF conventions 1.11, §7.1, have them and DYNAMICO writes
    /// them, with fields at cells; or UGRID's, with fields at faces or nodes.
    Cf,
}

impl fmt::Display for Convention {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Convention::Mpas => "MPAS",
            Convention::Icon => "ICON",
            Convention::Cf => "polygons",
        })
    }
}

/// The tables that icoray reads of a mesh, owned.
///
/// For MPAS, the tables as the file stores them, numbered from 1; missing ones are made from the others where these
/// determine them. For ICON, `corner_cell` is `vertex_of_cell`, or is rebuilt from the triangles' bounds where the file
/// has no tables, and all others are made of it, numbered from 0. Of polygons with bounds, points in one place are one
/// corner, and all is made of the polygons' corners, numbered from 0. UGRID's faces are such polygons, or triangles as
/// ICON's.
#[derive(Debug, Clone)]
pub struct Mesh {
    pub(super) path: PathBuf,
    pub(super) convention: Convention,
    pub(super) center: Positions,
    pub(super) corner: Positions,
    /// The corners of each cell.
    pub(super) polygons: Polygons,
    pub(super) corner_cell: Vec<i32>,
    pub(super) corner_edge: Vec<i32>,
    pub(super) edge_corner: Vec<i32>,
}

/// Longitudes and latitudes in radians.
#[derive(Debug, Clone)]
pub(super) struct Positions {
    pub(super) lon: OwnedReals,
    pub(super) lat: OwnedReals,
}

impl Positions {
    fn borrowed(&self) -> LonLat<'_> {
        LonLat { lon_rad: self.lon.as_reals(), lat_rad: self.lat.as_reals() }
    }

    fn is_same(&self, other: &Self) -> bool {
        let equal = |a: &OwnedReals, b: &OwnedReals| match (a, b) {
            (OwnedReals::F32(a), OwnedReals::F32(b)) => a == b,
            (OwnedReals::F64(a), OwnedReals::F64(b)) => a == b,
            _ => false,
        };
        equal(&self.lon, &other.lon) && equal(&self.lat, &other.lat)
    }
}

impl Mesh {
    /// The tables, borrowed. Their MPAS names stand at [`GridTables`].
    pub fn tables(&self) -> GridTables<'_> {
        GridTables {
            index_base: self.index_base(),
            center: self.center.borrowed(),
            corner: self.corner.borrowed(),
            cell_corner: self.polygons.corners.as_slice().into(),
            cell_corner_row: self.polygons.row,
            cell_corner_count: Some(self.polygons.count.as_slice().into()),
            corner_cell: self.corner_cell.as_slice().into(),
            corner_edge: self.corner_edge.as_slice().into(),
            edge_corner: self.edge_corner.as_slice().into(),
        }
    }

    /// The tables as a checked grid.
    ///
    /// # Errors
    /// As [`Grid::new`], with the file's name before the sentence.
    pub fn grid(&self) -> Result<Grid<'_>> {
        Grid::new(self.tables()).map_err(|e| e.within(self.path.display()))
    }

    /// The model whose conventions the file follows.
    pub fn convention(&self) -> Convention {
        self.convention
    }

    /// Number of cells: MPAS's `nCells`, the points of ICON's triangles.
    pub fn cells(&self) -> usize {
        self.tables().cells()
    }

    /// Number of corners: MPAS's `nVertices`, ICON's triangles, the points of polygons.
    pub fn corners(&self) -> usize {
        self.tables().corners()
    }

    /// Number of edges.
    pub fn edges(&self) -> usize {
        self.tables().edges()
    }

    /// The most corners that a cell may have: row length of MPAS's `verticesOnCell`.
    pub fn max_edges(&self) -> usize {
        self.polygons.row
    }

    /// Bytes that the tables take.
    pub fn bytes(&self) -> usize {
        let reals = [&self.center, &self.corner].map(|p| p.lon.bytes() + p.lat.bytes());
        let indices =
            [&self.polygons.corners, &self.polygons.count, &self.corner_cell, &self.corner_edge, &self.edge_corner];
        reals.iter().sum::<usize>() + indices.map(|table| size_of_val(table.as_slice())).iter().sum::<usize>()
    }

    /// The same mesh, whose tables are numbered from 0, as one of MPAS, whose are from 1.
    pub(super) fn into_mpas(mut self) -> Self {
        let tables = [&mut self.polygons.corners, &mut self.corner_cell, &mut self.corner_edge, &mut self.edge_corner];
        tables.into_iter().flatten().for_each(|entry| *entry += 1);
        Mesh { convention: Convention::Mpas, ..self }
    }

    /// The number of the first cell, corner and edge.
    fn index_base(&self) -> i32 {
        i32::from(self.convention == Convention::Mpas)
    }

    /// The file that the tables are from, as given.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether all tables are equal, in whatever file they are: what was derived from one mesh holds for the other.
    pub fn is_same(&self, other: &Mesh) -> bool {
        self.convention == other.convention
            && self.polygons == other.polygons
            && [&self.corner_cell, &self.corner_edge, &self.edge_corner]
                == [&other.corner_cell, &other.corner_edge, &other.edge_corner]
            && self.center.is_same(&other.center)
            && self.corner.is_same(&other.corner)
    }

    /// The cells around a corner, counted from 0; `None` where the mesh has a hole.
    pub(crate) fn cells_at(&self, corner: usize) -> [Option<usize>; 3] {
        let number = |k| i64::from(self.corner_cell[3 * corner + k]) - i64::from(self.index_base());
        let cell = |k| usize::try_from(number(k)).ok();
        [0, 1, 2].map(|k| cell(k).filter(|&cell| cell < self.cells()))
    }
}

/// The variable of that name, of numbers of that kind over those dimensions.
pub(super) fn find<'a>(source: &'a dyn Source, name: &str, dimensions: &[&str], integer: bool) -> Result<&'a Variable> {
    let variable = source.variable(name).ok_or_else(|| missing(source, name))?;
    let fine = match variable.kind {
        Kind::F32 | Kind::F64 => !integer,
        Kind::Integer => integer,
        Kind::Text | Kind::Other => false,
    };
    if !fine || !variable.lies_at_times_over(dimensions) {
        return Err(source.error(
            ErrorKind::Grid,
            format_args!(
                "variable {variable}, expected {name}({}) of {}",
                dimensions.join(", "),
                if integer { "integer" } else { "float or double" }
            ),
        ));
    }
    Ok(variable)
}

pub(super) fn missing(source: &dyn Source, name: &str) -> Error {
    source.error(
        ErrorKind::Grid,
        format_args!("variable {name} is missing: the file holds no whole mesh; {IN_ANOTHER_FILE}"),
    )
}
