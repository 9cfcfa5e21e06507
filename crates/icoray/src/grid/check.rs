//! The checks that make the walk's promises hold: every index in range, tables that agree with each other, and a
//! triangulation that covers the sphere exactly once.
//!
//! All passes are parallel over rows; the first bad row in table order is reported, so the message does not depend on
//! the number of threads.

use super::seats::Seats;
use super::tables::{GridTables, Indices, LonLat};
use crate::error::{Error, ErrorKind, Result};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// A triangle is degenerate when twice its area is below this part of its longest side squared.
const SLIVER: f64 = 1e-9;
/// The spherical areas must sum to 4π within this relative error. Without folds the sum is a whole multiple of 4π.
const COVER: f64 = 1e-6;

fn bad(context: String) -> Error {
    Error::new(ErrorKind::Grid, context)
}

fn expect_len(table: &str, len: usize, rows: usize, row: usize) -> Result<()> {
    // Wider than any table's length, so that no length of a row wraps round to the right one.
    let expected = rows as u128 * row as u128;
    if len as u128 == expected {
        return Ok(());
    }
    Err(bad(format!("{table}: {len} entries, expected {expected} ({rows} rows of {row})")))
}

/// Every table has the length that the numbers of cells, corners and edges ask for, and V - E + F = 2.
pub(super) fn sizes(t: &GridTables) -> Result<()> {
    let (cells, corners, edges) = (t.cells(), t.corners(), t.edges());
    if !(0..=1).contains(&t.index_base) {
        return Err(Error::new(
            ErrorKind::Argument,
            format!("index_base: {}, expected 0 or 1", t.index_base),
        ));
    }
    expect_len("center latitude", t.center.lat_rad.len(), cells, 1)?;
    expect_len("corner latitude", t.corner.lat_rad.len(), corners, 1)?;
    if t.cell_corner_row < 3 {
        return Err(bad(format!("cell_corner: row length {}, expected at least 3", t.cell_corner_row)));
    }
    expect_len("cell_corner", t.cell_corner.len(), cells, t.cell_corner_row)?;
    if let Some(count) = t.cell_corner_count {
        expect_len("cell_corner_count", count.len(), cells, 1)?;
    }
    expect_len("corner_cell", t.corner_cell.len(), corners, 3)?;
    expect_len("corner_edge", t.corner_edge.len(), corners, 3)?;
    expect_len("edge_corner", t.edge_corner.len(), edges, 2)?;
    if cells < 4 || i32::try_from(edges + 1).is_err() {
        return Err(bad(format!(
            "center: {cells} cells with {edges} edges, expected at least 4 cells and fewer than 2^31 edges"
        )));
    }
    let has_hole = |r: &usize| t.corner_cell.row::<3>(*r).into_iter().any(|c| is_hole(c, t, cells));
    if let Some(row) = (0..corners).find(has_hole) {
        return Err(Error::new(
            ErrorKind::Unsupported,
            format!(
                "corner_cell row {}: {:?} names a cell that is not there: the mesh has a hole \
                 (culled land, a limited area or a rank's part); only whole spheres are rendered yet",
                row as i64 + i64::from(t.index_base),
                t.corner_cell.row::<3>(row)
            ),
        ));
    }
    if cells + corners != edges + 2 {
        return Err(bad(format!(
            "{cells} cells - {edges} edges + {corners} corners = {}, expected 2 (a closed sphere)",
            cells as i64 - edges as i64 + corners as i64
        )));
    }
    Ok(())
}

/// The marks that models put where a neighbour is missing: 0 in 1-based tables, -1, or one past the last cell.
fn is_hole(cell: i64, t: &GridTables, cells: usize) -> bool {
    let base = i64::from(t.index_base);
    cell == base - 1 || cell == -1 || cell == cells as i64 + base
}

fn first_error<E: Send>(
    rows: usize,
    check: impl Fn(usize) -> Option<E> + Sync + Send,
) -> std::result::Result<(), E> {
    match (0..rows).into_par_iter().with_min_len(4096).find_map_first(check) {
        Some(error) => Err(error),
        None => Ok(()),
    }
}

fn position_error(table: &str, at: &LonLat, i: usize, base: i32) -> Option<Error> {
    let (lon, lat) = (at.lon_rad.get(i), at.lat_rad.get(i));
    // A little slack: π/2 and 2π rounded to f32 lie above the real ones.
    let fine = lon.abs() <= TAU + 1e-6 && lat.abs() <= FRAC_PI_2 + 1e-6;
    (!fine).then(|| {
        bad(format!(
            "{table} row {}: longitude {lon}, latitude {lat}, expected radians in [-2π, 2π] and [-π/2, π/2]",
            i as i64 + i64::from(base)
        ))
    })
}

