//! A part of a grid for each node or rank: its own cells and triangles, and the ranks that have the others.
//!
//! A node has a grid of the cells that its ranks own and a halo; its ranks share the part: each of them has all of its
//! grid and fields, and they divide the work. Where a scene requests fragments and every rank has the whole grid, a
//! part is a range of its rows. A triangle belongs to the part with its cell of the lowest number: this partitions all
//! triangles, and with a halo one cell wide a part has all of each of its triangles.
//!
//! Gradients and averages of halo cells, whose neighbours a node may not have, come from their owners.

use super::mesh::NodeMesh;
use super::node_ranks::NodeRanks;
use super::{RankLists, Ranks};
use crate::device::OwnedColumns;
use bytemuck::Pod;
use icoray_grid::marks::Marks;
use icoray_grid::{CenterField, Error, ErrorKind, Grid, OwnedReals, Result};
use icoray_kernel::owned_region::OwnedRegion;
use std::f64::consts::PI;

/// Cells that ranks exchange.
type CellsOfRanks = RankLists<u32>;

/// A part of a grid, agreed on by all ranks.
#[derive(Debug, Clone)]
pub(crate) struct Part<'m> {
    owns_cell: Marks<'m>,
    region: OwnedRegion<'m>,
    /// For each rank, the own cells whose values it needs.
    sends: CellsOfRanks,
    /// For each rank, the halo cells whose values it sends, in the order of sending.
    receives: CellsOfRanks,
    covered: f64,
    cells: u64,
    /// The ranks that share this part.
    node: NodeRanks,
}

/// Marks of own cells, as `owns_cell` states them, and of own triangles.
pub(super) fn marks(grid: &Grid, owns_cell: impl Fn(usize) -> bool) -> [Marks<'static>; 2] {
    let cells = Marks::new((0..grid.cells()).map(owns_cell));
    let lowest = |triangle: u32| grid.triangle(triangle).into_iter().min().unwrap_or(0);
    let owns = |triangle: u32| grid.is_triangle(triangle) && cells.has(lowest(triangle) as usize);
    let triangles = Marks::new((0..grid.triangles() as u32).map(owns));
    [cells, triangles]
}

impl<'m> Part<'m> {
    /// The part that the ranks of a node share, with these [`marks`]. Collective.
    pub(super) fn of_node(ranks: &mut Ranks, mesh: &NodeMesh, marks: [Marks<'m>; 2], node: &NodeRanks) -> Result<Self> {
        let partners = node_partners(ranks, mesh, node)?;
        Part::of_mates(ranks, mesh.grid, marks, partners, node.clone())
    }

    /// The share of this rank in a grid that every rank has whole: a range of rows. Collective.
    ///
    /// # Errors
    /// [`ErrorKind::Mpi`] when the transport fails.
    pub fn of_whole(ranks: &mut Ranks, grid: &Grid) -> Result<Self> {
        let (rank, size) = (ranks.rank(), ranks.size());
        let marks = marks(grid, |cell| cell * size / grid.cells() == rank);
        // It has all that gradients and averages of halo cells are computed from.
        Part::of_mates(ranks, grid, marks, Default::default(), NodeRanks::alone(rank))
    }

    /// The part of `grid` with these marks of own cells and triangles, shared by `node`; `sends` and `receives` are the
    /// cells of its halo exchange. Collective.
    fn of_mates(
        ranks: &mut Ranks,
        grid: &Grid,
        [owns_cell, triangles]: [Marks<'m>; 2],
        (sends, receives): (CellsOfRanks, CellsOfRanks),
        node: NodeRanks,
    ) -> Result<Self> {
        let region = OwnedRegion::new(grid, triangles);
        let mut part = Part { region, owns_cell, sends, receives, covered: 0.0, cells: 0, node };
        // Each part counts once.
        let mine = if part.node.is_leader() { part.extent(grid) } else { (1.0, 0.0, 0) };
        let both = |a: (f64, f64, u64), b: (f64, f64, u64)| (a.0.min(b.0), a.1 + b.1, a.2 + b.2);
        let (lowest_facet, area, cells) = ranks.reduce_values(mine, both)?;
        part.region.lower_facet(lowest_facet);
        (part.covered, part.cells) = (area / (4.0 * PI), cells);
        Ok(part)
    }

    /// Number of own cells, summed over all ranks.
    pub fn cells(&self) -> u64 {
        self.cells
    }

    /// The fraction of the sphere that the triangles of all ranks cover: 1 if the mesh has no hole.
    pub fn covered(&self) -> f64 {
        self.covered
    }

    /// The ranks that share this part.
    pub fn node(&self) -> &NodeRanks {
        &self.node
    }

    /// Whether this rank counts a cell in sums over all ranks: exactly one rank counts each cell.
    pub fn counts(&self, cell: usize) -> bool {
        self.owns(cell) && self.node.has_share(cell)
    }

    /// Whether a cell is this part's own.
    pub fn owns(&self, cell: usize) -> bool {
        self.owns_cell.has(cell)
    }

    /// Whether a triangle is this part's own; false for numbers out of range.
    #[inline]
    pub fn has(&self, triangle: u32) -> bool {
        self.region.has(triangle)
    }

    /// Own triangles and their extent.
    pub fn region(&self) -> &OwnedRegion<'m> {
        &self.region
    }

    /// The part as a device reads it, for columns between the radii `inner` and `outer`.
    pub fn own(&self, inner: f64, outer: f64) -> OwnedColumns<'_> {
        let (middle, reach) = self.region.ball(inner, outer);
        OwnedColumns {
            triangles: self.region.triangles(),
            lowest_facet: self.region.lowest_facet(),
            middle: middle.to_array(),
            reach,
        }
    }

