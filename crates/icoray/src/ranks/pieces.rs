//! Messages of any length over transports that count their bytes in 32 bits.

use super::team::Message;
use super::wire::{WireError, decode, encode};
use icoray_grid::{Error, ErrorKind, Result};
use std::collections::BTreeMap;

/// Maximum number of bytes of a piece, without the 9 behind them.
const MAX_BYTES: usize = 1 << 30;
/// The last byte of each piece, after the 8 bytes of its call's number: the message ends here.
const END: u8 = 0;
/// The message continues in the sender's next piece.
const MORE: u8 = 1;
/// The sender's frame has ended with the error in this message.
const BROKEN: u8 = 2;

/// Bytes with the rank that they are sent to or received from.
pub(super) type Addressed = (usize, Vec<u8>);

/// Splits messages into pieces, and joins pieces to messages.
#[derive(Debug)]
pub(crate) struct Pieces {
    /// Incomplete messages, by sender.
    begun: BTreeMap<usize, Vec<u8>>,
    pub(super) most: usize,
}

impl Default for Pieces {
    fn default() -> Self {
        Pieces { begun: BTreeMap::new(), most: MAX_BYTES }
    }
}

impl Pieces {
    /// Passes the pieces of a message to `send`, in order.
    pub fn split(&self, call: u64, body: Result<Vec<u8>>, mut send: impl FnMut(Vec<u8>) -> Result<()>) -> Result<()> {
        let (mut bytes, kind) = match body {
            Ok(bytes) => (bytes, END),
            Err(error) => (encode(&WireError::from(&error)), BROKEN),
        };
        let mut send_piece = |mut bytes: Vec<u8>, kind: u8| {
            bytes.extend_from_slice(&call.to_le_bytes());
            bytes.push(kind);
            send(bytes)
        };
        while bytes.len() > self.most {
            let rest = bytes.split_off(self.most);
            send_piece(bytes, MORE)?;
            bytes = rest;
        }
        send_piece(bytes, kind)
    }

    /// The message that ends with this piece.
    pub fn join(&mut self, (from, mut bytes): Addressed) -> Result<Option<Message>> {
        let cut = || Error::new(ErrorKind::Mpi, format!("a message of rank {from} is shorter than its header states"));
        let kind = bytes.pop().ok_or_else(cut)?;
        let (body, call) = bytes.split_last_chunk().ok_or_else(cut)?;
        let (length, call) = (body.len(), u64::from_le_bytes(*call));
        bytes.truncate(length);
        let bytes = match self.begun.remove(&from) {
            Some(begun) => [begun, bytes].concat(),
            None => bytes,
        };
        let body = match kind {
            MORE => {
                self.begun.insert(from, bytes);
                return Ok(None);
            }
            BROKEN => Err(decode::<WireError>(&bytes)?.received()),
            _ => Ok(bytes),
        };
        Ok(Some(Message { from, call, body }))
    }
}
