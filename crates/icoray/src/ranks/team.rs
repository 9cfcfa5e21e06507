//! The ranks of a team, and collective calls made of messages from one rank to another.
//!
//! Ranks form a tree, rank 0 at its root, in which each has up to [`FAN_OUT`] children: with up to 33 ranks all
//! exchange messages with rank 0, and no rank sends more than a few for any number of ranks. Each message has the
//! number of its call, as ranks may be calls apart.
//!
//! Calls belong to frames. A rank whose frame has ended with an error notifies its parent and children, which do the
//! same. No rank waits for one that has left a frame, and the next frame starts anew ([`Team::begin_frame`]).

use super::messages::{Communicator, MessageQueue, Messages, pause};
use super::node::Sharing;
use super::pieces::{Addressed, Pieces};
use super::wire::{decode, decode_next, encode};
use super::{RankMessages, Traffic};
use icoray_grid::{Error, ErrorKind, Result};
use std::collections::{BTreeMap, VecDeque};
use std::fmt;
use std::mem::take;
use std::time::Instant;

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

/// Joins the bytes of two ranks or groups of ranks.
pub type JoinBytes<'j> = &'j dyn Fn(Vec<u8>, Vec<u8>) -> Result<Vec<u8>>;

/// The place of a rank among the others.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    /// Its number, from 0.
    pub rank: usize,
    /// Number of ranks.
    pub size: usize,
    /// Its number among the ranks of its node, from 0.
    pub node_rank: usize,
    /// Number of ranks of its node.
    pub node_size: usize,
    /// The first rank of its node.
    pub node_leader: usize,
}

/// The ranks that [`Messages`] connect. `reduce`, `share`, `share_among`, `find_group`, `broadcast`, `exchange` and
/// `node` are collective: every rank calls the same ones in the same order. Between two of them ranks may send to
/// rank 0, which has to receive all of it before the next. Dropping a team is collective too, unless ranks are gone or
/// it was given up.
///
/// # Errors
/// All methods: [`ErrorKind::Mpi`] when the transport itself fails. Then ranks may no longer be in step, and the team
/// is unusable.
pub struct Team {
    messages: Box<dyn Messages>,
    pub(super) pieces: Pieces,
    pub(super) place: Place,
    pub(super) sharing: Sharing,
    /// Maximum number of children of a rank.
    pub(super) fan_out: usize,
    /// Number of the last collective call.
    call: u64,
    /// Messages that arrived before their turn.
    early: VecDeque<Message>,
    /// The error with which another rank's frame has ended, if it ends this one's too.
    broken: Option<Error>,
    traffic: Traffic,
}

impl fmt::Debug for Team {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "rank {} of {}", self.rank(), self.size())
    }
}

#[expect(clippy::missing_errors_doc, reason = "the type has them")]
impl Team {
    /// The ranks of `comm`, which is freed on drop. Collective.
    pub fn over<C: Communicator>(comm: C) -> Result<Self> {
        let [node_rank, node_size, node_leader] = comm.place_on_host()?;
        let place = Place { rank: comm.rank(), size: comm.size(), node_rank, node_size, node_leader };
        Ok(Team::new(Box::new(MessageQueue::new(comm)), place, Sharing::Files))
    }

    /// The ranks between which `messages` go.
    pub(super) fn new(messages: Box<dyn Messages>, place: Place, sharing: Sharing) -> Self {
        Team {
            messages,
            pieces: Pieces::default(),
            place,
            sharing,
            fan_out: FAN_OUT,
            call: 0,
            early: VecDeque::new(),
            broken: None,
            traffic: Traffic::default(),
        }
    }

    /// This process's number, from 0.
    pub fn rank(&self) -> usize {
        self.place.rank
    }

    /// Number of processes, at least 1.
    pub fn size(&self) -> usize {
        self.place.size
    }

    /// Whether ranks can be reached no more, now or later: then the team can only be dropped. Not collective.
    pub fn is_gone(&self) -> bool {
        self.messages.is_gone()
    }

