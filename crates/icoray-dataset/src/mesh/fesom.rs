//! The mesh of FESOM2 in `fesom.mesh.diag.nc` without UGRID's variables: nodes, and elements of three of them.

use super::angles::{direction, into_radians};
use super::tables::Mesh;
use crate::source::{Source, Variable};
use crate::sources::Sources;
use icoray::{ErrorKind, OwnedReals, Result};

/// Nodes of each element, from 1: by element, or by position in it.
const ELEMENTS: &str = "elements";
/// Longitudes, then latitudes of all nodes.
const NODES: &str = "nodes";

/// The first file that has both tables, and the tables.
fn find(sources: &Sources) -> Option<(&dyn Source, [&Variable; 2])> {
    sources.others_first().find_map(|source| {
        let [elements, nodes] = [ELEMENTS, NODES].map(|name| source.variable(name));
        let (elements, nodes) = (elements?, nodes?);
        let has_threes = matches!(elements.after_time(), [a, b] if a.len == 3 || b.len == 3);
        let has_pairs = matches!(nodes.after_time(), [two, _] if two.len == 2);
        (has_threes && has_pairs && nodes.kind.is_real()).then_some((source, [elements, nodes]))
    })
}

/// Whether any of the files has such a mesh.
pub(super) fn is_in(sources: &Sources) -> bool {
    find(sources).is_some()
}

pub(super) fn read(sources: &Sources) -> Result<Mesh> {
    let (source, [elements, nodes]) = find(sources).expect("one has a mesh, or this is not called");
    let mut lon = source.all_numbers(nodes)?;
    let lat = lon.split_off(lon.len() / 2);
    let mut angles = [lon, lat].map(OwnedReals::F64);
    into_radians(source, [NODES, NODES], &mut angles)?;
    let [lon, lat] = angles;
    let node = |i| direction(lon.as_reals().get(i), lat.as_reals().get(i));
    let nodes: Vec<[f64; 3]> = (0..lon.as_reals().len()).map(node).collect();
    let table = source.all_integers(elements)?;
    let count = table.len() / 3;
    let is_by_place = elements.after_time()[0].len == 3;
    let entry = |i: usize| if is_by_place { table[i % 3 * count + i / 3] } else { table[i] };
    let rows: Vec<i32> = (0..3 * count).map(|i| entry(i).saturating_sub(1)).collect();
    if let Some(i) = rows.iter().position(|node| !(0..nodes.len() as i64).contains(&i64::from(*node))) {
        let context = format!("{ELEMENTS}: node {} of element {}, expected 1 to {}", entry(i), i / 3, nodes.len());
        return Err(source.error(ErrorKind::Grid, context));
    }
    Mesh::of_faces(source.path(), &nodes, None, rows, 3).map_err(|e| e.within(source.path().display()))
}
