//! Domain decomposition as in a model: own cells, a halo one cell wide, local numbers.

use crate::shading::direction;
use crate::sphere::Sphere;
use icoray::{IcosahedralMesh, Owned, PartCells};
use rayon::prelude::*;

/// Marks entries that a rank does not have.
const MISSING: i32 = -1;

/// Assignment of cells to ranks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Partition {
    /// Segments of the Morton order: compact patches.
    Patches,
    /// Segments of the mesh's own order.
    Rows,
    /// Random ranks.
    Random,
}

impl Partition {
    /// The rank of each cell; ranks have equal numbers of cells, or one more.
    pub fn owners(self, mesh: &IcosahedralMesh, ranks: usize) -> Vec<usize> {
        let key = |cell: usize| match self {
            Partition::Patches => morton(mesh.lon_center_rad[cell], mesh.lat_center_rad[cell]),
            Partition::Rows => cell as u64,
            Partition::Random => split_mix_64(cell as u64),
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

/// Morton code of a direction in the cube around the sphere, with 16 bits per axis.
fn morton(lon_rad: f64, lat_rad: f64) -> u64 {
    let at = direction(lon_rad, lat_rad).to_array().map(|x| ((x + 1.0) * 32767.5) as u64);
    let bits = (0..48).map(|bit| (at[bit % 3] >> (bit / 3) & 1) << bit);
    bits.sum()
}

/// SplitMix64 hash.
fn split_mix_64(n: u64) -> u64 {
    let z = (n + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// One rank's part of a sphere.
#[derive(Debug)]
pub(super) struct MeshPart {
    /// Global numbers: own cells, then the halo.
    global: Vec<i32>,
    own: usize,
    /// Tables in local numbers, [`MISSING`] where another rank has the entry, and the values.
    pub sphere: Sphere,
}

impl MeshPart {
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
        let local = IcosahedralMesh {
            lon_center_rad: rows(&mesh.lon_center_rad, 1, &global).collect(),
            lat_center_rad: rows(&mesh.lat_center_rad, 1, &global).collect(),
            lon_corner_rad: rows(&mesh.lon_corner_rad, 1, &corners).collect(),
            lat_corner_rad: rows(&mesh.lat_corner_rad, 1, &corners).collect(),
            cell_corner: rows(&mesh.cell_corner, 6, &global).map(|c| corner[c as usize]).collect(),
            corner_cell: rows(&mesh.corner_cell, 3, &corners).map(|c| cell[c as usize]).collect(),
            corner_edge: rows(&mesh.corner_edge, 3, &corners).map(|e| edge[e as usize]).collect(),
            edge_corner: rows(&mesh.edge_corner, 2, &edges).map(|c| corner[c as usize]).collect(),
        };
        let values = rows(&sphere.values, sphere.layers.count(), &global).collect();
        let sphere = Sphere { mesh: local, layers: sphere.layers.clone(), values };
        MeshPart { own, sphere, global: global.into_iter().map(|cell| cell as i32).collect() }
    }

    pub fn cells(&self) -> PartCells<'_> {
        PartCells { global: self.global.as_slice().into(), owned: Owned::First(self.own) }
    }
}

/// Numbers of the rows that `stays` selects.
fn kept<const N: usize>(table: &[[i32; N]], stays: impl Fn(&[i32; N]) -> bool) -> Vec<usize> {
    (0..table.len()).filter(|&row| stays(&table[row])).collect()
}

/// For each of `count` rows its position in `kept`.
fn numbers(kept: &[usize], count: usize) -> Vec<i32> {
    let mut numbers = vec![MISSING; count];
    (0..).zip(kept).for_each(|(number, &row)| numbers[row] = number);
    numbers
}

/// The entries of rows of `width`.
fn rows<'a, V: Copy>(table: &'a [V], width: usize, kept: &'a [usize]) -> impl Iterator<Item = V> + 'a {
    kept.iter().flat_map(move |&row| table[row * width..(row + 1) * width].iter().copied())
}