    /// Replaces the rows of halo cells next to own ones by those of their owners; `row_of` finds a cell's row.
    /// Collective.
    pub fn fill_halo<V: Pod>(
        &self,
        ranks: &mut Ranks,
        values: &mut [V],
        row_of: impl Fn(&mut [V], u32) -> &mut [V],
    ) -> Result<()> {
        let mut message = |cells: &Vec<u32>| {
            let mut bytes = Vec::new();
            cells.iter().for_each(|cell| bytes.extend_from_slice(bytemuck::cast_slice(row_of(values, *cell))));
            bytes
        };
        let messages = self.sends.iter().map(|(rank, cells)| (*rank, message(cells))).collect();
        let received = ranks.exchange(messages)?;
        let is_complete = self.receives.iter().all(|(rank, cells)| {
            let mut unread = received.get(rank).map_or(&[][..], Vec::as_slice);
            cells.iter().all(|cell| {
                let row: &mut [u8] = bytemuck::cast_slice_mut(row_of(values, *cell));
                let from = unread.split_off(..row.len());
                from.inspect(|from| row.copy_from_slice(from)).is_some()
            })
        });
        let cut = || Error::new(ErrorKind::Mpi, "values of halo cells are cut short");
        ranks.collective(is_complete.then_some(()).ok_or_else(cut))
    }

    /// Replaces averages of halo cells, some of whose corners are missing here, by those of their owners. Collective.
    pub fn fill_averages(&self, ranks: &mut Ranks, field: &mut CenterField) -> Result<()> {
        let layers = field.field().shape().layers;
        let row = |cell: u32| cell as usize * layers..(cell as usize + 1) * layers;
        match field.values_mut() {
            OwnedReals::F32(values) => self.fill_halo(ranks, values, |values, cell| &mut values[row(cell)]),
            OwnedReals::F64(values) => self.fill_halo(ranks, values, |values, cell| &mut values[row(cell)]),
        }
    }

    /// The lowest radius of own facets, the solid angle of own triangles and the number of own cells.
    fn extent(&self, grid: &Grid) -> (f64, f64, u64) {
        let cells = (0..grid.cells()).filter(|cell| self.owns(*cell)).count() as u64;
        let (mut lowest_facet, mut area) = (1.0f64, 0.0);
        for triangle in (0..grid.triangles() as u32).filter(|t| self.has(*t)) {
            let [a, b, c] = grid.triangle(triangle).map(|cell| grid.direction(cell));
            let normal = (b - a).cross(c - a);
            let volume = a.dot(normal).abs();
            lowest_facet = lowest_facet.min(volume / normal.length());
            area += 2.0 * volume.atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a));
        }
        (lowest_facet, area, cells)
    }
}

/// For each rank of another node, the own cells whose values it needs and the cells whose values it sends: each rank
/// exchanges with its partner on each other node. Collective.
fn node_partners(ranks: &mut Ranks, mesh: &NodeMesh, node: &NodeRanks) -> Result<(CellsOfRanks, CellsOfRanks)> {
    let (mut requests, mut receives) = (RankLists::new(), RankLists::new());
    let owners = mesh.owner.iter().map(|owner| *owner as usize);
    let partners = node.partners(ranks, &owners.clone().filter(|owner| !node.is_mate(*owner)).collect())?;
    for (row, owner) in (0u32..).zip(owners) {
        // This rank's own node has no partner.
        if let Some(partner) = partners.get(&owner) {
            requests.entry(*partner).or_default().push(mesh.grid.number(row as usize));
            receives.entry(*partner).or_default().push(row);
        }
    }
    let requests = ranks.exchange_lists(&requests)?;
    let row = |cell: u64| {
        mesh.row(cell).ok_or_else(|| Error::new(ErrorKind::Internal, format!("cell {cell} is not on this node")))
    };
    let rows = |(rank, cells): (usize, Vec<u64>)| Ok((rank, cells.into_iter().map(row).collect::<Result<_>>()?));
    Ok((ranks.collective_work(|| requests.into_iter().map(rows).collect())?, receives))
}
