//! Reads the mesh tables of a file in any of the conventions.

mod angles;
mod cf;
mod columns;
mod fesom;
mod icon;
mod mpas;
mod one_mesh;
mod points;
mod polygons;
mod tables;
mod ugrid;

pub(crate) use columns::{is_angle, is_coordinate};
pub(crate) use one_mesh::{expect as expect_one_mesh, expect_one_name};
pub use tables::{Convention, Mesh};

use crate::sources::{IN_ANOTHER_FILE, Sources};
use icoray::{ErrorKind, Result};

type Reader = fn(&Sources) -> Result<Mesh>;

/// The reader of the mesh in the files.
fn reader(sources: &Sources) -> Result<Option<Reader>> {
    // Without a table of neighbours, columns suffice.
    let are_columns = columns::are_in(sources);
    let all: [(bool, Reader); 6] = [
        (ugrid::is_in(sources)?, ugrid::read),
        (fesom::is_in(sources), fesom::read),
        (mpas::is_in(sources)? && (mpas::has_tables(sources) || !are_columns), mpas::read),
        (icon::has_triangles(sources) || icon::is_in(sources) && !are_columns, icon::read),
        (cf::is_in(sources), cf::read),
        (are_columns, columns::read),
    ];
    Ok(all.into_iter().find(|(is_there, _)| *is_there).map(|(_, reader)| reader))
}

/// Whether the files have a mesh of a kind that [`read`] supports.
pub(crate) fn is_known(sources: &Sources) -> Result<bool> {
    Ok(reader(sources)?.is_some())
}

/// Reads the tables in the convention of the files; their content is checked by [`Mesh::grid`].
pub(crate) fn read(sources: &Sources) -> Result<Mesh> {
    if let Some(reader) = reader(sources)? {
        return reader(sources);
    }
    let there = sources.fields().numbers_in_words();
    Err(sources.error(
        ErrorKind::Grid,
        format_args!(
            "no mesh is known of {there}: looked for MPAS's (dimension nCells, variables lonCell, verticesOnCell and more) and for \
             ICON's (variable vertex_of_cell, or clon_bnds or clon_vertices) and for polygons with bounds (lon_bnds(cell, \
             6)), for UGRID's (a variable with cf_role mesh_topology), for FESOM's (variables elements and nodes), and for \
             places of columns (lon(ncol), lat(ncol) and a field over ncol, or lon(y, x) and lat(y, x)); {IN_ANOTHER_FILE}"
        ),
    ))
}
