//! The encoding of messages between ranks: `postcard`, as all ranks run the same program.

use super::Ranks;
use icoray_grid::{Error, ErrorKind, Result};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Encodes a value.
pub(crate) fn encode<T: Serialize + ?Sized>(value: &T) -> Vec<u8> {
    postcard::to_stdvec(value).expect("messages consist of numbers, texts and lists of known length")
}

/// Decodes a value from the front of `bytes` and advances `bytes` past it.
pub(crate) fn decode_next<'b, T: Deserialize<'b>>(bytes: &mut &'b [u8]) -> Result<T> {
    let (value, others) = postcard::take_from_bytes(bytes)
        .map_err(|e| Error::new(ErrorKind::Mpi, format!("a message between ranks cannot be decoded: {e}")))?;
    *bytes = others;
    Ok(value)
}

/// Decodes a value.
pub(crate) fn decode<'b, T: Deserialize<'b>>(mut bytes: &'b [u8]) -> Result<T> {
    decode_next(&mut bytes)
}

/// Lists by the rank that they are sent to or received from.
pub(crate) type RankLists<T> = BTreeMap<usize, Vec<T>>;

/// An error in a message.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct WireError {
    kind: i32,
    context: String,
}

impl From<&Error> for WireError {
    fn from(error: &Error) -> Self {
        WireError { kind: error.kind().number(), context: error.context().to_owned() }
    }
}

impl WireError {
    /// Converts an error received from another rank. An `impl From` would make the type of `?` in closures of other
    /// crates ambiguous.
    pub fn received(self) -> Error {
        Error::new(ErrorKind::of_number(self.kind), self.context)
    }
}

impl Ranks {
    /// Sends a list to each of some ranks, and returns those that this one receives, its own included. Collective.
    pub(crate) fn exchange_lists<T: Serialize + DeserializeOwned>(
        &mut self,
        mine: &RankLists<T>,
    ) -> Result<RankLists<T>> {
        let received = self.exchange(mine.iter().map(|(rank, list)| (*rank, encode(list))).collect())?;
        received.iter().map(|(rank, bytes)| Ok((*rank, decode(bytes)?))).collect()
    }

    /// The values that `work` returns on all ranks, in order of rank: for what each rank needs of all others. If it fails
    /// or panics on any rank, that is the error of all ranks. Collective.
    pub(crate) fn share_work<T: Serialize + DeserializeOwned>(
        &mut self,
        work: impl FnOnce() -> Result<T>,
    ) -> Result<Vec<T>> {
        let mine = self.collective_work(work)?;
        self.share(&encode(&mine))?.iter().map(|bytes| decode(bytes)).collect()
    }

    /// The values of all ranks, joined by `join`, which is associative and commutative. Collective.
    pub(crate) fn reduce_values<T: Serialize + DeserializeOwned>(
        &mut self,
        mine: T,
        join: impl Fn(T, T) -> T,
    ) -> Result<T> {
        let Some(team) = &mut self.team else { return Ok(mine) };
        let joined = team.reduce(encode(&mine), &|a, b| Ok(encode(&join(decode(&a)?, decode(&b)?))))?;
        decode(&team.broadcast(joined)?)
    }

    /// As [`Self::reduce_values`], of the values that `work` returns. If it fails or panics on any rank, that is the
    /// error of all ranks. Collective.
    pub(crate) fn reduce_work<T: Serialize + DeserializeOwned>(
        &mut self,
        work: impl FnOnce() -> Result<T>,
        join: impl Fn(T, T) -> T,
    ) -> Result<T> {
        let mine = self.collective_work(work)?;
        self.reduce_values(mine, join)
    }
}
