//! The ranks of an MPI communicator, over any binding. All of their messages are non-blocking requests, as in
//! [`MessageQueue`], and collective calls are made of these: no rank occupies a processor in MPI while it waits for
//! others.

use super::message_queue::{Communicator, MessageQueue};
use super::shared_node::{MeetingMemory, group_on_host, new_name};
use super::tree::Tree;
use super::{JoinBytes, NAP, NodeShare, PointToPoint, RankMessages, Team, Traffic};
use icoray_grid::Result;
use icoray_shared_memory::SharedMemory;
use std::sync::{Arc, Mutex};
use std::thread::{sleep, yield_now};
use std::time::{Duration, Instant};

/// Time for which a waiting rank yields the processor before it sleeps.
const EAGER: Duration = Duration::from_micros(100);

/// The ranks of a communicator, which is freed on drop. Dropping is collective, unless ranks are gone or the team was
/// given up.
#[derive(Debug)]
pub struct CommunicatorTeam<C: Communicator> {
    tree: Tree<MessageQueue<C>>,
    host_leader: usize,
    /// Where ranks meet that share memory, once they do.
    meeting: Option<Arc<Mutex<MessageQueue<C>>>>,
}

impl<C: Communicator> CommunicatorTeam<C> {
    /// The ranks of `comm`. Collective.
    ///
    /// # Errors
    /// [`ErrorKind::Mpi`](icoray_grid::ErrorKind::Mpi) when MPI fails.
    pub fn new(comm: C) -> Result<Self> {
        let [host_rank, host_leader] = comm.place_on_host()?;
        let tree = Tree::new(MessageQueue::new(comm), host_rank);
        Ok(CommunicatorTeam { tree, host_leader, meeting: None })
    }

    fn comm(&self) -> &C {
        self.tree.messages.comm()
    }

    /// Memory that these ranks have mapped, `None` on all of them if one of them cannot; and whether any ranks of the
    /// team have mapped memory. Collective.
    fn mapped(&mut self, members: &[usize], bytes: usize) -> Result<(Option<SharedMemory>, bool)> {
        let name = new_name();
        let makes = members[0] == self.rank() && members.len() > 1;
        let made = if makes { SharedMemory::create(&name, bytes).ok() } else { None };
        let mapped = self.mapped_with(made, &name, members, bytes);
        if makes {
            SharedMemory::remove(&name);
        }
        mapped
    }

    /// As [`Self::mapped`], where the first of these ranks has made memory of this name, if it can.
    fn mapped_with(
        &mut self,
        made: Option<SharedMemory>,
        name: &str,
        members: &[usize],
        bytes: usize,
    ) -> Result<(Option<SharedMemory>, bool)> {
        let names = self.share_among(members, made.as_ref().map_or_else(Vec::new, |_| name.into()))?;
        let of_leader = String::from_utf8_lossy(&names[0]);
        let opened = || (!of_leader.is_empty()).then(|| SharedMemory::open(&of_leader, bytes).ok()).flatten();
        let memory = made.or_else(opened);
        let place = members.iter().take_while(|member| **member < self.rank()).count();
        let memory = memory.filter(|memory| memory.populate(place, members.len()).is_ok());
        let is_mapped = self.share_among(members, vec![u8::from(memory.is_some())])?;
        let memory = memory.filter(|_| is_mapped.iter().all(|is_mapped| *is_mapped == [1]));
        let is_any_mapped =
            self.reduce(is_mapped.concat(), &|a, b| Ok(vec![u8::from([a, b].concat().contains(&1))]))?;
        Ok((memory, self.broadcast(is_any_mapped)?.contains(&1)))
    }

    /// Makes a collective call; returns when all messages of this rank in it are sent, so that no rank waits for the
    /// next call of this one.
    fn collective<R>(&mut self, call: impl FnOnce(&mut Tree<MessageQueue<C>>) -> Result<R>) -> Result<R> {
        let result = call(&mut self.tree)?;
        let start = Instant::now();
        while !self.tree.is_sent()? {
            self.tree.collect()?;
            pause(start);
        }
        Ok(result)
    }
}

/// Yields the processor, or sleeps if this rank has waited for some time since `since`.
pub(super) fn pause(since: Instant) {
    if since.elapsed() < EAGER { yield_now() } else { sleep(NAP) }
}

impl<C: Communicator> Team for CommunicatorTeam<C> {
    fn rank(&self) -> usize {
        self.comm().rank()
    }

    fn size(&self) -> usize {
        self.comm().size()
    }

    fn is_gone(&self) -> bool {
        self.comm().is_gone()
    }

    fn give_up(&mut self) {
        self.comm().give_up();
    }

    fn reduce(&mut self, mine: Vec<u8>, join: JoinBytes) -> Result<Vec<u8>> {
        self.collective(|tree| tree.reduce(mine, join))
    }

    fn broadcast(&mut self, mine: Vec<u8>) -> Result<Vec<u8>> {
        self.collective(|tree| tree.broadcast(mine))
    }

    fn send(&mut self, bytes: Vec<u8>) -> Result<()> {
        self.tree.send(bytes)
    }

    fn is_sent(&mut self) -> Result<bool> {
        self.tree.is_sent()
    }

    fn try_receive(&mut self) -> Result<Option<(usize, Vec<u8>)>> {
        self.tree.try_receive()
    }

    fn exchange(&mut self, mine: RankMessages) -> Result<RankMessages> {
        self.collective(|tree| tree.exchange(mine))
    }

    fn share_among(&mut self, members: &[usize], mine: Vec<u8>) -> Result<Vec<Vec<u8>>> {
        self.collective(|tree| tree.share_among(members, mine))
    }

    fn traffic(&self) -> Traffic {
        self.tree.traffic()
    }

    fn point_to_point(&mut self) -> Result<Box<dyn PointToPoint>> {
        Ok(Box::new(MessageQueue::new(self.comm().duplicate()?)))
    }

    fn node_rank(&mut self) -> Result<usize> {
        self.tree.node_rank()
    }

    fn node_leader(&mut self) -> Result<usize> {
        Ok(self.host_leader)
    }

    fn memory_mates(&mut self) -> Result<Vec<usize>> {
        let group = group_on_host(self.tree.node_rank()?);
        self.find_group(self.host_leader, group)
    }

    fn node(&mut self, bytes: usize) -> Result<NodeShare> {
        let members = self.memory_mates()?;
        let (mapped, is_shared) = self.mapped(&members, bytes)?;
        let share = match mapped {
            Some(memory) => NodeShare { leader: members[0], is_refused: false, memory: Box::new(memory) },
            None => NodeShare { is_refused: members.len() > 1, ..NodeShare::alone(self.rank(), bytes) },
        };
        if !is_shared {
            return Ok(share);
        }
        let meeting = match &self.meeting {
            Some(meeting) => meeting.clone(),
            None => Arc::new(Mutex::new(MessageQueue::new(self.comm().duplicate()?))),
        };
        self.meeting = Some(meeting.clone());
        Ok(NodeShare { memory: Box::new(MeetingMemory { memory: share.memory, meeting }), ..share })
    }
}
