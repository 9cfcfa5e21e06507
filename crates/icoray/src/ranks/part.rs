//! A rank's part of a grid that is spread over ranks: which cells and triangles are its own, and who has the others.
//!
//! Each rank has a grid of its own cells and a halo, with local numbers. A triangle belongs to the rank that owns its cell of
//! the lowest global number: a partition of all triangles, each of which its owner has whole where the halo is one cell wide.
//!
//! Ranks of a node may have a part together: each of them has all of its grid and fields, and they share what is done of it.
//!
//! Gradients and averages of halo cells, whose neighbours a rank may not have, come from their owners.

mod owners;

use super::Ranks;
use super::cells::{Owned, PartCells};
use super::mesh::NodeMesh;
use super::nodes::Nodes;
use super::words::{Reader, Words};
use crate::device::Own;
use crate::error::{Error, ErrorKind, Result};
use crate::grid::Grid;
use crate::kernel::plane::RayLine;
use glam::DVec3;
use owners::Local;
use std::f64::consts::PI;

/// Some cells for each rank.
type CellsOfRanks = Vec<Vec<u32>>;

/// A rank's part of a grid, agreed on by all ranks.
#[derive(Debug, Clone)]
pub struct Part {
    owns_cell: Vec<bool>,
    owns_triangle: Vec<bool>,
    /// For each rank, own cells whose values it needs.
    sends: CellsOfRanks,
    /// For each rank, halo cells whose values come from there, in the order in which they do.
    receives: CellsOfRanks,
    /// Middle of the own triangles, and the cosine of the angle to the farthest of their vertices.
    cap: Option<(DVec3, f64)>,
    lowest_facet: f64,
    covered: f64,
    cells: u64,
    ranks: usize,
    /// The ranks that have this part together, rising, and this rank's place among them.
    mates: Vec<usize>,
    place: usize,
    is_of_node: bool,
}

/// What ranks with parts have agreed on.
pub(super) struct Agreed {
    /// Of each cell, its number in the whole grid, counted from 0.
    pub global: Vec<u64>,
    /// Of each cell, the rank that owns it.
    pub owner: Vec<u32>,
    owns_cell: Vec<bool>,
    owns_triangle: Vec<bool>,
    sends: CellsOfRanks,
    receives: CellsOfRanks,
}

impl Agreed {
    /// Agrees on whose each cell is. Collective; `grid` is this rank's own.
    pub fn new(ranks: &mut Ranks, grid: &Grid, cells: &PartCells) -> Result<Self> {
        let local = ranks.attempt(|| Local::new(grid, cells, ranks.size()));
        let local = ranks.together(local)?;
        let owner = local.find_owners(ranks)?;
        let (sends, receives) = local.find_partners(ranks, grid, &owner)?;
        let Local { global, owns_cell, owns_triangle, .. } = local;
        Ok(Agreed { global, owner, owns_cell, owns_triangle, sends, receives })
    }
}

/// What is carried from rank to rank.
pub(crate) trait Carried: Sized {
    fn put(&self, words: &mut Words);
    fn get(reader: &mut Reader) -> Result<Self>;
}

impl Carried for f32 {
    fn put(&self, words: &mut Words) {
        words.put_f32(*self);
    }

    fn get(reader: &mut Reader) -> Result<Self> {
        reader.get_f32()
    }
}

impl Carried for f64 {
    fn put(&self, words: &mut Words) {
        words.put_f64(*self);
    }

    fn get(reader: &mut Reader) -> Result<Self> {
        reader.get_f64()
    }
}

impl Carried for [f32; 3] {
    fn put(&self, words: &mut Words) {
        self.iter().for_each(|value| value.put(words));
    }

    fn get(reader: &mut Reader) -> Result<Self> {
        Ok([f32::get(reader)?, f32::get(reader)?, f32::get(reader)?])
    }
}

/// What ranks add up of their parts.
struct Extent {
    lowest_facet: f64,
    area: f64,
    cells: u64,
}

