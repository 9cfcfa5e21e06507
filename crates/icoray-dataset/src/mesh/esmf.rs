//! ESMF's unstructured meshes: the nodes of each element, in a table or behind each other.
//! Format: ESMF reference manual, "ESMF unstructured grid file format", <https://earthsystemmodeling.org/docs>.

use super::angles::positions_of_pairs;
use super::columns::number_of_fields;
use super::polygons::NONE;
use super::tables::{Mesh, missing};
use super::ugrid::{Rows, of_rows};
use crate::source::{Source, Variable};
use crate::sources::Sources;
use icoray::{ErrorKind, Result};

/// Nodes of each element, from 1 unless `start_index` is 0.
const TABLE: &str = "elementConn";
/// Number of nodes of each element.
const COUNTS: &str = "numElementConn";
/// Coordinates of each node.
const NODES: &str = "nodeCoords";
/// Maximum number of nodes of an element: the counts are bytes in ESMF's files.
const MAX_NODES: usize = i8::MAX as usize;

/// The first file that has such a mesh, if there are fields of as many columns as elements or nodes: the rows and
/// columns of a lat-lon grid become columns later.
pub(super) fn find(sources: &Sources) -> Option<&dyn Source> {
    let has_fields = |variable: &Variable| {
        let longest = variable.after_time().iter().max_by_key(|dimension| dimension.len);
        longest.is_some_and(|places| number_of_fields(sources, places) > 0)
    };
    sources.others_first().find(|source| {
        let mut places = [COUNTS, NODES].into_iter().filter_map(|name| source.variable(name));
        [TABLE, COUNTS].iter().all(|name| source.variable(name).is_some()) && places.any(has_fields)
    })
}

pub(super) fn read(sources: &Sources, source: &dyn Source) -> Result<Mesh> {
    let pairs = |name: &str| source.find(name).map(positions_of_pairs).transpose();
    let expected = |name: &str| source.find(name).ok_or_else(|| missing(source, name));
    let nodes = pairs(NODES)?.ok_or_else(|| missing(source, NODES))?;
    let table = expected(TABLE)?;
    let counts = expected(COUNTS)?.all_integers()?;
    let numbers = table.all_integers()?;
    let stride = table.variable.after_time().get(1).map(|nodes| nodes.len);
    let last = nodes.lon.as_reals().len();
    let base = table.numbers("start_index")?.first().map_or(1, |base| *base as i32);
    let row = counts.iter().copied().max().unwrap_or(0).clamp(3, MAX_NODES as i32) as usize;
    let (mut rows, mut next) = (Vec::with_capacity(row * counts.len()), 0);
    for (element, count) in counts.iter().map(|count| (*count).max(0) as usize).enumerate() {
        let start = stride.map_or(next, |stride| element * stride);
        let max = stride.map_or(MAX_NODES, |stride| stride.min(MAX_NODES));
        let entries = numbers.get(start..start + count).filter(|_| count <= max);
        let entries = entries.ok_or_else(|| {
            let context = format!(
                "{TABLE}: element {element} has {count} nodes by {COUNTS}, expected at most {max} of those there"
            );
            table.error(ErrorKind::Grid, context)
        })?;
        let is_there = |node: &&i32| (0..last as i64).contains(&(i64::from(**node) - i64::from(base)));
        if let Some(node) = entries.iter().find(|node| !is_there(node)) {
            let ends = [i64::from(base), last as i64 + i64::from(base) - 1];
            let context = format!("{TABLE}: node {node} of element {element}, expected {} to {}", ends[0], ends[1]);
            return Err(table.error(ErrorKind::Grid, context));
        }
        rows.extend(entries.iter().map(|node| node - base).chain(std::iter::repeat_n(NONE, row - count)));
        next += count;
    }
    of_rows(sources, table, nodes, pairs("centerCoords")?, Rows { nodes: rows, len: row })
}
