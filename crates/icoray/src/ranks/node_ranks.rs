//! Finds the ranks that share memory.

use super::Ranks;
use super::wire::{decode, encode};
use icoray_grid::Result;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// Columns or triangles of which a rank has a turn before the next one of its node: those that rays pass are close
/// together in most meshes, so longer turns would leave ranks without work.
const TURN: usize = 1024;

/// The node of this rank: a group of ranks that share memory, identified by its lowest rank, its leader. A rank knows
/// of other nodes only what it asks for ([`Self::partners`]).
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct NodeRanks {
    /// The ranks of the node, in rising order.
    mates: Vec<usize>,
    /// This rank's index among them.
    place: usize,
}

impl NodeRanks {
    /// Finds the ranks of this one's node. Collective.
    pub fn find(ranks: &mut Ranks) -> Result<Self> {
        let found = ranks.team.as_mut().map_or_else(|| Ok(vec![0]), |team| team.memory_mates());
        let mates = ranks.collective(found)?;
        let place = mates.iter().take_while(|mate| **mate < ranks.rank()).count();
        Ok(NodeRanks { mates, place })
    }

    /// One rank that shares its memory with no other.
    pub fn alone(rank: usize) -> Self {
        NodeRanks { mates: vec![rank], place: 0 }
    }

    pub fn leader(&self) -> usize {
        self.mates[0]
    }

    pub fn is_leader(&self) -> bool {
        self.place == 0
    }

    /// Whether a rank is on this one's node.
    pub fn is_mate(&self, rank: usize) -> bool {
        self.mates.binary_search(&rank).is_ok()
    }

    /// All of them, in rising order.
    pub fn mates(&self) -> &[usize] {
        &self.mates
    }

    /// This rank's index among them.
    pub fn place(&self) -> usize {
        self.place
    }

    /// Whether the thing `number` is this rank's where mates divide work: they have equal shares.
    pub fn has_share(&self, number: usize) -> bool {
        number % self.mates.len() == self.place
    }

    /// This rank's turns among `count` columns or triangles, where mates share work: each has some of them in turn.
    pub fn turns(&self, count: usize) -> impl Iterator<Item = Range<usize>> + use<> {
        let (place, size) = (self.place, self.mates.len());
        (place * TURN..count).step_by(size * TURN).map(move |first| first..count.min(first + TURN))
    }

    /// For each of the ranks `others` of other nodes one of them on its node, with which this rank exchanges data: the
    /// same for all of a node. Mates have different ones, as far as there are enough. `others` are equal on all mates.
    /// Collective.
    pub fn partners(&self, ranks: &mut Ranks, others: &BTreeSet<usize>) -> Result<BTreeMap<usize, usize>> {
        let asked = others.iter().filter(|other| self.has_share(**other)).map(|other| (*other, vec![0]));
        let asking = ranks.exchange(asked.collect())?;
        let answers = ranks.exchange(asking.into_keys().map(|rank| (rank, encode(&self.leader()))).collect())?;
        let leaders: Vec<(usize, Vec<u8>)> = answers.into_iter().collect();
        let mut nodes: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for bytes in ranks.share_among(&self.mates, encode(&leaders))? {
            for (rank, leader) in decode::<Vec<(usize, Vec<u8>)>>(&bytes)? {
                nodes.entry(decode(&leader)?).or_default().push(rank);
            }
        }
        let mut partners = BTreeMap::new();
        for of in nodes.into_values() {
            let partner = of[self.place % of.len()];
            partners.extend(of.into_iter().map(|rank| (rank, partner)));
        }
        Ok(partners)
    }

    /// A rank of each other node, which receives the columns of this one. Collective.
    pub fn of_all(&self, ranks: &mut Ranks) -> Result<BTreeSet<usize>> {
        let others = (0..ranks.size()).filter(|rank| !self.is_mate(*rank)).collect();
        Ok(self.partners(ranks, &others)?.into_values().collect())
    }
}
