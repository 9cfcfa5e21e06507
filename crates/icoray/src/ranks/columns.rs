//! Gathers fields of which each rank has some columns, once per node.
//!
//! Where every rank has the tables of the whole grid, so has the field that a node puts together. Where ranks have
//! parts, it has the columns of the node's mesh: own ones and, around them, those of other nodes. Each rank writes its
//! own columns to its node's memory and sends those that other nodes need to one rank of each, which writes them there,
//! one field after the other. A node has one copy of each field. Columns that are not a rank's own are not read.

use super::cells::{PartCells, PartCorners};
use super::corner_owners::OwnCorners;
use super::mesh::{NodeMesh, Numbers};
use super::nodes::Nodes;
use super::part::Agreed;
use super::supply::Supply;
use super::{Node, NodeFields, Part, Ranks, Stored, bad};
use crate::fields::Fields;
use bytemuck::Pod;
use icoray_grid::ColumnCount;
use icoray_grid::grid::OwnedGrid;
use icoray_grid::{Error, ErrorKind, Result};
use icoray_grid::{Field, Location};
use icoray_grid::{Grid, Reals};
use std::sync::Arc;
use std::time::Instant;

mod whole;

/// The most bytes that a rank sends at once, to all nodes together, unless a single column for each has more.
const MAX_BYTES: usize = 64 << 20;

/// Which columns of fields a rank has, agreed on by all ranks.
#[derive(Debug, Clone)]
pub struct Columns {
    center: Supply,
    corner: Supply,
    /// Whether ranks have numbered the corners of their fields.
    has_corner_numbers: bool,
    /// Cells of this rank's tables.
    cells: usize,
    /// Ranks with the same mesh.
    nodes: Nodes,
    /// The mesh that is drawn if ranks have parts; `None` if they have the whole grid's tables.
    node_grid: Option<Arc<NodeGrid>>,
}

/// The grid that the ranks of a node have together.
#[derive(Debug)]
pub(crate) struct NodeGrid {
    grid: OwnedGrid,
    /// Which of it is the node's own, where there are other nodes.
    pub part: Option<Part>,
}

impl NodeGrid {
    pub fn grid(&self) -> &Grid<'_> {
        self.grid.grid()
    }

    /// Bytes of its tables and of what is derived from them.
    pub fn bytes(&self) -> usize {
        self.grid.bytes()
    }
}

/// A field of which ranks have some columns each, and where the whole of it is put together.
pub(super) struct GatherTarget<'f> {
    /// This rank's columns.
    pub field: Field<'f>,
    /// The whole.
    pub whole: Stored,
}

impl GatherTarget<'_> {
    /// The layout, which must be equal on all ranks: otherwise they would overwrite each other's columns.
    fn facts(&self) -> [(&'static str, String); 3] {
        let (name, bits) = (display_name(&self.whole.name), if self.whole.is_f64 { 64 } else { 32 });
        let place = if self.whole.location == Location::Corner { "corners" } else { "centres" };
        [
            ("has", format!("{name} of {} layers of {bits} bits", self.whole.layers)),
            ("has", format!("{name} at {place}")),
            ("has", format!("{name} with missing values marked by {:?}", self.whole.fill)),
        ]
    }
}

/// The name of a field, or of the heights, in messages.
fn display_name(name: &Option<String>) -> String {
    name.as_ref().map_or("heights".into(), |name| format!("{name:?}"))
}

impl Columns {
    /// Agrees with the other ranks on whose each cell is, where each rank has the tables of its part, `cells` with a row
    /// for each cell of `grid`, and `corners`, if any rank has them, with one for each corner: puts the parts of each
    /// node together. Collective.
    pub(super) fn of_parts(
        ranks: &mut Ranks,
        grid: &Grid,
        cells: &PartCells,
        corners: Option<&PartCorners>,
    ) -> Result<Self> {
        let Agreed { global, owner, .. } = Agreed::new(ranks, grid, cells)?;
        let own_corners = OwnCorners::read(ranks, grid, corners)?;
        let nodes = Nodes::find(ranks)?;
        let corner = own_corners.as_ref().map(OwnCorners::numbers);
        let numbers = Numbers { grid, global: &global, owner: &owner, corner, rank: ranks.rank() };
        let mesh = NodeMesh::new(ranks, &numbers, &nodes)?;
        let [center, corner] = Supply::of_parts(ranks, &numbers, &mesh, &nodes, own_corners.as_ref())?;
        let part = if nodes.is_one() { None } else { Some(Part::of_node(ranks, &mesh, &nodes)?) };
        let node_grid = Some(Arc::new(NodeGrid { grid: mesh.grid, part }));
        let has_corner_numbers = own_corners.is_some();
        Ok(Columns { center, corner, has_corner_numbers, cells: grid.cells(), nodes, node_grid })
    }

