//! Several processes, the ranks, draw one picture: each some of its tiles, over data that every one of them has, or a
//! whole picture of its [`Part`]. Of data of which ranks have some [`Columns`] each, every node makes itself a copy.
//!
//! A [`Team`] carries bytes between ranks; what they say is decided here, and is the same over MPI and between threads
//! ([`local_team`]). The rule that keeps anybody from waiting for ever: ranks talk in phases that each of them enters,
//! whatever has gone wrong on it, and every phase ends with the same outcome on all. A frame has three:
//!
//! 1. [`Ranks::agree`]: is everybody ready, of one mind, and what does rank 0 say? Again where rank 0 has decided more.
//! 2. Tiles go to rank 0 as they are drawn, in whatever order, and behind them whether their rank has drawn all of them.
//! 3. Rank 0 tells all what came of it.
//!
//! Only the thread that calls talks; the renderer's threads never do, and draw on meanwhile.

mod agree;
mod cells;
mod columns;
mod deal;
mod gather;
mod held;
mod local;
mod node;
mod packed;
mod part;
mod words;

pub use agree::{Agreement, Refusal, Word};
use cells::bad;
pub use cells::{Owned, PartCells};
pub use columns::Columns;
pub(crate) use columns::Placed;
pub(crate) use gather::{Share, Told};
pub use held::Held;
pub use local::{LocalTeam, local_nodes, local_team};
pub(crate) use node::Node;
pub use node::{NodeMemory, NodeShare};
pub use part::Part;
pub(crate) use words::{Reader, Words};

use crate::error::{Error, Result};
use deal::Costs;
use std::fmt;

/// What carries bytes between ranks. `share`, `broadcast` and `exchange` are collective: every rank calls the same ones in the
/// same order. Between two of them ranks may send to rank 0, which has to receive all of it before the next.
///
/// # Errors
/// Of every method: [`ErrorKind::Mpi`](crate::ErrorKind::Mpi) when the transport itself fails. Then ranks may no longer be
/// in step, and the team is of no more use.
pub trait Team: Send {
    /// This process's number, from 0.
    fn rank(&self) -> usize;

    /// How many there are, at least 1.
    fn size(&self) -> usize;

    /// Whether ranks can be reached no more, now or later: then nothing but dropping the team is of use. Not collective.
    fn is_gone(&self) -> bool {
        false
    }

    /// A rank has left: the team is let go without a word to the others, who might never answer. Not collective.
    fn give_up(&mut self) {}

    /// Hands every rank's bytes to all, in order of rank.
    #[expect(clippy::missing_errors_doc, reason = "the trait has them")]
    fn share(&mut self, mine: &[u8]) -> Result<Vec<Vec<u8>>>;

    /// Rank 0's bytes to all; those of others are let go.
    #[expect(clippy::missing_errors_doc, reason = "the trait has them")]
    fn broadcast(&mut self, mine: Vec<u8>) -> Result<Vec<u8>>;

    /// Begins to send bytes to rank 0, from any other; waits for nobody.
    #[expect(clippy::missing_errors_doc, reason = "the trait has them")]
    fn send(&mut self, bytes: Vec<u8>) -> Result<()>;

    /// Helps along what this rank is sending; whether all of it has gone. It has to have, before the next collective call.
    #[expect(clippy::missing_errors_doc, reason = "the trait has them")]
    fn is_sent(&mut self) -> Result<bool>;

    /// At rank 0: bytes that have come, with the number of the rank that sent them, in the order in which that rank did.
    #[expect(clippy::missing_errors_doc, reason = "the trait has them")]
    fn try_receive(&mut self) -> Result<Option<(usize, Vec<u8>)>>;

    /// Hands `mine[j]` to rank `j` and returns what each rank has for this one, in order of rank. What is for oneself is
    /// handed back as it is.
    ///
    /// # Panics
    /// When `mine` has not as many entries as there are ranks.
    #[expect(clippy::missing_errors_doc, reason = "the trait has them")]
    fn exchange(&mut self, mine: Vec<Vec<u8>>) -> Result<Vec<Vec<u8>>>;

    /// This process's number among those of its node, from 0. Collective. By itself a team takes all to be on one node.
    #[expect(clippy::missing_errors_doc, reason = "the trait has them")]
    fn node_rank(&mut self) -> Result<usize> {
        Ok(self.rank())
    }

    /// Memory of so many bytes for each node, as many on all ranks. Where none can be shared, each rank has its own.
    /// Collective; so is dropping it, unless ranks are gone or the team was given up.
    #[expect(clippy::missing_errors_doc, reason = "the trait has them")]
    fn node(&mut self, bytes: usize) -> Result<NodeShare> {
        Ok(NodeShare::alone(self.rank(), bytes))
    }
}

/// The ranks that draw together, and what the last frame taught about its tiles.
pub struct Ranks {
    /// Memory of this rank's node, once it was needed. Dropped before the team that gave it.
    node: Option<Node>,
    /// `None` is one process alone.
    team: Option<Box<dyn Team>>,
    /// A rank that has left while others stayed, after which nobody talks any more.
    left: Option<usize>,
    /// At rank 0: of the last frame.
    costs: Option<Costs>,
    /// Once it was needed.
    node_rank: Option<usize>,
}

impl Ranks {
    /// One process that draws alone: nothing is sent, and panics are not caught.
    pub fn alone() -> Self {
        Ranks { node: None, team: None, left: None, costs: None, node_rank: Some(0) }
    }

    /// Those of a team.
    pub fn new(team: Box<dyn Team>) -> Self {
        Ranks { node: None, team: Some(team), left: None, costs: None, node_rank: None }
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

    /// Whether this is the process that has the picture in the end.
    pub fn is_root(&self) -> bool {
        self.rank() == 0
    }

    /// This process's number among those of its node, from 0. Collective.
    pub(crate) fn node_rank(&mut self) -> Result<usize> {
        if let (None, Some(team)) = (self.node_rank, &mut self.team) {
            let found = team.node_rank();
            self.node_rank = Some(self.together(found)?);
        }
        Ok(self.node_rank.unwrap_or(0))
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

impl fmt::Debug for Ranks {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "rank {} of {}", self.rank(), self.size())
    }
}

#[cfg(test)]
mod tests;
