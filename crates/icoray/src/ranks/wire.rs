//! The encoding of messages between ranks: `postcard`, as all ranks run the same program.

use super::Ranks;
use icoray_grid::{Error, ErrorKind, Result};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

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

/// Encodes one list per rank; an empty list becomes an empty message, which is not sent.
pub(crate) fn encode_lists<T: Serialize>(lists: &[Vec<T>]) -> Vec<Vec<u8>> {
    lists.iter().map(|list| if list.is_empty() { Vec::new() } else { encode(list) }).collect()
}

/// Decodes one rank's message, encoded by [`encode_lists`].
pub(crate) fn decode_list<T: DeserializeOwned>(bytes: &[u8]) -> Result<Vec<T>> {
    if bytes.is_empty() { Ok(Vec::new()) } else { decode(bytes) }
}

/// Decodes the messages of all ranks, encoded by [`encode_lists`].
pub(crate) fn decode_lists<T: DeserializeOwned>(messages: &[Vec<u8>]) -> Result<Vec<Vec<T>>> {
    messages.iter().map(|bytes| decode_list(bytes)).collect()
}

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
    /// Every rank's value, in order of rank. Collective.
    pub(crate) fn share_values<T: Serialize + DeserializeOwned>(&mut self, mine: &T) -> Result<Vec<T>> {
        self.share(&encode(mine))?.iter().map(|bytes| decode(bytes)).collect()
    }

    /// As [`Self::share_values`], of the values that `work` returns. If it fails or panics on any rank, that is the error
    /// of all ranks. Collective.
    pub(crate) fn share_work<T: Serialize + DeserializeOwned>(
        &mut self,
        work: impl FnOnce() -> Result<T>,
    ) -> Result<Vec<T>> {
        let mine = self.attempt(work);
        let mine = self.collective(mine)?;
        self.share_values(&mine)
    }
}
