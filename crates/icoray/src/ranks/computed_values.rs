//! Fields that a rank computes from others: alone, or with the other ranks of its node, each the columns of its turns, in
//! memory that all read.

use super::{NodeMemory, NodeRanks, Part, Ranks};
use crate::fields::FieldLayout;
use icoray_grid::threads::Threads;
use icoray_grid::{ComputedField, Field, OwnedReals, Reals, Result};
use rayon::prelude::*;
use std::ops::Range;

/// A field that was computed from others.
#[derive(Debug)]
pub(crate) enum ComputedValues {
    /// By this rank.
    Own(ComputedField),
    /// By the ranks of the node together.
    Shared(NodeValues),
}

/// A field computed before, or one whose memory is free.
pub(crate) type Cached = std::result::Result<ComputedField, Option<ComputedField>>;

impl ComputedValues {
    /// Computes a field of this layout, in f64 if `is_f64`, on these threads: `make` returns the values of some columns,
    /// in memory of values before if there is any. Each of the `mates` computes those of its turns, if there are any and
    /// all nodes have memory to share; otherwise each rank has all, the `cached` ones or in their memory. Collective.
    pub fn compute(
        ranks: &mut Ranks,
        mates: Option<&NodeRanks>,
        threads: &Threads,
        (at, is_f64): (FieldLayout, bool),
        cached: impl FnOnce() -> Result<Cached> + Send,
        make: impl Fn(Range<usize>, Option<OwnedReals>) -> OwnedReals + Sync,
    ) -> Result<Self> {
        if let Some(mates) = mates
            && let Some(shared) = NodeValues::compute(ranks, mates, threads, (at, is_f64), &make)?
        {
            return Ok(ComputedValues::Shared(shared));
        }
        let own = || {
            cached()?.or_else(|memory| {
                let values = make(0..at.columns, memory.map(ComputedField::into_values));
                Ok(ComputedField::new(values, at.location, at.layers))
            })
        };
        ranks.collective_work(|| threads.run(own).map(ComputedValues::Own))
    }

    /// The field.
    pub fn field(&self) -> Field<'_> {
        match self {
            ComputedValues::Own(values) => values.field(),
            ComputedValues::Shared(values) => values.field(),
        }
    }

    /// Replaces the columns of halo cells by those of their owners. Collective.
    pub fn fill_halo(&mut self, ranks: &mut Ranks, part: &Part) -> Result<()> {
        match self {
            ComputedValues::Own(values) => part.fill_averages(ranks, values),
            ComputedValues::Shared(NodeValues { memory, at, is_f64, .. }) => {
                part.fill_shared_halo(ranks, memory, (0, width(*at, *is_f64)))
            }
        }
    }

    /// Bytes that this rank reports: of what its node shares one rank does.
    pub fn reported_bytes(&self) -> usize {
        match self {
            ComputedValues::Own(values) => values.bytes(),
            ComputedValues::Shared(NodeValues { at, is_f64, is_reporter: true, .. }) => {
                at.columns * width(*at, *is_f64)
            }
            ComputedValues::Shared(_) => 0,
        }
    }

    /// Keeps the memory for the next frame.
    pub fn leave(self, ranks: &mut Ranks, keep_own: impl FnOnce(ComputedField)) {
        match self {
            ComputedValues::Own(values) => keep_own(values),
            ComputedValues::Shared(values) => ranks.keep_node(values.memory),
        }
    }
}

/// Bytes of a column.
fn width(at: FieldLayout, is_f64: bool) -> usize {
    at.layers * if is_f64 { size_of::<f64>() } else { size_of::<f32>() }
}

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
    /// As [`ComputedValues::compute`]; `None` if the ranks of some node have no memory to share. Collective.
    fn compute(
        ranks: &mut Ranks,
        mates: &NodeRanks,
        threads: &Threads,
        (at, is_f64): (FieldLayout, bool),
        make: impl Fn(Range<usize>, Option<OwnedReals>) -> OwnedReals + Sync,
    ) -> Result<Option<Self>> {
        let width = width(at, is_f64);
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

    fn field(&self) -> Field<'_> {
        let count = self.at.columns * self.at.layers;
        let values = match self.is_f64 {
            true => Reals::F64(&bytemuck::cast_slice(self.memory.bytes())[..count]),
            false => Reals::F32(&bytemuck::cast_slice(self.memory.bytes())[..count]),
        };
        self.at.field(values, None)
    }
}
