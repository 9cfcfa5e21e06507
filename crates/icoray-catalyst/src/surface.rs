//! The mesh of the sphere that the columns of all ranks stand on.
//!
//! Each rank sends the directions of its columns of points and the polygons of its columns of elements; all ranks put the
//! same whole mesh together. Columns of different ranks in one place are one node of the mesh.

use crate::columns::Columns;
use glam::DVec3;
use icoray::{Error, ErrorKind, Result};
use icoray_dataset::Mesh;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::path::Path;

/// A rank's piece of a mesh.
#[derive(Debug, Default, Clone, Serialize, Deserialize)]
pub struct Piece {
    /// Number of points in a column; 0 on a rank without elements.
    pub levels: usize,
    /// Unit vectors of the columns of points.
    pub directions: Vec<[f64; 3]>,
    /// The columns around each column of elements.
    pub polygons: Vec<Vec<u32>>,
}

/// The whole mesh, and which part of it this rank has.
pub struct Surface {
    /// Its tables.
    pub mesh: Mesh,
    /// Rows of this rank's columns of points in the mesh, and whether this rank owns them.
    pub nodes: OwnedRows,
    /// The same of this rank's columns of elements, all of which it owns.
    pub faces: OwnedRows,
    /// Whether elements are triangles: corners of the cells around the points.
    pub has_triangles: bool,
}

/// Rows of the whole mesh's tables.
#[derive(Debug, Default, Clone, PartialEq)]
pub struct OwnedRows {
    pub row: Vec<i64>,
    pub is_owned: Vec<i32>,
}

/// Columns deviate from straight lines through the origin by no more than this, radians.
const STRAIGHT: f64 = 1e-4;

/// The directions of columns.
///
/// # Errors
/// [`icoray::ErrorKind::Grid`] names a point that is not above its column, as seen from the origin.
pub fn directions(columns: &Columns, place: impl Fn(u32) -> DVec3) -> Result<Vec<[f64; 3]>> {
    let columns = columns.points.chunks_exact(columns.levels.max(1));
    columns.map(|column| Ok(direction_of(column, &place)?.to_array())).collect()
}

/// The direction of a column of points.
///
/// # Errors
/// As [`directions`].
pub fn direction_of(column: &[u32], place: impl Fn(u32) -> DVec3) -> Result<DVec3> {
    let unit = |point: u32| place(point) / place(point).length();
    let outermost = unit(column[column.len() - 1]);
    for &point in column {
        let apart = unit(point).distance(outermost);
        // Not a number either.
        if apart.is_nan() || apart > STRAIGHT {
            let DVec3 { x, y, z } = place(point);
            return Err(Error::grid(format!(
                "point {point} at ({x}, {y}, {z}) is not below the outermost one of its column, as seen from the origin: \
                 expected columns of a sphere around it"
            )));
        }
    }
    Ok(outermost)
}

impl Surface {
    /// The mesh of all ranks' pieces; `rank` is this one.
    ///
    /// # Errors
    /// [`icoray::ErrorKind::Grid`] names columns and elements that two ranks have, or one has twice.
    pub fn of(pieces: &[Piece], rank: usize, name: &str) -> Result<Self> {
        let nodes = Nodes::of(pieces)?;
        let mut faces: Vec<&[u32]> = Vec::new();
        let mut starts = Vec::new();
        for piece in pieces {
            starts.push(faces.len());
            faces.extend(piece.polygons.iter().map(Vec::as_slice));
        }
        let rank_of = |face: usize| starts.partition_point(|start| *start <= face) - 1;
        let row = faces.iter().map(|face| face.len()).max().unwrap_or(0).max(3);
        let has_triangles = faces.iter().all(|face| face.len() == 3);
        let mut table = Vec::with_capacity(row * faces.len());
        let mut known: HashMap<Vec<i32>, usize> = HashMap::new();
        for (i, face) in faces.iter().enumerate() {
            let of = rank_of(i);
            let start = table.len();
            table.extend(face.iter().map(|node| nodes.number[of][*node as usize] as i32));
            let mut key = table[start..].to_vec();
            key.sort_unstable();
            if let Some(other) = known.insert(key, i) {
                let [a, b] = [other, i].map(|face| (face - starts[rank_of(face)], rank_of(face)));
                return Err(Error::grid(format!(
                    "the column of elements {} of rank {} is also that of {} of rank {}; expected each on one rank, without \
                     ghosts",
                    b.0, b.1, a.0, a.1
                )));
            }
            table.resize(start + row, -1);
        }
        let middles: Option<Vec<[f64; 3]>> =
            (!has_triangles).then(|| table.chunks_exact(row).map(|face| centroid(face, &nodes.directions)).collect());
        let mesh = Mesh::of_faces(Path::new(name), &nodes.directions, middles.as_deref(), table, row)?;
        if mesh.corners_in_file() != mesh.corners() {
            let what =
                "more than 3 columns of elements meet in a column of points, expected prisms on hexagons or triangles";
            return Err(Error::new(ErrorKind::Unsupported, what));
        }
        let count = pieces[rank].polygons.len();
        let own_faces =
            OwnedRows { row: (0..count).map(|i| (starts[rank] + i) as i64).collect(), is_owned: vec![1; count] };
        Ok(Surface { mesh, nodes: nodes.of_rank(rank), faces: own_faces, has_triangles })
    }
}

