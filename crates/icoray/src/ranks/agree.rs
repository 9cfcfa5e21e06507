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

/// The votes of some ranks.
#[derive(Debug, Serialize, Deserialize)]
struct JoinedVotes {
    /// The refusal of the lowest rank that refuses.
    refusal: Option<(usize, i32, String)>,
    /// The facts of the lowest rank.
    lowest: RankFacts,
    /// The lowest rank whose facts differ from these.
    other: Option<RankFacts>,
    /// The lowest rank that leaves.
    leaves: Option<usize>,
    /// Whether any rank stays.
    is_any_left: bool,
}

/// The facts of a rank, by name.
#[derive(Debug, Serialize, Deserialize)]
struct RankFacts {
    rank: usize,
    facts: Vec<(String, String)>,
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
        let join = |a: Vec<u8>, b: Vec<u8>| Ok(encode(&JoinedVotes::join(decode(&a)?, decode(&b)?)));
        let joined = team.reduce(encode(&JoinedVotes::of_rank(team.rank(), mine)), &join)?;
        let outcome = if team.rank() == 0 { encode(&(joined, mine.value)) } else { Vec::new() };
        let (votes, value): (Vec<u8>, Vec<u8>) = decode(&team.broadcast(outcome)?)?;
        let votes: JoinedVotes = decode(&votes)?;
        if votes.is_any_left {
            self.left = votes.leaves;
        }
        if self.left.is_some() {
            team.give_up();
        }
        Ok(Agreement { refusal: votes.into_refusal(), value })
    }

    /// Returns `mine` if it is a success on all ranks; else all ranks return the error of the lowest failed rank.
    /// Collective.
    ///
    /// # Errors
    /// The error of the lowest failed rank, with the rank's number; [`ErrorKind::Mpi`] when the transport fails.
    pub fn collective<R>(&mut self, mine: Result<R>) -> Result<R> {
        self.agree_all(mine, |_| Vec::new())
    }

    /// As [`Self::collective`], of the result of `work`, whose panics are errors too if there are other ranks. Collective.
    pub(crate) fn collective_work<R>(&mut self, work: impl FnOnce() -> Result<R>) -> Result<R> {
        let mine = self.attempt(work);
        self.collective(mine)
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

impl JoinedVotes {
    fn of_rank(rank: usize, vote: &Vote) -> Self {
        let facts = vote.facts.iter().map(|(name, value)| ((*name).to_owned(), value.clone())).collect();
        JoinedVotes {
            refusal: vote.refusal.map(|(number, sentence)| (rank, number, sentence.to_owned())),
            lowest: RankFacts { rank, facts },
            other: None,
            leaves: vote.leaves.then_some(rank),
            is_any_left: !vote.leaves,
        }
    }

    /// The votes of both groups of ranks.
    fn join(a: Self, b: Self) -> Self {
        let (a, b) = if a.lowest.rank < b.lowest.rank { (a, b) } else { (b, a) };
        // If the lowest ranks of both have the same facts, those of b that differ from them differ from those of a.
        let of_b = if b.lowest.facts == a.lowest.facts { b.other } else { Some(b.lowest) };
        JoinedVotes {
            refusal: a.refusal.into_iter().chain(b.refusal).min_by_key(|(rank, ..)| *rank),
            lowest: a.lowest,
            other: a.other.into_iter().chain(of_b).min_by_key(|other| other.rank),
            leaves: a.leaves.into_iter().chain(b.leaves).min(),
            is_any_left: a.is_any_left || b.is_any_left,
        }
    }

    /// The refusal of the lowest rank that refuses, or else the first fact in which the lowest rank that differs from
    /// rank 0 differs.
    fn into_refusal(self) -> Option<Refusal> {
        if let Some((rank, number, sentence)) = self.refusal {
            return Some(Refusal { number: Some(number), rank, sentence });
        }
        let (root, RankFacts { rank, facts }) = (self.lowest.facts, self.other?);
        let differs = facts.iter().zip(&root).find(|(mine, roots)| mine != roots);
        let sentence = match differs {
            Some(((name, mine), (roots_name, roots))) if name == roots_name => {
                format!("{name} {mine}, but {roots} on rank 0; ranks that draw one picture must have the same")
            }
            _ => "is in another call than rank 0".into(),
        };
        Some(Refusal { number: None, rank, sentence })
    }
}
