//! Finds the ranks that share memory.

use super::Ranks;
use icoray_grid::Result;
use std::collections::BTreeMap;

/// Nodes: groups of ranks that share memory, each identified by its lowest rank, its leader.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Nodes {
    /// The leader of each rank's node.
    leader: Vec<usize>,
    rank: usize,
}

impl Nodes {
    /// The nodes whose leaders are given for each rank, as `rank` sees them.
    pub fn new(leader: Vec<usize>, rank: usize) -> Self {
        Nodes { leader, rank }
    }

    /// Finds the nodes of all ranks. Collective.
    pub fn find(ranks: &mut Ranks) -> Result<Self> {
        let mine = match &mut ranks.team {
            Some(team) => team.memory_leader(),
            None => Ok(0),
        };
        let mine = ranks.collective(mine)?;
        Ok(Nodes::new(ranks.share_values(&mine)?, ranks.rank()))
    }

    /// All ranks as one node, whether they share memory or not.
    pub fn one(ranks: &Ranks) -> Self {
        Nodes::new(vec![0; ranks.size()], ranks.rank())
    }

    /// The leader of a rank's node.
    pub fn leader_of(&self, rank: usize) -> usize {
        self.leader[rank]
    }

    /// Whether a rank is on this one's node.
    pub fn is_mate(&self, rank: usize) -> bool {
        self.leader[rank] == self.leader[self.rank]
    }

    pub fn is_leader(&self) -> bool {
        self.leader[self.rank] == self.rank
    }

    /// The ranks of a node, in rising order.
    pub fn members(&self, leader: usize) -> impl Iterator<Item = usize> + '_ {
        self.leader.iter().enumerate().filter(move |(_, its)| **its == leader).map(|(rank, _)| rank)
    }

    /// The ranks of this one's node, in rising order.
    pub fn mates(&self) -> Vec<usize> {
        self.members(self.leader[self.rank]).collect()
    }

    /// Whether all ranks are on one node.
    pub fn is_one(&self) -> bool {
        self.leader.iter().all(|leader| *leader == self.leader[0])
    }

    /// By leader of each other node, a rank of it, which exchanges data with this one; the ranks of a node have different
    /// ones, as far as there are enough.
    pub fn partners(&self) -> BTreeMap<usize, usize> {
        let mut nodes: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (rank, leader) in self.leader.iter().enumerate() {
            nodes.entry(*leader).or_default().push(rank);
        }
        let mates = nodes.remove(&self.leader[self.rank]).unwrap_or_default();
        let place = mates.iter().take_while(|mate| **mate < self.rank).count();
        nodes.into_iter().map(|(leader, members)| (leader, members[place % members.len()])).collect()
    }
}
