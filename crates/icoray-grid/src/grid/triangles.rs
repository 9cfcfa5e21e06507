//! Makes a mesh's tables of corners and edges from its triangles alone.

use super::constrained_delaunay::{CENTER, coord};
use crate::error::{Error, Result};
use glam::DVec3;
use robust::{Coord3D, orient3d};
use std::cmp::Ordering;

/// Entry for a missing neighbour, in tables that count from 0.
const NONE: i32 = -1;

/// The tables of [`GridTables`](super::GridTables) that follow from `corner_cell`; numbered from 0, and -1 for a
/// missing neighbour.
#[derive(Debug, Default, PartialEq)]
pub struct Connectivity {
    /// As [`GridTables::corner_edge`](super::GridTables::corner_edge): column k is the side opposite the cell in
    /// column k of `corner_cell`.
    pub corner_edge: Vec<i32>,
    /// As [`GridTables::edge_corner`](super::GridTables::edge_corner).
    pub edge_corner: Vec<i32>,
    /// As [`GridTables::cell_corner`](super::GridTables::cell_corner), in order around each cell.
    pub cell_corner: Vec<i32>,
    /// As [`GridTables::cell_corner_row`](super::GridTables::cell_corner_row).
    pub cell_corner_row: usize,
    /// As [`GridTables::cell_corner_count`](super::GridTables::cell_corner_count).
    pub cell_corner_count: Vec<i32>,
}

impl Connectivity {
    /// Finds the edges and each cell's corners; `corner_cell` has rows of three cells, numbered from 0. A side without
    /// a triangle beyond is the rim of a mesh with holes.
    ///
    /// # Errors
    /// [`crate::ErrorKind::Grid`] names a row that does not have three different cells from 0 to `cells` - 1, and a
    /// side that more than two triangles have.
    pub fn new(corner_cell: &[i32], cells: usize) -> Result<Self> {
        let around = Around::new(corner_cell, cells)?;
        let mut corner_edge = vec![NONE; corner_cell.len()];
        let mut edge_corner = Vec::with_capacity(corner_cell.len());
        let side_opposite = |corner: i32, pair: [i32; 2]| {
            let row = row(corner_cell, corner);
            3 * corner as usize + (0..3).find(|&k| !pair.contains(&row[k])).unwrap_or(0)
        };
        for cell in 0..cells as i32 {
            for &corner in around.of(cell) {
                for other in row(corner_cell, corner).into_iter().filter(|&other| other > cell) {
                    let mut sharing = around.of(cell).iter().filter(|c| row(corner_cell, **c).contains(&other));
                    let (first, second) = (sharing.next(), sharing.next());
                    if sharing.next().is_some() {
                        return Err(Error::grid(format!(
                            "more than two triangles have a side between the points {cell} and {other}"
                        )));
                    }
                    if first == Some(&corner) {
                        let edge = (edge_corner.len() / 2) as i32;
                        edge_corner.extend([corner, second.copied().unwrap_or(NONE)]);
                        corner_edge[side_opposite(corner, [cell, other])] = edge;
                        if let Some(&second) = second {
                            corner_edge[side_opposite(second, [cell, other])] = edge;
                        }
                    }
                }
            }
        }
        Ok(Connectivity { corner_edge, edge_corner, ..around.rows(corner_cell) })
    }
}

/// The direction at equal distance from three points: the middle of the circle through them, on their side. Of any
/// length.
pub fn circumcenter(points: [[f64; 3]; 3]) -> [f64; 3] {
    let [a, b, c] = points.map(DVec3::from_array);
    let normal = (b - a).cross(c - a);
    (normal * normal.dot(a + b + c).signum()).to_array()
}

