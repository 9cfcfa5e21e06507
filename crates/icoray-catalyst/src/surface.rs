//! The mesh of the sphere that the columns of all ranks stand on.
//!
//! Each rank sends the directions of its columns of points and the polygons of its columns of elements; all ranks put the
//! same whole mesh together. Columns of different ranks in one place are one node of the mesh.

use crate::columns::Columns;
use glam::DVec3;
use icoray::{Error, Owned, PartCells, PartCorners, Result};
use icoray_dataset::{DistinctPoints, Mesh};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::path::Path;

#[derive(Debug, Default, Clone, Serialize, Deserialize)]
pub struct Piece {
    /// Number of points in a column; 0 on a rank without elements.
    pub levels: usize,
    /// Number of elements in a column.
    pub layers: usize,
    /// Unit vectors of the columns of points.
    pub directions: Vec<[f64; 3]>,
    /// The columns around each column of elements; none if elements are points.
    pub polygons: Vec<Vec<u32>>,
}

/// The mesh of the sphere, and which part of it this rank has.
///
/// Values at points and at elements are on one mesh: its cells and corners. Only where more than three columns of
/// elements meet in a column of points, columns of points are the cells of a second mesh.
pub struct Surface {
    /// One mesh or two.
    pub meshes: Vec<Mesh>,
    /// This rank's columns of points.
    pub points: Placement,
    /// This rank's columns of elements, all of which it owns unless they are points.
    pub elements: Placement,
}

/// Columns as rows of a mesh.
pub struct Placement {
    /// The number of the mesh.
    pub mesh: usize,
    /// Whether they are its corners; otherwise its cells.
    pub is_at_corners: bool,
    pub rows: OwnedRows,
}

/// Rows of the whole mesh's tables.
#[derive(Debug, Default, Clone, PartialEq)]
pub struct OwnedRows {
    pub row: Vec<i64>,
    pub is_owned: Vec<i32>,
}

impl OwnedRows {
    pub fn as_cells(&self) -> PartCells<'_> {
        PartCells { global: self.row.as_slice().into(), owned: Owned::Marked(&self.is_owned) }
    }

    /// `None` without corners.
    pub fn as_corners(&self) -> Option<PartCorners<'_>> {
        let PartCells { global, owned } = self.as_cells();
        (!self.row.is_empty()).then_some(PartCorners { global, owned })
    }
}

/// Columns deviate from straight lines through the origin by no more than this, radians.
const STRAIGHT: f64 = 1e-4;

/// The directions of columns. Fails for a point that is not above its column, as seen from the origin.
pub fn directions(columns: &Columns, place: impl Fn(u32) -> DVec3) -> Result<Vec<[f64; 3]>> {
    let columns = columns.points.chunks_exact(columns.levels.max(1));
    columns.map(|column| Ok(direction_of(column, &place)?.to_array())).collect()
}

/// The direction of a column of points; fails as [`directions`].
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
    /// The mesh of all ranks' pieces, of which no two have the same column or element; `rank` is this one.
    pub fn of(pieces: &[Piece], rank: usize, name: &str) -> Result<Self> {
        let nodes = Nodes::of(pieces).map_err(|e| e.within(name))?;
        let Faces { table, row, starts } = Faces::of(pieces, &nodes).map_err(|e| e.within(name))?;
        let (path, directions, own_nodes) = (Path::new(name), &nodes.directions.all, nodes.of_rank(rank));
        let own = starts[rank]..starts[rank + 1];
        let own_faces = OwnedRows { is_owned: vec![1; own.len()], row: own.map(|face| face as i64).collect() };
        let at = |mesh, is_at_corners, rows| Placement { mesh, is_at_corners, rows };
        if pieces.iter().flat_map(|piece| &piece.polygons).all(|polygon| polygon.len() == 3) {
            let is_of_points = table.is_empty();
            let mesh = Mesh::of_nodes(path, directions, table, row)?;
            let elements = if is_of_points { at(0, false, own_nodes.clone()) } else { at(0, true, own_faces) };
            return Ok(Surface { meshes: vec![mesh], points: at(0, false, own_nodes), elements });
        }
        let middles: Vec<[f64; 3]> = table.chunks_exact(row).map(|face| centroid(face, directions)).collect();
        let mesh = Mesh::of_faces(path, directions, &middles, table.clone(), row)?;
        let elements = at(0, false, own_faces);
        if mesh.corners_in_file() == mesh.corners() {
            return Ok(Surface { meshes: vec![mesh], points: at(0, true, own_nodes), elements });
        }
        let meshes = vec![mesh, Mesh::of_nodes(path, directions, table, row)?];
        Ok(Surface { meshes, points: at(1, false, own_nodes), elements })
    }
}

/// The columns of elements of all ranks as faces of one mesh.
struct Faces {
    /// The nodes of each, with -1 after the last one.
    table: Vec<i32>,
    /// Length of a row of the table.
    row: usize,
    /// The first face of each rank, and the number of all.
    starts: Vec<usize>,
}

