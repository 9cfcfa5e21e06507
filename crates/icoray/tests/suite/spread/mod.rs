//! Meshes that are spread over ranks, which are threads.
//!
//! The parent module has the modules `common` and `culled`.

#![allow(dead_code, reason = "each test takes what it needs of this")]

use super::common::on_nodes;
use super::culled::{Culled, Mark, Style, directions};
use glam::DVec3;
use icoray::{Decomposition, Grid, IcosahedralMesh, Owned, PartCells, Ranks};
use icoray_test_support::Random;

/// A mesh of which each cell has an owner.
pub struct Spread {
    pub parts: Vec<Culled>,
    /// Of each part, which cells are its own.
    pub owned: Vec<Vec<i32>>,
    /// Of each part, the number of each cell in the whole mesh, from 1.
    pub global: Vec<Vec<i64>>,
}

/// Owner of the cells of a hole.
pub const NO_OWNER: usize = usize::MAX;

impl Spread {
    /// Tables have different corners beside holes and different marks.
    pub fn new(mesh: &IcosahedralMesh, ranks: usize, owner: &[usize]) -> Self {
        Self::with_styles(mesh, ranks, owner, [Style::Corners, Style::Triangles])
    }

    /// All tables have all corners.
    pub fn with_corners(mesh: &IcosahedralMesh, ranks: usize, owner: &[usize]) -> Self {
        Self::with_styles(mesh, ranks, owner, [Style::Corners; 2])
    }

    fn with_styles(mesh: &IcosahedralMesh, ranks: usize, owner: &[usize], styles: [Style; 2]) -> Self {
        let part = |rank: usize| {
            let mut stays: Vec<bool> = owner.iter().map(|owner| *owner == rank).collect();
            for row in mesh.corner_cell.chunks_exact(3) {
                if row.iter().any(|cell| owner[*cell as usize] == rank) {
                    row.iter().for_each(|cell| stays[*cell as usize] |= owner[*cell as usize] != NO_OWNER);
                }
            }
            Culled::new(mesh, &stays, styles[rank % 2], [Mark::BeforeFirst, Mark::BehindLast][rank % 2], 1)
        };
        let parts: Vec<Culled> = (0..ranks).map(part).collect();
        let owned = parts.iter().enumerate();
        let owned = owned.map(|(rank, p)| p.cells.iter().map(|c| i32::from(owner[*c] == rank)).collect());
        let global = parts.iter().map(|p| p.cells.iter().map(|c| *c as i64 + 1).collect());
        Spread { owned: owned.collect(), global: global.collect(), parts }
    }

    /// What `work` makes of each rank's grid and of what it holds, on nodes.
    pub fn on_nodes<R: Send>(
        &self,
        node_of: &[usize],
        work: impl Fn(&mut Ranks, &Culled, &Grid, Result<Decomposition, icoray::Error>) -> R + Sync,
    ) -> Vec<R> {
        on_nodes(node_of, |ranks| {
            let rank = ranks.rank();
            let culled = &self.parts[rank];
            let grid = culled.grid();
            let cells =
                PartCells { global: self.global[rank].as_slice().into(), owned: Owned::Marked(&self.owned[rank]) };
            let decomposition = Decomposition::new(ranks, &grid, &cells);
            work(ranks, culled, &grid, decomposition)
        })
    }

    /// As [`Self::on_nodes`], where each rank is a node of its own.
    pub fn each<R: Send>(
        &self,
        work: impl Fn(&mut Ranks, &Culled, &Grid, Result<Decomposition, icoray::Error>) -> R + Sync,
    ) -> Vec<R> {
        let node_of: Vec<usize> = (0..self.parts.len()).collect();
        self.on_nodes(&node_of, work)
    }
}

/// `owner`, with [`NO_OWNER`] for cells that do not stay.
pub fn without_holes(mut owner: Vec<usize>, stays: &[bool]) -> Vec<usize> {
    owner.iter_mut().zip(stays).filter(|(_, stays)| !**stays).for_each(|(owner, _)| *owner = NO_OWNER);
    owner
}

/// Partitions with their names: who owns each cell.
pub fn partitions(mesh: &IcosahedralMesh, ranks: usize) -> Vec<(&'static str, Vec<usize>)> {
    let at = directions(&mesh.lon_center_rad, &mesh.lat_center_rad);
    // Patches around some places, as graph partitioners make them.
    let seeds: Vec<DVec3> = (0..ranks).map(|rank| at[Random::at(rank).below(at.len())]).collect();
    let nearest = |p: &DVec3| {
        let closer = |a: &usize, b: &usize| seeds[*a].dot(*p).total_cmp(&seeds[*b].dot(*p));
        (0..ranks).max_by(closer).unwrap()
    };
    let single = |cell: usize| if cell == 77 { ranks - 1 } else { cell % (ranks - 1).max(1) / 2 };
    let count = at.len();
    vec![
        ("contiguous rows", (0..count).map(|cell| cell * ranks / count).collect()),
        ("patches", at.iter().map(nearest).collect()),
        ("random cells", (0..count).map(|cell| Random::at(cell).below(ranks)).collect()),
        ("a single cell", (0..count).map(single).collect()),
    ]
}
