//! The checks on which the walk's guarantees rest: every index in range, tables that agree with each other, and a
//! triangulation that covers the sphere exactly once, together with the triangles of `hole_filling.rs` if the mesh has
//! holes.
//!
//! The tables must mark holes: a side ends the mesh only if they mark a cell or a corner beyond as missing.
//!
//! All passes are parallel over rows; the first bad row in table order is reported, so the message does not depend on
//! the number of threads.

use super::half_edges::{HalfEdges, half_edge, place};
use super::table_names::{entry, item, named, named_entry, named_row, row as row_of, rows};
use super::tables::{GridTables, Indices, LonLat};
use crate::array::MapInline;
use crate::error::{Error, ErrorKind, Result};
use crate::memory;
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::atomic::{AtomicUsize, Ordering};

/// A triangle is degenerate if twice its area is below this fraction of its longest side squared.
const SLIVER: f64 = 1e-9;
/// Rows that a thread checks at a time.
const BLOCK: usize = 4096;
/// The spherical areas must sum to 4π within this relative error. Without folds the sum is a whole multiple of 4π.
const COVER: f64 = 1e-6;

fn expect_len(table: &str, len: usize, rows: usize, row: usize) -> Result<()> {
    // Wider than any table's length, so that no length of a row wraps round to the right one.
    let expected = rows as u128 * row as u128;
    if len as u128 == expected {
        return Ok(());
    }
    Err(Error::grid(format!("{}: {len} entries, expected {expected} ({rows} rows of {row})", named(table))))
}

/// Whether a closed sphere has these numbers of cells V, corners F and edges E: V - E + F = 2, and each of the 3 sides
/// of a triangle is an edge between two.
pub(super) fn is_sphere([cells, corners, edges]: [usize; 3]) -> bool {
    cells + corners == edges + 2 && 2 * edges == 3 * corners
}

/// Refuses exchanged numbers of cells, corners and edges, before reading a table that may be shorter than they state.
///
/// The numbers are exchanged if exchanging two of them gives those of a closed sphere. For exchanged cells and corners,
/// 2E = 3V and V - E + F = 2 give E = 3F - 6: of all triangles only 6 pairs share a side, and no model makes such a
/// mesh of 100 cells. This does not apply to a mesh with holes; there [`edge_ends`] finds the corners that do not
/// exist.
fn refuse_swapped(given: [usize; 3]) -> Result<()> {
    const PAIRS: [(usize, usize, &str); 3] =
        [(0, 1, "cells and corners"), (0, 2, "cells and edges"), (1, 2, "corners and edges")];
    let is_exchanged = |(a, b, _): &(usize, usize, &str)| {
        let mut other = given;
        other.swap(*a, *b);
        is_sphere(other)
    };
    let [cells, corners, edges] = given;
    match PAIRS.into_iter().find(is_exchanged).filter(|_| !is_sphere(given) && cells + corners >= 100) {
        Some((.., names)) => Err(Error::grid(format!(
            "{cells} cells, {corners} corners and {edges} edges: {names} look swapped, expected 2 corners for 3 edges, \
             and as many cells and corners as edges and 2"
        ))),
        None => Ok(()),
    }
}

/// Both ends of each edge are corners that exist or missing ones. This table is read first: it is as long as `edges`
/// states, and names corners that do not exist if cells and corners are exchanged.
pub(super) fn edge_ends(t: &GridTables) -> Result<()> {
    let base = i64::from(t.index_base);
    let [cells, corners] = [t.cells(), t.corners()].map(|count| base..base + count as i64);
    first_error(t.edge_corner.len(), |i| {
        let corner = t.edge_corner.get(i);
        (!corners.contains(&corner) && !is_mark(corner, t.corners(), t.index_base)).then(|| {
            Error::grid(format!(
                "{}: {corner}, expected {} to {}{}",
                named_entry(t, "edge_corner", i / 2, i % 2),
                corners.start,
                corners.end - 1,
                if cells.contains(&corner) { "; the numbers of cells and corners look swapped" } else { "" }
            ))
        })
    })
}