impl Faces {
    fn of(pieces: &[Piece], nodes: &Nodes) -> Result<Self> {
        let row = pieces.iter().flat_map(|piece| &piece.polygons).map(Vec::len).max().unwrap_or(0).max(3);
        let (mut table, mut starts) = (Vec::new(), vec![0]);
        let mut known: HashMap<Vec<i32>, [usize; 2]> = HashMap::new();
        for (rank, (piece, number)) in pieces.iter().zip(&nodes.number).enumerate() {
            for (i, polygon) in piece.polygons.iter().enumerate() {
                let start = table.len();
                table.extend(polygon.iter().map(|node| number[*node as usize] as i32));
                let mut key = table[start..].to_vec();
                key.sort_unstable();
                if let Some([other, of_rank]) = known.insert(key, [i, rank]) {
                    return Err(Error::grid(format!(
                        "the column of elements {i} of rank {rank} is also that of {other} of rank {of_rank}; expected each \
                         on one rank, without ghosts"
                    )));
                }
                table.resize(start + row, -1);
            }
            starts.push(table.len() / row);
        }
        Ok(Faces { table, row, starts })
    }
}

/// The columns of points of all ranks as nodes of one mesh.
struct Nodes {
    directions: DistinctPoints,
    /// The node of each column of each rank.
    number: Vec<Vec<usize>>,
    /// The lowest rank that has each node.
    owner: Vec<usize>,
}

impl Nodes {
    fn of(pieces: &[Piece]) -> Result<Self> {
        let mut nodes =
            Nodes { directions: DistinctPoints::new(tolerance(pieces)), number: Vec::new(), owner: Vec::new() };
        for (rank, piece) in pieces.iter().enumerate() {
            let first = nodes.owner.len();
            let mut number = Vec::with_capacity(piece.directions.len());
            for direction in &piece.directions {
                let node = nodes.directions.find_or_add(*direction);
                if node >= first && node < nodes.owner.len() {
                    let other = number.iter().position(|n| *n == node).unwrap_or(0);
                    return Err(Error::grid(format!(
                        "columns {other} and {} of rank {rank} are in one place: points are duplicated, expected shared ones",
                        number.len()
                    )));
                }
                nodes.owner.resize(nodes.directions.all.len(), rank);
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
                let [a, b] = [*a, b].map(|node| DVec3::from_array(piece.directions[node as usize]));
                shortest = shortest.min(a.distance(b));
            }
        }
    }
    let rounding = 1e-6_f64;
    if shortest.is_infinite() {
        return rounding;
    }
    rounding.max(1e-3 * shortest).min(0.25 * shortest).max(f64::MIN_POSITIVE)
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
    use icoray::{Grid, IcosahedralMesh};

    /// The triangles of an icosahedral mesh, over three ranks in turn.
    fn pieces(mesh: &IcosahedralMesh, ranks: usize, noise: f64) -> Vec<Piece> {
        let grid = Grid::new(mesh.tables()).unwrap();
        (0..ranks)
            .map(|rank| {
                let (mut local, mut piece) = (HashMap::new(), Piece { levels: 2, layers: 1, ..Piece::default() });
                for (_, triangle) in mesh.corner_cell.chunks_exact(3).enumerate().filter(|(i, _)| i % ranks == rank) {
                    let polygon = triangle.iter().map(|cell| {
                        *local.entry(*cell).or_insert_with(|| {
                            piece.directions.push(grid.directions()[*cell as usize].map(|x| x + noise * rank as f64));
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
                let [made] = &surface.meshes[..] else { panic!("one mesh") };
                assert_eq!((made.cells(), made.corners()), (mesh.cells(), mesh.corner_cell.len() / 3));
                assert_eq!(made.grid().unwrap().void_triangles(), 0);
                let elements = &surface.elements;
                assert!(elements.is_at_corners && elements.rows.is_owned.iter().all(|owned| *owned == 1));
                let rows = &surface.points.rows;
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
    fn elements_of_four_sides_have_a_mesh_of_elements_and_one_of_points() {
        // A hat on a box: at its brim two sides and two triangles meet.
        let ring = |z: f64| [[1.0, 0.0, z], [0.0, 1.0, z], [-1.0, 0.0, z], [0.0, -1.0, z]];
        let directions = [&ring(1.0)[..], &ring(-1.0), &[[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]].concat();
        let sides = (0..4u32).map(|k| vec![k, (k + 1) % 4, (k + 1) % 4 + 4, k + 4]);
        let fans = (0..8u32).map(|k| vec![k, (k + 1) % 4 + k / 4 * 4, 8 + k / 4]);
        let piece = Piece { levels: 2, layers: 1, directions, polygons: sides.chain(fans).collect() };
        let surface = Surface::of(&[piece], 0, "test").unwrap();
        assert!(surface.meshes.iter().all(|mesh| mesh.grid().unwrap().void_triangles() == 0));
        assert_eq!(surface.meshes.iter().map(Mesh::cells).collect::<Vec<_>>(), [12, 10]);
        let places = [&surface.elements, &surface.points].map(|at| (at.mesh, at.is_at_corners, at.rows.row.len()));
        assert_eq!(places, [(0, false, 12), (1, false, 10)]);
    }

    #[test]
    fn points_of_ranks_are_one_mesh_of_their_triangles() {
        let mesh = IcosahedralMesh::new(2).unwrap();
        let mut pieces = pieces(&mesh, 2, 0.0);
        pieces.iter_mut().for_each(|piece| piece.polygons.clear());
        let [first, second] = [0, 1].map(|rank| Surface::of(&pieces, rank, "test").unwrap());
        assert_eq!((first.meshes[0].cells(), first.meshes[0].corners()), (mesh.cells(), mesh.corner_cell.len() / 3));
        assert_eq!(first.points.rows, first.elements.rows);
        let owned = |surface: &Surface| surface.points.rows.is_owned.iter().sum::<i32>() as usize;
        assert_eq!(owned(&first) + owned(&second), mesh.cells());
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
