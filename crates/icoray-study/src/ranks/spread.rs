//! A mesh that is spread over ranks, as a model spreads it: own cells, a halo one cell wide, local numbers.

use crate::look::direction;
use crate::sphere::Sphere;
use icoray::{Field, Grid, GridTables, IcosahedralMesh, Location, LonLat, Owned, PartCells, Result, Shape};
use rayon::prelude::*;

/// In place of the number of what a rank has not.
const MISSING: i32 = -1;

/// How cells are dealt to ranks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Partition {
    /// Stretches of a space-filling (Morton) order: compact patches.
    Patches,
    /// Stretches of the mesh's own order.
    Rows,
    /// Each cell anywhere.
    Random,
}

impl Partition {
    /// The rank of each cell; all have as many, but for one.
    pub fn owners(self, mesh: &IcosahedralMesh, ranks: usize) -> Vec<usize> {
        let key = |cell: usize| match self {
            Partition::Patches => morton(mesh.lon_center_rad[cell], mesh.lat_center_rad[cell]),
            Partition::Rows => cell as u64,
            Partition::Random => mixed(cell as u64),
        };
        let mut order: Vec<usize> = (0..mesh.cells()).collect();
        order.par_sort_by_cached_key(|cell| key(*cell));
        let mut owners = vec![0; order.len()];
        for (place, cell) in order.iter().enumerate() {
            owners[*cell] = place * ranks / order.len();
        }
        owners
    }
}

/// A direction's place in the Morton order of the cube around the sphere, 2^16 to a side.
fn morton(lon_rad: f64, lat_rad: f64) -> u64 {
    let at = direction(lon_rad, lat_rad).to_array().map(|x| ((x + 1.0) * 32767.5) as u64);
    let bits = (0..48).map(|bit| (at[bit % 3] >> (bit / 3) & 1) << bit);
    bits.sum()
}

/// A number without order (SplitMix64).
fn mixed(n: u64) -> u64 {
    let z = (n + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// What one rank has of a sphere.
#[derive(Debug)]
pub(super) struct Local {
    /// The whole mesh's numbers: own cells, then the halo.
    global: Vec<i32>,
    own: usize,
    /// Longitude and latitude of cells, then of corners.
    lon_lat: [Vec<f64>; 4],
    cell_corner: Vec<i32>,
    corner_cell: Vec<i32>,
    corner_edge: Vec<i32>,
    edge_corner: Vec<i32>,
    /// Level-fastest.
    values: Vec<f32>,
}

impl Local {
    /// The parts of all ranks.
    pub fn all(sphere: &Sphere, partition: Partition, ranks: usize) -> Vec<Self> {
        let owners = partition.owners(&sphere.mesh, ranks);
        (0..ranks).into_par_iter().map(|rank| Self::new(sphere, &owners, rank)).collect()
    }

    fn new(sphere: &Sphere, owners: &[usize], rank: usize) -> Self {
        let mesh = &sphere.mesh;
        let mut global: Vec<usize> = (0..mesh.cells()).filter(|&cell| owners[cell] == rank).collect();
        let own = global.len();
        let mut is_local: Vec<bool> = owners.iter().map(|owner| *owner == rank).collect();
        for row in mesh.corner_cell.as_chunks::<3>().0 {
            if row.iter().any(|&cell| owners[cell as usize] == rank) {
                for cell in row.map(|cell| cell as usize) {
                    if !std::mem::replace(&mut is_local[cell], true) {
                        global.push(cell);
                    }
                }
            }
        }
        let cell = numbers(&global, mesh.cells());
        let is_whole = |row: &[i32; 3]| row.iter().all(|&c| is_local[c as usize]);
        let corners = kept(mesh.corner_cell.as_chunks().0, is_whole);
        let corner = numbers(&corners, mesh.corner_cell.len() / 3);
        let is_side = |row: &[i32; 2]| row.iter().any(|&c| corner[c as usize] != MISSING);
        let edges = kept(mesh.edge_corner.as_chunks().0, is_side);
        let edge = numbers(&edges, mesh.edge_corner.len() / 2);
        let layers = sphere.layers.count();
        Local {
            own,
            lon_lat: [
                rows(&mesh.lon_center_rad, 1, &global).collect(),
                rows(&mesh.lat_center_rad, 1, &global).collect(),
                rows(&mesh.lon_corner_rad, 1, &corners).collect(),
                rows(&mesh.lat_corner_rad, 1, &corners).collect(),
            ],
            cell_corner: rows(&mesh.cell_corner, 6, &global).map(|c| corner[c as usize]).collect(),
            corner_cell: rows(&mesh.corner_cell, 3, &corners).map(|c| cell[c as usize]).collect(),
            corner_edge: rows(&mesh.corner_edge, 3, &corners).map(|e| edge[e as usize]).collect(),
            edge_corner: rows(&mesh.edge_corner, 2, &edges).map(|c| corner[c as usize]).collect(),
            values: rows(&sphere.values, layers, &global).collect(),
            global: global.into_iter().map(|cell| cell as i32).collect(),
        }
    }

    pub fn grid(&self) -> Result<Grid<'_>> {
        let [lon, lat, corner_lon, corner_lat] = self.lon_lat.each_ref().map(|all| all.as_slice().into());
        Grid::new(GridTables {
            index_base: 0,
            center: LonLat { lon_rad: lon, lat_rad: lat },
            corner: LonLat { lon_rad: corner_lon, lat_rad: corner_lat },
            cell_corner: self.cell_corner.as_slice().into(),
            cell_corner_row: 6,
            cell_corner_count: None,
            corner_cell: self.corner_cell.as_slice().into(),
            corner_edge: self.corner_edge.as_slice().into(),
            edge_corner: self.edge_corner.as_slice().into(),
        })
    }

    pub fn cells(&self) -> PartCells<'_> {
        PartCells { global: self.global.as_slice().into(), owned: Owned::First(self.own) }
    }

    pub fn field(&self) -> Result<Field<'_>> {
        let layers = self.values.len() / self.global.len().max(1);
        let shape = Shape::level_fastest(self.global.len(), layers);
        Field::new(self.values.as_slice().into(), shape, Location::Center, None)
    }
}

/// The rows that are kept.
fn kept<const N: usize>(table: &[[i32; N]], stays: impl Fn(&[i32; N]) -> bool) -> Vec<usize> {
    (0..table.len()).filter(|&row| stays(&table[row])).collect()
}

/// The place of each of `count` rows among those that are kept.
fn numbers(kept: &[usize], count: usize) -> Vec<i32> {
    let mut numbers = vec![MISSING; count];
    (0..).zip(kept).for_each(|(number, &row)| numbers[row] = number);
    numbers
}

/// The entries of rows of `width`.
fn rows<'a, V: Copy>(table: &'a [V], width: usize, kept: &'a [usize]) -> impl Iterator<Item = V> + 'a {
    kept.iter().flat_map(move |&row| table[row * width..(row + 1) * width].iter().copied())
}