    /// Marks that a rank has left: the team is dropped without messages to the others, which might never answer. Not
    /// collective.
    pub fn give_up(&mut self) {
        self.messages.give_up();
    }

    /// Joins the bytes of all ranks by `join`, in an order that depends on the number of ranks only, and returns them at
    /// rank 0; other ranks return no bytes, and may do so before all have called this.
    pub fn reduce(&mut self, mut mine: Vec<u8>, join: JoinBytes) -> Result<Vec<u8>> {
        self.call += 1;
        for child in self.children() {
            mine = join(mine, self.receive(child)?)?;
        }
        if let Some(parent) = self.parent() {
            self.post(parent, Ok(take(&mut mine)))?;
        }
        self.flush()?;
        Ok(mine)
    }

    /// Returns rank 0's bytes on all ranks; those of other ranks are dropped.
    pub fn broadcast(&mut self, mine: Vec<u8>) -> Result<Vec<u8>> {
        self.call += 1;
        let bytes = match self.parent() {
            Some(parent) => self.receive(parent)?,
            None => mine,
        };
        for child in self.children() {
            self.post(child, Ok(bytes.clone()))?;
        }
        self.flush()?;
        Ok(bytes)
    }

    /// Sends `mine` and returns what other ranks sent to this one. A rank's bytes to itself are returned unchanged;
    /// empty messages are not sent.
    pub fn exchange(&mut self, mut mine: RankMessages) -> Result<RankMessages> {
        mine.retain(|_, bytes| !bytes.is_empty());
        let mut theirs = RankMessages::new();
        theirs.extend(mine.remove_entry(&self.rank()));
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
        self.flush()?;
        Ok(theirs)
    }

    /// Returns the bytes of all ranks, in order of rank, on every rank. Each rank receives as many bytes as all ranks
    /// send: for what every rank needs of all others.
    pub fn share(&mut self, mine: &[u8]) -> Result<Vec<Vec<u8>>> {
        let all = self.reduce(encode(&(self.rank(), mine)), &|mut all, mut others| {
            all.append(&mut others);
            Ok(all)
        })?;
        let all = self.broadcast(all)?;
        let mut unread = &all[..];
        let mut shared = vec![Vec::new(); self.size()];
        while !unread.is_empty() {
            let (rank, bytes): (usize, &[u8]) = decode_next(&mut unread)?;
            let of_rank = shared.get_mut(rank);
            *of_rank.ok_or_else(|| Error::new(ErrorKind::Mpi, format!("a message of rank {rank}")))? = bytes.to_vec();
        }
        Ok(shared)
    }

    /// Returns the bytes of the `members` of this rank's group, in their order: equal on all of them, and each rank is in
    /// one group. The number of a rank's messages grows with the logarithm of theirs: by Bruck's algorithm, in each round
    /// a rank doubles the number of successive members whose bytes it has.
    pub fn share_among(&mut self, members: &[usize], mine: Vec<u8>) -> Result<Vec<Vec<u8>>> {
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
        self.flush()?;
        Ok(all)
    }

    /// The ranks that give the same `leader`, which finds them, and the same `group`, in rising order.
    pub fn find_group(&mut self, leader: usize, group: usize) -> Result<Vec<usize>> {
        let groups = self.exchange([(leader, encode(&group))].into())?;
        let same_as = |group: &[u8]| -> Vec<usize> {
            groups.iter().filter(|(_, other)| *other == group).map(|(rank, _)| *rank).collect()
        };
        let found = self.exchange(groups.iter().map(|(rank, group)| (*rank, encode(&same_as(group)))).collect())?;
        found.get(&leader).map_or_else(
            || Err(Error::new(ErrorKind::Mpi, format!("rank {leader} has not found the ranks of its node"))),
            |bytes| decode(bytes),
        )
    }

    /// Starts to send bytes to rank 0, from any other rank, without waiting.
    pub fn send(&mut self, bytes: Vec<u8>) -> Result<()> {
        self.post(0, Ok(bytes))
    }

