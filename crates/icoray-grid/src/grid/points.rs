//! A mesh of points alone: columns of a model without tables become the cells, and the Delaunay triangles of their
//! directions the corners.
//!
//! Points are inserted into [`ConstrainedDelaunay`], whose predicates are exact, in rounds that double and along a
//! curve that fills space (Amenta, Choi and Rote 2003, doi:10.1145/777792.777824), so that each is located in a few
//! steps and the time is O(n log n). The triangulation starts as a tetrahedron of points around the sphere's centre.
//! Points of a region have none; then one synthetic point on the other side of the sphere completes it, and its
//! triangles are removed.
//!
//! The result is the hull of the points, which also covers the outside of a region. No point lies in a triangle's
//! circumcircle: if that circle is much larger than others at the same points, the triangle lies outside and is
//! removed.

use super::constrained_delaunay::{ConstrainedDelaunay, ConstraintError, Face};
use super::generate::IcosahedralMesh;
use super::tables::LonLat;
use super::triangles::{Connectivity, circumcenter, cut_polygon};
use super::{OwnedTables, check};
use crate::error::{Error, ErrorKind, Result};
use crate::memory;
use glam::DVec3;
use rayon::prelude::*;
use std::cmp::Ordering;

/// Points nearer to each other than this count as one, radians: 2 m on the Earth. Meridians at 0 and 2π in f32 differ
/// by 1.7e-7.
const SAME: f64 = 3e-7;
/// A triangle is outside if its circumcircle is larger than this many times the smallest ones at its points. Inside,
/// circles differ by less than twice from one triangle to the next, or, at scattered points, mostly by less than 5
/// times.
const OUTSIDE: f64 = 5.0;
/// A point with more triangles is left out, and its ring is cut into others: the rows of the tables are as long as the
/// largest number of triangles at a point, which at the pole of a lat-lon grid is that of the meridians.
const MOST_TRIANGLES: u32 = 64;
/// Bisections of the icosahedron in whose directions the points of the first tetrahedron are searched.
const LEVEL: u32 = 1;
/// Minimum volume that a face of a tetrahedron around the centre spans with the centre: below the first a synthetic
/// point replaces one of the points, and below the second the points lie on one great circle, to rounding.
const VOLUME: f64 = 1e-9;
const FLAT: f64 = 1e-14;
/// Marks the synthetic point instead of a row.
const SYNTHETIC: u32 = u32::MAX;
/// Bits of each coordinate along the curve.
const CURVE_BITS: u32 = 20;
/// Bytes per point of the triangulation and of the tables made from it, which exist at the same time.
const BYTES: u64 = 400;

impl OwnedTables {
    /// The tables of a mesh whose cells are points, of a whole sphere or of regions, and whose corners are the Delaunay
    /// triangles of the points, with their circumcentres as positions. The same points give the same tables, and in
    /// another order the same triangles. Of points
    /// less than 3e-7 rad (2 m on the Earth) apart, as a lat-lon grid has at its poles and at a repeated meridian, one
    /// is a vertex of triangles; the others are cells that no picture shows.
    ///
    /// A triangle whose circumcircle is more than 5 times as large as others at its points lies outside of the region.
    ///
    /// # Errors
    /// [`ErrorKind::Grid`] if the numbers of longitudes and latitudes differ, names a point that is not finite or looks
    /// like degrees, and if the points span no area. [`ErrorKind::Memory`] if the tables do not fit.
    pub fn of_points(center: LonLat) -> Result<Self> {
        let LonLat { lon_rad, lat_rad } = center;
        let points = lon_rad.len();
        if lat_rad.len() != points || i32::try_from(6 * points as u64).is_err() {
            let expected = "as many latitudes as longitudes, at most 357 million";
            return Err(Error::grid(format!(
                "{points} longitudes and {} latitudes, expected {expected}",
                lat_rad.len()
            )));
        }
        memory::require("triangles of the points", BYTES * points as u64, None)?;
        let angles = [lon_rad, lat_rad].map(|angle| (0..points).map(|i| angle.get(i)).collect());
        let mut tables = OwnedTables { center: angles, ..OwnedTables::default() };
        let directions = check::directions(&tables.tables())?;
        tables.corner_cell = triangles(&directions)?;
        let of = |cell: i32| directions[cell as usize];
        let place = |row: &[i32]| {
            let [x, y, z] = circumcenter([of(row[0]), of(row[1]), of(row[2])]);
            (y.atan2(x), z.atan2(x.hypot(y)))
        };
        let (lon, lat) = tables.corner_cell.par_chunks_exact(3).map(place).unzip();
        tables.corner = [lon, lat];
        tables.connectivity = Connectivity::new(&tables.corner_cell, points)?;
        Ok(tables)
    }
}

