//! Reads the mesh tables of a file in any of the conventions.

mod angles;
mod cf;
mod fesom;
mod icon;
mod mpas;
mod one_mesh;
mod points;
mod polygons;
mod tables;
mod ugrid;

pub(crate) use one_mesh::{expect as expect_one_mesh, expect_one_name};
pub use tables::{Convention, Mesh};

use crate::sources::{IN_ANOTHER_FILE, Sources};
use icoray::{ErrorKind, Result};

/// Reads the tables in the convention of the files; their content is checked by [`Mesh::grid`].
pub(crate) fn read(sources: &Sources) -> Result<Mesh> {
    if ugrid::is_in(sources)? {
        return ugrid::read(sources);
    }
    if fesom::is_in(sources) {
        return fesom::read(sources);
    }
    if mpas::is_in(sources)? {
        return mpas::read(sources);
    }
    if icon::is_in(sources) {
        return icon::read(sources);
    }
    if cf::is_in(sources) {
        return cf::read(sources);
    }
    let there = sources.fields().numbers_in_words();
    Err(sources.error(
        ErrorKind::Grid,
        format_args!(
            "no mesh is known of {there}: looked for MPAS's (dimension nCells, variables lonCell, verticesOnCell and more) and for \
             ICON's (variable vertex_of_cell, or clon_bnds or clon_vertices) and for polygons with bounds (lon_bnds(cell, \
             6)), and for UGRID's (a variable with cf_role mesh_topology) and for FESOM's (variables elements and nodes); \
             {IN_ANOTHER_FILE}"
        ),
    ))
}
