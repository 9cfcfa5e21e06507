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

pub(crate) use columns::{is_angle, is_coordinate};
pub use tables::{Convention, Mesh};

use crate::sources::{IN_ANOTHER_FILE, Sources};
use icoray::{ErrorKind, Result};

/// What the files have of a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Found {
    Ugrid,
    Mpas,
    Icon,
    Polygons,
    Columns,
}

impl Found {
    fn of(sources: &Sources) -> Result<Option<Self>> {
        // Without a table of neighbours, columns will do.
        let are_columns = columns::are_in(sources);
        let all = [
            (ugrid::is_in(sources)?, Found::Ugrid),
            (mpas::is_in(sources)? && (mpas::has_tables(sources) || !are_columns), Found::Mpas),
            (icon::has_triangles(sources) || icon::is_in(sources) && !are_columns, Found::Icon),
            (cf::is_in(sources), Found::Polygons),
            (are_columns, Found::Columns),
        ];
        Ok(all.into_iter().find(|(is_there, _)| *is_there).map(|(_, found)| found))
    }
}

/// Whether the files have a mesh of a kind that [`read`] knows.
pub(crate) fn is_known(sources: &Sources) -> Result<bool> {
    Ok(Found::of(sources)?.is_some())
}

/// Reads the tables in the convention of the files; their content is checked by [`Mesh::grid`].
pub(crate) fn read(sources: &Sources) -> Result<Mesh> {
    match Found::of(sources)? {
        Some(Found::Ugrid) => return ugrid::read(sources),
        Some(Found::Mpas) => return mpas::read(sources),
        Some(Found::Icon) => return icon::read(sources),
        Some(Found::Polygons) => return cf::read(sources),
        Some(Found::Columns) => return columns::read(sources),
        None => {}
    }
    Err(sources.error(
        ErrorKind::Grid,
        format_args!(
            "no mesh is known: looked for MPAS's (dimension nCells, variables lonCell, verticesOnCell and more) and for \
             ICON's (variable vertex_of_cell, or clon_bnds or clon_vertices) and for polygons with bounds (lon_bnds(cell, \
             6)), for UGRID's (a variable with cf_role mesh_topology), and for places of columns (lon(ncol), lat(ncol) and \
             a field over ncol, or lon(y, x) and lat(y, x)); {IN_ANOTHER_FILE}"
        ),
    ))
}