/// The triangles, counter-clockwise from outside and in the order of their least cells.
fn triangles(directions: &[[f64; 3]]) -> Result<Vec<i32>> {
    let (mut triangulation, mut row) = first(directions).ok_or_else(|| {
        let found = directions.len();
        Error::grid(format!("the {found} points span no area, expected at least 3 that are not on one great circle"))
    })?;
    triangulation.same_squared = SAME * SAME;
    for cell in in_order(directions) {
        if row[..4].contains(&cell) {
            continue;
        }
        match triangulation.insert(DVec3::from_array(directions[cell as usize])) {
            Ok(_) => row.push(cell),
            Err(ConstraintError::Vertex(vertex)) => {
                let known = &mut row[vertex as usize];
                *known = cell.min(*known);
            }
            Err(_) => return Err(Error::new(ErrorKind::Internal, format!("point {cell} cannot be inserted"))),
        }
    }
    let mut rows: Vec<[i32; 3]> = inside(&triangulation, &row)
        .into_iter()
        .map(|vertices| {
            let cells = vertices.map(|v| row[v as usize] as i32);
            let least = (0..3).min_by_key(|k| cells[*k]).unwrap_or(0);
            [0, 1, 2].map(|k| cells[(least + k) % 3])
        })
        .collect();
    rows.par_sort_unstable();
    Ok(rows.into_flattened())
}

/// A tetrahedron around the centre, of points or of three of them and a synthetic one, and the row of each vertex.
fn first(directions: &[[f64; 3]]) -> Option<(ConstrainedDelaunay, Vec<u32>)> {
    let extreme = extremes(directions);
    let at = |row: u32| DVec3::from_array(directions[row as usize]);
    let opposite = -extreme.iter().map(|row| at(*row)).sum::<DVec3>().normalize_or_zero();
    let mut vertices: Vec<(u32, DVec3)> = extreme.into_iter().map(|row| (row, at(row))).collect();
    vertices.push((SYNTHETIC, opposite));
    let volume = |p: [usize; 3]| {
        let [a, b, c] = p.map(|i| vertices[i].1);
        a.dot(b.cross(c))
    };
    let count = vertices.len();
    let mut best: Option<(f64, [usize; 4])> = None;
    // Without the synthetic point first, which is the last one.
    for d in [0..count - 1, count - 1..count].into_iter().flatten() {
        if d == count - 1 && best.is_some_and(|(volume, _)| volume > VOLUME) {
            break;
        }
        for (a, b, c) in (0..d).flat_map(|a| (0..a).flat_map(move |b| (0..b).map(move |c| (a, b, c)))) {
            let [b, c] = if volume([a, b, c]) > 0.0 { [b, c] } else { [c, b] };
            let faces = [[a, b, c], [a, c, d], [a, d, b], [b, d, c]];
            let least = faces.into_iter().map(volume).fold(f64::INFINITY, f64::min);
            if least > best.map_or(FLAT, |(volume, _)| volume) {
                best = Some((least, [a, b, c, d]));
            }
        }
    }
    let four = best?.1.map(|i| vertices[i]);
    let triangulation = ConstrainedDelaunay::of_tetrahedron(four.map(|(_, point)| point))?;
    Some((triangulation, four.map(|(row, _)| row).to_vec()))
}

/// The rows of the points that lie farthest in each of some directions, without repetition.
fn extremes(directions: &[[f64; 3]]) -> Vec<u32> {
    let mesh = IcosahedralMesh::new(LEVEL).expect("a small mesh");
    let ways = mesh.lon_center_rad.iter().zip(&mesh.lat_center_rad);
    let ways: Vec<DVec3> = ways.map(|(lon, lat)| check::unit_vector(*lon, *lat)).collect();
    let along = |way: DVec3, row: u32| DVec3::from_array(directions[row as usize]).dot(way);
    let by_place = |a: u32, b: u32| order_of_places(directions, a, b);
    let farthest = |rows: &[u32], way: DVec3| {
        let farther = |a: &&u32, b: &&u32| along(way, **a).total_cmp(&along(way, **b)).then(by_place(**b, **a));
        rows.iter().max_by(farther).copied()
    };
    let of = |rows: &[u32]| ways.iter().filter_map(|way| farthest(rows, *way)).collect::<Vec<u32>>();
    let all: Vec<u32> = (0..directions.len() as u32).collect();
    let found: Vec<u32> = all.par_chunks(1 << 14).flat_map_iter(of).collect();
    let mut found = of(&found);
    found.sort_unstable_by(|a, b| by_place(*a, *b));
    found.dedup();
    found
}