/// The columns of points of all ranks as nodes of one mesh.
struct Nodes {
    /// Unit vectors.
    directions: Vec<[f64; 3]>,
    /// The node of each column of each rank.
    number: Vec<Vec<usize>>,
    /// The lowest rank that has each node.
    owner: Vec<usize>,
}

impl Nodes {
    fn of(pieces: &[Piece]) -> Result<Self> {
        let within = tolerance(pieces);
        let mut buckets: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
        let mut nodes = Nodes { directions: Vec::new(), number: Vec::new(), owner: Vec::new() };
        for (rank, piece) in pieces.iter().enumerate() {
            let first = nodes.directions.len();
            let mut number = Vec::with_capacity(piece.directions.len());
            for direction in &piece.directions {
                let known = around(*direction, within).into_iter().filter_map(|key| buckets.get(&key)).flatten();
                let same = known.copied().find(|&node| apart(nodes.directions[node], *direction) <= within);
                if let Some(node) = same.filter(|node| *node >= first) {
                    let other = number.iter().position(|n| *n == node).unwrap_or(0);
                    return Err(Error::grid(format!(
                        "columns {other} and {} of rank {rank} are in one place: points are duplicated, expected shared ones",
                        number.len()
                    )));
                }
                let node = same.unwrap_or_else(|| {
                    nodes.directions.push(*direction);
                    nodes.owner.push(rank);
                    buckets.entry(bucket(*direction, within)).or_default().push(nodes.directions.len() - 1);
                    nodes.directions.len() - 1
                });
                number.push(node);
            }
            nodes.number.push(number);
        }
        Ok(nodes)
    }

    /// The rows of a rank's columns; none of a rank that owns none of them.
    fn of_rank(&self, rank: usize) -> OwnedRows {
        let numbers = &self.number[rank];
        let is_owned: Vec<i32> = numbers.iter().map(|node| i32::from(self.owner[*node] == rank)).collect();
        if !is_owned.contains(&1) {
            return OwnedRows::default();
        }
        OwnedRows { row: numbers.iter().map(|node| *node as i64).collect(), is_owned }
    }
}

/// How far apart columns of two ranks may be and still be one: a small part of the shortest side, and no less than what
/// rounding to 32 bits may make of it.
fn tolerance(pieces: &[Piece]) -> f64 {
    let mut shortest = f64::INFINITY;
    for piece in pieces {
        for polygon in &piece.polygons {
            for (k, a) in polygon.iter().enumerate() {
                let b = polygon[(k + 1) % polygon.len()];
                shortest = shortest.min(apart(piece.directions[*a as usize], piece.directions[b as usize]));
            }
        }
    }
    let rounding = 1e-6_f64;
    rounding.max(1e-3 * shortest).min(0.25 * shortest).max(f64::MIN_POSITIVE)
}

/// Cubes that are twice as wide as what columns may be apart.
fn bucket(direction: [f64; 3], within: f64) -> [i64; 3] {
    direction.map(|x| (x / (2.0 * within)).floor() as i64)
}

/// The cubes that may have a column in the same place.
fn around(direction: [f64; 3], within: f64) -> Vec<[i64; 3]> {
    let mut keys: Vec<[i64; 3]> = Vec::new();
    for signs in 0..8 {
        let shifted = [0, 1, 2].map(|k| direction[k] + if signs >> k & 1 == 0 { -within } else { within });
        let key = bucket(shifted, within);
        if !keys.contains(&key) {
            keys.push(key);
        }
    }
    keys
}

fn apart(a: [f64; 3], b: [f64; 3]) -> f64 {
    DVec3::from_array(a).distance(DVec3::from_array(b))
}

/// The direction of a polygon's centroid: of the flat triangles from its first node, each weighted by its area.
fn centroid(face: &[i32], directions: &[[f64; 3]]) -> [f64; 3] {
    let nodes = face.iter().filter(|node| **node >= 0).map(|node| DVec3::from_array(directions[*node as usize]));
    let nodes: Vec<DVec3> = nodes.collect();
    let weighted = nodes[1..].windows(2).map(|pair| {
        let area = (pair[0] - nodes[0]).cross(pair[1] - nodes[0]).length();
        area * (nodes[0] + pair[0] + pair[1])
    });
    weighted.sum::<DVec3>().to_array()
}

#[cfg(test)]
mod tests {
    use super::*;
    use icoray::IcosahedralMesh;

