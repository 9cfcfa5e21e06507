//! Gathers fields of which each rank has some columns, once per node.
//!
//! If every rank has the tables of the whole grid, the field that a node gathers is whole. If ranks have parts, it has
//! the columns of the node's mesh: own ones and, around them, those of other nodes. Each rank writes its own columns to
//! its node's memory and sends those that other nodes need to one rank of each, which writes them there, one field
//! after the other. A node has one copy of each field. Only a rank's own columns are read.
//!
//! Fields at corners are rendered as averages at cells. If ranks have parts, each averages at its own cells, from the
//! model's array and a halo of corners, and the node stores the averages instead of the field. Derived fields are
//! computed before averages, so their inputs are gathered at corners.

use super::cells::{PartCells, PartCorners};
use super::corner_halo::CornerHalo;
use super::mesh::{NodeGrid, NodeMesh, Numbers};
use super::node_fields::{GatherTarget, NodeFields, Stored, display_name};
use super::node_ranks::NodeRanks;
use super::owners::{CellOwners, OwnCorners};
use super::supply::{ColumnLookup, Rows, Supply};
use super::{NodeMemory, RankMessages, Ranks, bad};
use crate::fields::Fields;
use icoray_grid::heights::check_corner_columns;
use icoray_grid::threads::Threads;
use icoray_grid::{ColumnCount, Error, ErrorKind, Field, Grid, Layers, Location, Reals, Result};
use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

mod source;
mod whole;

pub(super) use source::visit_columns;
use source::{ColumnSource, read_columns};

/// Maximum number of bytes that a rank sends at once, to all nodes together, unless a single column for each has more.
const MAX_BYTES: usize = 64 << 20;

/// The columns of fields that a rank has, agreed on by all ranks.
#[derive(Debug, Clone)]
pub struct Columns {
    center: Supply,
    corner: Supply,
    /// Whether ranks have numbered the corners of their fields.
    has_corner_numbers: bool,
    /// Cells of this rank's tables.
    cells: usize,
    node: NodeRanks,
    /// If ranks have the whole grid's tables, a rank of each other node, which receives own columns.
    partners: BTreeSet<usize>,
    /// The mesh that is drawn if ranks have parts; `None` if they have the whole grid's tables.
    node_grid: Option<Arc<NodeGrid>>,
    /// Corners whose values other ranks have, if ranks have parts.
    halo: Option<Arc<CornerHalo>>,
}

/// The inputs of gathering fields.
pub(crate) struct GatherInputs<'a> {
    pub threads: &'a Threads,
    /// This rank's grid.
    pub grid: &'a Grid<'a>,
    /// The layers of the heights.
    pub layers: &'a Layers,
    /// Names of the inputs of derived fields.
    pub derivation_inputs: Vec<&'a str>,
}

impl Columns {
    /// Agrees with the other ranks on the owner of each cell if each rank has the tables of its part: `cells` has a row
    /// for each cell of `grid`, and `corners`, if any rank has them, one for each corner. Joins the parts of each node.
    /// Collective.
    pub(super) fn of_parts(
        ranks: &mut Ranks,
        grid: &Grid,
        cells: &PartCells,
        corners: Option<&PartCorners>,
    ) -> Result<Self> {
        let CellOwners { global, owner } = CellOwners::agree(ranks, grid, cells)?;
        let own_corners = OwnCorners::read(ranks, grid, corners)?;
        let node = NodeRanks::find(ranks)?;
        let corner = own_corners.as_ref().map(OwnCorners::numbers);
        let numbers = Numbers { grid, global: &global, owner: &owner, corner, rank: ranks.rank() };
        let (node_grid, mesh_numbers) = NodeGrid::join(ranks, &numbers, &node)?;
        let mesh = ranks.collective(NodeMesh::new(node_grid.grid(), &mesh_numbers))?;
        let lookup = ranks.collective_work(|| Ok(ColumnLookup::new(&numbers)))?;
        let [center, corner] = Supply::of_parts(ranks, (&numbers, &lookup), &mesh, &node, own_corners.as_ref())?;
        let halo = Some(Arc::new(CornerHalo::find(ranks, &numbers, &lookup, own_corners.as_ref())?));
        ranks.keep_node(mesh_numbers);
        let node_grid = Some(Arc::new(node_grid));
        let (has_corner_numbers, partners) = (own_corners.is_some(), BTreeSet::new());
        Ok(Columns { center, corner, has_corner_numbers, cells: grid.cells(), node, partners, node_grid, halo })
    }