/// Every table has the length that follows from the numbers of cells, corners and edges. No table is read.
pub(super) fn sizes(t: &GridTables) -> Result<()> {
    let (cells, corners, edges) = (t.cells(), t.corners(), t.edges());
    refuse_swapped([cells, corners, edges])?;
    if !(0..=1).contains(&t.index_base) {
        return Err(Error::new(ErrorKind::Argument, format!("index_base: {}, expected 0 or 1", t.index_base)));
    }
    expect_len("center latitude", t.center.lat_rad.len(), cells, 1)?;
    expect_len("corner latitude", t.corner.lat_rad.len(), corners, 1)?;
    if t.cell_corner_row < 3 {
        let table = named("cell_corner");
        return Err(Error::grid(format!("{table}: row length {}, expected at least 3", t.cell_corner_row)));
    }
    expect_len("cell_corner", t.cell_corner.len(), cells, t.cell_corner_row)?;
    if let Some(count) = t.cell_corner_count {
        expect_len("cell_corner_count", count.len(), cells, 1)?;
    }
    expect_len("corner_cell", t.corner_cell.len(), corners, 3)?;
    expect_len("corner_edge", t.corner_edge.len(), corners, 3)?;
    expect_len("edge_corner", t.edge_corner.len(), edges, 2)?;
    if i32::try_from(edges + 1).is_err() {
        return Err(Error::grid(format!("{}: {edges} edges, expected fewer than 2^31", named("edge_corner"))));
    }
    Ok(())
}

/// Whether something is missing; otherwise V - E + F = 2.
pub(super) fn has_hole(t: &GridTables) -> Result<bool> {
    let (cells, corners, edges) = (t.cells(), t.corners(), t.edges());
    let misses = |table: Indices, limit: usize| {
        let all = (0..table.len()).into_par_iter().with_min_len(1 << 16);
        all.any(|i| is_mark(table.get(i), limit, t.index_base))
    };
    // Without corners there is no table that could miss one.
    let has_hole = corners == 0 || misses(t.corner_cell, cells) || misses(t.edge_corner, corners);
    // Rows of halos and padding in a model's arrays are cells without corners, and not part of the sphere.
    let of_sphere = || (0..cells).into_par_iter().with_min_len(BLOCK).filter(|&r| !is_lone(t, r)).count();
    if !has_hole && cells + corners != edges + 2 && of_sphere() + corners != edges + 2 {
        return Err(Error::grid(format!(
            "{cells} cells - {edges} edges + {corners} corners = {}, expected 2 (a closed sphere: no cell and no corner is \
             marked as missing)",
            cells as i64 - edges as i64 + corners as i64
        )));
    }
    Ok(has_hole)
}

/// The marks of models for a missing neighbour: 0 in 1-based tables, -1, or one past the last row.
fn is_mark(number: i64, rows: usize, index_base: i32) -> bool {
    let base = i64::from(index_base);
    number == base - 1 || number == -1 || number == rows as i64 + base
}

/// Whether all corners of row `r` of `cell_corner` are missing.
fn is_lone(t: &GridTables, r: usize) -> bool {
    let start = r * t.cell_corner_row;
    (start..start + t.cell_corner_row).all(|i| is_mark(t.cell_corner.get(i), t.corners(), t.index_base))
}

/// Whether all cells of row `r` of `corner_cell` exist, in a mesh that may have holes.
fn is_triangle(t: &GridTables, r: usize) -> bool {
    t.corner_cell.row::<3>(r).into_iter().all(|cell| !is_mark(cell, t.cells(), t.index_base))
}

fn first_error<E: Send>(rows: usize, check: impl Fn(usize) -> Option<E> + Sync + Send) -> std::result::Result<(), E> {
    let blocks = (0..rows.div_ceil(BLOCK)).into_par_iter();
    // A loop for each block: an iterator that checks at each row whether to continue takes twice the time.
    let in_block = |block: usize| (block * BLOCK..rows.min((block + 1) * BLOCK)).find_map(&check);
    match blocks.find_map_first(in_block) {
        Some(error) => Err(error),
        None => Ok(()),
    }
}

fn position_error(t: &GridTables, table: &str, at: &LonLat, i: usize) -> Option<Error> {
    let (lon, lat) = (at.lon_rad.get(i), at.lat_rad.get(i));
    // A little slack: π/2 and 2π rounded to f32 exceed the real ones.
    let fine = lon.abs() <= TAU + 1e-6 && lat.abs() <= FRAC_PI_2 + 1e-6;
    (!fine).then(|| {
        let is_degrees = lon.abs() <= 360.0 && lat.abs() <= 90.0;
        Error::grid(format!(
            "{}: longitude {lon}, latitude {lat}, expected radians in [-2π, 2π] and [-π/2, π/2]{}",
            item(t, table, i),
            if is_degrees { "; these look like degrees" } else { "" }
        ))
    })
}