impl Part {
    /// Agrees with the other ranks on whose each cell is. Collective; `grid` is this rank's own.
    ///
    /// # Errors
    /// The same on all ranks: [`ErrorKind::Grid`](crate::ErrorKind::Grid) where numbers or marks do not fit the grid, a cell is owned by two ranks or
    /// by none, or a halo is too narrow; [`ErrorKind::Mpi`](crate::ErrorKind::Mpi) when the transport fails.
    pub fn new(ranks: &mut Ranks, grid: &Grid, cells: &PartCells) -> Result<Self> {
        let Agreed { owns_cell, owns_triangle, sends, receives, .. } = Agreed::new(ranks, grid, cells)?;
        let mut part = Part {
            cap: cap(grid, &owns_triangle),
            owns_cell,
            owns_triangle,
            sends,
            receives,
            lowest_facet: 1.0,
            covered: 0.0,
            cells: 0,
            ranks: ranks.size(),
            mates: vec![ranks.rank()],
            place: 0,
            is_of_node: false,
        };
        part.add_up(ranks, grid)?;
        Ok(part)
    }

    /// The part that the ranks of a node have together. Collective.
    pub(super) fn of_node(ranks: &mut Ranks, mesh: &NodeMesh, nodes: &Nodes) -> Result<Self> {
        let (grid, rank) = (mesh.grid(), ranks.rank());
        let owns_cell: Vec<bool> = mesh.owner.iter().map(|owner| nodes.is_mate(*owner as usize)).collect();
        // Cells are in the order of their numbers.
        let lowest = |triangle: u32| grid.triangle(triangle).into_iter().min().unwrap_or(0);
        let owns = |triangle: u32| grid.is_triangle(triangle) && owns_cell[lowest(triangle) as usize];
        let owns_triangle: Vec<bool> = (0..grid.triangles() as u32).map(owns).collect();
        let (sends, receives) = node_partners(ranks, mesh, nodes)?;
        let mates = nodes.mates();
        let mut part = Part {
            cap: cap(grid, &owns_triangle),
            owns_cell,
            owns_triangle,
            sends,
            receives,
            lowest_facet: 1.0,
            covered: 0.0,
            cells: 0,
            ranks: ranks.size(),
            place: mates.iter().position(|mate| *mate == rank).unwrap_or(0),
            mates,
            is_of_node: true,
        };
        part.add_up(ranks, grid)?;
        Ok(part)
    }

    /// The share of this rank in a grid that every rank has whole: rows from one to the next.
    ///
    /// # Errors
    /// As [`Part::new`].
    pub fn of_whole(ranks: &mut Ranks, grid: &Grid) -> Result<Self> {
        let (rank, size, base) = (ranks.rank(), ranks.size(), i64::from(grid.tables().index_base));
        let global: Vec<i64> = (base..).take(grid.cells()).collect();
        let is_own = |cell: usize| cell * size / grid.cells() == rank;
        let marks: Vec<i32> = (0..grid.cells()).map(|cell| is_own(cell).into()).collect();
        let cells = PartCells { global: global.as_slice().into(), owned: Owned::Marked(&marks) };
        Part::new(ranks, grid, &cells)
    }

    /// Number of own cells, of all ranks together.
    pub fn cells(&self) -> u64 {
        self.cells
    }

    /// The part of the sphere that the triangles of all ranks cover: 1 where the mesh has no hole.
    pub fn covered(&self) -> f64 {
        self.covered
    }

    /// Ranks that agreed on it.
    pub fn ranks(&self) -> usize {
        self.ranks
    }

    /// The ranks that have this part together, rising.
    pub(crate) fn mates(&self) -> &[usize] {
        &self.mates
    }

    /// This rank's place among them.
    pub(crate) fn place(&self) -> usize {
        self.place
    }

    /// Whether it is that of a node, not of a rank.
    pub(crate) fn is_of_node(&self) -> bool {
        self.is_of_node
    }

    /// Whether this rank tells of a cell where ranks add up what they know of all: each cell is told of once.
    pub(crate) fn tells(&self, cell: usize) -> bool {
        self.owns_cell[cell] && cell % self.mates.len() == self.place
    }

