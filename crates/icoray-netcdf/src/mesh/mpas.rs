//! MPAS's tables, as the MPAS mesh specification 1.0 has them.

use super::{Convention, Mesh, Positions, find};
use crate::source::Source;
use crate::sources::Sources;
use icoray::{ErrorKind, Result};

/// Whether any of the files follows MPAS's conventions.
pub(super) fn is_in(sources: &Sources) -> Result<bool> {
    for source in sources.all() {
        if source.dimension_len("nCells")?.is_some() {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Reads the nine tables from the first of the other files that has any, or from the fields' own.
pub(super) fn read(sources: &Sources) -> Result<Mesh> {
    for source in sources.all() {
        expect_sphere(source)?;
    }
    let has_mesh =
        |source: &&Source| ["lonCell", "cellsOnVertex"].iter().any(|n| source.variable(n).is_some());
    let source = sources.others_first().find(has_mesh).or(sources.others_first().next());
    let source = source.expect("a file is open");
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
            format_args!(
                "vertexDegree is {degree}, expected 3: only meshes whose corners each join 3 cells are rendered"
            ),
        ));
    }
    let two = vertices_on_edge.dimensions[1].len;
    if two != 2 {
        return Err(
            source.error(ErrorKind::Grid, format_args!("{vertices_on_edge}: rows of {two}, expected 2"))
        );
    }
    Ok(Mesh {
        path: source.path().to_owned(),
        convention: Convention::Mpas,
        index_base: 1,
        center: Positions { lon: source.all_reals(lon_cell)?, lat: source.all_reals(lat_cell)? },
        corner: Positions { lon: source.all_reals(lon_vertex)?, lat: source.all_reals(lat_vertex)? },
        cell_corner_row: vertices_on_cell.dimensions[1].len,
        cell_corner: source.all_integers(vertices_on_cell)?,
        cell_corner_count: source.all_integers(edges_of_cell)?,
        corner_cell: source.all_integers(cells_on_vertex)?,
        corner_edge: source.all_integers(edges_on_vertex)?,
        edge_corner: source.all_integers(vertices_on_edge)?,
    })
}

/// Refuses a mesh that says it is planar. The attribute may be absent: [`icoray::Grid::new`] finds out then.
fn expect_sphere(source: &Source) -> Result<()> {
    match source.text("on_a_sphere")? {
        Some(answer) if answer.to_ascii_uppercase().starts_with('N') => Err(source.error(
            ErrorKind::Unsupported,
            format_args!("on_a_sphere is {answer}: the mesh is planar, only meshes on a sphere are rendered"),
        )),
        _ => Ok(()),
    }
}
