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
//! those of a node share what they need of each other ([`Team::share_among`]). [`Team::share`] is for columns over whole
//! tables, and for probes.

mod agree;
mod cells;
mod columns;
mod communicator_team;
mod corner_halo;
mod corner_owners;
mod decomposition;
mod fragments;
mod gather;
mod load_balance;
mod local;
mod mesh;
mod message_queue;
mod node;
mod node_fields;
mod nodes;
mod owners;
mod packed;
mod part;
mod pieces;
mod pump;
mod shared_node;
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
pub use decomposition::{Decomposition, DistributedGrid};
pub(crate) use fragments::{ReceivedFragments, Traced};
pub(crate) use gather::{FrameSummary, TileAssignment, TileShare};
pub use local::{LocalMessages, LocalTeam, local_nodes, local_nodes_over, local_team, on_local_nodes};
pub use message_queue::{Communicator, MessageQueue};
use node::Returned;
pub(crate) use node::{LentNode, Node};
pub use node::{NodeMemory, NodeShare};
pub(crate) use node_fields::{NodeFields, Stored};
pub(crate) use part::Part;
pub(crate) use pump::{MessagePump, pumped};
pub use pump::{Messages, PointToPoint};
use wire::decode;
pub(crate) use wire::{RankLists, decode_lists, decode_next, encode, encode_lists};

use icoray_grid::{Error, ErrorKind, Result};
pub(crate) use load_balance::TileCosts;
use std::collections::BTreeMap;
use std::fmt;
use std::thread::sleep;
use std::time::Duration;

/// Messages by the rank that they are sent to or received from.
pub type RankMessages = BTreeMap<usize, Vec<u8>>;

/// Joins the bytes of two ranks or groups of ranks.
pub type JoinBytes<'j> = &'j dyn Fn(Vec<u8>, Vec<u8>) -> Result<Vec<u8>>;

/// Messages that a rank has sent to others.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Traffic {
    /// Their number.
    pub messages: u64,
    /// Their bytes.
    pub bytes: u64,
}

/// Transport of bytes between ranks. `reduce`, `share`, `share_among`, `find_group`, `broadcast` and `exchange` are
/// collective: every rank calls the same ones in the same order. Between two of them ranks may send to rank 0, which has
/// to receive all of it before the next.
///
/// # Errors
/// All methods: [`ErrorKind::Mpi`] when the transport itself fails. Then ranks may no longer be in step, and the team
/// is unusable.
#[expect(clippy::missing_errors_doc, reason = "the trait has them")]
pub trait Team: Send {
    /// This process's number, from 0.
    fn rank(&self) -> usize;

    /// Number of processes, at least 1.
    fn size(&self) -> usize;

    /// Whether ranks can be reached no more, now or later: then the team can only be dropped. Not collective.
    fn is_gone(&self) -> bool {
        false
    }

    /// Marks that a rank has left: the team is dropped without messages to the others, which might never answer. Not
    /// collective.
    fn give_up(&mut self) {}

    /// Joins the bytes of all ranks by `join`, in an order that depends on the number of ranks only, and returns them at
    /// rank 0; other ranks return no bytes, and may do so before all have called this.
    fn reduce(&mut self, mine: Vec<u8>, join: JoinBytes) -> Result<Vec<u8>>;

    /// Returns the bytes of all ranks, in order of rank, on every rank. Each rank receives as many bytes as all ranks
    /// send: for what every rank needs of all others.
    fn share(&mut self, mine: &[u8]) -> Result<Vec<Vec<u8>>> {
        let all = self.reduce(encode(&(self.rank(), mine)), &|mut all, mut others| {
            all.append(&mut others);
            Ok(all)
        })?;
        let all = self.broadcast(all)?;
        let mut unread = &all[..];
        let mut shared = vec![Vec::new(); self.size()];
        while !unread.is_empty() {
            let (rank, bytes): (usize, &[u8]) = decode_next(&mut unread)?;
            let of_rank = shared.get_mut(rank);
            *of_rank.ok_or_else(|| Error::new(ErrorKind::Mpi, format!("a message of rank {rank}")))? = bytes.to_vec();
        }
        Ok(shared)
    }