/// Checks the cell centres and gives their unit vectors.
pub(super) fn directions(t: &GridTables) -> Result<Vec<[f64; 3]>> {
    first_error(t.cells(), |i| position_error("center", &t.center, i, t.index_base))?;
    let rows = (0..t.cells()).into_par_iter().with_min_len(4096);
    Ok(rows.map(|i| unit_vector(t.center.lon_rad.get(i), t.center.lat_rad.get(i)).to_array()).collect())
}

/// Unit vector at a longitude and latitude in radians.
pub(crate) fn unit_vector(lon_rad: f64, lat_rad: f64) -> DVec3 {
    let ((sin_lon, cos_lon), (sin_lat, cos_lat)) = (lon_rad.sin_cos(), lat_rad.sin_cos());
    DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat).normalize()
}

/// Checks the corners' coordinates.
pub(super) fn corner_positions(t: &GridTables) -> Result<()> {
    first_error(t.corners(), |i| position_error("corner", &t.corner, i, t.index_base))
}

/// Every index names a row that exists.
pub(super) fn indices(t: &GridTables) -> Result<()> {
    let base = i64::from(t.index_base);
    let check = |name: &str,
                 table: Indices,
                 row: usize,
                 limit: usize,
                 used: &(dyn Fn(usize) -> usize + Sync + Send)| {
        // In i64 no number of either width wraps round into the range.
        let range = base..base + limit as i64;
        first_error(table.len() / row, |r| {
            let column = (0..used(r)).find(|column| !range.contains(&table.get(r * row + column)))?;
            Some(bad(format!(
                "{name} row {}, column {column}: {}, expected {} to {}",
                r as i64 + base,
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
                bad(format!(
                    "cell_corner_count row {}: {}, expected 3 to {}",
                    r as i64 + base,
                    count.get(r),
                    t.cell_corner_row
                ))
            })
        })?;
    }
    let used = |r: usize| t.cell_corner_count.map_or(t.cell_corner_row, |count| count.get(r) as usize);
    check("cell_corner", t.cell_corner, t.cell_corner_row, t.corners(), &used)?;
    check("corner_cell", t.corner_cell, 3, t.cells(), &|_| 3)?;
    check("corner_edge", t.corner_edge, 3, t.edges(), &|_| 3)?;
    check("edge_corner", t.edge_corner, 2, t.corners(), &|_| 2)
}

/// Row `r` of a checked table with `N` columns, numbered from 0.
#[inline]
fn row<const N: usize>(t: &GridTables, table: Indices, r: usize) -> [usize; N] {
    table.row(r).map(|number| (number - i64::from(t.index_base)) as usize)
}

/// Finds each triangle's seats, and that its cells, its edges and the triangles beyond them agree.
pub(super) fn triangles(t: &GridTables, direction: &[[f64; 3]]) -> Result<Vec<Seats>> {
    let rows = (0..t.corners()).into_par_iter().with_min_len(4096);
    let seats: Vec<std::result::Result<Seats, ()>> =
        rows.map(|r| seats_of(t, direction, r).map_err(|_| ())).collect();
    // The message is made once, for the first bad row.
    if let Some(r) = seats.iter().position(std::result::Result::is_err) {
        return Err(seats_of(t, direction, r).expect_err("the same row was bad a moment ago"));
    }
    Ok(seats.into_iter().flatten().collect())
}

fn seats_of(t: &GridTables, direction: &[[f64; 3]], r: usize) -> Result<Seats> {
    let number = |i: usize| i as i64 + i64::from(t.index_base);
    let cells: [usize; 3] = row(t, t.corner_cell, r);
    if cells[0] == cells[1] || cells[1] == cells[2] || cells[2] == cells[0] {
        return Err(bad(format!(
            "corner_cell row {}: {:?}, expected three different cells",
            number(r),
            cells.map(number)
        )));
    }
    let mut opposite = [None; 3];
    for (column, edge) in row::<3>(t, t.corner_edge, r).into_iter().enumerate() {
        let [a, b] = row(t, t.edge_corner, edge);
        if a == b || (a != r && b != r) {
            return Err(bad(format!(
                "edge_corner row {}: [{}, {}], expected two corners, one of them {} (corner_edge row {}, column {column} names this edge)",
                number(edge),
                number(a),
                number(b),
                number(r),
                number(r)
            )));
        }
        let other = if a == r { b } else { a };
        let beyond: [usize; 3] = row(t, t.corner_cell, other);
        let apart: Vec<usize> = (0..3).filter(|&k| !beyond.contains(&cells[k])).collect();
        let &[k] = apart.as_slice() else {
            return Err(bad(format!(
                "corner_cell rows {} and {}: {} cells in common, expected 2 (edge {} joins these corners)",
                number(r),
                number(other),
                3 - apart.len(),
                number(edge)
            )));
        };
        if let Some(taken) = opposite[k].replace(column) {
            return Err(bad(format!(
                "corner_edge row {}: columns {taken} and {column} both lie opposite cell {}, expected one side per cell",
                number(r),
                number(cells[k])
            )));
        }
    }
    let [a, b, c] = cells.map(|cell| DVec3::from_array(direction[cell]));
    let det = a.dot((b - a).cross(c - a));
    let longest = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
    if det.abs() <= SLIVER * longest {
        return Err(bad(format!(
            "corner_cell row {}: the centres of cells {:?} span no area",
            number(r),
            cells.map(number)
        )));
    }
    let side = opposite.map(|s| s.expect("three columns took three different places"));
    Ok(Seats::new(side, det < 0.0))
}

/// The corners of each cell are those whose row of `corner_cell` names the cell, each of them once.
pub(super) fn cells(t: &GridTables) -> Result<()> {
    let number = |i: usize| i as i64 + i64::from(t.index_base);
    let mut around = vec![0u32; t.cells()];
    for cell in t.corner_cell.iter() {
        around[(cell - i64::from(t.index_base)) as usize] += 1;
    }
    first_error(t.cells(), |r| {
        let start = r * t.cell_corner_row;
        let used = t.cell_corner_count.map_or(t.cell_corner_row, |count| count.get(r) as usize);
        let corner = |column: usize| t.cell_corner.get(start + column);
        let at_cell = |column: &usize| {
            let corner = (corner(*column) - i64::from(t.index_base)) as usize;
            t.corner_cell.row::<3>(corner).contains(&number(r))
        };
        if let Some(column) = (0..used).find(|column| !at_cell(column)) {
            return Some(bad(format!(
                "cell_corner row {}, column {column}: corner {}, expected one whose corner_cell row names the cell",
                number(r),
                corner(column)
            )));
        }
        let distinct = (0..used).filter(|&i| (0..i).all(|j| corner(j) != corner(i))).count();
        (distinct != around[r] as usize).then(|| {
            bad(format!(
                "cell_corner row {}: {distinct} different corners, expected the {} whose corner_cell rows name the cell",
                number(r),
                around[r]
            ))
        })
    })
}

/// The triangles turn the same way on both sides of every edge and cover the sphere exactly once.
pub(super) fn closed(t: &GridTables, direction: &[[f64; 3]], seats: &[Seats]) -> Result<()> {
    let number = |i: usize| i as i64 + i64::from(t.index_base);
    let wound = |r: usize| {
        let [a, b, c] = row(t, t.corner_cell, r);
        if seats[r].is_clockwise() { [a, c, b] } else { [a, b, c] }
    };
    let runs = |r: usize, from: usize, to: usize| {
        let v = wound(r);
        (0..3).any(|k| v[k] == from && v[(k + 1) % 3] == to)
    };
    first_error(t.corners(), |r| {
        let v = wound(r);
        row::<3>(t, t.corner_edge, r).into_iter().find_map(|edge| {
            let [a, b] = row(t, t.edge_corner, edge);
            let other = if a == r { b } else { a };
            let folded = (0..3).any(|k| runs(other, v[k], v[(k + 1) % 3]));
            folded.then(|| {
                bad(format!(
                    "corner_cell rows {} and {}: the triangles lie on the same side of edge {}, expected a surface without folds",
                    number(r), number(other), number(edge)
                ))
            })
        })
    })?;
    // Fixed blocks summed in order: the same sum for any number of threads.
    let area: f64 = (0..t.corners())
        .into_par_iter()
        .with_min_len(4096)
        .map(|r| solid_angle(wound(r).map(|cell| DVec3::from_array(direction[cell]))))
        .collect::<Vec<f64>>()
        .iter()
        .sum();
    if (area / (4.0 * PI) - 1.0).abs() > COVER {
        return Err(bad(format!(
            "corner_cell: the triangles' areas sum to {:.9} of the sphere, expected 1",
            area / (4.0 * PI)
        )));
    }
    Ok(())
}

/// Solid angle of a triangle of unit vectors (Van Oosterom and Strackee 1983, doi:10.1109/TBME.1983.325207).
fn solid_angle([a, b, c]: [DVec3; 3]) -> f64 {
    let det = a.dot((b - a).cross(c - a));
    2.0 * det.atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
}