/// Checks the coordinates of cells and corners and returns the cells' unit vectors.
pub(super) fn directions(t: &GridTables) -> Result<Vec<[f64; 3]>> {
    first_error(t.cells(), |i| position_error(t, "center", &t.center, i))?;
    first_error(t.corners(), |i| position_error(t, "corner", &t.corner, i))?;
    let mut directions = memory::room_for("directions of the cells", t.cells())?;
    let rows = (0..t.cells()).into_par_iter().with_min_len(4096);
    let at = |i: usize| unit_vector(t.center.lon_rad.get(i), t.center.lat_rad.get(i)).to_array();
    rows.map(at).collect_into_vec(&mut directions);
    Ok(directions)
}

/// Unit vector at a longitude and latitude in radians.
pub fn unit_vector(lon_rad: f64, lat_rad: f64) -> DVec3 {
    let ((sin_lon, cos_lon), (sin_lat, cos_lat)) = (lon_rad.sin_cos(), lat_rad.sin_cos());
    DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat).normalize()
}

/// Every index names an existing row, or a missing one if the mesh may have holes.
pub(super) fn indices(t: &GridTables, has_hole: bool) -> Result<()> {
    let base = i64::from(t.index_base);
    let check = |name: &str,
                 table: Indices,
                 row: usize,
                 limit: usize,
                 used: &(dyn Fn(usize) -> usize + Sync + Send),
                 may_miss: &(dyn Fn(usize) -> bool + Sync + Send)| {
        // In i64 no number of either width wraps round into the range.
        let range = base..base + limit as i64;
        first_error(table.len() / row, |r| {
            let is_wrong = |column: &usize| {
                let number = table.get(r * row + column);
                !(range.contains(&number) || is_mark(number, limit, t.index_base) && may_miss(r))
            };
            let column = (0..used(r)).find(is_wrong)?;
            Some(Error::grid(format!(
                "{}: {}, expected {} to {}",
                named_entry(t, name, r, column),
                table.get(r * row + column),
                base,
                range.end - 1
            )))
        })
    };
    if let Some(count) = t.cell_corner_count {
        let range = 3..=t.cell_corner_row as i64;
        first_error(count.len(), |r| {
            (!range.contains(&count.get(r))).then(|| {
                Error::grid(format!(
                    "{}: {}, expected 3 to {}",
                    item(t, "cell_corner_count", r),
                    count.get(r),
                    t.cell_corner_row
                ))
            })
        })?;
    }
    let used = |r: usize| t.cell_corner_count.map_or(t.cell_corner_row, |count| count.get(r) as usize);
    check("cell_corner", t.cell_corner, t.cell_corner_row, t.corners(), &used, &|r| has_hole || is_lone(t, r))?;
    check("corner_cell", t.corner_cell, 3, t.cells(), &|_| 3, &|_| has_hole)?;
    // A triangle has all its sides, whether or not triangles lie beyond them.
    check("corner_edge", t.corner_edge, 3, t.edges(), &|_| 3, &|r| has_hole && !is_triangle(t, r))
}

/// The hint for refused tables whose numbers begin at the other `index_base`: the tables of cells and corners contain
/// the first number there, but not the last one here.
pub(super) fn other_base(t: &GridTables) -> Option<String> {
    let looks_other = |table: Indices, rows: usize| {
        let [first, last] = [0, rows as i64].map(|number| table.iter().any(|known| known == number));
        if t.index_base == 0 { last && !first } else { first && !last }
    };
    let other = 1 - t.index_base;
    (looks_other(t.corner_cell, t.cells()) && looks_other(t.edge_corner, t.corners()))
        .then(|| format!("; numbers begin at {other}: set index_base = {other}"))
}

/// Row `r` of a checked table with `N` columns, numbered from 0.
#[inline(always)]
fn row<const N: usize>(t: &GridTables, table: Indices, r: usize) -> [usize; N] {
    let (numbers, base) = (table.row::<N>(r), i64::from(t.index_base));
    let mut row = [0; N];
    for k in 0..N {
        row[k] = (numbers[k] - base) as usize;
    }
    row
}

/// The half-edges of each triangle, whose cells, edges and the triangles beyond them agree. Not known is whether these
/// wind as it does ([`folds`]).
pub(super) fn triangles(t: &GridTables, direction: &[[f64; 3]], has_hole: bool) -> Result<Vec<HalfEdges>> {
    let (rows, most) = (t.corners(), HalfEdges::MAX_TRIANGLES);
    if rows > most {
        let parts = "divide the mesh with icoray_part_set";
        return Err(Error::grid(format!("corner: {rows} rows, expected at most {most} in a process; {parts}")));
    }
    let mut found = memory::room_for("half-edges of the grid", rows)?;
    let first_bad = AtomicUsize::new(usize::MAX);
    let or_marked = |r: usize| {
        half_edges_of(t, direction, has_hole, r).unwrap_or_else(|_| {
            first_bad.fetch_min(r, Ordering::Relaxed);
            HalfEdges::default()
        })
    };
    (0..rows).into_par_iter().with_min_len(BLOCK).map(or_marked).collect_into_vec(&mut found);
    // The message is made once, for the first bad row.
    match first_bad.into_inner() {
        usize::MAX => Ok(found),
        r => Err(half_edges_of(t, direction, has_hole, r).expect_err("the same row was bad a moment ago")),
    }
}