    /// The same of a triangle; any number will do.
    pub(crate) fn tells_triangle(&self, triangle: u32) -> bool {
        self.has(triangle) && triangle as usize % self.mates.len() == self.place
    }

    /// Whether a cell is this part's own.
    pub fn owns(&self, cell: usize) -> bool {
        self.owns_cell[cell]
    }

    /// Whether a triangle is this part's own; any number will do.
    #[inline]
    pub(crate) fn has(&self, triangle: u32) -> bool {
        self.owns_triangle.get(triangle as usize).is_some_and(|is_own| *is_own)
    }

    /// Own triangles.
    pub fn triangles(&self) -> usize {
        self.owns_triangle.iter().filter(|is_own| **is_own).count()
    }

    /// Height of the lowest place of any rank's facets over a unit sphere.
    pub(crate) fn lowest_facet(&self) -> f64 {
        self.lowest_facet
    }

    /// Whether a line may meet own columns between the radii `inner` and `outer`.
    pub(crate) fn is_near(&self, line: &RayLine, inner: f64, outer: f64) -> bool {
        let (middle, reach) = self.ball(inner, outer);
        let (x, q) = (middle.dot(line.plane.x) - line.b, middle.dot(line.plane.q));
        x * x + q * q <= reach
    }

    /// A ball around own columns between the radii `inner` and `outer`: its middle, and the square of its radius, which is
    /// negative where there are none.
    fn ball(&self, inner: f64, outer: f64) -> (DVec3, f64) {
        let Some((axis, cos)) = self.cap else { return (DVec3::ZERO, -1.0) };
        if cos <= 0.1 {
            return (DVec3::ZERO, f64::INFINITY);
        }
        // Columns go down to the facets below the inner radius, at worst to the chord of the cap.
        let low = inner * cos;
        // A ball around the rim's disc at the outer radius has the cap in it, and the rim of its bottom.
        let middle = outer * cos * axis;
        let reach = |r: f64| r * r - 2.0 * r * outer * cos * cos + outer * outer * cos * cos;
        (middle, reach(low).max(reach(outer)) * (1.0 + 1e-9))
    }

