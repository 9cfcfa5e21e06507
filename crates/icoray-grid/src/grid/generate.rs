//! The icosahedral mesh: an icosahedron whose triangles are bisected n times (§1.1 of the paper, Figure 1).
//!
//! Each bisection numbers the new cells, edges and triangles by formula (new cell = cells + edge, children of triangle
//! t = 4t..4t+4, of edge e = 2e, 2e+1, inner edges = 2·edges + 3t..), so every pass is parallel over rows and the
//! result does not depend on the number of threads. n gives 10·4ⁿ + 2 cells; n = 5 and n = 8 are the paper's grids.

use super::tables::{GridTables, LonLat};
use crate::error::{Error, ErrorKind, Result};
use crate::memory;
use bytemuck::allocation::cast_vec;
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// The largest `level` of [`IcosahedralMesh::new`]: 167,772,162 cells, whose edges still fit 32-bit indices.
pub const MAX_LEVEL: u32 = 12;

/// Bytes per cell that [`IcosahedralMesh::new`] takes: 144 of the tables, and 24 of a position.
const PEAK_BYTES: u64 = 168;

/// A generated mesh that owns its six tables, numbered from 0.
///
/// ```
/// use icoray_grid::IcosahedralMesh;
///
/// let mesh = IcosahedralMesh::new(4)?;
/// assert_eq!(mesh.cells(), 10 * 4usize.pow(4) + 2);
/// // Three cells around each corner.
/// assert_eq!(mesh.corner_cell.len(), 3 * mesh.lon_corner_rad.len());
/// # Ok::<(), icoray_grid::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct IcosahedralMesh {
    /// Longitude of each cell centre, radians in [0, 2π).
    pub lon_center_rad: Vec<f64>,
    /// Latitude of each cell centre, radians.
    pub lat_center_rad: Vec<f64>,
    /// Longitude of each corner (the triangle's circumcentre), radians in [0, 2π).
    pub lon_corner_rad: Vec<f64>,
    /// Latitude of each corner, radians.
    pub lat_corner_rad: Vec<f64>,
    /// Six corners per cell, counter-clockwise; a pentagon repeats its last one.
    pub cell_corner: Vec<i32>,
    /// Three cells per corner, counter-clockwise.
    pub corner_cell: Vec<i32>,
    /// Three edges per corner; column k lies opposite column k of `corner_cell`.
    pub corner_edge: Vec<i32>,
    /// Two corners per edge.
    pub edge_corner: Vec<i32>,
}

struct Bisection {
    position: Vec<DVec3>,
    edge: Vec<[u32; 2]>,
    triangle: Vec<[u32; 3]>,
    side: Vec<[u32; 3]>,
}

impl IcosahedralMesh {
    /// Bisects the icosahedron `level` times.
    ///
    /// # Errors
    /// [`ErrorKind::Argument`] when `level` is above [`MAX_LEVEL`]; [`ErrorKind::Memory`] if the tables do not fit.
    pub fn new(level: u32) -> Result<Self> {
        if level > MAX_LEVEL {
            return Err(Error::new(ErrorKind::Argument, format!("mesh level {level}, expected 0 to {MAX_LEVEL}")));
        }
        memory::require("a generated mesh", PEAK_BYTES * (10 * 4u64.pow(level) + 2), None)?;
        let mut mesh = icosahedron();
        for _ in 0..level {
            mesh = mesh.bisect();
        }
        Ok(mesh.into_tables())
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.lon_center_rad.len()
    }

    /// The tables, borrowed.
    pub fn tables(&self) -> GridTables<'_> {
        GridTables {
            index_base: 0,
            center: LonLat::of(&self.lon_center_rad, &self.lat_center_rad),
            corner: LonLat::of(&self.lon_corner_rad, &self.lat_corner_rad),
            cell_corner: self.cell_corner.as_slice().into(),
            cell_corner_row: 6,
            cell_corner_count: None,
            corner_cell: self.corner_cell.as_slice().into(),
            corner_edge: self.corner_edge.as_slice().into(),
            edge_corner: self.edge_corner.as_slice().into(),
        }
    }
}

