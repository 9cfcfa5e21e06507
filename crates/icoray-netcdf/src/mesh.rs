//! The mesh tables of a file, whatever model wrote it.

mod angles;
mod cf;
mod icon;
mod mpas;
mod points;
mod polygons;

use crate::reals::OwnedReals;
use crate::source::{Kind, Source, Variable};
use crate::sources::Sources;
use icoray::{Error, ErrorKind, Grid, GridTables, LonLat, Result};
use std::fmt;
use std::path::PathBuf;

/// Whose conventions a file follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Convention {
    /// MPAS: hexagons with their tables; fields at cells or corners.
    Mpas,
    /// ICON: triangles, which are the corners of the hexagons around their points; fields at corners or, rarely, at cells.
    Icon,
    /// Polygons with their bounds over one dimension, as the CF conventions 1.11, §7.1, have them and DYNAMICO writes them;
    /// fields at cells.
    Cf,
}

impl fmt::Display for Convention {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Convention::Mpas => "MPAS",
            Convention::Icon => "ICON",
            Convention::Cf => "CF polygons",
        })
    }
}

/// The tables that icoray reads of a mesh, owned.
///
/// Of MPAS as the file stores them, numbered from 1; those that lack are made of the others where these determine them. Of
/// ICON `corner_cell` is `vertex_of_cell`, or is rebuilt from the triangles' bounds where the file has no tables, and all
/// others are made of it, numbered from 0. Of polygons with bounds, points in one place are one corner, and all is made of
/// the polygons' corners, numbered from 0.
#[derive(Debug, Clone)]
pub struct Mesh {
    path: PathBuf,
    convention: Convention,
    index_base: i32,
    center: Positions,
    corner: Positions,
    cell_corner: Vec<i32>,
    cell_corner_row: usize,
    cell_corner_count: Vec<i32>,
    corner_cell: Vec<i32>,
    corner_edge: Vec<i32>,
    edge_corner: Vec<i32>,
}

/// Longitudes and latitudes in radians.
#[derive(Debug, Clone)]
struct Positions {
    lon: OwnedReals,
    lat: OwnedReals,
}

impl Positions {
    fn borrowed(&self) -> LonLat<'_> {
        LonLat { lon_rad: self.lon.as_reals(), lat_rad: self.lat.as_reals() }
    }
}

impl Mesh {
    /// Reads the tables of whichever model's the files are; what they say is checked by [`Mesh::grid`].
    pub(crate) fn read(sources: &Sources) -> Result<Self> {
        if mpas::is_in(sources)? {
            return mpas::read(sources);
        }
        if icon::is_in(sources) {
            return icon::read(sources);
        }
        if cf::is_in(sources) {
            return cf::read(sources);
        }
        Err(sources.error(
            ErrorKind::Grid,
            "no mesh is known: looked for MPAS's (dimension nCells, variables lonCell, verticesOnCell and more) and for ICON's \
             (variable vertex_of_cell, or clon_bnds or clon_vertices) and for polygons with bounds (lon_bnds(cell, 6)); it may \
             be in another file, such as the run's grid file",
        ))
    }

    /// The tables, borrowed. Their MPAS names stand at [`GridTables`].
    pub fn tables(&self) -> GridTables<'_> {
        GridTables {
            index_base: self.index_base,
            center: self.center.borrowed(),
            corner: self.corner.borrowed(),
            cell_corner: self.cell_corner.as_slice().into(),
            cell_corner_row: self.cell_corner_row,
            cell_corner_count: Some(self.cell_corner_count.as_slice().into()),
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

    /// Whose conventions the file follows.
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
        self.cell_corner_row
    }

    /// Bytes that the tables take.
    pub fn bytes(&self) -> usize {
        let reals = [&self.center, &self.corner].map(|p| p.lon.bytes() + p.lat.bytes());
        let indices = [
            &self.cell_corner,
            &self.cell_corner_count,
            &self.corner_cell,
            &self.corner_edge,
            &self.edge_corner,
        ];
        reals.iter().sum::<usize>() + indices.map(|table| size_of_val(table.as_slice())).iter().sum::<usize>()
    }

    /// The file that the tables are from.
    pub(crate) fn path(&self) -> &std::path::Path {
        &self.path
    }

    /// The cells around a corner, counted from 0; `None` where the mesh has a hole.
    pub(crate) fn cells_at(&self, corner: usize) -> [Option<usize>; 3] {
        let number = |k| i64::from(self.corner_cell[3 * corner + k]) - i64::from(self.index_base);
        let cell = |k| usize::try_from(number(k)).ok();
        [0, 1, 2].map(|k| cell(k).filter(|&cell| cell < self.cells()))
    }
}

/// The variable of that name, of numbers of that kind over those dimensions.
fn find<'a>(source: &'a Source, name: &str, dimensions: &[&str], integer: bool) -> Result<&'a Variable> {
    let variable = source.variable(name).ok_or_else(|| missing(source, name))?;
    let fine = match variable.kind {
        Kind::F32 | Kind::F64 => !integer,
        Kind::Integer => integer,
        Kind::Text | Kind::Other => false,
    };
    if !fine || !variable.lies_over(dimensions) {
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

fn missing(source: &Source, name: &str) -> Error {
    source.error(
        ErrorKind::Grid,
        format_args!(
            "variable {name} is missing: the file holds no whole mesh; it may be in another file, such as the run's init or \
             grid file"
        ),
    )
}
