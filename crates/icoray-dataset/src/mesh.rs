//! Reads the mesh tables of a file in any of the conventions.

mod angles;
mod cf;
mod columns;
mod esmf;
mod healpix;
mod icon;
mod mpas;
mod one_mesh;
mod points;
mod polygons;
mod tables;
mod triangles;
pub(crate) mod ugrid;

pub(crate) use columns::{is_angle, is_coordinate};
pub(crate) use one_mesh::{expect as expect_one_mesh, expect_one_name};
pub use points::DistinctPoints;
pub use tables::{Mesh, MeshLayout};

use crate::sources::{IN_ANOTHER_FILE, Sources};
use icoray::{ErrorKind, Result};

/// Reads a mesh that was found.
type Reader<'a> = Box<dyn FnOnce() -> Result<Mesh> + 'a>;

fn boxed<'a>(read: impl FnOnce() -> Result<Mesh> + 'a) -> Reader<'a> {
    Box::new(read)
}

/// The reader of the mesh in the files.
fn reader(sources: &Sources) -> Result<Option<Reader<'_>>> {
    let columns = columns::find(sources);
    // Without a table of neighbours, columns suffice.
    let is_mpas = mpas::is_in(sources)? && (mpas::has_tables(sources) || columns.is_none());
    let is_icon = icon::has_triangles(sources) || icon::is_in(sources) && columns.is_none();
    let all = [
        ugrid::find(sources)?.map(|found| boxed(move || Ok(ugrid::read(sources, &found)?.with_format("UGRID")))),
        esmf::find(sources).map(|found| boxed(move || Ok(esmf::read(sources, found)?.with_format("ESMF")))),
        triangles::find(sources).map(|found| boxed(move || triangles::read(found))),
        is_mpas.then(|| boxed(|| mpas::read(sources))),
        is_icon.then(|| boxed(|| icon::read(sources))),
        cf::find(sources).map(|found| boxed(move || found.mesh())),
        columns.map(|found| boxed(move || columns::read(&found))),
        healpix::find(sources).map(|found| boxed(move || healpix::read(sources, found))),
    ];
    Ok(all.into_iter().flatten().next())
}

/// Whether the files have a mesh of a kind that [`read`] supports.
pub(crate) fn is_known(sources: &Sources) -> Result<bool> {
    Ok(reader(sources)?.is_some())
}

/// Reads the tables in the convention of the files; their content is checked by [`Mesh::grid`].
pub(crate) fn read(sources: &Sources) -> Result<Mesh> {
    if let Some(reader) = reader(sources)? {
        return reader();
    }
    let there = sources.fields().numbers_in_words();
    Err(sources.error(
        ErrorKind::Grid,
        format_args!(
            "no mesh is known of {there}: looked for MPAS's (dimension nCells, variables lonCell, verticesOnCell and more) and for \
             ICON's (variable vertex_of_cell, or clon_bnds or clon_vertices) and for polygons with bounds (lon_bnds(cell, \
             6), or SCRIP's grid_corner_lon), for UGRID's (a variable with cf_role mesh_topology), for ESMF's (variable \
             elementConn), for FESOM's and FVCOM's (variables elements and nodes, or nv), for HEALPix (a variable with \
             grid_mapping_name healpix), and for places of columns (lon(ncol), lat(ncol) and a field over ncol, or \
             lon(y, x) and lat(y, x)); {IN_ANOTHER_FILE}"
        ),
    ))
}