    /// Bytes of the tables that this rank made for its node's mesh: 0 where ranks have the whole grid's.
    pub fn table_bytes(&self) -> usize {
        self.node_grid.as_ref().map_or(0, |node| node.bytes())
    }

    /// Columns that a field of this rank has.
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
    /// [`ErrorKind::Field`] where the field has other columns.
    pub(super) fn owned(&self, field: &Field) -> Result<Vec<bool>> {
        let (columns, expected) = (field.shape().columns, self.of_field_at(field.location()));
        if columns != expected {
            let message = format!("{columns} columns, expected {expected}, as many as this rank has");
            return Err(Error::new(ErrorKind::Field, message));
        }
        Ok(self.supply(field.location()).owned())
    }

    /// Puts `fields`, which have this rank's columns, together in the node's memory. Collective, and so is what comes
    /// of it. The memory is handed back by [`NodeFields::leave`].
    ///
    /// # Errors
    /// The same on all ranks: the error of `fields` on any of them, [`ErrorKind::Field`] with the field's name where it
    /// has other columns, and [`ErrorKind::Mpi`] where ranks have different fields or the transport fails.
    pub(crate) fn gather<'f>(
        &self,
        ranks: &mut Ranks,
        grid: &Grid,
        fields: impl FnOnce() -> Result<Fields<'f>>,
    ) -> Result<NodeFields> {
        let start = Instant::now();
        let places = ranks.attempt(|| self.places(grid, &fields()?));
        let (places, bytes) =
            ranks.agree_all(places, |(places, _)| places.iter().flat_map(GatherTarget::facts).collect())?;
        let mut node = ranks.take_node(bytes)?;
        let mut copied = Ok(0);
        for place in &places {
            // After a failure the collective calls go on: the other ranks wait in them.
            let bytes = self.gather_by(ranks, &mut node, place, MAX_BYTES);
            copied = copied.and_then(|sum| Ok(sum + bytes?));
        }
        match ranks.collective(copied) {
            Ok(bytes_copied) => {
                let (stored, copy_s) = (places.into_iter().map(|place| place.whole).collect(), start.elapsed());
                let copy_s = copy_s.as_secs_f64();
                Ok(NodeFields { node, grid: self.node_grid.clone(), stored, bytes_copied, copy_s })
            }
            Err(error) => {
                ranks.keep_node(node);
                Err(error)
            }
        }
    }

    /// Where the whole of each field is to be put together, and bytes for all of them on whichever node: as many on all
    /// ranks.
    pub(super) fn places<'f>(&self, grid: &Grid, fields: &Fields<'f>) -> Result<(Vec<GatherTarget<'f>>, usize)> {
        if grid.cells() != self.cells {
            let message = format!("{} cells, expected {}, of which ranks have agreed", grid.cells(), self.cells);
            return Err(bad(message));
        }
        let (mut places, mut end, mut bytes) = (Vec::new(), 0, 0);
        let named = fields.iter().map(|(name, field)| (Some(name.to_owned()), *field));
        for (name, field) in named.chain(fields.heights().map(|heights| (None, *heights))) {
            self.check_columns(grid, &field).map_err(|e| e.within(display_name(&name)))?;
            let whole = Stored {
                name,
                at: end,
                columns: self.supply(field.location()).rows,
                layers: field.shape().layers,
                location: field.location(),
                is_f64: matches!(field.samples(), Reals::F64(_)),
                fill: field.fill(),
            };
            end = whole.end().next_multiple_of(size_of::<f64>());
            let most = self.supply(field.location()).max_rows() * whole.width();
            bytes += most.next_multiple_of(size_of::<f64>());
            places.push(GatherTarget { field, whole });
        }
        Ok((places, bytes))
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

    /// Puts a field together, of its own columns on each rank, with at most so many bytes sent at once; returns the
    /// bytes that this rank wrote to the node's memory. Collective, and so is what comes of it, but for a failure
    /// that is to be told to the others.
    pub(super) fn gather_by(
        &self,
        ranks: &mut Ranks,
        node: &mut Node,
        place: &GatherTarget,
        most: usize,
    ) -> Result<u64> {
        let (field, at, width) = (&place.field, place.whole.at, place.whole.width());
        let supply = self.supply(field.location());
        let mut columns = 0;
        node.memory.begin()?;
        let mut outcome = ranks.attempt(|| {
            visit(field, &supply.own, |row, bytes| {
                node.memory.put(at + row as usize * width, bytes);
                columns += 1;
            });
            Ok(())
        });
        let at_once = (most / (width + 8) / ranks.size()).max(1);
        let sends_own = self.node_grid.is_none() || node.is_refused;
        let rounds = if ranks.size() > 1 { supply.max_sent(sends_own).div_ceil(at_once) } else { 0 };
        for round in 0..rounds {
            // After a failure the collective calls go on: the other ranks wait in them.
            let messages = ranks.attempt(|| Ok(self.messages(ranks.size(), node, place, round * at_once, at_once)));
            let messages = messages.unwrap_or_else(|error| {
                outcome = std::mem::replace(&mut outcome, Ok(())).and(Err(error));
                vec![Vec::new(); ranks.size()]
            });
            for bytes in ranks.exchange(messages)? {
                let read = read_columns(&bytes, width, supply.rows, |row, bytes| {
                    node.memory.put(at + row * width, bytes);
                    columns += 1;
                });
                outcome = outcome.and(read);
            }
        }
        node.memory.settle()?;
        outcome.map(|()| (columns * width) as u64)
    }

    /// For each rank, `count` of the columns that it takes in for its node, from the one number `first` on.
    fn messages(&self, ranks: usize, node: &Node, place: &GatherTarget, first: usize, count: usize) -> Vec<Vec<u8>> {
        let supply = self.supply(place.field.location());
        let mut messages = vec![Vec::new(); ranks];
        let mut same: Option<(usize, usize)> = None;
        for to in &node.partners {
            let rows = supply.for_rank(&self.nodes, *to);
            // Nodes with the same mesh get the same columns.
            if let Some((_, other)) = same.filter(|(leader, _)| *leader == self.nodes.leader_of(*to)) {
                messages[*to] = messages[other].clone();
                continue;
            }
            let range = |k: usize| k.min(rows.len());
            let message = &mut messages[*to];
            visit(&place.field, &rows[range(first)..range(first + count)], |row, bytes| {
                message.extend_from_slice(&u64::from(row).to_le_bytes());
                message.extend_from_slice(bytes);
            });
            same = Some((self.nodes.leader_of(*to), *to));
        }
        messages
    }
}

