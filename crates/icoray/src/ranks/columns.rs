//! Columns of some cells each, over tables of the whole grid that every rank has: who owns what, and how fields are put
//! together, once per node.
//!
//! Each rank writes its own columns to its node's memory and sends them to one rank of each other node, which writes them
//! there, one field after the other. So a node has one copy of each field, which is the only one.

use super::cells::{Numbered, PartCells};
use super::words::{Reader, Words};
use super::{Node, Ranks, bad};
use crate::error::{Error, ErrorKind, Result};
use crate::field::{Field, Location};
use crate::fields::Fields;
use crate::grid::{Grid, Reals};
use crate::shape::Shape;
use bytemuck::Pod;
use std::ops::Range;

/// The most bytes that a rank sends at once, to all nodes together, unless a single column for each has more.
const MOST: usize = 64 << 20;

/// Which columns of the whole grid's fields a rank has, agreed on by all ranks.
#[derive(Debug, Clone)]
pub struct Columns {
    /// Own columns, as they stand here, with their cells in the whole grid.
    own: Vec<(u32, u32)>,
    /// Columns that the fields of this rank have.
    count: usize,
    /// Cells of the whole grid.
    cells: usize,
    /// Own columns of the rank that has most.
    most: usize,
}

/// A field of which ranks have some columns each, and where the whole of it is put together.
pub(crate) struct Placed<'f> {
    /// How a scene calls it; `None` for the heights.
    pub name: Option<String>,
    /// This rank's columns.
    pub field: Field<'f>,
    /// Where it begins in the node's memory.
    pub at: usize,
}

impl Placed<'_> {
    /// What must be the same on all ranks: else they would write over each other's.
    pub fn facts(&self) -> [(&'static str, String); 2] {
        let (name, bits) = (self.called(), 8 * value_bytes(&self.field));
        let layers = self.field.shape().layers;
        [
            ("has", format!("{name} of {layers} layers of {bits} bits")),
            ("has", format!("{name} with missing values marked by {:?}", self.field.fill())),
        ]
    }

    fn called(&self) -> String {
        self.name.as_ref().map_or("heights".into(), |name| format!("{name:?}"))
    }
}

impl Columns {
    /// Agrees with the other ranks on whose each cell is. Collective; all have the whole grid's tables.
    pub(super) fn new(ranks: &mut Ranks, grid: &Grid, cells: &PartCells) -> Result<Self> {
        let base = i64::from(grid.tables().index_base);
        let all = grid.cells();
        let numbers = ranks.attempt(|| {
            let numbers = Numbered::new(cells, cells.global.len(), base, Some(base + all as i64 - 1))?;
            let own = (0u32..).zip(numbers.global).zip(numbers.owns_cell).filter(|(_, is_own)| *is_own);
            Ok(own.map(|((column, cell), _)| (column, cell as u32)).collect::<Vec<_>>())
        });
        let own = ranks.together(numbers)?;
        refuse_other_owners(ranks, &own, all, base)?;
        let mut most = 0;
        for bytes in ranks.share(&Words::default().put(own.len() as u64).0)? {
            most = most.max(Reader(&bytes).get()? as usize);
        }
        Ok(Columns { own, count: cells.global.len(), cells: all, most })
    }

    /// Columns that a field of this rank has.
    ///
    /// # Errors
    /// [`ErrorKind::Field`] where it is not at centres.
    pub fn of_field_at(&self, location: Location) -> Result<usize> {
        if location == Location::Center {
            return Ok(self.count);
        }
        let message = "at corners, expected centres: ranks have the whole grid's tables and columns of some cells each; \
                       fields at corners are drawn where each rank has its own part's tables";
        Err(Error::new(ErrorKind::Field, message))
    }

    /// Of each column that a field of this rank has, whether it is its own.
    pub(crate) fn owned(&self) -> Vec<bool> {
        let mut owned = vec![false; self.count];
        self.own.iter().for_each(|(column, _)| owned[*column as usize] = true);
        owned
    }