    /// Progresses the messages that this rank is sending; returns whether all are sent. They must be, before the next
    /// collective call.
    pub fn is_sent(&mut self) -> Result<bool> {
        self.messages.is_sent()
    }

    /// At rank 0: bytes that have arrived, with the number of the rank that sent them, in the order of that rank.
    pub fn try_receive(&mut self) -> Result<Option<(usize, Vec<u8>)>> {
        self.collect()?;
        self.take_where(|_| true)
    }

    /// At rank 0, without other work: returns when there are bytes to receive.
    pub fn wait(&mut self) -> Result<()> {
        while self.broken.is_none() && !self.early.iter().any(|message| message.call == self.call) {
            let piece = self.messages.receive()?;
            self.join(piece)?;
        }
        Ok(())
    }

    /// Waits until all ranks have called this.
    pub(super) fn meet(&mut self) -> Result<()> {
        if self.messages.can_meet() {
            return self.messages.meet();
        }
        let met = self.reduce(Vec::new(), &|met, _| Ok(met))?;
        self.broadcast(met).map(drop)
    }

    /// This process's number among those of its node, from 0.
    pub fn node_rank(&self) -> usize {
        self.place.node_rank
    }

    /// Number of ranks of this one's node.
    pub fn node_size(&self) -> usize {
        self.place.node_size
    }

    /// The number of the first rank of this one's node.
    pub fn node_leader(&self) -> usize {
        self.place.node_leader
    }

    /// Messages between the same ranks, separate from those of this team. Collective; so is dropping them, unless ranks
    /// are gone or the team was given up.
    ///
    /// # Errors
    /// [`ErrorKind::Unsupported`] if the transport has none.
    pub fn point_to_point(&mut self) -> Result<Box<dyn Messages>> {
        self.messages.duplicate()
    }

    /// The messages that this rank has sent so far. Not collective.
    pub fn traffic(&self) -> Traffic {
        self.traffic
    }

    /// Begins a frame: drops messages of a frame that ended early. Not collective. Only if ranks notify each other when
    /// one of them leaves a frame ([`Self::break_off`]).
    pub(super) fn begin_frame(&mut self) {
        let frame = (self.call >> FRAME) + 1;
        (self.call, self.broken) = (frame << FRAME, None);
        take(&mut self.early).into_iter().for_each(|message| self.keep(message));
    }

    /// Ends this rank's frame with `error`, which other ranks may not have received; their calls fail until the next
    /// frame. Not collective.
    pub(super) fn break_off(&mut self, error: &Error) {
        for neighbour in self.parent().into_iter().chain(self.children()) {
            // No rank waits if no rank can be reached.
            let _ = self.post(neighbour, Err(error.clone()));
        }
    }
}

impl Team {
    /// Sends a message of the current call without waiting.
    fn post(&mut self, to: usize, body: Result<Vec<u8>>) -> Result<()> {
        self.pieces.split(self.call, body, |piece| {
            self.traffic.messages += 1;
            self.traffic.bytes += piece.len() as u64;
            self.messages.send(to, piece)
        })
    }

    fn parent(&self) -> Option<usize> {
        self.rank().checked_sub(1).map(|before| before / self.fan_out)
    }

    fn children(&self) -> std::ops::Range<usize> {
        let first = self.rank() * self.fan_out + 1;
        first.min(self.size())..(first + self.fan_out).min(self.size())
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
        Ok(counts.get(&self.rank()).copied().unwrap_or(0))
    }

    /// The child below which a rank is, if it is below this one.
    fn branch_of(&self, mut rank: usize) -> Option<usize> {
        while rank > self.rank() {
            let parent = (rank - 1) / self.fan_out;
            if parent == self.rank() {
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
    fn collect(&mut self) -> Result<()> {
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

    /// Returns when all messages of this rank are sent, so that no rank waits for the next call of this one.
    fn flush(&mut self) -> Result<()> {
        let start = Instant::now();
        while !self.messages.is_sent()? {
            self.collect()?;
            pause(start);
        }
        Ok(())
    }
}
