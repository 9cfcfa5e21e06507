//! The exchange of fragments: from the ranks that traced them through their parts to the owners of tiles.

use super::{RankMessages, Ranks};
use icoray_grid::{Error, ErrorKind, Result};
use icoray_kernel::Counts;
use std::collections::BTreeMap;

/// What a rank traced through its part.
#[derive(Debug, Default)]
pub(crate) struct Traced {
    /// The encoded fragments of tiles that have any.
    pub tiles: BTreeMap<u32, Vec<u8>>,
    /// Seconds of tiles.
    pub seconds: Vec<(u32, f32)>,
    /// Counts of rays.
    pub counts: Counts,
}

impl Traced {
    /// The messages to the owners of tiles with fragments: of each tile its number (4 bytes) and its fragments. Counts
    /// the bytes of fragments for other ranks.
    pub fn messages(&mut self, ranks: &Ranks, owners: &[u32]) -> RankMessages {
        let mut messages = RankMessages::new();
        for (tile, fragments) in std::mem::take(&mut self.tiles) {
            let owner = owners[tile as usize] as usize;
            let message = messages.entry(owner).or_default();
            message.extend_from_slice(&tile.to_le_bytes());
            message.extend_from_slice(&fragments);
            if owner != ranks.rank() {
                self.counts.fragment_bytes += (4 + fragments.len()) as u64;
            }
        }
        messages
    }
}

/// Passes each tile of received [`Traced::messages`] to `give` with the bytes from its fragments on, in order of the ranks
/// that sent them; `give` advances the bytes past the tile.
pub(crate) fn read_fragments<'r>(
    received: &'r RankMessages,
    mut give: impl FnMut(u32, &mut &'r [u8]) -> Result<()>,
) -> Result<()> {
    for bytes in received.values() {
        let mut unread = &bytes[..];
        while let Some((number, rest)) = unread.split_first_chunk::<4>() {
            unread = rest;
            give(u32::from_le_bytes(*number), &mut unread)?;
        }
        if !unread.is_empty() {
            return Err(Error::new(ErrorKind::Mpi, "a message with fragments is cut short"));
        }
    }
    Ok(())
}
