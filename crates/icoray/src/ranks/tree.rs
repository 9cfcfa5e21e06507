//! Collective calls made of messages from one rank to another.
//!
//! Ranks form a tree, rank 0 at its root, in which each has up to [`FAN_OUT`] children: with up to 33 ranks all
//! exchange messages with rank 0, and no rank sends more than a few for any number of ranks. Each message has the
//! number of its call, as ranks may be calls apart.
//!
//! Calls belong to frames. A rank whose frame has ended with an error notifies its parent and children, which do the
//! same. No rank waits for one that has left a frame, and the next frame starts anew ([`Team::begin_frame`]).

use super::pieces::{Addressed, Pieces};
use super::wire::{decode, encode};
use super::{JoinBytes, Messages, RankMessages, Team, Traffic};
use icoray_grid::{Error, Result};
use std::collections::{BTreeMap, VecDeque};
use std::mem::take;

/// Maximum number of children of a rank.
const FAN_OUT: usize = 32;

/// The bits of a call's number from this one on are the number of its frame.
const FRAME: u32 = 32;

/// A message between two ranks.
#[derive(Debug)]
pub(crate) struct Message {
    pub from: usize,
    /// Number of its collective call, or of the last one before it.
    pub call: u64,
    /// Bytes, or the error with which the sender's frame has ended.
    pub body: Result<Vec<u8>>,
}

/// Collective calls over messages.
#[derive(Debug)]
pub(crate) struct Tree<M> {
    pub messages: M,
    pub(super) pieces: Pieces,
    /// This process's number among the ranks of its node.
    node_rank: usize,
    fan_out: usize,
    /// Number of the last collective call.
    call: u64,
    /// Messages that arrived before their turn.
    early: VecDeque<Message>,
    /// The error with which another rank's frame has ended, if it ends this one's too.
    broken: Option<Error>,
    traffic: Traffic,
}

impl<M: Messages> Tree<M> {
    pub fn new(messages: M, node_rank: usize) -> Self {
        let (pieces, early) = (Pieces::default(), VecDeque::new());
        let traffic = Traffic::default();
        Tree { messages, pieces, node_rank, fan_out: FAN_OUT, call: 0, early, broken: None, traffic }
    }

    /// Sends a message of the current call without waiting.
    fn post(&mut self, to: usize, body: Result<Vec<u8>>) -> Result<()> {
        self.pieces.split(self.call, body, |piece| {
            self.traffic.messages += 1;
            self.traffic.bytes += piece.len() as u64;
            self.messages.send(to, piece)
        })
    }

    fn parent(&self) -> Option<usize> {
        self.messages.rank().checked_sub(1).map(|before| before / self.fan_out)
    }

    fn children(&self) -> std::ops::Range<usize> {
        let first = self.messages.rank() * self.fan_out + 1;
        first.min(self.messages.size())..(first + self.fan_out).min(self.messages.size())
    }

    /// Number of ranks that send bytes to this one, which sends to the ranks `to`. Numbers of the ranks below a rank
    /// are added on the way to the root; on the way back each child receives those of its own branch.
    fn count_senders(&mut self, to: impl Iterator<Item = usize>) -> Result<u64> {
        self.call += 1;
        let mut counts: BTreeMap<usize, u64> = to.map(|rank| (rank, 1)).collect();
        for child in self.children() {
            for (rank, count) in decode::<Vec<(usize, u64)>>(&self.receive(child)?)? {
                *counts.entry(rank).or_default() += count;
            }
        }
        let listed = |counts: &BTreeMap<usize, u64>| encode(&counts.iter().collect::<Vec<_>>());
        if let Some(parent) = self.parent() {
            self.post(parent, Ok(listed(&counts)))?;
            counts = decode::<Vec<(usize, u64)>>(&self.receive(parent)?)?.into_iter().collect();
        }
        let mut below: BTreeMap<usize, BTreeMap<usize, u64>> = self.children().map(|c| (c, BTreeMap::new())).collect();
        for (rank, count) in &counts {
            let branch = self.branch_of(*rank).and_then(|child| below.get_mut(&child));
            branch.map(|branch| branch.insert(*rank, *count));
        }
        for (child, counts) in below {
            self.post(child, Ok(listed(&counts)))?;
        }
        Ok(counts.get(&self.messages.rank()).copied().unwrap_or(0))
    }

    /// The child below which a rank is, if it is below this one.
    fn branch_of(&self, mut rank: usize) -> Option<usize> {
        while rank > self.messages.rank() {
            let parent = (rank - 1) / self.fan_out;
            if parent == self.messages.rank() {
                return Some(rank);
            }
            rank = parent;
        }
        None
    }

    /// The bytes that rank `of` sends in this call.
    fn receive(&mut self, of: usize) -> Result<Vec<u8>> {
        self.next_where(|from| from == of).map(|(_, bytes)| bytes)
    }

    fn next_where(&mut self, is_wanted: impl Fn(usize) -> bool) -> Result<(usize, Vec<u8>)> {
        loop {
            if let Some(found) = self.take_where(&is_wanted)? {
                return Ok(found);
            }
            let piece = self.messages.receive()?;
            self.join(piece)?;
        }
    }