    /// Whether ranks have the tables of their parts, not those of the whole grid.
    pub fn has_parts(&self) -> bool {
        self.node_grid.is_some()
    }

    /// Bytes of the tables of the node's mesh, which its ranks share, at the rank that made them; 0 at others, and if
    /// ranks have the whole grid's.
    pub fn table_bytes(&self) -> usize {
        self.node_grid.as_ref().map_or(0, |node| node.bytes)
    }

    /// As [`Decomposition::drawn_grid`](super::Decomposition::drawn_grid).
    pub(super) fn drawn_grid<'g>(&'g self, own: &'g Grid<'g>) -> Option<&'g Grid<'g>> {
        let node = self.node_grid.as_ref();
        node.map_or(Some(own), |node| node.part().is_none().then(|| node.grid()))
    }

    /// As [`Decomposition::node_grid`](super::Decomposition::node_grid).
    pub(super) fn node_grid<'g>(&'g self, own: &'g Grid<'g>) -> &'g Grid<'g> {
        self.node_grid.as_ref().map_or(own, |node| node.grid())
    }

    /// Number of columns of a field of this rank.
    pub fn of_field_at(&self, location: Location) -> usize {
        self.supply(location).count
    }

    fn supply(&self, location: Location) -> &Supply {
        match location {
            Location::Center => &self.center,
            Location::Corner => &self.corner,
        }
    }

    /// Marks of the columns of this rank's field that it owns.
    ///
    /// # Errors
    /// [`ErrorKind::Field`] if the field has other columns.
    pub(super) fn owned(&self, field: &Field) -> Result<Vec<bool>> {
        let (columns, expected) = (field.shape().columns, self.of_field_at(field.location()));
        if columns != expected {
            let message = format!("{columns} columns, expected {expected}, as many as this rank has");
            return Err(Error::new(ErrorKind::Field, message));
        }
        Ok(self.supply(field.location()).owned())
    }

    /// Gathers `fields`, which have this rank's columns, in the node's memory. Collective, and all ranks have the same
    /// result. [`NodeFields::leave`] returns the memory.
    ///
    /// Equal on all ranks: the error of `fields` on any of them, [`ErrorKind::Field`] with the field's name if it has
    /// other columns, and [`ErrorKind::Mpi`] if ranks have different fields or the transport fails.
    pub(crate) fn gather<'f>(
        &self,
        ranks: &mut Ranks,
        inputs: &GatherInputs,
        fields: impl FnOnce() -> Result<Fields<'f>>,
    ) -> Result<NodeFields> {
        let start = Instant::now();
        let targets = ranks.attempt(|| self.targets(inputs, &fields()?));
        let (targets, bytes) =
            ranks.agree_all(targets, |(targets, _)| targets.iter().flat_map(GatherTarget::facts).collect())?;
        let heights_error = self.check_heights(ranks, inputs, &targets);
        let mut node = ranks.take_node(bytes)?;
        let mut written = Ok([0; 2]);
        for target in &targets {
            // After a failure the collective calls go on: the other ranks wait in them.
            let bytes = self.gather_by(ranks, inputs, &mut node, target, MAX_BYTES);
            written = written.and_then(|mut sums: [u64; 2]| {
                sums[usize::from(target.whole.is_average)] += bytes?;
                Ok(sums)
            });
        }
        match ranks.collective(written) {
            Ok([bytes_copied, bytes_averaged]) => Ok(NodeFields {
                mates: (ranks.size() > 1 && node.is_shared && !node.is_refused).then(|| self.node.clone()),
                node,
                grid: self.node_grid.clone(),
                stored: targets.into_iter().map(|target| target.whole).collect(),
                heights_error,
                bytes_copied,
                bytes_averaged,
                copy_s: start.elapsed().as_secs_f64(),
            }),
            Err(error) => {
                ranks.keep_node(node);
                Err(error)
            }
        }
    }

    /// Checks own heights at corners before they are averaged; the error is the same on all ranks. Collective.
    fn check_heights(&self, ranks: &mut Ranks, inputs: &GatherInputs, targets: &[GatherTarget]) -> Option<Error> {
        let is_heights = |target: &&GatherTarget| target.whole.name.is_none() && target.whole.is_average;
        let (target, halo) = (targets.iter().find(is_heights)?, self.halo.as_ref()?);
        let GatherInputs { threads, grid, layers, .. } = *inputs;
        let reads = |corner: usize| halo.reads(corner);
        let check = || threads.run(|| check_corner_columns(grid, &target.field, layers, reads));
        ranks.collective_work(check).err()
    }

    /// The place of each whole field, and the bytes of all of them on any node: equal on all ranks.
    pub(super) fn targets<'f>(
        &self,
        inputs: &GatherInputs,
        fields: &Fields<'f>,
    ) -> Result<(Vec<GatherTarget<'f>>, usize)> {
        let grid = inputs.grid;
        if grid.cells() != self.cells {
            let message = format!("{} cells, expected {}, of which ranks have agreed", grid.cells(), self.cells);
            return Err(bad(message));
        }
        let (mut targets, mut end, mut bytes) = (Vec::new(), 0, 0);
        let named = fields.iter().map(|(name, field)| (Some(name.to_owned()), *field));
        for (name, field) in named.chain(fields.heights().map(|heights| (None, *heights))) {
            self.check_columns(grid, &field).map_err(|e| e.within(display_name(&name)))?;
            let is_input = name.as_deref().is_some_and(|name| inputs.derivation_inputs.contains(&name));
            let is_average = self.halo.is_some() && field.location() == Location::Corner && !is_input;
            let location = if is_average { Location::Center } else { field.location() };
            let whole = Stored {
                name,
                at: end,
                columns: self.supply(location).rows,
                layers: field.shape().layers,
                location,
                is_average,
                is_f64: matches!(field.samples(), Reals::F64(_)),
                fill: field.fill().filter(|_| !is_average),
            };
            end = whole.end().next_multiple_of(size_of::<f64>());
            let [_, _, max_rows, _] = self.supply(location).max;
            let most = max_rows * whole.width();
            bytes += most.next_multiple_of(size_of::<f64>());
            targets.push(GatherTarget { field, whole });
        }
        Ok((targets, bytes))
    }

    /// Refuses a field that has other columns than this rank.
    fn check_columns(&self, grid: &Grid, field: &Field) -> Result<()> {
        let (shape, columns) = (field.shape(), self.of_field_at(field.location()));
        if shape.columns == columns {
            return Ok(());
        }
        let each = match field.location() {
            Location::Center => "per row of cell_global",
            Location::Corner if self.has_corner_numbers => "per row of corner_global",
            Location::Corner => "per corner",
        };
        let expected = ColumnCount { columns, ..ColumnCount::new(grid, field.location()) };
        Err(expected.error(shape.columns, each))
    }

    /// Gathers a field from the own columns of each rank, with at most `most` bytes sent at once; returns the bytes
    /// that this rank wrote to the node's memory. Collective, and all ranks have the same result, except for a failure
    /// that has yet to be sent to the others.
    pub(super) fn gather_by(
        &self,
        ranks: &mut Ranks,
        inputs: &GatherInputs,
        node: &mut NodeMemory,
        target: &GatherTarget,
        most: usize,
    ) -> Result<u64> {
        let halo = match self.halo.as_ref().filter(|_| target.whole.is_average) {
            Some(halo) => Some((halo, halo.exchange(ranks, &target.field)?)),
            None => None,
        };
        let halo = halo.as_ref().map(|(halo, values)| (&***halo, values));
        let source = ColumnSource::new(&target.field, inputs, halo)?;
        let (at, width) = (target.whole.at, target.whole.width());
        let supply = self.supply(target.whole.location);
        let mut columns = 0;
        node.begin(ranks.team.as_mut())?;
        let mut outcome = ranks.attempt(|| {
            source.visit(&supply.own, |row, bytes| {
                node.put(at + row as usize * width, bytes);
                columns += 1;
            });
            Ok(())
        });
        let [max_own, max_others, _, max_receivers] = supply.max;
        let receivers = max_receivers + if node.is_refused { ranks.size() } else { 0 };
        let at_once = (most / (width + 8) / receivers.max(1)).max(1);
        let sends_own = self.node_grid.is_none() || node.is_refused;
        let max_sent = if sends_own { max_own } else { max_others };
        let rounds = if ranks.size() > 1 { max_sent.div_ceil(at_once) } else { 0 };
        for round in 0..rounds {
            // After a failure the collective calls go on: the other ranks wait in them.
            let range = round * at_once..(round + 1) * at_once;
            let messages = ranks.attempt(|| Ok(self.messages(ranks, node, (&source, supply), range)));
            let messages = messages.unwrap_or_else(|error| {
                outcome = std::mem::replace(&mut outcome, Ok(())).and(Err(error));
                RankMessages::new()
            });
            let mut received: Vec<(usize, Vec<u8>)> = ranks.exchange(messages)?.into_iter().collect();
            if node.is_refused {
                // What one rank receives from other node, all of this one need.
                let from_others = received.iter().filter(|(from, _)| !self.node.is_mate(*from));
                let bytes: Vec<u8> = from_others.flat_map(|(_, bytes)| bytes).copied().collect();
                let mates = self.mates_apart(ranks, node);
                received.extend(ranks.exchange(mates.map(|mate| (mate, bytes.clone())).collect())?);
            }
            for (_, bytes) in received {
                let read = read_columns(&bytes, width, supply.rows, |row, bytes| {
                    node.put(at + row * width, bytes);
                    columns += 1;
                });
                outcome = outcome.and(read);
            }
        }
        node.settle(ranks.team.as_mut())?;
        outcome.map(|()| (columns * width) as u64)
    }

    /// The messages to each rank: of the columns that it takes in for its node, those whose numbers are in `range`.
    fn messages(
        &self,
        ranks: &Ranks,
        node: &NodeMemory,
        (source, supply): (&ColumnSource, &Supply),
        range: Range<usize>,
    ) -> RankMessages {
        let message = |rows: &Rows| {
            let [first, end] = [range.start, range.end].map(|k| k.min(rows.len()));
            let mut message = Vec::new();
            source.visit(&rows[first..end], |row, bytes| {
                message.extend_from_slice(&u64::from(row).to_le_bytes());
                message.extend_from_slice(bytes);
            });
            message
        };
        let mut messages: RankMessages = supply.others.iter().map(|(to, rows)| (*to, message(rows))).collect();
        let to: Vec<usize> = self.partners.iter().copied().chain(self.mates_apart(ranks, node)).collect();
        if !to.is_empty() {
            let own = message(&supply.own);
            messages.extend(to.into_iter().map(|to| (to, own.clone())));
        }
        messages
    }

    /// The other ranks of this one's node, if they have memory of their own.
    fn mates_apart(&self, ranks: &Ranks, node: &NodeMemory) -> impl Iterator<Item = usize> {
        let (rank, is_apart) = (ranks.rank(), node.is_refused_here);
        self.node.mates().iter().copied().filter(move |mate| is_apart && *mate != rank)
    }
}
