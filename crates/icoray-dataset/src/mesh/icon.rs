//! ICON's triangles as the corners of hexagons: icoray's cells are the triangles' points, its corners the triangles.
//!
//! Grid files have `vertex_of_cell`. Files with data mostly have no tables, but each triangle's own three points
//! (`clon_bnds`, `clat_bnds`; extpar's `clon_vertices`, `clat_vertices`): coincident points count as one, which gives
//! the same table ([`PolygonVariables`]). Formats: ICON grid files, <https://gitlab.dkrz.de/icon>; CF conventions 1.11, §7.1.

use super::angles::positions;
use super::cf::PolygonVariables;
use super::tables::{Convention, Mesh, find, missing};
use crate::source::Source;
use crate::sources::{IN_ANOTHER_FILE, Sources};
use icoray::{ErrorKind, Result};

/// Whether any of the files has triangles with their points.
pub(super) fn has_triangles(sources: &Sources) -> bool {
    let has = |source| PolygonVariables::of_triangles(source).is_some();
    sources.all().any(|source| source.variable("vertex_of_cell").is_some() || has(source))
}

/// Whether any of the files has triangles. Only ICON has `clon`.
pub(super) fn is_in(sources: &Sources) -> bool {
    let has_middles = |source: &dyn Source| source.variable("clon").is_some_and(|v| v.after_time().len() == 1);
    has_triangles(sources) || sources.all().any(has_middles)
}

pub(super) fn read(sources: &Sources) -> Result<Mesh> {
    let with_tables = sources.others_first().find(|source| source.variable("vertex_of_cell").is_some());
    if let Some(source) = with_tables {
        return of_tables(source);
    }
    match sources.others_first().find_map(PolygonVariables::of_triangles) {
        Some(triangles) => triangles.mesh(),
        None => Err(sources.error(
            ErrorKind::Grid,
            format_args!(
                "no clon_bnds or clon_vertices, clat_bnds or clat_vertices of triangles with 3 points: without them or \
                 vertex_of_cell the triangles are not known; {IN_ANOTHER_FILE}"
            ),
        )),
    }
}

/// The mesh of a grid file.
fn of_tables(source: &dyn Source) -> Result<Mesh> {
    if let Some(geometry) = source.number("grid_geometry")?.filter(|geometry| *geometry != 1.0) {
        let context = format!("grid_geometry is {geometry}, expected 1: only meshes on a sphere are rendered");
        return Err(source.error(ErrorKind::Unsupported, context));
    }
    let variable = source.variable("vertex_of_cell").ok_or_else(|| missing(source, "vertex_of_cell"))?;
    let [three, cells] = match variable.after_time() {
        [three, cells] if three.len == 3 => [three, cells],
        _ => {
            let context = format!("variable {variable}, expected vertex_of_cell(nv = 3, cell) of integer");
            return Err(source.error(ErrorKind::Grid, context));
        }
    };
    let table = find(source, "vertex_of_cell", &[&three.name, &cells.name], true)?;
    let corner = positions(source, "clon", "clat", &cells.name)?;
    let vertex = source.variable("vlon").ok_or_else(|| missing(source, "vlon"))?;
    let vertices = vertex.after_time().first().map_or("", |d| d.name.as_str());
    let center = positions(source, "vlon", "vlat", vertices)?;
    // The file has the triangles' first points, then their second, then their third.
    let by_column = source.all_integers(table)?;
    let triangles = by_column.len() / 3;
    let corner_cell = (0..by_column.len()).map(|i| by_column[i % 3 * triangles + i / 3].saturating_sub(1)).collect();
    Mesh::of_triangles(source.path(), Convention::Icon, [center, corner], corner_cell)
        .map_err(|e| e.within(source.path().display()))
}
