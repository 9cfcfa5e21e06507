//! Renders one picture with several processes, the ranks. Each rank draws some of its tiles from data that all ranks
//! have or, over several nodes, the whole picture of its node's part. If each rank has some [`Columns`] of the
//! data, every node makes one copy of them, and one mesh of the parts of its ranks.
//!
//! A [`Team`] transports bytes between ranks. This module defines the messages, which are the same over MPI and between
//! threads ([`local_nodes`]). One rule excludes deadlocks: ranks communicate in phases that each of them enters, even
//! after an error, and every phase ends with the same outcome on all. A frame has three:
//!
//! 1. [`Ranks::agree`] compares the ranks' inputs and states, and sends the values that rank 0 decides. It is repeated
//!    for further decisions of rank 0.
//! 2. Tiles go to rank 0 as they are drawn, in any order; a rank that fails sends a mark instead of the others.
//! 3. Rank 0 sends the outcome to all: the pixels at edges, for a second round, and the end of the frame.
//!
//! Only the calling thread communicates; the renderer's threads draw meanwhile.
//!
//! No message grows with the number of ranks, nor does the number that a rank sends: what all ranks contribute to is
//! joined on the way to rank 0 ([`Team::reduce`]), ranks send each other only what is not empty ([`Team::exchange`]), and
//! those of a node share what they need of each other ([`Team::share_among`]). [`Team::share`] is for probes.

mod agree;
mod cells;
mod columns;
mod computed_values;
mod corner_halo;
mod decomposition;
mod fragments;
mod gather;
mod load_balance;
mod local;
mod mesh;
mod messages;
mod node;
mod node_fields;
mod node_ranks;
mod owners;
mod packed;
mod part;
mod pieces;
mod pump;
mod supply;
mod team;
mod wire;

pub(crate) use agree::HAS_WHOLE;
pub use agree::{Agreement, Refusal, Vote};
use cells::bad;
pub use cells::{Owned, PartCells, PartCorners};
pub use columns::Columns;
pub(crate) use columns::GatherInputs;
pub(crate) use computed_values::ComputedValues;
pub use decomposition::{Decomposition, DistributedGrid};
pub(crate) use fragments::{Traced, read_fragments};
pub(crate) use gather::{FrameSummary, TileAssignment, TileShare};
pub use local::{LocalMessages, local_nodes, local_nodes_over, local_team, on_local_nodes, on_threads};
pub use messages::{Communicator, Messages};
pub use node::NodeMemory;
pub(crate) use node::PutBytes;
pub(crate) use node_fields::NodeFields;
pub(crate) use node_ranks::NodeRanks;
pub(crate) use part::{CountedColumns, Part};
pub(crate) use pump::MessagePump;
pub use team::{JoinBytes, Team};
pub(crate) use wire::{RankLists, decode, encode};

use icoray_grid::{Error, Result};
pub(crate) use load_balance::TileCosts;
use std::collections::BTreeMap;
use std::fmt;
use std::time::Duration;

/// Messages by the rank that they are sent to or received from.
pub type RankMessages = BTreeMap<usize, Vec<u8>>;

/// Messages that a rank has sent to others.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Traffic {
    /// Their number.
    pub messages: u64,
    /// Their bytes.
    pub bytes: u64,
}

/// Time for which a rank that waits for messages sleeps: short, but not a loop that keeps a processor busy.
const NAP: Duration = Duration::from_micros(50);

/// The ranks that draw together, and the costs of the last frame's tiles.
#[derive(Default)]
pub struct Ranks {
    /// Memory of this rank's node that no frame uses, in the same order on all ranks.
    nodes: Vec<NodeMemory>,
    /// `None` for a single process.
    team: Option<Team>,
    /// A rank that closed its context before the others; no messages are exchanged after that.
    left: Option<usize>,
    /// Seconds of the last frame's tiles, at rank 0.
    costs: Option<TileCosts>,
    /// Seconds of the last frame's tiles of fragments, on this rank's node.
    part_costs: Option<TileCosts>,
}

impl Ranks {
    /// One process that draws alone: no message is sent, and panics are not caught.
    pub fn alone() -> Self {
        Ranks::default()
    }

    /// The ranks of a team.
    pub fn new(team: Team) -> Self {
        Ranks { team: Some(team), ..Ranks::default() }
    }

