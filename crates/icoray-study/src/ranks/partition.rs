//! Domain decomposition as in a model: own cells, a halo one cell wide, local numbers.

use crate::renumber::{MISSING, morton, numbers, rows};
use icoray::{IcosahedralMesh, Owned, PartCells};
use icoray_reference::sphere::Sphere;
use icoray_test_support::Random;
use rayon::prelude::*;

/// The distribution of a picture's work over ranks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Sharing {
    /// By tiles, of data that all ranks have.
    Tiles,
    /// By data: compact patches of cells.
    Patches,
    /// By data: stretches of the cells in the order of the mesh.
    Rows,
    /// By data: each cell anywhere.
    Random,
}

/// The rank of each cell; ranks have equal numbers of cells, or one more.
fn owners(mesh: &IcosahedralMesh, sharing: Sharing, ranks: usize) -> Vec<usize> {
    let key = |cell: usize| match sharing {
        Sharing::Patches => morton(mesh.lon_center_rad[cell], mesh.lat_center_rad[cell]),
        Sharing::Tiles | Sharing::Rows => cell as u64,
        Sharing::Random => Random::at(cell).bits(),
    };
    let mut order: Vec<usize> = (0..mesh.cells()).collect();
    order.par_sort_by_cached_key(|cell| key(*cell));
    let mut owners = vec![0; order.len()];
    for (place, cell) in order.iter().enumerate() {
        owners[*cell] = place * ranks / order.len();
    }
    owners
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
    pub fn all(sphere: &Sphere, sharing: Sharing, ranks: usize) -> Vec<Self> {
        let owners = owners(&sphere.mesh, sharing, ranks);
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
