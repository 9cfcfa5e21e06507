//! ICON's triangles as the corners of hexagons: icoray's cells are the triangles' points, its corners the triangles.
//!
//! Grid files have a table ([`super::triangles`]). Files with data mostly have none, but each triangle's own three
//! points (`clon_bnds`, `clat_bnds`; extpar's `clon_vertices`, `clat_vertices`): coincident points count as one, which
//! gives the same table ([`PolygonVariables`]). Format: CF conventions 1.11, §7.1.

use super::cf::PolygonVariables;
use super::tables::Mesh;
use crate::source::Source;
use crate::sources::{IN_ANOTHER_FILE, Sources};
use icoray::{ErrorKind, Result};

/// Whether any of the files has triangles with their points.
pub(super) fn has_triangles(sources: &Sources) -> bool {
    sources.all().any(|source| PolygonVariables::of_triangles(source).is_some())
}

/// Whether any of the files has triangles. Only ICON has `clon`.
pub(super) fn is_in(sources: &Sources) -> bool {
    let has_middles = |source: &dyn Source| source.variable("clon").is_some_and(|v| v.after_time().len() == 1);
    has_triangles(sources) || sources.all().any(has_middles)
}

pub(super) fn read(sources: &Sources) -> Result<Mesh> {
    match sources.others_first().find_map(PolygonVariables::of_triangles) {
        Some(triangles) => triangles.mesh(),
        None => Err(sources.error(
            ErrorKind::Grid,
            format_args!(
                "no clon_bnds or clon_vertices, clat_bnds or clat_vertices of triangles with 3 points: without them or \
                 vertex_of_cell(nv, cell) with vlon and vlat the triangles are not known; {IN_ANOTHER_FILE}"
            ),
        )),
    }
}