/// Cuts a polygon of points into triangles by Delaunay's rule: no point of the polygon lies in the circumcircle of a
/// triangle. `polygon` has different numbers of points, in order around it in either direction, and `at` their places.
/// If points lie on one circle, their places decide: the triangles are the same for any numbers, first point and direction
/// of the polygon. The polygon is convex.
pub fn cut_polygon<N: Copy>(polygon: &[N], at: impl Fn(N) -> [f64; 3]) -> Vec<[N; 3]> {
    if let [a, b, c] = *polygon {
        return vec![[a, b, c]];
    }
    let mut polygon = polygon.to_vec();
    let order = |a: N, b: N| at(a).partial_cmp(&at(b)).unwrap_or(Ordering::Equal);
    let least = (0..polygon.len()).min_by(|i, j| order(polygon[*i], polygon[*j])).unwrap_or(0);
    polygon.rotate_left(least);
    let is_reversed = polygon.len() > 2 && order(polygon[1], polygon[polygon.len() - 1]).is_gt();
    if is_reversed {
        polygon[1..].reverse();
    }
    let place = |i: usize| coord(DVec3::from_array(at(polygon[i])));
    let mut triangles = Vec::with_capacity(polygon.len().saturating_sub(2));
    let mut sides = vec![[0, polygon.len().saturating_sub(1)]];
    while let Some([first, last]) = sides.pop() {
        if last - first < 2 {
            continue;
        }
        let ends = [first, last].map(place);
        let from_middle = |i: usize| (2 * i).abs_diff(first + last);
        let mut apex = first + 1;
        for other in first + 2..last {
            let plane = |p: Coord3D<f64>| orient3d(ends[0], place(apex), ends[1], p);
            // Negative beyond the plane of the triangle, as seen from the sphere's centre.
            let above = plane(place(other)) * plane(CENTER).signum();
            if above < 0.0 || above == 0.0 && from_middle(other) < from_middle(apex) {
                apex = other;
            }
        }
        let [a, b, c] = [first, apex, last].map(|i| polygon[i]);
        triangles.push(if is_reversed { [c, b, a] } else { [a, b, c] });
        sides.extend([[first, apex], [apex, last]]);
    }
    triangles
}

fn row(corner_cell: &[i32], corner: i32) -> [i32; 3] {
    std::array::from_fn(|k| corner_cell[3 * corner as usize + k])
}

/// The triangles around each cell.
struct Around {
    start: Vec<usize>,
    corners: Vec<i32>,
}

impl Around {
    fn new(corner_cell: &[i32], cells: usize) -> Result<Self> {
        let mut start = vec![0; cells + 1];
        for (corner, triangle) in corner_cell.chunks_exact(3).enumerate() {
            let [a, b, c] = [0, 1, 2].map(|k| triangle[k]);
            if a == b || b == c || c == a {
                return Err(Error::grid(format!(
                    "triangle {corner} has the points {triangle:?}, expected three different ones"
                )));
            }
            for &cell in triangle {
                let Some(count) = usize::try_from(cell).ok().and_then(|cell| start[1..].get_mut(cell)) else {
                    return Err(Error::grid(format!(
                        "triangle {corner} has the points {triangle:?}, expected 0 to {}",
                        cells as i64 - 1
                    )));
                };
                *count += 1;
            }
        }
        for i in 0..cells {
            start[i + 1] += start[i];
        }
        let mut next = start.clone();
        let mut corners = vec![0; corner_cell.len()];
        for (i, &cell) in corner_cell.iter().enumerate() {
            corners[next[cell as usize]] = (i / 3) as i32;
            next[cell as usize] += 1;
        }
        Ok(Around { start, corners })
    }

    fn of(&self, cell: i32) -> &[i32] {
        &self.corners[self.start[cell as usize]..self.start[cell as usize + 1]]
    }