    /// The triangles of an icosahedral mesh, over three ranks in turn.
    fn pieces(mesh: &IcosahedralMesh, ranks: usize, noise: f64) -> Vec<Piece> {
        let tables = mesh.tables();
        let (lon, lat) = (tables.center.lon_rad, tables.center.lat_rad);
        let node =
            |i: usize| [lat.get(i).cos() * lon.get(i).cos(), lat.get(i).cos() * lon.get(i).sin(), lat.get(i).sin()];
        (0..ranks)
            .map(|rank| {
                let (mut local, mut piece) = (HashMap::new(), Piece { levels: 2, ..Piece::default() });
                for (_, triangle) in mesh.corner_cell.chunks_exact(3).enumerate().filter(|(i, _)| i % ranks == rank) {
                    let polygon = triangle.iter().map(|cell| {
                        *local.entry(*cell).or_insert_with(|| {
                            piece.directions.push(node(*cell as usize).map(|x| x + noise * rank as f64));
                            piece.directions.len() as u32 - 1
                        })
                    });
                    let polygon = polygon.collect();
                    piece.polygons.push(polygon);
                }
                piece
            })
            .collect()
    }

    #[test]
    fn pieces_of_ranks_are_one_mesh_again() {
        let mesh = IcosahedralMesh::new(3).unwrap();
        for noise in [0.0, 1e-7] {
            let pieces = pieces(&mesh, 3, noise);
            let mut owned = vec![0; mesh.cells()];
            for rank in 0..3 {
                let surface = Surface::of(&pieces, rank, "test").unwrap();
                assert_eq!((surface.mesh.cells(), surface.mesh.corners()), (mesh.cells(), mesh.corner_cell.len() / 3));
                assert_eq!(surface.mesh.grid().unwrap().void_triangles(), 0);
                assert!(surface.has_triangles && surface.faces.is_owned.iter().all(|owned| *owned == 1));
                let rows = &surface.nodes;
                rows.row.iter().zip(&rows.is_owned).for_each(|(row, own)| owned[*row as usize] += own);
            }
            assert!(owned.iter().all(|count| *count == 1), "each cell has one owner");
        }
    }

    #[test]
    fn elements_of_two_ranks_and_points_in_one_place_are_refused() {
        let mesh = IcosahedralMesh::new(1).unwrap();
        let message = |pieces: &[Piece]| Surface::of(pieces, 0, "test").err().unwrap().to_string();
        let mut twice = pieces(&mesh, 1, 0.0);
        let node = twice[0].directions[7];
        twice[0].directions.push(node);
        assert!(message(&twice).contains("columns 7 and 42 of rank 0 are in one place: points are duplicated"));
        let mut ghost = pieces(&mesh, 1, 0.0);
        ghost.push(ghost[0].clone());
        assert!(message(&ghost).contains("elements 0 of rank 1 is also that of 0 of rank 0"), "{}", message(&ghost));
    }

    #[test]
    fn elements_of_four_sides_are_refused() {
        // A hat on a box: at its brim two sides and two triangles meet.
        let ring = |z: f64| [[1.0, 0.0, z], [0.0, 1.0, z], [-1.0, 0.0, z], [0.0, -1.0, z]];
        let directions = [&ring(1.0)[..], &ring(-1.0), &[[0.0, 0.0, 1.0]]].concat();
        let sides = (0..4u32).map(|k| vec![k, (k + 1) % 4, (k + 1) % 4 + 4, k + 4]);
        let fans = (0..4u32).map(|k| vec![k, (k + 1) % 4, 8]);
        let piece = Piece { levels: 2, directions, polygons: sides.chain(fans).collect() };
        let error = Surface::of(&[piece], 0, "test").err().unwrap();
        assert_eq!(error.kind(), ErrorKind::Unsupported);
        assert!(error.to_string().contains("more than 3 columns of elements meet"), "{error}");
    }

    #[test]
    fn centroids_of_regular_polygons_are_their_middles() {
        let nodes: Vec<[f64; 3]> = (0..6)
            .map(|k| f64::from(k).mul_add(1.047_197_551_196_597_6, 0.3))
            .map(|a| [0.1 * a.cos(), 0.1 * a.sin(), 1.0])
            .collect();
        let [x, y, z] = centroid(&[0, 1, 2, 3, 4, 5, -1], &nodes);
        assert!((x / z).abs() < 1e-15 && (y / z).abs() < 1e-15);
    }

    #[test]
    fn columns_are_straight() {
        let place = |point: u32| DVec3::new(0.0, if point == 1 { 1e-3 } else { 0.0 }, 1.0 + 0.1 * f64::from(point));
        assert_eq!(direction_of(&[0, 2], place).unwrap(), DVec3::Z);
        let error = direction_of(&[0, 1, 2], place).unwrap_err().to_string();
        assert!(error.contains("point 1 at (0, 0.001, 1.1)"), "{error}");
    }
}
