//! Whole fields in the memory of a node.

use super::mesh::NodeGrid;
use super::node_ranks::NodeRanks;
use super::{NodeMemory, Part, Ranks};
use crate::fields::Fields;
use icoray_grid::{Error, ErrorKind, Field, Grid, Location, Reals, Result, Shape};
use std::sync::Arc;

/// A field's place in a node's memory and its form there: level-fastest.
#[derive(Debug, Clone)]
pub(crate) struct Stored {
    /// The name that scenes use; `None` for the heights.
    pub name: Option<String>,
    /// Offset in bytes, a multiple of 8.
    pub at: usize,
    pub columns: usize,
    pub layers: usize,
    pub location: Location,
    /// Whether these are averages of a field at corners.
    pub is_average: bool,
    pub is_f64: bool,
    pub fill: Option<f64>,
}

impl Stored {
    /// Bytes of a column.
    pub fn width(&self) -> usize {
        self.layers * if self.is_f64 { size_of::<f64>() } else { size_of::<f32>() }
    }

    /// Offset of its end.
    pub fn end(&self) -> usize {
        self.at + self.columns * self.width()
    }

    fn field<'n>(&self, bytes: &'n [u8]) -> Result<Field<'n>> {
        let cut = |e| Error::new(ErrorKind::Internal, format!("the node's memory: {e}"));
        let bytes = &bytes[self.at..self.end()];
        let samples = if self.is_f64 {
            Reals::F64(bytemuck::try_cast_slice(bytes).map_err(cut)?)
        } else {
            Reals::F32(bytemuck::try_cast_slice(bytes).map_err(cut)?)
        };
        Field::new(samples, Shape::level_fastest(self.columns, self.layers), self.location, self.fill)
    }
}

/// A field of which each rank has some columns, and the place of the gathered field.
pub(super) struct GatherTarget<'f> {
    /// This rank's columns.
    pub field: Field<'f>,
    /// The gathered field.
    pub whole: Stored,
}

impl GatherTarget<'_> {
    /// The layout, which must be equal on all ranks: otherwise they would overwrite each other's columns.
    pub fn facts(&self) -> [(&'static str, String); 3] {
        let (name, bits) = (display_name(&self.whole.name), if self.whole.is_f64 { 64 } else { 32 });
        let place = if self.field.location() == Location::Corner { "corners" } else { "centres" };
        [
            ("has", format!("{name} of {} layers of {bits} bits", self.whole.layers)),
            ("has", format!("{name} at {place}")),
            ("has", format!("{name} with missing values marked by {:?}", self.field.fill())),
        ]
    }
}

/// The name of a field, or of the heights, in messages.
pub(super) fn display_name(name: &Option<String>) -> String {
    name.as_ref().map_or("heights".into(), |name| format!("{name:?}"))
}

/// Whole fields, and heights if there are any, that the ranks of a node have gathered in its memory.
pub(crate) struct NodeFields {
    pub node: NodeMemory,
    /// The ranks that read these fields, if any ranks share memory and none has its own although it should.
    pub mates: Option<NodeRanks>,
    /// The grid of the fields if ranks have parts.
    pub grid: Option<Arc<NodeGrid>>,
    pub stored: Vec<Stored>,
    /// The error of heights at corners, found before they were averaged; equal on all ranks.
    pub heights_error: Option<Error>,
    /// Bytes of fields that this rank wrote.
    pub bytes_copied: u64,
    /// Bytes of averages that it wrote.
    pub bytes_averaged: u64,
    /// Seconds of gathering.
    pub copy_s: f64,
}

impl NodeFields {
    /// The fields.
    ///
    /// # Errors
    /// [`ErrorKind::Internal`] where the memory is not aligned.
    pub fn fields(&self) -> Result<Fields<'_>> {
        let (mut named, mut heights) = (Vec::new(), None);
        for stored in &self.stored {
            let field = stored.field(self.node.bytes())?;
            match &stored.name {
                Some(name) => named.push((name.as_str(), field)),
                None => heights = Some(field),
            }
        }
        Ok(Fields::new(named).with_heights(heights))
    }

    /// Whether some of `fields` are averages of fields at corners.
    pub fn are_averaged(&self, fields: &Fields) -> bool {
        let is_needed = |name: &Option<String>| match name {
            Some(name) => fields.iter().any(|(needed, _)| needed == name),
            None => fields.heights().is_some(),
        };
        self.stored.iter().any(|stored| stored.is_average && is_needed(&stored.name))
    }

    /// The grid of the fields: the node's, or `given` if ranks have the whole one.
    pub fn grid<'g>(&'g self, given: &'g Grid<'g>) -> &'g Grid<'g> {
        self.grid.as_ref().map_or(given, |node| node.grid())
    }

    /// Marks of the node's own cells, if there are other nodes with parts.
    pub fn part(&self) -> Option<&Part<'_>> {
        self.grid.as_ref()?.part()
    }

    /// As [`Columns::table_bytes`](super::Columns::table_bytes).
    pub fn table_bytes(&self) -> usize {
        self.grid.as_ref().map_or(0, |node| node.bytes)
    }

    /// Whether some ranks have their own memory although they should share it.
    pub fn is_refused(&self) -> bool {
        self.node.is_refused || self.grid.as_ref().is_some_and(|grid| grid.is_refused)
    }

    /// Returns the memory for the next frame.
    pub fn leave(self, ranks: &mut Ranks) {
        ranks.keep_node(self.node);
    }
}
