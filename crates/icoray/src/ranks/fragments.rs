//! The exchange of fragments: from the ranks that traced them through their parts to the owners of tiles.

use super::wire::{decode_next, encode};
use super::{RankMessages, Ranks, TileCosts};
use crate::raster::{Raster, Tiling};
use icoray_grid::{Error, ErrorKind, Result};
use icoray_kernel::Counts;
use std::collections::BTreeMap;

/// The head of a message, which ends it or is followed by tiles, each its number (4 bytes) and its fragments: the
/// seconds of tiles of the sender.
type Head = Vec<(u32, f32)>;

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

/// The messages that a rank has received.
#[derive(Debug)]
pub(crate) struct ReceivedFragments(RankMessages);

impl Traced {
    /// The messages to the owners of tiles with fragments and, for the seconds, to `mates`, the ranks with the same part.
    /// Counts the bytes of fragments for other ranks.
    pub fn messages(&mut self, ranks: &Ranks, mates: &[usize], owners: &[u32]) -> RankMessages {
        let (none, seconds) = (encode(&Head::new()), encode(&self.seconds));
        let mut messages: RankMessages = mates.iter().map(|mate| (*mate, seconds.clone())).collect();
        for (tile, fragments) in std::mem::take(&mut self.tiles) {
            let owner = owners[tile as usize] as usize;
            let message = messages.entry(owner).or_insert_with(|| none.clone());
            message.extend_from_slice(&tile.to_le_bytes());
            message.extend_from_slice(&fragments);
            if owner != ranks.rank() {
                self.counts.fragment_bytes += (4 + fragments.len()) as u64;
            }
        }
        messages
    }
}

impl ReceivedFragments {
    /// Exchanges messages with the other ranks. Collective.
    pub fn exchange(ranks: &mut Ranks, messages: RankMessages) -> Result<Self> {
        ranks.exchange(messages).map(ReceivedFragments)
    }

    /// Passes each tile to `give` with the bytes from its fragments on, in order of the ranks that sent them; `give`
    /// advances the bytes past the tile.
    pub fn read<'r>(&'r self, mut give: impl FnMut(u32, &mut &'r [u8]) -> Result<()>) -> Result<()> {
        for bytes in self.0.values() {
            let mut unread = &bytes[..];
            decode_next::<Head>(&mut unread)?;
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

    /// The seconds of the tiles of a part, as received from the ranks that share it.
    pub fn costs(&self, raster: Raster, mates: &[usize]) -> Result<TileCosts> {
        let mut costs = TileCosts::new(raster);
        for bytes in mates.iter().filter_map(|mate| self.0.get(mate)) {
            for (tile, seconds) in decode_next::<Head>(&mut &bytes[..])? {
                if tile >= raster.tiles() {
                    return Err(Error::new(ErrorKind::Mpi, format!("seconds of a tile {tile} of {}", raster.tiles())));
                }
                costs.set(tile, seconds.into());
            }
        }
        Ok(costs)
    }
}
