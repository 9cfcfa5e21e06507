//! The ranks of an MPI communicator, over any binding. All of their messages are non-blocking requests, as in
//! [`MessageQueue`], and collective calls are made of these: no rank occupies a processor in MPI while it waits for
//! others.

use super::message_queue::{Communicator, MessageQueue};
use super::pieces::Pieces;
use super::pump::gone;
use super::tree::{Link, Message, Tree};
use super::{NAP, NodeShare, PointToPoint, Team};
use icoray_grid::Result;
use std::thread::{sleep, yield_now};
use std::time::{Duration, Instant};

/// Time for which a waiting rank yields the processor before it sleeps.
const EAGER: Duration = Duration::from_micros(100);

/// The ranks of a communicator, which is freed on drop. Dropping is collective, unless ranks are gone or the team was
/// given up.
#[derive(Debug)]
pub struct CommunicatorTeam<C: Communicator> {
    tree: Tree<Letters<C>>,
    host_leader: usize,
}

/// Messages of a communicator.
#[derive(Debug)]
struct Letters<C: Communicator> {
    queue: MessageQueue<C>,
    pieces: Pieces,
    host_rank: usize,
}

impl<C: Communicator> CommunicatorTeam<C> {
    /// The ranks of `comm`. Collective.
    ///
    /// # Errors
    /// [`ErrorKind::Mpi`](icoray_grid::ErrorKind::Mpi) when MPI fails.
    pub fn new(comm: C) -> Result<Self> {
        let [host_rank, host_leader] = comm.place_on_host()?;
        let letters = Letters { queue: MessageQueue::new(comm), pieces: Pieces::default(), host_rank };
        Ok(CommunicatorTeam { tree: Tree::new(letters), host_leader })
    }

    fn comm(&self) -> &C {
        self.tree.link.queue.comm()
    }

    /// Makes a collective call; returns when all messages of this rank in it are sent, so that no rank waits for the
    /// next call of this one.
    fn collective<R>(&mut self, call: impl FnOnce(&mut Tree<Letters<C>>) -> Result<R>) -> Result<R> {
        let result = call(&mut self.tree)?;
        let start = Instant::now();
        while !self.tree.link.queue.is_sent()? {
            self.tree.collect()?;
            pause(start);
        }
        Ok(result)
    }
}

/// Yields the processor, or sleeps if this rank has waited for some time since `since`.
fn pause(since: Instant) {
    if since.elapsed() < EAGER { yield_now() } else { sleep(NAP) }
}

impl<C: Communicator> Link for Letters<C> {
    fn rank(&self) -> usize {
        self.queue.comm().rank()
    }

    fn size(&self) -> usize {
        self.queue.comm().size()
    }

    fn node_rank(&self) -> usize {
        self.host_rank
    }

    fn post(&mut self, to: usize, call: u64, body: Result<Vec<u8>>) -> Result<()> {
        self.pieces.split(call, body, |piece| self.queue.send(to, piece))
    }

    fn next(&mut self) -> Result<Message> {
        let start = Instant::now();
        loop {
            if let Some(message) = self.try_next()? {
                return Ok(message);
            }
            if self.queue.is_gone() {
                return Err(gone());
            }
            pause(start);
        }
    }

    fn try_next(&mut self) -> Result<Option<Message>> {
        while let Some(piece) = self.queue.try_receive()? {
            if let Some(message) = self.pieces.join(piece)? {
                return Ok(Some(message));
            }
        }
        Ok(None)
    }
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

    fn share(&mut self, mine: &[u8]) -> Result<Vec<Vec<u8>>> {
        self.collective(|tree| tree.share(mine))
    }

    fn broadcast(&mut self, mine: Vec<u8>) -> Result<Vec<u8>> {
        self.collective(|tree| tree.broadcast(mine))
    }

    fn send(&mut self, bytes: Vec<u8>) -> Result<()> {
        self.tree.send(bytes)
    }

    fn is_sent(&mut self) -> Result<bool> {
        self.tree.link.queue.is_sent()
    }

    fn try_receive(&mut self) -> Result<Option<(usize, Vec<u8>)>> {
        self.tree.try_receive()
    }

    fn exchange(&mut self, mine: Vec<Vec<u8>>) -> Result<Vec<Vec<u8>>> {
        self.collective(|tree| tree.exchange(mine))
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

    fn memory_leader(&mut self) -> Result<usize> {
        self.comm().memory_leader()
    }

    fn node(&mut self, bytes: usize) -> Result<NodeShare> {
        self.comm().node(bytes)
    }
}