    /// This process's number, from 0.
    pub fn rank(&self) -> usize {
        self.team.as_ref().map_or(0, Team::rank)
    }

    /// Number of ranks, at least 1.
    pub fn size(&self) -> usize {
        self.team.as_ref().map_or(1, Team::size)
    }

    /// Whether this is one process without a team; a team may have one rank too.
    pub fn is_alone(&self) -> bool {
        self.team.is_none()
    }

    /// Whether the other ranks can be reached no more: MPI was finalised, or a rank closed its context before the
    /// others.
    pub fn is_gone(&self) -> bool {
        self.left.is_some() || self.team.as_ref().is_some_and(Team::is_gone)
    }

    /// Whether this is rank 0, which receives the picture.
    pub fn is_root(&self) -> bool {
        self.rank() == 0
    }

    /// The messages that this rank has sent so far. Not collective.
    pub fn traffic(&self) -> Traffic {
        self.team.as_ref().map_or_else(Traffic::default, Team::traffic)
    }

    /// This process's number among those of its node, from 0.
    pub(crate) fn node_rank(&self) -> usize {
        self.team.as_ref().map_or(0, Team::node_rank)
    }

    /// Number of processes of this node, this one included.
    pub(crate) fn node_size(&self) -> usize {
        self.team.as_ref().map_or(1, Team::node_size)
    }

    /// Number of ranks of this node, this one included, that may run on some of the processors of `mask`, a bit for
    /// each; an empty mask stands for all of them. Collective.
    ///
    /// # Errors
    /// [`Mpi`](crate::ErrorKind::Mpi) when the transport fails.
    pub fn sharing_processors(&mut self, mask: &[u8]) -> Result<usize> {
        let Some(team) = &mut self.team else { return Ok(1) };
        let mates = team.find_group(team.node_leader(), 0)?;
        let masks = team.share_among(&mates, mask.to_vec())?;
        Ok(masks.iter().filter(|other| overlap(mask, other)).count())
    }

    /// The same ranks for another thread, and the pump that moves their messages; `None` for one process alone. Collective.
    pub(crate) fn pumped(&mut self) -> Result<Option<(Ranks, MessagePump)>> {
        let Some(team) = &mut self.team else { return Ok(None) };
        let made = team.pumped();
        self.collective(made).map(|(team, pump)| Some((Ranks::new(team), pump)))
    }

    /// Begins a frame that other ranks may leave early ([`Team::begin_frame`]).
    pub(crate) fn begin_frame(&mut self) {
        self.team.iter_mut().for_each(Team::begin_frame);
    }

    /// Notifies the others that this rank's frame has ended with `error` ([`Team::break_off`]).
    pub(crate) fn break_off(&mut self, error: &Error) {
        self.team.iter_mut().for_each(|team| team.break_off(error));
    }

    /// Every rank's bytes, in order of rank. Collective.
    pub(crate) fn share(&mut self, mine: &[u8]) -> Result<Vec<Vec<u8>>> {
        match &mut self.team {
            Some(team) => team.share(mine),
            None => Ok(vec![mine.to_vec()]),
        }
    }

    /// The bytes of the `members` of this rank's group, in their order ([`Team::share_among`]). Collective.
    pub(crate) fn share_among(&mut self, members: &[usize], mine: Vec<u8>) -> Result<Vec<Vec<u8>>> {
        match &mut self.team {
            Some(team) => team.share_among(members, mine),
            None => Ok(vec![mine]),
        }
    }

    /// Sends `mine`, and returns the messages to this rank, its own included. Collective.
    pub(crate) fn exchange(&mut self, mine: RankMessages) -> Result<RankMessages> {
        match &mut self.team {
            Some(team) => team.exchange(mine),
            None => Ok(mine),
        }
    }

    /// Runs some of this rank's work. If other ranks wait for it, a panic becomes an error, which they receive.
    pub(crate) fn attempt<R>(&self, work: impl FnOnce() -> Result<R>) -> Result<R> {
        if self.team.is_some() { Error::of_panics(work) } else { work() }
    }
}

/// Whether two masks have a processor in common.
fn overlap(one: &[u8], other: &[u8]) -> bool {
    one.is_empty() || other.is_empty() || one.iter().zip(other).any(|(a, b)| a & b != 0)
}

impl fmt::Debug for Ranks {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "rank {} of {}", self.rank(), self.size())
    }
}

#[cfg(test)]
mod tests;
