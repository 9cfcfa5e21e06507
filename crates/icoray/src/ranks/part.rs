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
use super::{NodeMemory, RankLists, RankMessages, Ranks};
use crate::device::OwnedColumns;
use bytemuck::Pod;
use icoray_grid::marks::Marks;
use icoray_grid::{ComputedField, Error, ErrorKind, Grid, Location, OwnedReals, Result};
use icoray_kernel::owned_region::OwnedRegion;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Cells that ranks exchange.
type CellsOfRanks = RankLists<u32>;

/// Cells whose values a rank exchanges with those of other nodes.
#[derive(Debug, Clone, Default)]
struct HaloExchange {
    /// For each rank, the own cells whose values it needs.
    sends: CellsOfRanks,
    /// For each rank, the halo cells whose values it sends, in the order of sending.
    receives: CellsOfRanks,
}

/// A part of a grid, agreed on by all ranks.
#[derive(Debug, Clone)]
pub(crate) struct Part<'m> {
    owns_cell: Marks<'m>,
    region: OwnedRegion<'m>,
    /// The exchange of this rank's share of the node's halo cells, and that of the others.
    halo: [HaloExchange; 2],
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
        let halo = halo_exchanges(ranks, mesh, node)?;
        Part::of_mates(ranks, mesh.grid, marks, halo, node.clone())
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

    /// The part of `grid` with these marks of own cells and triangles, shared by `node`. Collective.
    fn of_mates(
        ranks: &mut Ranks,
        grid: &Grid,
        [owns_cell, triangles]: [Marks<'m>; 2],
        halo: [HaloExchange; 2],
        node: NodeRanks,
    ) -> Result<Self> {
        let region = OwnedRegion::new(grid, triangles);
        let mut part = Part { region, owns_cell, halo, covered: 0.0, cells: 0, node };
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

    /// Replaces the rows of halo cells by those of their owners; each cell has a row of `layers` values. Collective.
    pub fn fill_halo<V: Pod>(&self, ranks: &mut Ranks, values: &mut [V], layers: usize) -> Result<()> {
        let (rows, width): (&mut [u8], _) = (bytemuck::cast_slice_mut(values), layers * size_of::<V>());
        let received = exchange_rows(ranks, &self.halo, rows, width)?;
        let read = read_rows(&self.halo, &received, width, |at, row| rows[at..at + width].copy_from_slice(row));
        ranks.collective(read)
    }

    /// As [`Self::fill_halo`], for rows of `width` bytes at offset `start` of memory that the ranks of the node share.
    pub fn fill_shared_halo(
        &self,
        ranks: &mut Ranks,
        memory: &mut NodeMemory,
        (start, width): (usize, usize),
    ) -> Result<()> {
        let halo = &self.halo[..1];
        let received = exchange_rows(ranks, halo, &memory.bytes()[start..], width)?;
        memory.write(ranks, |put| read_rows(halo, &received, width, |at, row| put(start + at, row)))
    }

    /// Replaces averages of halo cells, some of whose corners are missing here, by those of their owners. Collective.
    pub fn fill_averages(&self, ranks: &mut Ranks, field: &mut ComputedField) -> Result<()> {
        let layers = field.field().shape().layers;
        match field.values_mut() {
            OwnedReals::F32(values) => self.fill_halo(ranks, values, layers),
            OwnedReals::F64(values) => self.fill_halo(ranks, values, layers),
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

/// The columns that this rank counts in sums over all ranks: exactly one rank counts each, or every rank all of them.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct CountedColumns<'f> {
    part: Option<&'f Part<'f>>,
    mates: Option<&'f NodeRanks>,
}

impl<'f> CountedColumns<'f> {
    /// Those of a rank's part, if it has one, which it shares with `mates` if they read the same fields.
    pub fn new(part: Option<&'f Part<'f>>, mates: Option<&'f NodeRanks>) -> Self {
        CountedColumns { part, mates: part.map(Part::node).or(mates) }
    }

    /// Whether ranks divide the columns among them.
    pub fn is_divided(self) -> bool {
        self.mates.is_some()
    }

    /// Whether this rank counts a column.
    pub fn has(self, location: Location, column: usize) -> bool {
        let is_own = self.part.is_none_or(|part| match location {
            Location::Center => part.owns(column),
            Location::Corner => part.has(column as u32),
        });
        is_own && self.mates.is_none_or(|mates| mates.has_share(column))
    }
}

/// Sends the rows, of `width` bytes, of own cells to other ranks, and returns the messages to this one. Collective.
fn exchange_rows(ranks: &mut Ranks, halo: &[HaloExchange], rows: &[u8], width: usize) -> Result<RankMessages> {
    let mut messages = RankMessages::new();
    for (rank, cells) in halo.iter().flat_map(|halo| &halo.sends) {
        let message = messages.entry(*rank).or_default();
        cells.iter().for_each(|cell| message.extend_from_slice(&rows[*cell as usize * width..][..width]));
    }
    ranks.exchange(messages)
}

/// Calls `put` with the offset of each halo cell's row and the row of its owner.
fn read_rows(
    halo: &[HaloExchange],
    received: &RankMessages,
    width: usize,
    mut put: impl FnMut(usize, &[u8]),
) -> Result<()> {
    let mut unread: BTreeMap<usize, &[u8]> = received.iter().map(|(rank, bytes)| (*rank, &**bytes)).collect();
    for (rank, cells) in halo.iter().flat_map(|halo| &halo.receives) {
        for cell in cells {
            let row = unread.get_mut(rank).and_then(|unread| unread.split_off(..width));
            let row = row.ok_or_else(|| Error::new(ErrorKind::Mpi, "values of halo cells are cut short"))?;
            put(*cell as usize * width, row);
        }
    }
    Ok(())
}

/// The exchange of halo cells, which each rank makes with its partner on each other node: of its share, and of the other
/// halo cells of its node. Collective.
fn halo_exchanges(ranks: &mut Ranks, mesh: &NodeMesh, node: &NodeRanks) -> Result<[HaloExchange; 2]> {
    let owners = mesh.owner.iter().map(|owner| *owner as usize);
    let partners = node.partners(ranks, &owners.clone().filter(|owner| !node.is_mate(*owner)).collect())?;
    let row = |cell: u64| {
        mesh.row(cell).ok_or_else(|| Error::new(ErrorKind::Internal, format!("cell {cell} is not on this node")))
    };
    let rows = |(rank, cells): (usize, Vec<u64>)| Ok((rank, cells.into_iter().map(row).collect::<Result<_>>()?));
    let mut halo = <[HaloExchange; 2]>::default();
    for (halo, is_share) in halo.iter_mut().zip([true, false]) {
        let mut requests = RankLists::new();
        for (row, owner) in (0u32..).zip(owners.clone()).filter(|(row, _)| node.has_share(*row as usize) == is_share) {
            // This rank's own node has no partner.
            if let Some(partner) = partners.get(&owner) {
                requests.entry(*partner).or_default().push(mesh.grid.number(row as usize));
                halo.receives.entry(*partner).or_default().push(row);
            }
        }
        let requests = ranks.exchange_lists(&requests)?;
        halo.sends = ranks.collective_work(|| requests.into_iter().map(rows).collect())?;
    }
    Ok(halo)
}
