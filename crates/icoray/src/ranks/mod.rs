//! Several processes, the ranks, draw one picture. Each rank draws some of its tiles from data that all ranks have, or,
//! over several nodes, the whole picture of its node's [`Part`]. If each rank has some [`Columns`] of the data, every
//! node makes one copy of them, and one mesh of the parts of its ranks.
//!
//! A [`Team`] transports bytes between ranks. This module defines the messages, which are the same over MPI and between
//! threads ([`local_team`]). One rule excludes deadlocks: ranks communicate in phases that each of them enters, even
//! after an error, and every phase ends with the same outcome on all. A frame has three:
//!
//! 1. [`Ranks::agree`] compares the ranks' inputs and states, and sends the values that rank 0 decides. It is repeated
//!    for further decisions of rank 0.
//! 2. Tiles go to rank 0 as they are drawn, in any order, followed by a mark that the rank has drawn all of them.
//! 3. Rank 0 sends the outcome to all: the pixels at edges, for a second round, and the end of the frame.
//!
//! Only the calling thread communicates; the renderer's threads draw meanwhile.

mod agree;
mod cells;
mod columns;
mod communicator_team;
mod corner_halo;
mod corner_owners;
mod decomposition;
mod gather;
mod load_balance;
mod local;
mod mesh;
mod message_queue;
mod node;
mod node_fields;
mod nodes;
mod packed;
mod part;
mod pieces;
mod pump;
mod supply;
mod tree;
mod wire;

pub(crate) use agree::HAS_WHOLE;
pub use agree::{Agreement, Refusal, Vote};
use cells::bad;
pub use cells::{Owned, PartCells, PartCorners};
pub use columns::Columns;
pub(crate) use columns::GatherInputs;
pub use communicator_team::CommunicatorTeam;
pub use decomposition::Decomposition;
pub(crate) use gather::{FrameSummary, TileAssignment};
pub use local::{LocalTeam, local_nodes, local_team};
pub use message_queue::{Communicator, MessageQueue};
pub(crate) use node::Node;
pub use node::{NodeMemory, NodeShare};
pub(crate) use node_fields::{NodeFields, Stored};
pub use part::Part;
pub use pump::PointToPoint;
pub(crate) use pump::{MessagePump, pumped};
pub(crate) use wire::{decode_list, decode_lists, decode_next, encode, encode_lists};

use icoray_grid::{Error, ErrorKind, Result};
pub(crate) use load_balance::TileCosts;
use std::fmt;
use std::thread::sleep;
use std::time::Duration;

/// Transport of bytes between ranks. `share`, `broadcast` and `exchange` are collective: every rank calls the same ones
/// in the same order. Between two of them ranks may send to rank 0, which has to receive all of it before the next.
///
/// # Errors
/// All methods: [`ErrorKind::Mpi`] when the transport itself fails. Then ranks may no longer be
/// in step, and the team is of no more use.
#[expect(clippy::missing_errors_doc, reason = "the trait has them")]
pub trait Team: Send {
    /// This process's number, from 0.
    fn rank(&self) -> usize;

    /// How many there are, at least 1.
    fn size(&self) -> usize;

    /// Whether ranks can be reached no more, now or later: then nothing but dropping the team is of use. Not
    /// collective.
    fn is_gone(&self) -> bool {
        false
    }

    /// A rank has left: the team is let go without a word to the others, who might never answer. Not collective.
    fn give_up(&mut self) {}

    /// Hands every rank's bytes to all, in order of rank.
    fn share(&mut self, mine: &[u8]) -> Result<Vec<Vec<u8>>>;

    /// Rank 0's bytes to all; those of others are let go.
    fn broadcast(&mut self, mine: Vec<u8>) -> Result<Vec<u8>>;

    /// Begins to send bytes to rank 0, from any other, without waiting.
    fn send(&mut self, bytes: Vec<u8>) -> Result<()>;

    /// Helps along what this rank is sending; whether all of it has gone. It has to have, before the next collective
    /// call.
    fn is_sent(&mut self) -> Result<bool>;

    /// At rank 0: bytes that have come, with the number of the rank that sent them, in the order in which that rank
    /// did.
    fn try_receive(&mut self) -> Result<Option<(usize, Vec<u8>)>>;

    /// At rank 0, with nothing else to do: returns when there may be bytes to receive, or a little later.
    fn wait(&mut self) -> Result<()> {
        sleep(NAP);
        Ok(())
    }

    /// Hands `mine[j]` to rank `j` and returns what each rank has for this one, in order of rank. What is for oneself
    /// is handed back as it is.
    ///
    /// # Panics
    /// When `mine` has not as many entries as there are ranks.
    fn exchange(&mut self, mine: Vec<Vec<u8>>) -> Result<Vec<Vec<u8>>>;

    /// This process's number among those of its node, from 0. Collective. By itself a team takes all to be on one node.
    fn node_rank(&mut self) -> Result<usize> {
        Ok(self.rank())
    }

    /// The number of the first rank of this one's node. Collective. By itself a team takes all to be on one node.
    fn node_leader(&mut self) -> Result<usize> {
        Ok(0)
    }

    /// The lowest of the ranks that share memory with this one, of [`Self::node`]. Collective. By itself a team takes
    /// none to share.
    fn memory_leader(&mut self) -> Result<usize> {
        Ok(self.rank())
    }