/// The icosahedron with cells on both poles: 12 cells, 30 edges, 20 triangles wound counter-clockwise from outside.
fn icosahedron() -> Bisection {
    let mut position = vec![DVec3::Z];
    for (ring, lat) in [(0, 0.5f64.atan()), (1, -0.5f64.atan())] {
        for k in 0..5 {
            let lon = (f64::from(k) + 0.5 * f64::from(ring)) * TAU / 5.0;
            position.push(DVec3::new(lat.cos() * lon.cos(), lat.cos() * lon.sin(), lat.sin()));
        }
    }
    position.push(DVec3::NEG_Z);
    let mut triangle = Vec::new();
    for k in 0..5u32 {
        let next = (k + 1) % 5;
        let (upper, upper_next, lower, lower_next) = (1 + k, 1 + next, 6 + k, 6 + next);
        triangle.push([0, upper, upper_next]);
        triangle.push([upper, lower, upper_next]);
        triangle.push([lower, lower_next, upper_next]);
        triangle.push([11, lower_next, lower]);
    }
    let mut edge: Vec<[u32; 2]> = Vec::new();
    let side = triangle
        .iter()
        .map(|v: &[u32; 3]| {
            [0, 1, 2].map(|k| {
                let (a, b) = (v[(k + 1) % 3], v[(k + 2) % 3]);
                let key = [a.min(b), a.max(b)];
                let known = edge.iter().position(|e| *e == key);
                known.unwrap_or_else(|| {
                    edge.push(key);
                    edge.len() - 1
                }) as u32
            })
        })
        .collect();
    Bisection { position, edge, triangle, side }
}

impl Bisection {
    fn bisect(self) -> Self {
        let cells = self.position.len() as u32;
        let edges = self.edge.len() as u32;
        let midpoint = self.edge.par_iter().map(|&[a, b]| {
            let sum = self.position[a as usize] + self.position[b as usize];
            sum.normalize()
        });
        let position = self.position.par_iter().copied().chain(midpoint).collect();
        let mut edge = vec![[0; 2]; 2 * self.edge.len() + 3 * self.triangle.len()];
        let (halves, inner) = edge.split_at_mut(2 * self.edge.len());
        halves.par_chunks_exact_mut(2).zip(&self.edge).enumerate().for_each(|(e, (half, &[a, b]))| {
            let middle = cells + e as u32;
            half.copy_from_slice(&[[a, middle], [b, middle]]);
        });
        inner.par_chunks_exact_mut(3).zip(&self.side).for_each(|(row, side)| {
            for k in 0..3 {
                row[k] = [cells + side[(k + 1) % 3], cells + side[(k + 2) % 3]];
            }
        });
        let half_at = |e: u32, cell: u32| 2 * e + u32::from(self.edge[e as usize][0] != cell);
        let mut triangle = vec![[0; 3]; 4 * self.triangle.len()];
        let mut side = vec![[0; 3]; 4 * self.triangle.len()];
        let parents = self.triangle.par_iter().zip(&self.side).enumerate();
        triangle.par_chunks_exact_mut(4).zip(side.par_chunks_exact_mut(4)).zip(parents).for_each(
            |((child, child_side), (t, (v, s)))| {
                // Opposite vertex k lies side s[k], whose middle is m[k]; inner edge k cuts off vertex k.
                let m = s.map(|e| cells + e);
                let inner = [0, 1, 2].map(|k| 2 * edges + 3 * t as u32 + k);
                for k in 0..3 {
                    let (next, last) = ((k + 1) % 3, (k + 2) % 3);
                    child[k] = [v[k], m[last], m[next]];
                    child_side[k] = [inner[k], half_at(s[next], v[k]), half_at(s[last], v[k])];
                }
                child[3] = m;
                child_side[3] = inner;
            },
        );
        Bisection { position, edge, triangle, side }
    }