    /// Where the whole of each field is to be put together, and bytes for all of them, where `fields` have this rank's
    /// columns.
    ///
    /// # Errors
    /// With the field's name: [`ErrorKind::Field`] where it has other columns.
    pub(crate) fn places<'f>(&self, grid: &Grid, fields: &Fields<'f>) -> Result<(Vec<Placed<'f>>, usize)> {
        let (mut places, mut end) = (Vec::new(), 0);
        let named = fields.iter().map(|(name, field)| (Some(name.to_owned()), *field));
        for (name, field) in named.chain(fields.heights().map(|heights| (None, *heights))) {
            let place = Placed { name, field, at: end };
            let bytes = self.bytes_for(grid, &place.field).map_err(|e| e.within(place.called()))?;
            end += bytes.next_multiple_of(size_of::<f64>());
            places.push(place);
        }
        Ok((places, end))
    }

    /// Bytes that all columns of the whole grid take, where `field` has this rank's.
    fn bytes_for(&self, grid: &Grid, field: &Field) -> Result<usize> {
        let (shape, expected) = (field.shape(), self.of_field_at(field.location())?);
        if shape.columns != expected {
            let message =
                format!("{} columns, expected {expected}, one per row of cell_global", shape.columns);
            return Err(Error::new(ErrorKind::Field, message));
        }
        if grid.cells() != self.cells {
            return Err(bad(format!(
                "{} cells, expected {}, of which ranks have agreed",
                grid.cells(),
                self.cells
            )));
        }
        Ok(self.cells * column_bytes(field))
    }

    /// Puts a field together in the node's memory, of its own columns on each rank; returns the bytes that this rank
    /// wrote there. Collective, and so is what comes of it, but for a failure that is to be told to the others.
    pub(crate) fn gather(&self, ranks: &mut Ranks, node: &mut Node, place: &Placed) -> Result<u64> {
        self.gather_by(ranks, node, place, MOST)
    }

    /// The same with at most so many bytes sent at once.
    pub(super) fn gather_by(
        &self,
        ranks: &mut Ranks,
        node: &mut Node,
        place: &Placed,
        most: usize,
    ) -> Result<u64> {
        let Placed { field, at, .. } = place;
        let width = column_bytes(field);
        let mut columns = 0;
        node.memory.begin()?;
        let mut outcome = ranks.attempt(|| {
            self.visit(field, 0..self.own.len(), |cell, bytes| {
                node.memory.put(at + cell as usize * width, bytes);
                columns += 1;
            });
            Ok(())
        });
        let at_once = (most / (width + 8) / ranks.size()).max(1);
        let rounds = if ranks.size() > 1 { self.most.div_ceil(at_once) } else { 0 };
        for round in 0..rounds {
            // Where something has failed the others wait for this rank all the same.
            let message = ranks.attempt(|| {
                let range = |k: usize| (k * at_once).min(self.own.len());
                let mut words = Words::default();
                self.visit(field, range(round)..range(round + 1), |cell, bytes| {
                    words.put(cell.into()).put_raw(bytes);
                });
                Ok(words.0)
            });
            let mut messages = vec![Vec::new(); ranks.size()];
            match message {
                Ok(message) => node.partners.iter().for_each(|to| messages[*to].clone_from(&message)),
                Err(error) => outcome = outcome.and(Err(error)),
            }
            for bytes in ranks.exchange(messages)? {
                let taken = take(&bytes, width, self.cells, |cell, bytes| {
                    node.memory.put(at + cell * width, bytes);
                    columns += 1;
                });
                outcome = outcome.and(taken);
            }
        }
        node.memory.settle()?;
        outcome.map(|()| (columns * width) as u64)
    }

    /// The whole fields, once all are put together.
    pub(crate) fn wholes<'n>(&self, node: &'n Node, places: &[Placed]) -> Result<Fields<'n>> {
        let (mut named, mut heights) = (Vec::new(), None);
        for place in places {
            let whole = self.whole(node, place)?;
            match &place.name {
                Some(name) => named.push((name.as_str(), whole)),
                None => heights = Some(whole),
            }
        }
        let fields = Fields::new(named);
        Ok(match heights {
            Some(heights) => fields.with_heights(heights),
            None => fields,
        })
    }

    /// A whole field.
    pub(super) fn whole<'n>(&self, node: &'n Node, Placed { field, at, .. }: &Placed) -> Result<Field<'n>> {
        let count = self.cells * field.shape().layers;
        let cut = |e| Error::new(ErrorKind::Internal, format!("the node's memory: {e}"));
        let bytes = &node.memory.bytes()[*at..][..self.cells * column_bytes(field)];
        let samples = match field.samples() {
            Reals::F32(_) => Reals::F32(&bytemuck::try_cast_slice(bytes).map_err(cut)?[..count]),
            Reals::F64(_) => Reals::F64(&bytemuck::try_cast_slice(bytes).map_err(cut)?[..count]),
        };
        let shape = Shape::level_fastest(self.cells, field.shape().layers);
        Field::new(samples, shape, Location::Center, field.fill())
    }

    /// The cells and values of some own columns, layer by layer.
    fn visit(&self, field: &Field, own: Range<usize>, visit: impl FnMut(u32, &[u8])) {
        match field.samples() {
            Reals::F32(data) => visit_columns(data, field, &self.own[own], visit),
            Reals::F64(data) => visit_columns(data, field, &self.own[own], visit),
        }
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

fn value_bytes(field: &Field) -> usize {
    match field.samples() {
        Reals::F32(_) => size_of::<f32>(),
        Reals::F64(_) => size_of::<f64>(),
    }
}

fn column_bytes(field: &Field) -> usize {
    value_bytes(field) * field.shape().layers
}

/// Hands on the columns of a message, each with its cell before it.
fn take(bytes: &[u8], width: usize, cells: usize, mut column: impl FnMut(usize, &[u8])) -> Result<()> {
    let mut reader = Reader(bytes);
    while !reader.0.is_empty() {
        let cell = reader.get()? as usize;
        if cell >= cells {
            return Err(Error::new(ErrorKind::Mpi, format!("a column of cell {cell} of {cells}")));
        }
        column(cell, reader.get_raw(width)?);
    }
    Ok(())
}

/// Refuses cells that are owned by two ranks or by none. Rank `c mod ranks` looks after cell c.
fn refuse_other_owners(ranks: &mut Ranks, own: &[(u32, u32)], cells: usize, base: i64) -> Result<()> {
    let (rank, size) = (ranks.rank(), ranks.size());
    let mut messages = vec![Words::default(); size];
    for (_, cell) in own {
        messages[*cell as usize % size].put((*cell).into());
    }
    let came = ranks.exchange(messages.into_iter().map(|words| words.0).collect())?;
    let checked = ranks.attempt(|| {
        let mut owners: Vec<Option<usize>> = vec![None; cells.saturating_sub(rank).div_ceil(size)];
        for (owner, bytes) in came.iter().enumerate() {
            let mut reader = Reader(bytes);
            while !reader.0.is_empty() {
                let cell = reader.get()? as usize;
                if let Some(other) = owners[cell / size].replace(owner) {
                    let cell = cell as i64 + base;
                    return Err(bad(format!(
                        "cell {cell} is owned by ranks {other} and {owner}, expected one owner"
                    )));
                }
            }
        }
        if let Some(nobodys) = owners.iter().position(Option::is_none) {
            let cell = (nobodys * size + rank) as i64 + base;
            return Err(bad(format!(
                "cell {cell} of the whole grid is owned by no rank, expected one owner"
            )));
        }
        Ok(())
    });
    ranks.together(checked)
}