    /// The next message of this call that has arrived.
    fn take_where(&mut self, is_wanted: impl Fn(usize) -> bool) -> Result<Option<(usize, Vec<u8>)>> {
        if let Some(error) = &self.broken {
            return Err(error.clone());
        }
        let is_it = |message: &Message| message.call == self.call && is_wanted(message.from);
        let Some(at) = self.early.iter().position(is_it) else {
            return Ok(None);
        };
        let found = self.early.remove(at);
        found.map(|Message { from, body, .. }| Ok((from, body?))).transpose()
    }

    /// Stores the messages that have arrived.
    pub fn collect(&mut self) -> Result<()> {
        while let Some(piece) = self.messages.try_receive()? {
            self.join(piece)?;
        }
        Ok(())
    }

    fn join(&mut self, piece: Addressed) -> Result<()> {
        self.pieces.join(piece)?.into_iter().for_each(|message| self.keep(message));
        Ok(())
    }

    fn keep(&mut self, message: Message) {
        let [its, mine] = [message.call, self.call].map(|call| call >> FRAME);
        match message.body {
            _ if its < mine => {}
            Err(error) if its == mine => self.broken = self.broken.take().or(Some(error)),
            body => self.early.push_back(Message { body, ..message }),
        }
    }
}

impl<M: Messages> Team for Tree<M> {
    fn rank(&self) -> usize {
        self.messages.rank()
    }

    fn size(&self) -> usize {
        self.messages.size()
    }

    fn reduce(&mut self, mut mine: Vec<u8>, join: JoinBytes) -> Result<Vec<u8>> {
        self.call += 1;
        for child in self.children() {
            mine = join(mine, self.receive(child)?)?;
        }
        match self.parent() {
            Some(parent) => self.post(parent, Ok(mine)).map(|()| Vec::new()),
            None => Ok(mine),
        }
    }

    fn broadcast(&mut self, mine: Vec<u8>) -> Result<Vec<u8>> {
        self.call += 1;
        let bytes = match self.parent() {
            Some(parent) => self.receive(parent)?,
            None => mine,
        };
        for child in self.children() {
            self.post(child, Ok(bytes.clone()))?;
        }
        Ok(bytes)
    }

    /// The ranks first find the number of senders to each.
    fn exchange(&mut self, mut mine: RankMessages) -> Result<RankMessages> {
        mine.retain(|_, bytes| !bytes.is_empty());
        let mut theirs = RankMessages::new();
        theirs.extend(mine.remove_entry(&self.messages.rank()));
        let senders = self.count_senders(mine.keys().copied())?;
        self.call += 1;
        for (to, bytes) in mine {
            self.post(to, Ok(bytes))?;
        }
        for _ in 0..senders {
            theirs.extend([self.next_where(|_| true)?]);
        }
        // A rank that has all of its messages may send to rank 0 while that still receives those of this call.
        self.call += 1;
        Ok(theirs)
    }

    /// Bruck's algorithm: in each round a rank doubles the number of successive members whose bytes it has.
    fn share_among(&mut self, members: &[usize], mine: Vec<u8>) -> Result<Vec<Vec<u8>>> {
        self.call += 1;
        let (count, rank) = (members.len(), self.rank());
        let place = members.iter().take_while(|member| **member < rank).count();
        let mut all = vec![mine];
        while all.len() < count {
            let known = all.len();
            self.post(members[(place + count - known) % count], Ok(encode(&all[..known.min(count - known)])))?;
            all.extend(decode::<Vec<Vec<u8>>>(&self.receive(members[(place + known) % count])?)?);
        }
        all.rotate_right(place);
        Ok(all)
    }

    fn send(&mut self, bytes: Vec<u8>) -> Result<()> {
        self.post(0, Ok(bytes))
    }

    fn is_sent(&mut self) -> Result<bool> {
        self.messages.is_sent()
    }

    fn try_receive(&mut self) -> Result<Option<(usize, Vec<u8>)>> {
        self.collect()?;
        self.take_where(|_| true)
    }

    fn wait(&mut self) -> Result<()> {
        while self.broken.is_none() && !self.early.iter().any(|message| message.call == self.call) {
            let piece = self.messages.receive()?;
            self.join(piece)?;
        }
        Ok(())
    }

    fn traffic(&self) -> Traffic {
        self.traffic
    }

    fn begin_frame(&mut self) {
        let frame = (self.call >> FRAME) + 1;
        (self.call, self.broken) = (frame << FRAME, None);
        take(&mut self.early).into_iter().for_each(|message| self.keep(message));
    }

    fn break_off(&mut self, error: &Error) {
        for neighbour in self.parent().into_iter().chain(self.children()) {
            // No rank waits if no rank can be reached.
            let _ = self.post(neighbour, Err(error.clone()));
        }
    }

    fn node_rank(&mut self) -> Result<usize> {
        Ok(self.node_rank)
    }
}

#[cfg(test)]
impl<M> Tree<M> {
    /// The same tree with fewer children per rank, so that few ranks form many levels.
    pub fn with_fan_out(self, fan_out: usize) -> Self {
        Tree { fan_out, ..self }
    }
}
