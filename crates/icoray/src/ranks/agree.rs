//! Agreement of all ranks before each phase: every rank is ready, and all have the same data.

use super::Ranks;
use super::wire::{decode, encode};
use icoray_grid::{Error, ErrorKind, Result};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// Name of the facts about tables and fields that every rank has whole. Parts differ by design.
pub(crate) const HAS_WHOLE: &str = "has of the whole grid (ranks with parts call icoray_part_set)";

/// The vote of one rank in an agreement.
#[derive(Debug, Clone, Default)]
pub struct Vote<'a> {
    /// The reason why it cannot continue: a number other than 0, and a sentence.
    pub refusal: Option<(i32, &'a str)>,
    /// Values that must be equal on all ranks, each with a name for the error message: "step", "6".
    pub facts: Vec<(&'static str, String)>,
    /// The value that rank 0 broadcasts; ignored on other ranks.
    pub value: &'a [u8],
    /// Whether the rank leaves after this agreement. If others stay, all give the team up, so that no rank waits for
    /// it.
    pub leaves: bool,
}

/// The outcome of an agreement, the same on all ranks.
#[derive(Debug, Clone)]
pub struct Agreement {
    /// The reason why no rank continues, if there is one.
    pub refusal: Option<Refusal>,
    /// The value of rank 0, whether or not all ranks continue.
    pub value: Vec<u8>,
}

/// The reason why ranks do not continue.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Refusal {
    /// The number that the rank gave; `None` if ranks disagree.
    pub number: Option<i32>,
    /// The number of that rank: the lowest that refuses, else the lowest that differs from rank 0.
    pub rank: usize,
    /// The rank's message, or the name of the fact and its values on both ranks.
    pub sentence: String,
}

/// One rank's [`Vote`], as received; the members are in the order in which they are sent.
#[derive(Debug, Deserialize)]
struct ReceivedVote {
    refusal: Option<(i32, String)>,
    facts: Vec<(String, String)>,
    value: Vec<u8>,
    leaves: bool,
}

impl Ranks {
    /// Exchanges the votes of all ranks. Collective. A refusal of any rank is the outcome on all ranks; facts are
    /// compared only if no rank refuses.
    ///
    /// # Errors
    /// [`ErrorKind::Mpi`] when the transport fails.
    pub fn agree(&mut self, mine: &Vote) -> Result<Agreement> {
        if let Some(rank) = self.left {
            let message = format!("rank {rank} has closed its context, so no picture can be drawn over all ranks");
            return Err(Error::new(ErrorKind::Mpi, message));
        }
        let Some(team) = &mut self.team else {
            let refusal = mine.refusal.map(|(number, sentence)| Refusal {
                number: Some(number),
                rank: 0,
                sentence: sentence.into(),
            });
            return Ok(Agreement { refusal, value: mine.value.to_vec() });
        };
        if team.is_gone() {
            return Err(Error::new(ErrorKind::Mpi, "ranks cannot be reached any more: MPI was finalised"));
        }
        let value = if team.rank() == 0 { mine.value } else { &[] };
        let votes = team.share(&encode(&(mine.refusal, &mine.facts, value, mine.leaves)))?;
        let mut votes = votes.iter().map(|bytes| decode(bytes)).collect::<Result<Vec<ReceivedVote>>>()?;
        if !votes.iter().all(|vote| vote.leaves) {
            self.left = votes.iter().position(|vote| vote.leaves);
        }
        if self.left.is_some() {
            team.give_up();
        }
        let refusal = refusal(&votes);
        let value = votes.first_mut().map(|root| std::mem::take(&mut root.value)).unwrap_or_default();
        Ok(Agreement { refusal, value })
    }

    /// Returns `mine` if it is a success on all ranks; else all ranks return the error of the lowest failed rank.
    /// Collective.
    ///
    /// # Errors
    /// The error of the lowest failed rank, with the rank's number; [`ErrorKind::Mpi`] when the transport fails.
    pub fn collective<R>(&mut self, mine: Result<R>) -> Result<R> {
        self.agree_all(mine, |_| Vec::new())
    }

    /// As [`Self::collective`], where the `facts` of a success must also be equal on all ranks.
    pub(crate) fn agree_all<R>(
        &mut self,
        mine: Result<R>,
        facts: impl FnOnce(&R) -> Vec<(&'static str, String)>,
    ) -> Result<R> {
        if self.team.is_none() {
            return mine;
        }
        let facts = mine.as_ref().map_or_else(|_| Vec::new(), facts);
        self.agree_on(mine.as_ref().map(drop).map_err(Error::clone), facts)?;
        mine
    }

    /// Rank 0's value if no rank has an error and the facts are equal; else the error of all ranks.
    pub(crate) fn agree_on<T: Serialize + DeserializeOwned>(
        &mut self,
        mine: Result<T>,
        facts: Vec<(&'static str, String)>,
    ) -> Result<T> {
        let mine = mine.map(|value| encode(&value));
        let vote = match &mine {
            Ok(value) => Vote { facts, value, ..Vote::default() },
            Err(e) => Vote { refusal: Some((e.kind().number(), e.context())), ..Vote::default() },
        };
        let Agreement { refusal, value } = self.agree(&vote)?;
        refusal.map_or_else(|| decode(&value), |refusal| Err(refusal.error(self.size())))
    }
}

impl Refusal {
    /// The sentence, preceded by the number of its rank if there are several ranks.
    pub fn message(&self, ranks: usize) -> String {
        if ranks == 1 { self.sentence.clone() } else { format!("rank {}: {}", self.rank, self.sentence) }
    }

    /// Converts the refusal to an error; ranks that differ are [`ErrorKind::Mpi`].
    pub(crate) fn error(&self, ranks: usize) -> Error {
        let kind = self.number.map_or(ErrorKind::Mpi, ErrorKind::of_number);
        Error::new(kind, self.message(ranks))
    }
}

/// The refusal of the lowest rank that refuses, or else the first fact in which the lowest rank that differs from rank
/// 0 differs.
fn refusal(votes: &[ReceivedVote]) -> Option<Refusal> {
    for (rank, vote) in votes.iter().enumerate() {
        if let Some((number, sentence)) = &vote.refusal {
            return Some(Refusal { number: Some(*number), rank, sentence: sentence.clone() });
        }
    }
    let root = votes.first()?;
    for (rank, other) in votes.iter().enumerate().skip(1) {
        let differs = other.facts.iter().zip(&root.facts).find(|(mine, roots)| mine != roots);
        let sentence = match differs {
            Some(((name, mine), (roots_name, roots))) if name == roots_name => {
                format!("{name} {mine}, but {roots} on rank 0; ranks that draw one picture must have the same")
            }
            None if other.facts.len() == root.facts.len() => continue,
            _ => "is in another call than rank 0".into(),
        };
        return Some(Refusal { number: None, rank, sentence });
    }
    None
}
