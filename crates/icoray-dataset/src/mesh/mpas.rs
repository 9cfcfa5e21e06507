//! MPAS's tables, according to the MPAS mesh specification 1.0; missing ones are derived from the others.

use super::angles::{self, of_directions};
use super::polygons::{NONE, Polygons, cells_of_corners, ends_of_edges};
use super::tables::{Mesh, MeshLayout, Positions, find, missing};
use crate::source::{Source, SourceVariable};
use crate::sources::Sources;
use icoray::{Connectivity, ErrorKind, Result};

/// Tables from which the others may be derived.
const TABLES: [&str; 6] =
    ["lonCell", "verticesOnCell", "cellsOnVertex", "cellsOnEdge", "edgesOnVertex", "verticesOnEdge"];

/// Whether any of the files follows MPAS's conventions.
pub(super) fn is_in(sources: &Sources) -> Result<bool> {
    Ok(sources.dimension_len("nCells")?.is_some())
}

/// Whether any of the files has a table of neighbours.
pub(super) fn has_tables(sources: &Sources) -> bool {
    sources.all().any(|source| TABLES[1..].iter().any(|table| source.variable(table).is_some()))
}

/// Reads the tables from the first of the other files that has any, or from the fields' own.
pub(super) fn read(sources: &Sources) -> Result<Mesh> {
    for source in sources.all() {
        expect_sphere(source)?;
    }
    let has_mesh = |source: &&dyn Source| TABLES.iter().any(|n| source.variable(n).is_some());
    let source = sources.others_first().find(has_mesh).or(sources.others_first().next());
    let source = source.expect("a file is open");
    let center = positions(source, ["lonCell", "latCell"], ["xCell", "yCell", "zCell"], "nCells")?;
    let corner = positions(source, ["lonVertex", "latVertex"], ["xVertex", "yVertex", "zVertex"], "nVertices")?;
    Tables::read(source)?.mesh(source, [center, corner])
}

/// Longitudes and latitudes; from Cartesian coordinates if there are none.
fn positions(source: &dyn Source, angles: [&str; 2], cartesian: [&str; 3], dimension: &str) -> Result<Positions> {
    let is_cartesian = source.variable(angles[0]).is_none() && cartesian.iter().all(|n| source.variable(n).is_some());
    if !is_cartesian {
        return angles::positions(source, angles, dimension);
    }
    let read = |name: &str| find(source, name, &[dimension], false)?.all_numbers();
    let [x, y, z] = cartesian;
    let [x, y, z] = [read(x)?, read(y)?, read(z)?];
    Ok(of_directions((0..x.len()).map(|i| [x[i], y[i], z[i]])))
}

/// The tables of a file: numbered from 1; `None` if the file lacks one.
struct Tables {
    cell_corner: Option<(Vec<i32>, usize)>,
    cell_corner_count: Option<Vec<i32>>,
    corner_cell: Option<Vec<i32>>,
    corner_edge: Option<Vec<i32>>,
    edge_corner: Option<Vec<i32>>,
    edge_cell: Option<Vec<i32>>,
}

impl Tables {
    fn read(source: &dyn Source) -> Result<Self> {
        let table = |name: &str, dimensions: &[&str]| {
            source.variable(name).map(|_| find(source, name, dimensions, true)).transpose()
        };
        let read = |found: Option<SourceVariable>| found.map(SourceVariable::all_integers).transpose();
        let vertices_on_cell = table("verticesOnCell", &["nCells", "maxEdges"])?;
        let cells_on_vertex = table("cellsOnVertex", &["nVertices", "vertexDegree"])?;
        let edges_on_vertex = table("edgesOnVertex", &["nVertices", "vertexDegree"])?;
        let vertices_on_edge = table("verticesOnEdge", &["nEdges", "TWO"])?;
        let cells_on_edge = table("cellsOnEdge", &["nEdges", "TWO"])?;
        let row = |found: SourceVariable| found.variable.after_time()[1].len;
        for degree in cells_on_vertex.into_iter().chain(edges_on_vertex).map(row) {
            if degree != 3 {
                return Err(source.error(
                    ErrorKind::Unsupported,
                    format_args!(
                        "vertexDegree is {degree}, expected 3: only meshes whose corners each join 3 cells are rendered"
                    ),
                ));
            }
        }
        if let Some(table) = vertices_on_edge.into_iter().chain(cells_on_edge).find(|table| row(*table) != 2) {
            let context = format!("{}: rows of {}, expected 2", table.variable, row(table));
            return Err(source.error(ErrorKind::Grid, context));
        }
        let row = vertices_on_cell.map_or(0, row);
        Ok(Tables {
            cell_corner: read(vertices_on_cell)?.map(|table| (table, row)),
            cell_corner_count: read(table("nEdgesOnCell", &["nCells"])?)?,
            corner_cell: read(cells_on_vertex)?,
            corner_edge: read(edges_on_vertex)?,
            edge_corner: read(vertices_on_edge)?,
            edge_cell: read(cells_on_edge)?,
        })
    }

