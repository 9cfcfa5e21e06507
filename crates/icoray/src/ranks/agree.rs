//! Whether all ranks are ready and of one mind: a status before each phase.

use super::Ranks;
use super::words::{Reader, Words};
use crate::error::{Error, ErrorKind, Result};

/// What a rank brings to an agreement.
#[derive(Debug, Clone, Default)]
pub struct Word<'a> {
    /// Why it cannot go on: a number other than 0, and a sentence.
    pub refusal: Option<(i32, &'a str)>,
    /// What must be the same on all, each with a name for the sentence that says it is not: "step", "6".
    pub facts: Vec<(&'static str, String)>,
    /// What rank 0 has to say; nobody reads that of others.
    pub value: &'a [u8],
    /// Whether it is the last that is heard of this rank. Where others stay, the team is given up: nobody waits for one that
    /// has left.
    pub leaves: bool,
}

/// What came of an agreement, the same on all ranks.
#[derive(Debug, Clone)]
pub struct Agreement {
    /// Why none of them goes on, if so.
    pub refusal: Option<Refusal>,
    /// What rank 0 said, whether or not all go on.
    pub value: Vec<u8>,
}

/// Why ranks do not go on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Refusal {
    /// The number that the rank gave; `None` where ranks are not of one mind.
    pub number: Option<i32>,
    /// That rank: the lowest of those that refuse, else the lowest that differs from rank 0.
    pub rank: usize,
    /// Its sentence, or which fact it is and what it is on both.
    pub sentence: String,
}

/// One rank's word, as it came.
struct Heard {
    refusal: Option<(i32, String)>,
    facts: Vec<(String, String)>,
    value: Vec<u8>,
    leaves: bool,
}

impl Ranks {
    /// Brings this rank's word, and tells what all are to do. Collective. Any refusal, of whichever rank, is everybody's, and
    /// facts are compared only where nobody refuses.
    ///
    /// # Errors
    /// [`ErrorKind::Mpi`] when the transport fails.
    pub fn agree(&mut self, mine: &Word) -> Result<Agreement> {
        if let Some(rank) = self.left {
            let message =
                format!("rank {rank} has closed its context, so no picture can be drawn over all ranks");
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
        let mut words = Words::default();
        let (number, sentence) = mine.refusal.unwrap_or_default();
        words.put(number as u64).put_bytes(sentence.as_bytes()).put_bytes(value).put(mine.leaves.into());
        words.put(mine.facts.len() as u64);
        for (name, fact) in &mine.facts {
            words.put_bytes(name.as_bytes()).put_bytes(fact.as_bytes());
        }
        let heard = team.share(&words.0)?;
        let mut heard = heard.iter().map(|bytes| hear(bytes)).collect::<Result<Vec<_>>>()?;
        if !heard.iter().all(|heard| heard.leaves) {
            self.left = heard.iter().position(|heard| heard.leaves);
        }
        if self.left.is_some() {
            team.give_up();
        }
        let refusal = refusal(&heard);
        let value = heard.first_mut().map(|root| std::mem::take(&mut root.value)).unwrap_or_default();
        Ok(Agreement { refusal, value })
    }

    /// Hands on what went well; what did not is brought to the others, who are at an agreement or will be, and what they
    /// agree on is the error of all.
    pub(crate) fn settle<R>(&mut self, mine: Result<R>) -> Result<R> {
        let error = match mine {
            Ok(value) => return Ok(value),
            Err(error) => error,
        };
        if self.team.is_none() {
            return Err(error);
        }
        self.agree_on(Err(error), Vec::new())
            .and_then(|_| Err(Error::new(ErrorKind::Internal, "a refusal was not heard")))
    }

    /// Hands on what went well everywhere; what did not on any rank is the error of all. A phase of its own: collective.
    ///
    /// # Errors
    /// That of the lowest rank that has one, with the rank's number; [`ErrorKind::Mpi`] when the transport fails.
    pub fn together<R>(&mut self, mine: Result<R>) -> Result<R> {
        self.of_one_mind(mine, |_| Vec::new())
    }

    /// The same where `facts` of what went well must be the same on all ranks.
    pub(crate) fn of_one_mind<R>(
        &mut self,
        mine: Result<R>,
        facts: impl FnOnce(&R) -> Vec<(&'static str, String)>,
    ) -> Result<R> {
        if self.team.is_none() {
            return mine;
        }
        let (word, facts) = match &mine {
            Ok(value) => (Ok(Vec::new()), facts(value)),
            Err(e) => (Err(e.clone()), Vec::new()),
        };
        self.agree_on(word, facts)?;
        mine
    }

    /// Rank 0's value where all are ready and of one mind, and the error of all where they are not.
    pub(crate) fn agree_on(
        &mut self,
        mine: Result<Vec<u8>>,
        facts: Vec<(&'static str, String)>,
    ) -> Result<Vec<u8>> {
        let word = match &mine {
            Ok(value) => Word { facts, value, ..Word::default() },
            Err(e) => Word { refusal: Some((e.kind().number(), e.context())), ..Word::default() },
        };
        let Agreement { refusal, value } = self.agree(&word)?;
        refusal.map_or(Ok(value), |refusal| Err(refusal.error(self.size())))
    }
}

impl Refusal {
    /// The sentence with the number of the rank whose it is, where there are several.
    pub fn told(&self, ranks: usize) -> String {
        if ranks == 1 { self.sentence.clone() } else { format!("rank {}: {}", self.rank, self.sentence) }
    }

    /// As an error; ranks that differ are [`ErrorKind::Mpi`].
    pub(crate) fn error(&self, ranks: usize) -> Error {
        let kind = self.number.map_or(ErrorKind::Mpi, ErrorKind::of_number);
        Error::new(kind, self.told(ranks))
    }
}

fn hear(bytes: &[u8]) -> Result<Heard> {
    let mut reader = Reader(bytes);
    let (number, sentence) = (reader.get()? as i32, reader.get_text()?);
    let value = reader.get_bytes()?.to_vec();
    let leaves = reader.get()? == 1;
    let mut facts = Vec::new();
    for _ in 0..reader.get()? {
        facts.push((reader.get_text()?, reader.get_text()?));
    }
    Ok(Heard { refusal: (number != 0).then_some((number, sentence)), facts, value, leaves })
}

/// The lowest rank's refusal, or what the lowest that differs from rank 0 has otherwise.
fn refusal(heard: &[Heard]) -> Option<Refusal> {
    for (rank, heard) in heard.iter().enumerate() {
        if let Some((number, sentence)) = &heard.refusal {
            return Some(Refusal { number: Some(*number), rank, sentence: sentence.clone() });
        }
    }
    let root = heard.first()?;
    for (rank, other) in heard.iter().enumerate().skip(1) {
        let differs = other.facts.iter().zip(&root.facts).find(|(mine, roots)| mine != roots);
        let sentence = match differs {
            Some(((name, mine), (roots_name, roots))) if name == roots_name => {
                format!(
                    "{name} {mine}, but {roots} on rank 0; ranks that draw one picture must have the same"
                )
            }
            None if other.facts.len() == root.facts.len() => continue,
            _ => "is in another call than rank 0".into(),
        };
        return Some(Refusal { number: None, rank, sentence });
    }
    None
}
