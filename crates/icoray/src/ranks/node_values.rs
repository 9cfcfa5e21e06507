//! Columns of values that the ranks of a node compute together, each those of its turns, in memory that all read.

use super::{NodeMemory, NodeRanks, Part, Ranks};
use crate::fields::FieldLayout;
use icoray_grid::threads::Threads;
use icoray_grid::{Field, OwnedReals, Reals, Result};
use rayon::prelude::*;
use std::ops::Range;

/// A field that the ranks of a node have computed, level-fastest; NaN where a value is missing.
#[derive(Debug)]
pub(crate) struct NodeValues {
    memory: NodeMemory,
    at: FieldLayout,
    is_f64: bool,
    /// Whether this rank reports the memory for its node.
    is_reporter: bool,
}

impl NodeValues {
    /// Computes a field of this layout, in f64 if `is_f64`, on these threads: `make` returns the values of some columns,
    /// and may reuse those that it returned before. `None` if the ranks of some node have no memory to share. Collective.
    pub fn compute(
        ranks: &mut Ranks,
        mates: &NodeRanks,
        threads: &Threads,
        at: FieldLayout,
        is_f64: bool,
        make: impl Fn(Range<usize>, Option<OwnedReals>) -> OwnedReals + Sync,
    ) -> Result<Option<Self>> {
        let width = at.layers * if is_f64 { size_of::<f64>() } else { size_of::<f32>() };
        let bytes = ranks.reduce_values(at.columns * width, usize::max)?;
        let mut memory = ranks.take_node(bytes)?;
        if memory.is_refused {
            return Ok(None);
        }
        memory.write(ranks, |put| {
            threads.run(|| {
                mates.turns(at.columns).par_bridge().for_each_init(
                    || None,
                    |memory, columns| {
                        let first = columns.start;
                        let values = make(columns, memory.take());
                        put(first * width, values.as_bytes());
                        *memory = Some(values);
                    },
                );
            });
            Ok(())
        })?;
        Ok(Some(NodeValues { memory, at, is_f64, is_reporter: mates.is_leader() }))
    }

    /// Replaces the columns of halo cells by those of their owners. Collective.
    pub fn fill_halo(&mut self, ranks: &mut Ranks, part: &Part) -> Result<()> {
        let width = self.at.layers * if self.is_f64 { size_of::<f64>() } else { size_of::<f32>() };
        part.fill_shared_halo(ranks, &mut self.memory, (0, width))
    }

    /// The field.
    pub fn field(&self) -> Field<'_> {
        let count = self.at.columns * self.at.layers;
        let values = match self.is_f64 {
            true => Reals::F64(&bytemuck::cast_slice(self.memory.bytes())[..count]),
            false => Reals::F32(&bytemuck::cast_slice(self.memory.bytes())[..count]),
        };
        self.at.field(values, None)
    }

    /// Its bytes, at the rank that reports them for its node; 0 at the others.
    pub fn reported_bytes(&self) -> usize {
        let each = if self.is_f64 { size_of::<f64>() } else { size_of::<f32>() };
        if self.is_reporter { self.at.columns * self.at.layers * each } else { 0 }
    }

    /// Returns the memory for the next frame.
    pub fn leave(self, ranks: &mut Ranks) {
        ranks.keep_node(self.memory);
    }
}