    /// Returns the bytes of the `members` of this rank's group, in their order: equal on all of them, and each rank is in
    /// one group. The number of a rank's messages grows with the logarithm of theirs.
    fn share_among(&mut self, members: &[usize], mine: Vec<u8>) -> Result<Vec<Vec<u8>>>;

    /// The ranks that give the same `leader`, which finds them, and the same `group`, in rising order.
    fn find_group(&mut self, leader: usize, group: usize) -> Result<Vec<usize>> {
        let groups = self.exchange([(leader, encode(&group))].into())?;
        let same_as = |group: &[u8]| -> Vec<usize> {
            groups.iter().filter(|(_, other)| *other == group).map(|(rank, _)| *rank).collect()
        };
        let found = self.exchange(groups.iter().map(|(rank, group)| (*rank, encode(&same_as(group)))).collect())?;
        found.get(&leader).map_or_else(
            || Err(Error::new(ErrorKind::Mpi, format!("rank {leader} has not found the ranks of its node"))),
            |bytes| decode(bytes),
        )
    }

    /// Returns rank 0's bytes on all ranks; those of other ranks are dropped.
    fn broadcast(&mut self, mine: Vec<u8>) -> Result<Vec<u8>>;

    /// Starts to send bytes to rank 0, from any other rank, without waiting.
    fn send(&mut self, bytes: Vec<u8>) -> Result<()>;

    /// Progresses the messages that this rank is sending; returns whether all are sent. They must be, before the next
    /// collective call.
    fn is_sent(&mut self) -> Result<bool>;

    /// At rank 0: bytes that have arrived, with the number of the rank that sent them, in the order of that rank.
    fn try_receive(&mut self) -> Result<Option<(usize, Vec<u8>)>>;

    /// At rank 0, without other work: returns when there may be bytes to receive, or a little later.
    fn wait(&mut self) -> Result<()> {
        sleep(NAP);
        Ok(())
    }

    /// Sends `mine` and returns what other ranks sent to this one. A rank's bytes to itself are returned unchanged;
    /// empty messages are not sent.
    fn exchange(&mut self, mine: RankMessages) -> Result<RankMessages>;

    /// This process's number among those of its node, from 0. Collective. By default all ranks are on one node.
    fn node_rank(&mut self) -> Result<usize> {
        Ok(self.rank())
    }

    /// The number of the first rank of this one's node. Collective. By default all ranks are on one node.
    fn node_leader(&mut self) -> Result<usize> {
        Ok(0)
    }

    /// The ranks that share memory with this one, of [`Self::node`], this one included, in rising order. Collective. By
    /// default no ranks share memory.
    fn memory_mates(&mut self) -> Result<Vec<usize>> {
        Ok(vec![self.rank()])
    }

    /// Allocates `bytes` bytes of memory for each node, equal on all ranks. If memory cannot be shared, each rank has
    /// its own. Collective; so is dropping it, unless ranks are gone or the team was given up.
    fn node(&mut self, bytes: usize) -> Result<NodeShare> {
        Ok(NodeShare::alone(self.rank(), bytes))
    }

    /// Messages between the same ranks, separate from those of this team. Collective; so is dropping them, unless ranks
    /// are gone or the team was given up. By default a team has none: [`ErrorKind::Unsupported`].
    fn point_to_point(&mut self) -> Result<Box<dyn PointToPoint>> {
        Err(Error::new(ErrorKind::Unsupported, "these ranks cannot render in the background"))
    }

    /// The messages of this team that this rank has sent so far, if the team counts them. Not collective.
    fn traffic(&self) -> Traffic {
        Traffic::default()
    }

    /// Begins a frame: drops messages of a frame that ended early. Not collective. Only for teams that notify ranks
    /// when one of them leaves a frame ([`Self::break_off`]).
    fn begin_frame(&mut self) {}

    /// Ends this rank's frame with `error`, which other ranks may not have received; their calls fail until the next
    /// frame. Not collective.
    fn break_off(&mut self, _error: &Error) {}
}

/// Time for which a rank that waits for messages sleeps: short, but not a loop that keeps a processor busy.
const NAP: Duration = Duration::from_micros(50);