fn half_edges_of(t: &GridTables, direction: &[[f64; 3]], has_hole: bool, r: usize) -> Result<HalfEdges> {
    if has_hole && !is_triangle(t, r) {
        return Ok(HalfEdges::default());
    }
    let number = |i: usize| i as i64 + i64::from(t.index_base);
    let cells: [usize; 3] = row(t, t.corner_cell, r);
    if cells[0] == cells[1] || cells[1] == cells[2] || cells[2] == cells[0] {
        return Err(Error::grid(format!(
            "{}: {:?}, expected three different cells",
            named_row(t, "corner_cell", r),
            cells.map(number)
        )));
    }
    // The triangle beyond the side opposite each cell; `Some(None)` at the rim.
    let mut sides = [None; 3];
    for (column, edge) in row::<3>(t, t.corner_edge, r).into_iter().enumerate() {
        let ends: [i64; 2] = t.edge_corner.row(edge);
        if ends[0] == ends[1] || !ends.contains(&number(r)) {
            return Err(Error::grid(format!(
                "{}: {ends:?}, expected two corners, one of them {} ({} names this edge)",
                named_row(t, "edge_corner", edge),
                number(r),
                entry(t, "corner_edge", r, column)
            )));
        }
        let other = if ends[0] == number(r) { ends[1] } else { ends[0] };
        if has_hole && is_mark(other, t.corners(), t.index_base) {
            // A side of the rim. Which one follows from the others.
            continue;
        }
        let other = (other - i64::from(t.index_base)) as usize;
        let beyond: [i64; 3] = t.corner_cell.row(other);
        let is_apart = cells.map_inline(|cell| !beyond.contains(&number(cell)));
        let Some(k) = only(is_apart) else {
            return Err(Error::grid(format!(
                "{}: {:?} and {beyond:?}, {} cells in common, expected 2 (edge {} joins these corners)",
                rows(t, "corner_cell", r, other),
                cells.map(number),
                is_apart.iter().filter(|is_apart| !**is_apart).count(),
                number(edge)
            )));
        };
        let is_joined = !has_hole || is_triangle(t, other);
        if is_joined && !t.corner_edge.row::<3>(other).contains(&number(edge)) {
            return Err(Error::grid(format!(
                "{}: {:?}, expected edge {} too, which leads there from corner {}",
                named_row(t, "corner_edge", other),
                t.corner_edge.row::<3>(other),
                number(edge),
                number(r)
            )));
        }
        if sides[k].replace(is_joined.then_some(other)).is_some() {
            return Err(Error::grid(format!(
                "{}: this edge and one before it lie opposite cell {}, expected one side per cell",
                named_entry(t, "corner_edge", r, column),
                number(cells[k])
            )));
        }
    }
    let [a, b, c] = cells.map_inline(|cell| DVec3::from_array(direction[cell]));
    let det = a.dot((b - a).cross(c - a));
    let longest = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
    if det.abs() <= SLIVER * longest {
        return Err(Error::grid(format!(
            "{}: the centres of cells {:?} span no area",
            named_row(t, "corner_cell", r),
            cells.map(number)
        )));
    }
    // Columns of the row in counter-clockwise order.
    const COLUMNS: [[usize; 3]; 2] = [[0, 1, 2], [0, 2, 1]];
    let order = COLUMNS[usize::from(det < 0.0)];
    let wound = order.map_inline(|column| cells[column]);
    let beyond = [0, 1, 2].map_inline(|k: usize| {
        let Some(other) = sides[order[k]].flatten() else { return HalfEdges::RIM };
        let theirs: [i64; 3] = t.corner_cell.row(other);
        // The other triangle passes the side in the opposite direction, if it winds alike.
        let [from, to] = [number(wound[(k + 2) % 3]), number(wound[(k + 1) % 3])];
        let begins = (0..3).find(|&i| theirs[i] == from).unwrap_or(0);
        let is_clockwise = theirs[(begins + 1) % 3] != to;
        half_edge(other as u32, COLUMNS[usize::from(is_clockwise)][begins])
    });
    Ok(HalfEdges::new(wound.map_inline(|cell| cell as u32), beyond))
}

