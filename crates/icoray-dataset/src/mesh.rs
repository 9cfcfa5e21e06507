//! Reads the mesh tables of a file in any of the conventions.

mod angles;
mod cf;
mod columns;
mod icon;
mod mpas;
mod points;
mod polygons;
mod tables;
mod ugrid;

pub(crate) use columns::is_coordinate;
pub use tables::{Convention, Mesh};

use crate::sources::{IN_ANOTHER_FILE, Sources};
use icoray::{ErrorKind, Result};

/// Reads the tables in the convention of the files; their content is checked by [`Mesh::grid`].
pub(crate) fn read(sources: &Sources) -> Result<Mesh> {
    if ugrid::is_in(sources)? {
        return ugrid::read(sources);
    }
    // Without a table of neighbours, columns will do.
    let are_columns = columns::are_in(sources);
    if mpas::is_in(sources)? && (mpas::has_tables(sources) || !are_columns) {
        return mpas::read(sources);
    }
    if icon::has_triangles(sources) || icon::is_in(sources) && !are_columns {
        return icon::read(sources);
    }
    if cf::is_in(sources) {
        return cf::read(sources);
    }
    if are_columns {
        return columns::read(sources);
    }
    Err(sources.error(
        ErrorKind::Grid,
        format_args!(
            "no mesh is known: looked for MPAS's (dimension nCells, variables lonCell, verticesOnCell and more) and for \
             ICON's (variable vertex_of_cell, or clon_bnds or clon_vertices) and for polygons with bounds (lon_bnds(cell, \
             6)), for UGRID's (a variable with cf_role mesh_topology), and for places of columns (lon(ncol), lat(ncol) and \
             a field over ncol); {IN_ANOTHER_FILE}"
        ),
    ))
}
