//! The mesh tables of an MPAS file.

use crate::reals::OwnedReals;
use crate::source::{Kind, Source, Variable};
use icoray::{ErrorKind, Grid, GridTables, LonLat, Result};
use std::path::PathBuf;

/// The tables that icoray reads of an MPAS mesh, owned, as the file stores them (numbered from 1).
#[derive(Debug, Clone)]
pub struct MpasMesh {
    path: PathBuf,
    lon_cell: OwnedReals,
    lat_cell: OwnedReals,
    lon_vertex: OwnedReals,
    lat_vertex: OwnedReals,
    vertices_on_cell: Vec<i32>,
    max_edges: usize,
    edges_of_cell: Vec<i32>,
    cells_on_vertex: Vec<i32>,
    edges_on_vertex: Vec<i32>,
    vertices_on_edge: Vec<i32>,
}

impl MpasMesh {
    /// Reads the nine tables; what they say is checked by [`MpasMesh::grid`].
    pub(crate) fn read(source: &Source) -> Result<Self> {
        expect_sphere(source)?;
        let table = |name: &str, dimensions: &[&str], integer: bool| find(source, name, dimensions, integer);
        let lon_cell = table("lonCell", &["nCells"], false)?;
        let lat_cell = table("latCell", &["nCells"], false)?;
        let lon_vertex = table("lonVertex", &["nVertices"], false)?;
        let lat_vertex = table("latVertex", &["nVertices"], false)?;
        let edges_of_cell = table("nEdgesOnCell", &["nCells"], true)?;
        let vertices_on_cell = table("verticesOnCell", &["nCells", "maxEdges"], true)?;
        let cells_on_vertex = table("cellsOnVertex", &["nVertices", "vertexDegree"], true)?;
        let edges_on_vertex = table("edgesOnVertex", &["nVertices", "vertexDegree"], true)?;
        let vertices_on_edge = table("verticesOnEdge", &["nEdges", "TWO"], true)?;
        let degree = cells_on_vertex.dimensions[1].len;
        if degree != 3 {
            return Err(source.error(
                ErrorKind::Unsupported,
                format_args!("vertexDegree is {degree}, expected 3: only meshes whose corners each join 3 cells are rendered"),
            ));
        }
        let two = vertices_on_edge.dimensions[1].len;
        if two != 2 {
            return Err(
                source.error(ErrorKind::Grid, format_args!("{vertices_on_edge}: rows of {two}, expected 2"))
            );
        }
        Ok(MpasMesh {
            path: source.path().to_owned(),
            lon_cell: source.all_reals(lon_cell)?,
            lat_cell: source.all_reals(lat_cell)?,
            lon_vertex: source.all_reals(lon_vertex)?,
            lat_vertex: source.all_reals(lat_vertex)?,
            max_edges: vertices_on_cell.dimensions[1].len,
            vertices_on_cell: source.all_integers(vertices_on_cell)?,
            edges_of_cell: source.all_integers(edges_of_cell)?,
            cells_on_vertex: source.all_integers(cells_on_vertex)?,
            edges_on_vertex: source.all_integers(edges_on_vertex)?,
            vertices_on_edge: source.all_integers(vertices_on_edge)?,
        })
    }

    /// The tables, borrowed. Their MPAS names stand at [`GridTables`].
    pub fn tables(&self) -> GridTables<'_> {
        GridTables {
            index_base: 1,
            center: LonLat { lon_rad: self.lon_cell.as_reals(), lat_rad: self.lat_cell.as_reals() },
            corner: LonLat { lon_rad: self.lon_vertex.as_reals(), lat_rad: self.lat_vertex.as_reals() },
            cell_corner: self.vertices_on_cell.as_slice().into(),
            cell_corner_row: self.max_edges,
            cell_corner_count: Some(self.edges_of_cell.as_slice().into()),
            corner_cell: self.cells_on_vertex.as_slice().into(),
            corner_edge: self.edges_on_vertex.as_slice().into(),
            edge_corner: self.vertices_on_edge.as_slice().into(),
        }
    }

    /// The tables as a checked grid.
    ///
    /// # Errors
    /// As [`Grid::new`], with the file's name before the sentence.
    pub fn grid(&self) -> Result<Grid<'_>> {
        Grid::new(self.tables()).map_err(|e| e.within(self.path.display()))
    }

    /// Number of cells (`nCells`).
    pub fn cells(&self) -> usize {
        self.tables().cells()
    }

    /// Number of corners (`nVertices`).
    pub fn corners(&self) -> usize {
        self.tables().corners()
    }

    /// Number of edges (`nEdges`).
    pub fn edges(&self) -> usize {
        self.tables().edges()
    }

    /// Row length of `verticesOnCell`: the most corners that a cell may have.
    pub fn max_edges(&self) -> usize {
        self.max_edges
    }

    /// Bytes that the tables take.
    pub fn bytes(&self) -> usize {
        let reals =
            [&self.lon_cell, &self.lat_cell, &self.lon_vertex, &self.lat_vertex].map(OwnedReals::bytes);
        let indices = [
            &self.vertices_on_cell,
            &self.edges_of_cell,
            &self.cells_on_vertex,
            &self.edges_on_vertex,
            &self.vertices_on_edge,
        ]
        .map(|table| size_of_val(table.as_slice()));
        reals.iter().chain(&indices).sum()
    }
}

/// Refuses a mesh that says it is planar. The attribute may be absent: [`Grid::new`] finds out then.
pub(crate) fn expect_sphere(source: &Source) -> Result<()> {
    match source.text("on_a_sphere")? {
        Some(answer) if answer.to_ascii_uppercase().starts_with('N') => Err(source.error(
            ErrorKind::Unsupported,
            format_args!("on_a_sphere is {answer}: the mesh is planar, only meshes on a sphere are rendered"),
        )),
        _ => Ok(()),
    }
}

fn find<'a>(source: &'a Source, name: &str, dimensions: &[&str], integer: bool) -> Result<&'a Variable> {
    let Some(variable) = source.variable(name) else {
        return Err(source.error(
            ErrorKind::Grid,
            format_args!(
                "variable {name} is missing: the file holds no whole MPAS mesh; it may be in another file, \
                 such as the run's init or grid file"
            ),
        ));
    };
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