    /// What a device needs of it, for columns between the radii `inner` and `outer`.
    pub(crate) fn own(&self, inner: f64, outer: f64) -> Own<'_> {
        let (middle, reach) = self.ball(inner, outer);
        Own {
            triangles: &self.owns_triangle,
            lowest_facet: self.lowest_facet,
            middle: middle.to_array(),
            reach,
        }
    }

    /// Replaces the rows of halo cells beside own ones by those of their owners; `row_of` finds a cell's row.
    /// Collective.
    pub(crate) fn fill_halo<V: Carried>(
        &self,
        ranks: &mut Ranks,
        values: &mut [V],
        row_of: impl Fn(&mut [V], u32) -> &mut [V],
    ) -> Result<()> {
        let mut messages = Vec::with_capacity(self.sends.len());
        for cells in &self.sends {
            let mut words = Words::default();
            cells
                .iter()
                .for_each(|cell| row_of(values, *cell).iter().for_each(|value| value.put(&mut words)));
            messages.push(words.0);
        }
        let came = ranks.exchange(messages)?;
        let mut take = || -> Result<()> {
            for (bytes, cells) in came.iter().zip(&self.receives) {
                let mut reader = Reader(bytes);
                for cell in cells {
                    for value in row_of(values, *cell) {
                        *value = V::get(&mut reader)?;
                    }
                }
            }
            Ok(())
        };
        let taken = take();
        ranks.together(taken)
    }

    /// The range of all parts' values and how many are missing, of this part's. Collective.
    pub(crate) fn whole_range(
        ranks: &mut Ranks,
        (range, missing): (Option<[f64; 2]>, u64),
    ) -> Result<(Option<[f64; 2]>, u64)> {
        let [low, high] = range.unwrap_or([f64::INFINITY, f64::NEG_INFINITY]);
        let mut words = Words::default();
        words.put_f64(low).put_f64(high).put(missing);
        let (mut low, mut high, mut missing) = (f64::INFINITY, f64::NEG_INFINITY, 0);
        for bytes in ranks.share(&words.0)? {
            let mut reader = Reader(&bytes);
            (low, high) = (low.min(reader.get_f64()?), high.max(reader.get_f64()?));
            missing += reader.get()?;
        }
        Ok(((low <= high).then_some([low, high]), missing))
    }

    fn add_up(&mut self, ranks: &mut Ranks, grid: &Grid) -> Result<()> {
        let mine = if self.place == 0 {
            self.extent(grid)
        } else {
            Extent { lowest_facet: 1.0, area: 0.0, cells: 0 }
        };
        let mut words = Words::default();
        words.put_f64(mine.lowest_facet).put_f64(mine.area).put(mine.cells);
        let mut area = 0.0;
        for bytes in ranks.share(&words.0)? {
            let mut reader = Reader(&bytes);
            self.lowest_facet = self.lowest_facet.min(reader.get_f64()?);
            area += reader.get_f64()?;
            self.cells += reader.get()?;
        }
        self.covered = area / (4.0 * PI);
        Ok(())
    }

    fn extent(&self, grid: &Grid) -> Extent {
        let cells = self.owns_cell.iter().filter(|is_own| **is_own).count() as u64;
        let mut extent = Extent { lowest_facet: 1.0, area: 0.0, cells };
        for triangle in (0..grid.triangles() as u32).filter(|t| self.has(*t)) {
            let [a, b, c] = grid.triangle(triangle).map(|cell| grid.direction(cell));
            let normal = (b - a).cross(c - a);
            let volume = a.dot(normal).abs();
            extent.lowest_facet = extent.lowest_facet.min(volume / normal.length());
            extent.area += 2.0 * volume.atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a));
        }
        extent
    }
}

/// Which own cells each rank of another node is sent values of, and which cells' values come from there: each rank exchanges
/// with its partner on each other node. Collective.
fn node_partners(ranks: &mut Ranks, mesh: &NodeMesh, nodes: &Nodes) -> Result<(CellsOfRanks, CellsOfRanks)> {
    let size = ranks.size();
    let (mut wishes, mut receives) = (vec![Words::default(); size], vec![Vec::new(); size]);
    let partners: Vec<usize> = nodes.partners().collect();
    let partner_of = |owner: u32| {
        let leader = nodes.leader_of(owner as usize);
        partners.iter().copied().find(|partner| nodes.leader_of(*partner) == leader)
    };
    for (row, owner) in (0u32..).zip(&mesh.owner).filter(|(_, owner)| !nodes.is_mate(**owner as usize)) {
        if let Some(partner) = partner_of(*owner) {
            wishes[partner].put(mesh.global[row as usize]);
            receives[partner].push(row);
        }
    }
    let came = ranks.exchange(wishes.into_iter().map(|words| words.0).collect())?;
    let row = |cell: &[u8; 8]| {
        let cell = u64::from_le_bytes(*cell);
        mesh.row(cell)
            .ok_or_else(|| Error::new(ErrorKind::Internal, format!("cell {cell} is not on this node")))
    };
    let sends =
        ranks.attempt(|| came.iter().map(|cells| cells.as_chunks().0.iter().map(row).collect()).collect());
    Ok((ranks.together(sends)?, receives))
}

/// The cap around own triangles.
fn cap(grid: &Grid, owns_triangle: &[bool]) -> Option<(DVec3, f64)> {
    let own = || (0u32..).zip(owns_triangle).filter(|(_, is_own)| **is_own);
    let vertices = || own().flat_map(|(t, _)| grid.triangle(t)).map(|cell| grid.direction(cell));
    let axis = vertices().sum::<DVec3>().try_normalize();
    let axis = axis.or_else(|| vertices().next())?;
    Some((axis, vertices().fold(1.0, |least: f64, v| least.min(v.dot(axis)))))
}
