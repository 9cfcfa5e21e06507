//! Domain decomposition as in a model: own cells, a halo one cell wide, local numbers.

use icoray::{IcosahedralMesh, Owned, PartCells};
use icoray_reference::culled::{Culled, Mark, Style};
use icoray_reference::shading::direction;
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

/// Morton code of a direction in the cube around the sphere, with 16 bits per axis.
pub(crate) fn morton(lon_rad: f64, lat_rad: f64) -> u64 {
    let at = direction(lon_rad, lat_rad).to_array().map(|x| ((x + 1.0) * 32767.5) as u64);
    let bits = (0..48).map(|bit| (at[bit % 3] >> (bit / 3) & 1) << bit);
    bits.sum()
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

/// One rank's part of a sphere: its own cells and a halo one cell wide.
pub(super) struct MeshPart {
    /// Tables in local numbers.
    pub tables: Culled,
    /// Number of each cell in the whole mesh.
    global: Vec<i32>,
    owned: Vec<i32>,
    /// The field, level-fastest.
    pub values: Vec<f32>,
}

impl MeshPart {
    pub fn all(sphere: &Sphere, sharing: Sharing, ranks: usize) -> Vec<Self> {
        let owners = owners(&sphere.mesh, sharing, ranks);
        (0..ranks).into_par_iter().map(|rank| Self::new(sphere, &owners, rank)).collect()
    }

    fn new(sphere: &Sphere, owners: &[usize], rank: usize) -> Self {
        let mut is_here: Vec<bool> = owners.iter().map(|owner| *owner == rank).collect();
        for row in sphere.mesh.corner_cell.as_chunks::<3>().0 {
            if row.iter().any(|&cell| owners[cell as usize] == rank) {
                row.iter().for_each(|&cell| is_here[cell as usize] = true);
            }
        }
        let columns = sphere.values.chunks_exact(sphere.layers.count()).zip(&is_here).filter(|(_, is_here)| **is_here);
        let tables = Culled::new(&sphere.mesh, &is_here, Style::Triangles, Mark::MinusOne, 0);
        MeshPart {
            global: tables.cells.iter().map(|cell| *cell as i32).collect(),
            owned: tables.cells.iter().map(|cell| i32::from(owners[*cell] == rank)).collect(),
            values: columns.flat_map(|(column, _)| column).copied().collect(),
            tables,
        }
    }

    pub fn cells(&self) -> PartCells<'_> {
        PartCells { global: self.global.as_slice().into(), owned: Owned::Marked(&self.owned) }
    }
}
