//! Work on a frame's fields that the ranks of a node share, as they read the same fields in its memory: each computes
//! what belongs to some cells, and all read the whole.

use super::scene_builder::SceneBuilder;
use crate::ranks::{NodeRanks, Ranks, decode, encode};
use icoray_grid::Result;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::array;
use std::ops::Range;

/// The ranks that share the work of a frame on their node, and the sizes of the largest grid of a node.
#[derive(Clone, Copy)]
pub(super) struct NodeWork<'f> {
    mates: &'f NodeRanks,
    pub max_cells: usize,
    pub max_triangles: usize,
    /// Whether all ranks skip empty space.
    pub finds_blocks: bool,
    /// Whether gradients may be partial on all ranks ([`SceneBuilder::partial_gradients`]).
    pub partial_gradients: bool,
}

impl<'f> NodeWork<'f> {
    /// The shared work of the frame of `builder`; `None` if not all ranks need what it computes, or those of a node do
    /// not read the same fields. Collective.
    pub fn agree(builder: &SceneBuilder<'_, 'f>, ranks: &mut Ranks) -> Result<Option<Self>> {
        let (context, savings) = (builder.context, builder.savings);
        let Some(mates) = context.mates else { return Ok(None) };
        // Ranks may have renderers of different savings and devices.
        let is_partial = builder.partial_gradients && savings.empty_space && savings.packing && savings.gradients;
        let mine = (
            [context.needs_scene(), savings.empty_space, is_partial],
            [context.grid.cells(), context.grid.triangles()],
        );
        let (flags, sizes) = ranks.reduce_values(mine, |(a, m), (b, n)| {
            (array::from_fn(|k| a[k] && b[k]), array::from_fn(|k| m[k].max(n[k])))
        })?;
        let ([all_need, finds_blocks, partial_gradients], [max_cells, max_triangles]) = (flags, sizes);
        let node = NodeWork { mates, max_cells, max_triangles, finds_blocks, partial_gradients };
        Ok(all_need.then_some(node))
    }

    /// This rank's turns among `count` cells or triangles.
    pub fn turns(&self, count: usize) -> impl Iterator<Item = Range<usize>> + use<> {
        self.mates.turns(count)
    }

    /// The sum of what the ranks of the node have each. Collective.
    pub fn sum<T: Serialize + DeserializeOwned>(
        &self,
        ranks: &mut Ranks,
        mine: &T,
        add: impl Fn(T, T) -> T,
    ) -> Result<T> {
        let all = ranks.share_among(self.mates.mates(), encode(mine))?;
        let mut sum = decode(&all[0])?;
        for other in &all[1..] {
            sum = add(sum, decode(other)?);
        }
        Ok(sum)
    }

    /// Whether this rank reports what the node has once.
    pub fn is_reporter(&self) -> bool {
        self.mates.is_leader()
    }
}