    /// The tables of corners around cells, without those of edges. At least 3 entries of a row count, of which those
    /// that are missing at a rim are marked.
    fn rows(&self, corner_cell: &[i32]) -> Connectivity {
        let cells = self.start.len() as i32 - 1;
        let cell_corner_count: Vec<i32> = (0..cells).map(|cell| self.of(cell).len().max(3) as i32).collect();
        let cell_corner_row = cell_corner_count.iter().max().map_or(3, |&count| count as usize);
        let mut cell_corner = vec![NONE; cells as usize * cell_corner_row];
        for (cell, place) in cell_corner.chunks_exact_mut(cell_corner_row).enumerate() {
            turn(corner_cell, cell as i32, self.of(cell as i32), place);
        }
        Connectivity { cell_corner, cell_corner_row, cell_corner_count, ..Connectivity::default() }
    }
}

/// Writes the triangles around a cell to `place`, each next to the one that it shares a side with. At a rim there are
/// several such runs, each of which begins at a side without a neighbour.
fn turn(corner_cell: &[i32], cell: i32, around: &[i32], place: &mut [i32]) {
    let others = |corner: i32| row(corner_cell, corner).into_iter().filter(move |&other| other != cell);
    let is_rim = |other: i32| around.iter().filter(|&&c| others(c).any(|o| o == other)).count() == 1;
    let mut left = around.to_vec();
    // The point that the last triangle shares with the next.
    let mut shared = None;
    for next in place.iter_mut().take(around.len()) {
        let beside = left.iter().position(|&corner| others(corner).any(|other| Some(other) == shared));
        let first = || left.iter().position(|&corner| others(corner).any(is_rim)).unwrap_or(0);
        *next = left.remove(beside.unwrap_or_else(first));
        shared = match beside {
            Some(_) => others(*next).find(|&other| Some(other) != shared),
            None => others(*next).find(|&other| !is_rim(other)),
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::{Grid, GridTables, IcosahedralMesh};
    use icoray_test_support::Random;

    fn grid_of<'a>(mesh: &'a IcosahedralMesh, corner_cell: &'a [i32], of: &'a Connectivity) -> GridTables<'a> {
        GridTables {
            corner_cell: corner_cell.into(),
            cell_corner: of.cell_corner.as_slice().into(),
            cell_corner_row: of.cell_corner_row,
            cell_corner_count: Some(of.cell_corner_count.as_slice().into()),
            corner_edge: of.corner_edge.as_slice().into(),
            edge_corner: of.edge_corner.as_slice().into(),
            ..mesh.tables()
        }
    }

    #[test]
    fn a_whole_sphere_passes_the_check() {
        let mesh = IcosahedralMesh::new(3).unwrap();
        let of = Connectivity::new(&mesh.corner_cell, mesh.cells()).unwrap();
        assert_eq!((of.cell_corner_row, of.edge_corner.len()), (6, mesh.edge_corner.len()));
        let grid = Grid::new(grid_of(&mesh, &mesh.corner_cell, &of)).unwrap();
        assert_eq!(grid.void_triangles(), 0);
    }

    #[test]
    fn corners_are_in_order_around_their_cell() {
        let mesh = IcosahedralMesh::new(2).unwrap();
        let of = Connectivity::new(&mesh.corner_cell, mesh.cells()).unwrap();
        for (cell, corners) in of.cell_corner.chunks_exact(6).enumerate() {
            let count = of.cell_corner_count[cell] as usize;
            for k in 0..count {
                let [one, next] = [corners[k], corners[(k + 1) % count]].map(|c| row(&mesh.corner_cell, c));
                assert_eq!(one.iter().filter(|point| next.contains(point)).count(), 2, "cell {cell}");
            }
        }
    }

    /// Triangles are taken away, at random, down to islands that touch at a point.
    #[test]
    fn a_sphere_with_holes_passes_the_check() {
        let mesh = IcosahedralMesh::new(2).unwrap();
        let mut random = Random::new(9);
        for keep in [95, 70, 40] {
            let kept = mesh
                .corner_cell
                .chunks_exact(3)
                .flat_map(|triangle| if random.below(100) < keep { triangle.to_vec() } else { vec![NONE; 3] });
            let kept: Vec<i32> = kept.collect();
            let there: Vec<i32> = kept.iter().copied().filter(|cell| *cell != NONE).collect();
            let of = Connectivity::new(&there, mesh.cells()).unwrap();
            let corner = |angle: &[f64]| -> Vec<f64> {
                (0..angle.len()).filter(|c| kept[3 * c] != NONE).map(|c| angle[c]).collect()
            };
            let (lon, lat) = (corner(&mesh.lon_corner_rad), corner(&mesh.lat_corner_rad));
            let mut tables = grid_of(&mesh, &there, &of);
            tables.corner.lon_rad = lon.as_slice().into();
            tables.corner.lat_rad = lat.as_slice().into();
            let grid = Grid::new(tables).unwrap();
            assert!(grid.void_triangles() > 10, "{keep}");
        }
    }

    /// A polygon around the pole, of which one corner comes first after the other.
    #[test]
    fn a_polygon_is_cut_alike_wherever_it_begins() {
        let mut random = Random::new(4);
        for corners in [3, 4, 5, 8, 40] {
            let turn = |k: usize| (k as f64 + 0.5 * random.unit()) / corners as f64 * std::f64::consts::TAU;
            let angle: Vec<f64> = (0..corners).map(turn).collect();
            // On one circle, and beside it.
            for width in [0.0, 1e-3] {
                let radius = |k: i32| 0.1 + width * f64::from(k * k % 7) / f64::from(corners as i32).powi(2);
                let at = |k: i32| {
                    let (sin, cos) = angle[k as usize].sin_cos();
                    DVec3::new(radius(k) * cos, radius(k) * sin, 1.0).normalize()
                };
                let cut = |polygon: &[i32]| {
                    let mut triangles = cut_polygon(polygon, |k| at(k).to_array());
                    triangles.iter_mut().for_each(|triangle| triangle.sort_unstable());
                    triangles.sort_unstable();
                    triangles
                };
                let mut polygon: Vec<i32> = (0..corners as i32).collect();
                let expected = cut(&polygon);
                assert_eq!(expected.len(), corners - 2);
                polygon.rotate_left(corners / 3);
                assert_eq!(cut(&polygon), expected);
                polygon.reverse();
                assert_eq!(cut(&polygon), expected);
                // Numbers from the other end.
                let last = corners as i32 - 1;
                let renumbered: Vec<i32> = polygon.iter().map(|k| last - k).collect();
                let mut triangles = cut_polygon(&renumbered, |k| at(last - k).to_array());
                triangles.iter_mut().for_each(|triangle| *triangle = triangle.map(|k| last - k));
                triangles.iter_mut().for_each(|triangle| triangle.sort_unstable());
                triangles.sort_unstable();
                assert_eq!(triangles, expected);
                for [a, b, c] in &expected {
                    let [a, b, c] = [*a, *b, *c].map(at);
                    let normal = (b - a).cross(c - a);
                    let beyond = polygon.iter().map(|other| normal.dot(at(*other) - a) * normal.z.signum());
                    assert!(beyond.fold(f64::NEG_INFINITY, f64::max) < 1e-15, "{corners} {width}");
                }
            }
        }
    }

    #[test]
    fn triangles_that_are_none_are_named() {
        for (corner_cell, part) in [
            (vec![0, 1, 1], "triangle 0 has the points [0, 1, 1]"),
            (vec![0, 1, 2, 0, 1, 4], "triangle 1 has the points [0, 1, 4], expected 0 to 3"),
            (vec![0, -1, 2], "expected 0 to 3"),
            (vec![0, 1, 2, 1, 0, 3, 0, 1, 3], "more than two triangles have a side between the points 0 and 1"),
        ] {
            let error = Connectivity::new(&corner_cell, 4).unwrap_err();
            assert!(error.to_string().contains(part), "{error}");
        }
    }
}
