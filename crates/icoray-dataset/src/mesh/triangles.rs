//! Tables of triangles of nodes: those of ICON's grid files, <https://gitlab.dkrz.de/icon>, of FESOM2's
//! `fesom.mesh.diag.nc` without UGRID's variables, and of FVCOM.

use super::angles::{of_directions, positions, positions_of_pairs};
use super::tables::{Mesh, MeshLayout, missing};
use crate::source::{SourceVariable, Variable};
use crate::sources::Sources;
use icoray::{ErrorKind, Result, circumcenter};

/// Names of a table with the nodes of each triangle from 1, and of its coordinates.
struct Names {
    /// The model.
    model: &'static str,
    table: &'static str,
    /// Longitude and latitude of the nodes, or one variable of both.
    nodes: &'static [&'static str],
    /// Longitude and latitude of the triangles' middles.
    middles: [&'static str; 2],
}

const NAMES: [Names; 3] = [
    Names { model: "ICON", table: "vertex_of_cell", nodes: &["vlon", "vlat"], middles: ["clon", "clat"] },
    Names { model: "FESOM2", table: "elements", nodes: &["nodes"], middles: ["", ""] },
    Names { model: "FVCOM", table: "nv", nodes: &["lon", "lat"], middles: ["lonc", "latc"] },
];

/// A file's table of triangles.
pub(super) struct Triangles<'a> {
    table: SourceVariable<'a>,
    names: &'static Names,
}

/// The table of the first file that has one: ICON's by its name alone; of the other names, which other tables have too,
/// only one of triangles with the nodes' coordinates.
pub(super) fn find(sources: &Sources) -> Option<Triangles<'_>> {
    sources.others_first().find_map(|source| {
        NAMES.iter().find_map(|names| {
            let table = source.find(names.table)?;
            let is_place = |v: &Variable| v.kind.is_real() && v.after_time().len() + names.nodes.len() == 3;
            let are_places = || names.nodes.iter().all(|name| source.variable(name).is_some_and(is_place));
            let is_found = table.own_name() == NAMES[0].table || has_threes(table.variable) && are_places();
            is_found.then_some(Triangles { table, names })
        })
    })
}

fn has_threes(table: &Variable) -> bool {
    matches!(table.after_time(), [a, b] if a.len == 3 || b.len == 3)
}

pub(super) fn read(Triangles { table, names }: Triangles) -> Result<Mesh> {
    let source = table.source;
    if let Some(geometry) = source.number("grid_geometry")?.filter(|geometry| *geometry != 1.0) {
        let context = format!("grid_geometry is {geometry}, expected 1: only meshes on a sphere are rendered");
        return Err(source.error(ErrorKind::Unsupported, context));
    }
    if !has_threes(table.variable) {
        return Err(table.unexpected(ErrorKind::Grid, "the 3 nodes of each triangle"));
    }
    let first = source.find(names.nodes[0]).ok_or_else(|| missing(source, names.nodes[0]))?;
    let nodes = match *names.nodes {
        [lon, lat] => positions(source, [lon, lat], first.variable.after_time().first().map_or("", |d| &d.name))?,
        _ => positions_of_pairs(first)?,
    };
    let is_by_place = table.variable.after_time()[0].len == 3;
    let triangle = &table.variable.after_time()[usize::from(is_by_place)].name;
    let has_middles = names.middles.iter().all(|name| source.variable(name).is_some());
    let middles = has_middles.then(|| positions(source, names.middles, triangle)).transpose()?;
    let numbers = table.all_integers()?;
    let (count, last) = (numbers.len() / 3, nodes.lon.as_reals().len());
    let entry = |i: usize| if is_by_place { numbers[i % 3 * count + i / 3] } else { numbers[i] };
    let rows: Vec<i32> = (0..3 * count).map(|i| entry(i).saturating_sub(1)).collect();
    if let Some(i) = rows.iter().position(|node| !(0..last as i64).contains(&i64::from(*node))) {
        let context = format!("{}: node {} of element {}, expected 1 to {last}", table.name(), entry(i), i / 3);
        return Err(source.error(ErrorKind::Grid, context));
    }
    let circle = |triangle: &[i32; 3]| circumcenter(triangle.map(|node| nodes.direction(node)));
    let corner = middles.unwrap_or_else(|| of_directions(rows.as_chunks().0.iter().map(circle)));
    Mesh::of_triangles(source.path(), MeshLayout::Triangles, [nodes, corner], rows)
        .map(|mesh| mesh.with_format(names.model))
        .map_err(|e| e.within(source.path().display()))
}