/// The order of two rows by their directions, in which points have one order for any numbers.
fn order_of_places(directions: &[[f64; 3]], a: u32, b: u32) -> Ordering {
    let bits = |row: u32| directions[row as usize].map(f64::to_bits);
    bits(a).cmp(&bits(b)).then(a.cmp(&b))
}

/// The rows in the order in which they are inserted.
fn in_order(directions: &[[f64; 3]]) -> Vec<u32> {
    let place = |row: u32| {
        // Half of the points are in the last round, a quarter in the one before, and so on.
        let mix = |hash: u64, x: f64| (hash ^ x.to_bits()).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(32);
        let round = directions[row as usize].into_iter().fold(1, mix);
        let round = round.wrapping_mul(0xd6e8_feb8_6659_fd93).leading_zeros();
        let scale = f64::from(1 << (CURVE_BITS - 1));
        let spread = |x: f64| {
            let cube = ((x + 1.0) * scale) as u64;
            (0..CURVE_BITS).fold(0, |bits, bit| bits | (cube >> bit & 1) << (3 * bit))
        };
        let [x, y, z] = directions[row as usize].map(spread);
        (63 - round, x | y << 1 | z << 2, row)
    };
    let mut order: Vec<(u32, u64, u32)> = (0..directions.len() as u32).into_par_iter().map(place).collect();
    order.par_sort_unstable_by(|(round, curve, row), (other_round, other_curve, other)| {
        (round, curve).cmp(&(other_round, other_curve)).then_with(|| order_of_places(directions, *row, *other))
    });
    order.into_iter().map(|(_, _, row)| row).collect()
}

/// The triangles whose circumcircles are not much larger than others at the same points, and those between three such
/// triangles, as scattered points have some. Points with very many triangles are left out, and their rings cut.
fn inside(triangulation: &ConstrainedDelaunay, row: &[u32]) -> Vec<[u32; 3]> {
    let faces = &triangulation.faces;
    let radius = |vertices: [u32; 3]| {
        if vertices.iter().any(|v| row[*v as usize] == SYNTHETIC) {
            return f64::INFINITY;
        }
        let [a, b, c] = vertices.map(|v| triangulation.point(v));
        (a - b).length() * (b - c).length() * (c - a).length() / (2.0 * (b - a).cross(c - a).length())
    };
    let mut smallest = vec![f64::INFINITY; row.len()];
    let mut count = vec![0u32; row.len()];
    for face in faces {
        let radius = radius(face.vertices);
        for v in face.vertices {
            smallest[v as usize] = smallest[v as usize].min(radius);
            count[v as usize] += 1;
        }
    }
    // The middle one of three: a point may have no triangle inside at all.
    let is_small = |face: &Face| {
        let mut around = face.vertices.map(|v| smallest[v as usize]);
        around.sort_by(f64::total_cmp);
        let radius = radius(face.vertices);
        radius.is_finite() && radius <= OUTSIDE * around[1]
    };
    let is_small: Vec<bool> = faces.iter().map(is_small).collect();
    let is_inside = |f: usize| {
        let is_between = || faces[f].beyond.iter().all(|beyond| is_small[*beyond as usize]);
        is_small[f] || is_between() && radius(faces[f].vertices).is_finite()
    };
    let is_hub = |v: &u32| {
        count[*v as usize] > MOST_TRIANGLES && triangulation.ring(*v).all(|(face, _)| is_inside(face as usize))
    };
    let volume = |[a, b, c]: [u32; 3]| {
        let [a, b, c] = [a, b, c].map(|v| triangulation.point(v));
        a.dot(b.cross(c))
    };
    let (mut is_left_out, mut triangles) = (vec![false; row.len()], Vec::new());
    for hub in (0..row.len() as u32).filter(is_hub) {
        let ring = triangulation.ring(hub).map(|(face, k)| faces[face as usize].vertices[(k + 1) % 3]);
        let ring: Vec<u32> = ring.collect();
        let cut = cut_polygon(&ring, |v| triangulation.point(v).to_array());
        if cut.iter().all(|triangle| volume(*triangle) > 0.0) && !ring.iter().any(|v| is_left_out[*v as usize]) {
            is_left_out[hub as usize] = true;
            triangles.extend(cut);
        }
    }
    let is_kept = |f: &usize| is_inside(*f) && !faces[*f].vertices.iter().any(|v| is_left_out[*v as usize]);
    triangles.extend((0..faces.len()).filter(is_kept).map(|f| faces[f].vertices));
    triangles
}

#[cfg(test)]
mod tests;