    /// Memory of so many bytes for each node, as many on all ranks. Where none can be shared, each rank has its own.
    /// Collective; so is dropping it, unless ranks are gone or the team was given up.
    fn node(&mut self, bytes: usize) -> Result<NodeShare> {
        Ok(NodeShare::alone(self.rank(), bytes))
    }

    /// Messages between the same ranks, apart from those of this team. Collective; so is dropping them, unless ranks
    /// are gone or the team was given up. By itself a team has none: [`ErrorKind::Unsupported`].
    fn point_to_point(&mut self) -> Result<Box<dyn PointToPoint>> {
        Err(Error::new(ErrorKind::Unsupported, "these ranks cannot render in the background"))
    }

    /// A frame begins: messages of a frame that ended early are dropped. Not collective. Only for teams whose ranks
    /// hear of it when one of them leaves a frame ([`Self::break_off`]).
    fn begin_frame(&mut self) {}

    /// This rank's frame has ended by `error`, which other ranks may not know; their calls fail until the next frame.
    /// Not collective.
    fn break_off(&mut self, _error: &Error) {}
}

/// How long a rank sleeps that waits for messages: short, and yet no loop that keeps a processor busy.
const NAP: Duration = Duration::from_micros(50);

/// The ranks that draw together, and what the last frame taught about its tiles.
#[derive(Default)]
pub struct Ranks {
    /// Memory of this rank's node that no frame uses, in the same order on all ranks. Dropped before the team that
    /// gave it.
    nodes: Vec<Node>,
    /// The transport; `None` for a single process.
    team: Option<Box<dyn Team>>,
    /// A rank that has closed its context while others have not; no messages are exchanged after that.
    left: Option<usize>,
    /// Seconds of the last frame's tiles, at rank 0.
    costs: Option<TileCosts>,
    /// Seconds of the last frame's tiles of fragments, of this rank's node.
    part_costs: Option<TileCosts>,
    /// This rank's number on its node, once it has been asked for.
    node_rank: Option<usize>,
}

impl Ranks {
    /// One process that draws alone: nothing is sent, and panics are not caught.
    pub fn alone() -> Self {
        Ranks::default()
    }

    /// Those of a team.
    pub fn new(team: Box<dyn Team>) -> Self {
        Ranks { team: Some(team), ..Ranks::default() }
    }

    /// This process's number, from 0.
    pub fn rank(&self) -> usize {
        self.team.as_ref().map_or(0, |team| team.rank())
    }

    /// How many there are, at least 1.
    pub fn size(&self) -> usize {
        self.team.as_ref().map_or(1, |team| team.size())
    }

    /// Whether this is one process without a team; a team may have one rank too.
    pub fn is_alone(&self) -> bool {
        self.team.is_none()
    }

    /// Whether the other ranks can be reached no more: MPI was finalised, or one of them has left before the others.
    pub fn is_gone(&self) -> bool {
        self.left.is_some() || self.team.as_ref().is_some_and(|team| team.is_gone())
    }

    /// Whether this is rank 0, which receives the picture.
    pub fn is_root(&self) -> bool {
        self.rank() == 0
    }

    /// This process's number among those of its node, from 0. Collective.
    pub(crate) fn node_rank(&mut self) -> Result<usize> {
        if let (None, Some(team)) = (self.node_rank, &mut self.team) {
            let found = team.node_rank();
            self.node_rank = Some(self.collective(found)?);
        }
        Ok(self.node_rank.unwrap_or(0))
    }

    /// How many ranks of this node, this one included, may run on some of the processors of `mask`, a bit for each; an
    /// empty mask stands for all of them. Collective.
    ///
    /// # Errors
    /// [`ErrorKind::Mpi`] when the transport fails.
    pub fn sharing_processors(&mut self, mask: &[u8]) -> Result<usize> {
        let Some(team) = &mut self.team else { return Ok(1) };
        let mine = team.node_leader();
        let leader = self.collective(mine)?;
        let masks = self.share_values(&(leader, mask.to_vec()))?;
        Ok(masks.iter().filter(|(other, others)| *other == leader && overlap(mask, others)).count())
    }

    /// Messages between the same ranks, apart from all others; `None` for one process alone. Collective.
    pub(crate) fn point_to_point(&mut self) -> Result<Option<Box<dyn PointToPoint>>> {
        let Some(team) = &mut self.team else { return Ok(None) };
        let made = team.point_to_point();
        self.collective(made).map(Some)
    }

    /// A frame begins that other ranks may leave early ([`Team::begin_frame`]).
    pub(crate) fn begin_frame(&mut self) {
        self.team.iter_mut().for_each(|team| team.begin_frame());
    }

    /// Tells the others that this rank's frame has ended by `error` ([`Team::break_off`]).
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

    /// Hands each rank what the others have for it: one of `mine` per rank, this one included. Collective.
    pub(crate) fn exchange(&mut self, mine: Vec<Vec<u8>>) -> Result<Vec<Vec<u8>>> {
        match &mut self.team {
            Some(team) => team.exchange(mine),
            None => Ok(mine),
        }
    }

    /// Does some of this rank's work. Where others wait for it a panic is an error like any other, of which they hear.
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
pub(crate) mod tests;
