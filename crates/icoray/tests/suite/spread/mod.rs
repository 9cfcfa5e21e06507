//! Meshes that are spread over ranks, which are threads.
//!
//! The parent module has the modules `common` and `culled`.

#![allow(dead_code, reason = "each test takes what it needs of this")]

use super::common::{Array, Arrays, fields, on_nodes, picture};
use super::culled::{Culled, Mark, Style, directions};
use glam::DVec3;
use icoray::{
    Decomposition, DistributedGrid, Frame, FrameReport, Grid, IcosahedralMesh, Layers, Location, Owned, PartCells,
    PartCorners, Ranks, Rendered, Renderer, Result, Scene, Shape,
};
use icoray_test_support::Random;

/// Cells or corners of a rank, and what it says of them.
#[derive(Debug, Clone, Default)]
pub struct Rows {
    /// The number of each in the whole mesh.
    pub rows: Vec<usize>,
    /// The number that the rank gives it.
    pub global: Vec<i64>,
    /// Whether it is the rank's own.
    pub owned: Vec<i32>,
}

impl Rows {
    pub fn new(rows: Vec<usize>, number: impl Fn(usize) -> i64, owns: impl Fn(usize) -> bool) -> Self {
        let global = rows.iter().map(|row| number(*row)).collect();
        let owned = rows.iter().map(|row| i32::from(owns(*row))).collect();
        Rows { rows, global, owned }
    }

    /// Own rows, numbered from 0.
    pub fn own(rows: Vec<usize>) -> Self {
        Self::new(rows, |row| row as i64, |_| true)
    }

    pub fn all(count: usize) -> Self {
        Self::own((0..count).collect())
    }

    pub fn cells(&self) -> PartCells<'_> {
        PartCells { global: self.global.as_slice().into(), owned: Owned::Marked(&self.owned) }
    }

    pub fn corners(&self) -> PartCorners<'_> {
        PartCorners { global: self.global.as_slice().into(), owned: Owned::Marked(&self.owned) }
    }

    /// A field of these rows: `value` of own rows and a layer, and `other` of a layer elsewhere, which must not be read.
    pub fn array(
        &self,
        layout: impl Fn(usize) -> Shape,
        (is_wide, location, fill): (bool, Location, Option<f64>),
        value: impl Fn(usize, usize) -> f64,
        other: fn(usize) -> f64,
    ) -> Array {
        Array::new(layout(self.rows.len()), is_wide, location, fill, |at, layer| match self.owned[at] {
            0 => other(layer),
            _ => value(self.rows[at], layer),
        })
    }
}

/// A mesh of which each cell has an owner.
pub struct Spread {
    pub parts: Vec<Culled>,
    /// The cells of each part, numbered from 1.
    pub cells: Vec<Rows>,
    /// The corners of each part; the owner of the first cell of a row has the values there.
    pub corners: Vec<Rows>,
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
        let number = |row: usize| row as i64 + 1;
        let rows = |(rank, part): (usize, &Culled)| {
            let cells = Rows::new(part.cells.clone(), number, |cell| owner[cell] == rank);
            (cells, Rows::new(part.corners.clone(), number, |corner| owner_of_corner(mesh, owner, corner) == rank))
        };
        let (cells, corners) = parts.iter().enumerate().map(rows).unzip();
        Spread { parts, cells, corners }
    }

    /// What `work` makes of each rank's grid and of what it holds, on nodes.
    pub fn on_nodes<R: Send>(
        &self,
        node_of: &[usize],
        work: impl Fn(&mut Ranks, &Culled, &Grid, Result<Decomposition>) -> R + Sync,
    ) -> Vec<R> {
        on_nodes(node_of, |ranks| {
            let rank = ranks.rank();
            let culled = &self.parts[rank];
            let grid = culled.grid();
            let decomposition = Decomposition::new(ranks, &grid, &self.cells[rank].cells());
            work(ranks, culled, &grid, decomposition)
        })
    }

    /// As [`Self::on_nodes`], where each rank is a node of its own.
    pub fn each<R: Send>(
        &self,
        work: impl Fn(&mut Ranks, &Culled, &Grid, Result<Decomposition>) -> R + Sync,
    ) -> Vec<R> {
        let node_of: Vec<usize> = (0..self.parts.len()).collect();
        self.on_nodes(&node_of, work)
    }

    /// What ranks on nodes make of their arrays, on one thread each: the last of the frames of some steps.
    pub fn render(
        &self,
        node_of: &[usize],
        scene: &Scene,
        layers: &Layers,
        steps: impl Fn(usize) -> Vec<Arrays> + Sync,
    ) -> Vec<Result<Rendered>> {
        self.on_nodes(node_of, |ranks, _, grid, decomposition| {
            let (renderer, decomposition) = (Renderer::new(1)?, decomposition.unwrap());
            let data = DistributedGrid { grid, decomposition: Some(&decomposition), layers };
            let frames = steps(ranks.rank()).into_iter();
            let frames = frames.map(|arrays| renderer.render_decomposed(ranks, scene, data, fields(&arrays)));
            frames.last().expect("at least one step")
        })
    }

    /// As [`Self::render`], the picture and the reports of all ranks.
    pub fn draw(
        &self,
        node_of: &[usize],
        scene: &Scene,
        layers: &Layers,
        steps: impl Fn(usize) -> Vec<Arrays> + Sync,
    ) -> (Frame, Vec<FrameReport>) {
        picture(self.render(node_of, scene, layers, steps).into_iter().map(Result::unwrap).collect())
    }
}

/// The owner of the first cell of a corner's row that has one.
pub fn owner_of_corner(mesh: &IcosahedralMesh, owner: &[usize], corner: usize) -> usize {
    let row = &mesh.corner_cell[3 * corner..][..3];
    row.iter().map(|cell| owner[*cell as usize]).find(|owner| *owner != NO_OWNER).unwrap_or(NO_OWNER)
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