/// The rows and values of some columns, layer by layer.
fn visit(field: &Field, columns: &[(u32, u32)], visit: impl FnMut(u32, &[u8])) {
    match field.samples() {
        Reals::F32(data) => visit_columns(data, field, columns, visit),
        Reals::F64(data) => visit_columns(data, field, columns, visit),
    }
}

fn visit_columns<S: Pod>(data: &[S], field: &Field, own: &[(u32, u32)], mut visit: impl FnMut(u32, &[u8])) {
    let (shape, elements) = (field.shape(), field.elements());
    let mut column = Vec::with_capacity(shape.layers);
    for (at, cell) in own {
        let base = elements.base(*at as usize);
        if shape.layer_stride == 1 {
            let first = elements.at(base, 0);
            visit(*cell, bytemuck::cast_slice(&data[first..first + shape.layers]));
            continue;
        }
        column.clear();
        column.extend((0..shape.layers).map(|layer| data[elements.at(base, layer)]));
        visit(*cell, bytemuck::cast_slice(&column));
    }
}

/// Reads the columns of a message: `width` bytes each, behind the 8 bytes of the row.
fn read_columns(bytes: &[u8], width: usize, rows: usize, mut column: impl FnMut(usize, &[u8])) -> Result<()> {
    for record in bytes.chunks(8 + width) {
        let cut = || Error::new(ErrorKind::Mpi, "a column of a message is cut short");
        let (row, values) = record.split_first_chunk().ok_or_else(cut)?;
        let row = u64::from_le_bytes(*row) as usize;
        if row >= rows || values.len() < width {
            return Err(Error::new(ErrorKind::Mpi, format!("a column of row {row} of {rows}")));
        }
        column(row, values);
    }
    Ok(())
}