/// The ranks that draw together, and the costs of the last frame's tiles.
#[derive(Default)]
pub struct Ranks {
    /// Memory of this rank's node that no frame uses, in the same order on all ranks. Dropped before the team that
    /// allocated it.
    nodes: Vec<Node>,
    /// Memory of nodes that was lent and returned, and the number of times that any was lent.
    returned: Returned,
    lent: u64,
    /// The transport; `None` for a single process.
    team: Option<Box<dyn Team>>,
    /// A rank that closed its context before the others; no messages are exchanged after that.
    left: Option<usize>,
    /// Seconds of the last frame's tiles, at rank 0.
    costs: Option<TileCosts>,
    /// Seconds of the last frame's tiles of fragments, on this rank's node.
    part_costs: Option<TileCosts>,
    /// This rank's number on its node, once requested.
    node_rank: Option<usize>,
}

impl Ranks {
    /// One process that draws alone: no message is sent, and panics are not caught.
    pub fn alone() -> Self {
        Ranks::default()
    }

    /// The ranks of a team.
    pub fn new(team: Box<dyn Team>) -> Self {
        Ranks { team: Some(team), ..Ranks::default() }
    }

    /// This process's number, from 0.
    pub fn rank(&self) -> usize {
        self.team.as_ref().map_or(0, |team| team.rank())
    }

    /// Number of ranks, at least 1.
    pub fn size(&self) -> usize {
        self.team.as_ref().map_or(1, |team| team.size())
    }

    /// Whether this is one process without a team; a team may have one rank too.
    pub fn is_alone(&self) -> bool {
        self.team.is_none()
    }

    /// Whether the other ranks can be reached no more: MPI was finalised, or a rank closed its context before the
    /// others.
    pub fn is_gone(&self) -> bool {
        self.left.is_some() || self.team.as_ref().is_some_and(|team| team.is_gone())
    }

    /// Whether this is rank 0, which receives the picture.
    pub fn is_root(&self) -> bool {
        self.rank() == 0
    }

    /// The messages that this rank has sent so far. Not collective.
    pub fn traffic(&self) -> Traffic {
        self.team.as_ref().map_or_else(Traffic::default, |team| team.traffic())
    }

    /// This process's number among those of its node, from 0. Collective.
    pub(crate) fn node_rank(&mut self) -> Result<usize> {
        if let (None, Some(team)) = (self.node_rank, &mut self.team) {
            let found = team.node_rank();
            self.node_rank = Some(self.collective(found)?);
        }
        Ok(self.node_rank.unwrap_or(0))
    }

    /// Number of ranks of this node, this one included, that may run on some of the processors of `mask`, a bit for
    /// each; an empty mask stands for all of them. Collective.
    ///
    /// # Errors
    /// [`ErrorKind::Mpi`] when the transport fails.
    pub fn sharing_processors(&mut self, mask: &[u8]) -> Result<usize> {
        let Some(team) = &mut self.team else { return Ok(1) };
        let mine = team.node_leader();
        let leader = self.collective(mine)?;
        // The leader of the node counts for all of its ranks.
        let masks = decode_lists::<u8>(&self.exchange(encode_lists(&[(leader, mask.to_vec())].into()))?);
        let masks = self.collective(masks)?;
        let count = |mask: &[u8]| masks.values().filter(|other| overlap(mask, other)).count();
        let counts = self.exchange(masks.iter().map(|(rank, mask)| (*rank, encode(&count(mask)))).collect())?;
        let count = counts.get(&leader).map_or_else(
            || Err(Error::new(ErrorKind::Mpi, format!("rank {leader} has not counted the ranks of its node"))),
            |bytes| decode(bytes),
        );
        self.collective(count)
    }

    /// Messages between the same ranks, separate from all others; `None` for one process alone. Collective.
    pub(crate) fn point_to_point(&mut self) -> Result<Option<Box<dyn PointToPoint>>> {
        let Some(team) = &mut self.team else { return Ok(None) };
        let made = team.point_to_point();
        self.collective(made).map(Some)
    }

    /// Begins a frame that other ranks may leave early ([`Team::begin_frame`]).
    pub(crate) fn begin_frame(&mut self) {
        self.team.iter_mut().for_each(|team| team.begin_frame());
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
pub(crate) mod tests;