/// The index of the only `true`, if there is exactly one.
#[inline(always)]
fn only(marks: [bool; 3]) -> Option<usize> {
    match marks {
        [true, false, false] => Some(0),
        [false, true, false] => Some(1),
        [false, false, true] => Some(2),
        _ => None,
    }
}

/// The corners of each cell are those whose row of `corner_cell` names the cell, each once.
pub(super) fn cells(t: &GridTables) -> Result<()> {
    let number = |i: usize| i as i64 + i64::from(t.index_base);
    let mut around = vec![0u32; t.cells()];
    for cell in t.corner_cell.iter().filter(|&cell| !is_mark(cell, t.cells(), t.index_base)) {
        around[(cell - i64::from(t.index_base)) as usize] += 1;
    }
    first_error(t.cells(), |r| {
        let start = r * t.cell_corner_row;
        let used = t.cell_corner_count.map_or(t.cell_corner_row, |count| count.get(r) as usize);
        let corner = |column: usize| t.cell_corner.get(start + column);
        let is_there = |column: &usize| !is_mark(corner(*column), t.corners(), t.index_base);
        let cells_at = |column: usize| t.corner_cell.row::<3>((corner(column) - i64::from(t.index_base)) as usize);
        let is_apart = |column: &usize| is_there(column) && !cells_at(*column).contains(&number(r));
        if let Some(column) = (0..used).find(is_apart) {
            return Some(Error::grid(format!(
                "{}: corner {}, where {} is {:?}, expected one that names cell {}",
                named_entry(t, "cell_corner", r, column),
                corner(column),
                row_of(t, "corner_cell", (corner(column) - i64::from(t.index_base)) as usize),
                cells_at(column),
                number(r)
            )));
        }
        let is_new = |&i: &usize| is_there(&i) && (0..i).all(|j| corner(j) != corner(i));
        let distinct = (0..used).filter(is_new).count();
        (distinct != around[r] as usize).then(|| {
            Error::grid(format!(
                "{}: {distinct} different corners, expected the {} whose corner_cell rows name the cell",
                named_row(t, "cell_corner", r),
                around[r]
            ))
        })
    })
}

/// The triangles on both sides of every edge that joins two turn the same way.
pub(super) fn folds(t: &GridTables, half_edges: &[HalfEdges]) -> Result<()> {
    let number = |i: usize| i as i64 + i64::from(t.index_base);
    first_error(t.corners(), |r| {
        let (here, v) = (&half_edges[r], half_edges[r].vertices());
        (0..3).filter(|&k| here.is_triangle() && !here.is_rim(k)).find_map(|k| {
            let (other, begins) = place(here.beyond(k));
            let w = half_edges[other as usize].vertices();
            ([w[begins], w[(begins + 1) % 3]] != [v[(k + 2) % 3], v[(k + 1) % 3]]).then(|| {
                let joins =
                    |edge: &i64| t.edge_corner.row::<2>((edge - number(0)) as usize).contains(&number(other as usize));
                let edge = t.corner_edge.row::<3>(r).into_iter().find(joins).unwrap_or_default();
                Error::grid(format!(
                    "{}: the triangles lie on the same side of edge {edge}, expected a surface without folds",
                    rows(t, "corner_cell", r, other as usize)
                ))
            })
        })
    })
}

/// The triangles, with void ones behind the rows of the table, cover the sphere exactly once.
pub(super) fn covers(direction: &[[f64; 3]], half_edges: &[HalfEdges], has_void: bool) -> Result<()> {
    let area = |sides: &HalfEdges| match sides.is_triangle() {
        true => solid_angle(sides.vertices().map_inline(|cell| DVec3::from_array(direction[cell as usize]))),
        false => 0.0,
    };
    // Fixed blocks summed in order: the same sum for any number of threads.
    let areas: Vec<f64> = half_edges.par_iter().fold_chunks(BLOCK, || 0.0, |sum, sides| sum + area(sides)).collect();
    let area: f64 = areas.into_iter().sum();
    if (area / (4.0 * PI) - 1.0).abs() > COVER {
        return Err(Error::grid(format!(
            "corner_cell: the triangles' areas sum to {:.9} of the sphere{}, expected 1",
            area / (4.0 * PI),
            if has_void { " with those that fill the holes" } else { "" }
        )));
    }
    Ok(())
}

/// Solid angle of a triangle of unit vectors (Van Oosterom and Strackee 1983, doi:10.1109/TBME.1983.325207).
fn solid_angle([a, b, c]: [DVec3; 3]) -> f64 {
    let det = a.dot((b - a).cross(c - a));
    2.0 * det.atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
}

#[cfg(test)]
mod tests;