    /// The mesh of these tables, or if one is missing of the polygons that the others determine.
    ///
    /// # Errors
    /// [`ErrorKind::Grid`] if these do not determine them, with the name of a missing one; [`ErrorKind::Unsupported`]
    /// if a corner joins more than 3 cells.
    fn mesh(self, source: &dyn Source, places: [Positions; 2]) -> Result<Mesh> {
        match self {
            Tables {
                cell_corner: Some((cell_corner, cell_corner_row)),
                cell_corner_count: Some(cell_corner_count),
                corner_cell: Some(corner_cell),
                corner_edge: Some(corner_edge),
                edge_corner: Some(edge_corner),
                edge_cell: _,
            } => {
                let connectivity =
                    Connectivity { corner_edge, edge_corner, cell_corner, cell_corner_row, cell_corner_count };
                Ok(Mesh::of_tables(source.path(), MeshLayout::Mpas, places, corner_cell, connectivity))
            }
            lacking => {
                let [cells, corners] = [0, 1].map(|k| places[k].lon.as_reals().len());
                let polygons = lacking.polygons(source, cells, corners)?;
                let mesh = Mesh::of_polygons(source.path(), places, polygons);
                mesh.map(Mesh::into_mpas).map_err(|e| e.within(source.path().display()))
            }
        }
    }

    /// The corners of each cell, numbered from 0.
    fn polygons(self, source: &dyn Source, cells: usize, corners: usize) -> Result<Polygons> {
        if let Some((table, row)) = self.cell_corner {
            let counted = within_counts(&table, row, self.cell_corner_count.as_deref());
            return Ok(Polygons::of_rows(&from_0(&counted), row));
        }
        let within = |e: icoray::Error| e.within(source.path().display());
        let ends = match (self.edge_corner, self.corner_edge) {
            (Some(ends), _) => Some(from_0(&ends)),
            (None, Some(edges)) => Some(ends_of_edges(&from_0(&edges)).map_err(within)?),
            (None, None) => None,
        };
        let corner_cell = match (self.corner_cell, &ends, self.edge_cell) {
            (Some(table), ..) => from_0(&table),
            (None, Some(ends), Some(beside)) => cells_of_corners(ends, &from_0(&beside), corners).map_err(within)?,
            _ => return Err(missing(source, "cellsOnVertex")),
        };
        if let Some(ends) = ends {
            return Polygons::of_edges(&corner_cell, &ends, cells).map_err(within);
        }
        let of = Connectivity::new(&corner_cell, cells).map_err(within)?;
        Ok(Polygons { corners: of.cell_corner, row: of.cell_corner_row, count: of.cell_corner_count })
    }
}

/// Converts a table numbered from 1 to one from 0, with marks for missing entries.
fn from_0(table: &[i32]) -> Vec<i32> {
    table.iter().map(|entry| if *entry > 0 { entry - 1 } else { NONE }).collect()
}

/// The table with 0 behind the entries that count.
fn within_counts(table: &[i32], row: usize, count: Option<&[i32]>) -> Vec<i32> {
    let mut table = table.to_vec();
    for (entries, count) in table.chunks_exact_mut(row.max(1)).zip(count.into_iter().flatten()) {
        entries.iter_mut().skip((*count).max(0) as usize).for_each(|entry| *entry = 0);
    }
    table
}

/// Refuses a mesh that is marked as planar. The attribute may be absent: then [`icoray::Grid::new`] detects it.
fn expect_sphere(source: &dyn Source) -> Result<()> {
    match source.text("on_a_sphere")? {
        Some(answer) if answer.to_ascii_uppercase().starts_with('N') => Err(source.error(
            ErrorKind::Unsupported,
            format_args!("on_a_sphere is {answer}: the mesh is planar, only meshes on a sphere are rendered"),
        )),
        _ => Ok(()),
    }
}
