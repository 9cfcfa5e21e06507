//! Tables of triangles of nodes: those of FESOM2's `fesom.mesh.diag.nc` without UGRID's variables, and FVCOM's.

use super::angles::{positions, positions_of_pairs};
use super::tables::{Mesh, Positions};
use super::ugrid::of_faces;
use crate::source::{Source, Variable};
use crate::sources::Sources;
use icoray::{ErrorKind, Result};

/// Names of tables, with the nodes of each triangle from 1, and of the variables of the nodes' and the triangles'
/// coordinates: longitude and latitude, or one variable of both.
const TABLES: [(&str, &[&str], [&str; 2]); 2] =
    [("elements", &["nodes"], ["", ""]), ("nv", &["lon", "lat"], ["lonc", "latc"])];

/// A file's table of triangles.
pub(super) struct Triangles<'a> {
    source: &'a dyn Source,
    table: &'a Variable,
    nodes: Vec<&'a Variable>,
    middles: [&'static str; 2],
}

/// The table of the first file that has one and the nodes' coordinates.
pub(super) fn find(sources: &Sources) -> Option<Triangles<'_>> {
    sources.others_first().find_map(|source| {
        TABLES.iter().find_map(|(table, nodes, middles)| {
            let table = source.variable(table)?;
            let nodes: Vec<&Variable> = nodes.iter().map(|name| source.variable(name)).collect::<Option<_>>()?;
            let has_threes = matches!(table.after_time(), [a, b] if a.len == 3 || b.len == 3);
            let are_places = nodes.iter().all(|v| v.kind.is_real() && v.after_time().len() + nodes.len() == 3);
            (has_threes && are_places).then_some(Triangles { source, table, nodes, middles: *middles })
        })
    })
}

pub(super) fn read(Triangles { source, table, nodes, middles }: Triangles) -> Result<Mesh> {
    let places = |[lon, lat]: [&str; 2]| -> Result<Positions> {
        positions(source, lon, lat, &source.expect(lon)?.after_time()[0].name)
    };
    let positions = match nodes[..] {
        [both] => positions_of_pairs(source, both)?,
        _ => places([&nodes[0].name, &nodes[1].name])?,
    };
    let middles = middles.iter().all(|name| source.variable(name).is_some()).then(|| places(middles)).transpose()?;
    let numbers = source.all_integers(table)?;
    let (count, last) = (numbers.len() / 3, positions.lon.as_reals().len());
    let is_by_place = table.after_time()[0].len == 3;
    let entry = |i: usize| if is_by_place { numbers[i % 3 * count + i / 3] } else { numbers[i] };
    let rows: Vec<i32> = (0..3 * count).map(|i| entry(i).saturating_sub(1)).collect();
    if let Some(i) = rows.iter().position(|node| !(0..last as i64).contains(&i64::from(*node))) {
        let context = format!("{}: node {} of element {}, expected 1 to {last}", table.name, entry(i), i / 3);
        return Err(source.error(ErrorKind::Grid, context));
    }
    of_faces(source.path(), positions, middles, (rows, 3), false).map_err(|e| e.within(source.path().display()))
}