    /// Makes the tables; beside them only the positions of the cells are in memory.
    fn into_tables(self) -> IcosahedralMesh {
        let Bisection { position, edge, triangle, side } = self;
        let edges = edge.len();
        drop(edge);
        let [corner_cell, corner_edge] = [triangle, side].map(|rows| cast_vec(rows.into_flattened()));
        let edge_corner = edge_corner(&corner_edge, edges);
        let cell_corner = cell_corner(&corner_cell, &corner_edge, &edge_corner, position.len());
        let corner = |row: &[i32]| {
            let [a, b, c] = [0, 1, 2].map(|k| position[row[k] as usize]);
            lon_lat((b - a).cross(c - a).normalize())
        };
        let (lon_corner_rad, lat_corner_rad) = corner_cell.par_chunks_exact(3).map(corner).unzip();
        let (lon_center_rad, lat_center_rad) = position.par_iter().copied().map(lon_lat).unzip();
        IcosahedralMesh {
            lon_center_rad,
            lat_center_rad,
            lon_corner_rad,
            lat_corner_rad,
            cell_corner,
            corner_cell,
            corner_edge,
            edge_corner,
        }
    }
}
/// The two corners of each edge, the lower number first.
fn edge_corner(corner_edge: &[i32], edges: usize) -> Vec<i32> {
    let mut edge_corner = vec![-1; 2 * edges];
    for (corner, sides) in corner_edge.chunks_exact(3).enumerate() {
        for &edge in sides {
            let first = 2 * edge as usize;
            let free = if edge_corner[first] < 0 { first } else { first + 1 };
            edge_corner[free] = corner as i32;
        }
    }
    edge_corner
}

/// The corners of each cell.
fn cell_corner(corner_cell: &[i32], corner_edge: &[i32], edge_corner: &[i32], cells: usize) -> Vec<i32> {
    let mut a_corner = vec![0; cells];
    for (corner, row) in corner_cell.chunks_exact(3).enumerate() {
        for &cell in row {
            a_corner[cell as usize] = corner as i32;
        }
    }
    let mut rings = vec![0; 6 * cells];
    rings.par_chunks_exact_mut(6).zip(a_corner).enumerate().for_each(|(cell, (place, start))| {
        place.copy_from_slice(&ring(cell as i32, start, corner_cell, corner_edge, edge_corner));
    });
    rings
}

/// The corners around `cell`, counter-clockwise from `start`; a pentagon's last one is repeated.
fn ring(cell: i32, start: i32, corner_cell: &[i32], corner_edge: &[i32], edge_corner: &[i32]) -> [i32; 6] {
    let mut ring = [start; 6];
    let mut corner = start;
    for place in 1..6 {
        let row = 3 * corner as usize;
        let k = (0..3).find(|&k| corner_cell[row + k] == cell).expect("the ring stays at its cell");
        let ends = 2 * corner_edge[row + (k + 1) % 3] as usize;
        let next = if edge_corner[ends] == corner { edge_corner[ends + 1] } else { edge_corner[ends] };
        if next == start {
            ring[place] = ring[place - 1];
            break;
        }
        ring[place] = next;
        corner = next;
    }
    ring
}

/// The grid of an icosahedral mesh, whose tables are never freed.
#[cfg(test)]
pub(crate) fn icosahedral_grid(level: u32) -> super::Grid<'static> {
    let mesh = Box::leak(Box::new(IcosahedralMesh::new(level).unwrap()));
    super::Grid::new(mesh.tables()).unwrap()
}

/// Longitude in [0, 2π) and latitude.
fn lon_lat(p: DVec3) -> (f64, f64) {
    let lon = p.y.atan2(p.x);
    // Adding 2π to a tiny negative longitude rounds to 2π itself, which is 0.
    let lon = if lon < 0.0 { lon + TAU } else { lon };
    (if lon < TAU { lon } else { 0.0 }, p.z.atan2(p.x.hypot(p.y)).clamp(-PI / 2.0, PI / 2.0))
}
