//! Ranks whose collective calls are made on another thread than their messages.
//!
//! A [`PumpedTeam`] is the team of a thread that must not call the transport (MPI allows one thread only). Its messages
//! lie in a channel until the thread that owns the transport moves them on, by calls of [`MessagePump::pump`] that
//! return at once; received ones return through another channel.

use super::NAP;
use super::communicator_team::pause;
use super::pieces::Addressed;
use super::tree::Tree;
use crossbeam_channel::{Receiver, Sender, TryRecvError, unbounded};
use icoray_grid::{Error, ErrorKind, Result};
use std::thread::{sleep, yield_now};
use std::time::{Duration, Instant};

/// Maximum time that [`MessagePump::pump`] takes.
const LONGEST: Duration = Duration::from_micros(500);
/// The time without any message after which it returns.
const QUIET: Duration = Duration::from_micros(100);

/// Messages between ranks, in calls that return at once. Messages from one rank to another arrive in order.
///
/// # Errors
/// All methods: [`ErrorKind::Mpi`] when the transport itself fails. Then it is unusable.
#[expect(clippy::missing_errors_doc, reason = "the trait has them")]
pub trait Messages: Send {
    /// This process's number, from 0.
    fn rank(&self) -> usize;

    /// Number of processes, at least 1.
    fn size(&self) -> usize;

    /// Whether ranks can be reached no more. Not collective.
    fn is_gone(&self) -> bool {
        false
    }

    /// Starts to send a message of at most 2^31 - 1 bytes to another rank.
    fn send(&mut self, to: usize, bytes: Vec<u8>) -> Result<()>;

    /// Progresses the messages that this rank is sending; returns whether all are sent.
    fn is_sent(&mut self) -> Result<bool>;

    /// A message that has arrived, with the number of the rank that sent it.
    fn try_receive(&mut self) -> Result<Option<(usize, Vec<u8>)>>;

    /// As [`Self::try_receive`], after waiting for a message.
    fn receive(&mut self) -> Result<(usize, Vec<u8>)> {
        let start = Instant::now();
        loop {
            if let Some(message) = self.try_receive()? {
                return Ok(message);
            }
            if self.is_gone() {
                return Err(gone());
            }
            pause(start);
        }
    }
}

/// Messages between ranks that can meet.
pub trait PointToPoint: Messages {
    /// Whether all ranks have called this since it last returned true. Called again until it does.
    ///
    /// # Errors
    /// [`ErrorKind::Mpi`] when the transport itself fails.
    fn try_meet(&mut self) -> Result<bool>;
}

/// Returns a team for another thread, and the pump that moves its messages over `transport`. `node_rank` is this
/// process's number on its node.
pub(crate) fn pumped(transport: Box<dyn PointToPoint>, node_rank: usize) -> (PumpedTeam, MessagePump) {
    let ((outbox, to_send), (inbox, received)) = (unbounded(), unbounded());
    let (rank, size) = (transport.rank(), transport.size());
    let mailbox = Mailbox { rank, size, outbox, inbox: received };
    let pump = MessagePump { transport, to_send, inbox: Some(inbox) };
    (Tree::new(mailbox, node_rank), pump)
}

/// The error of a call after MPI was finalised or a rank has left.
pub(super) fn gone() -> Error {
    Error::new(ErrorKind::Mpi, "ranks cannot be reached any more")
}

/// The transport's end of the channels.
pub(crate) struct MessagePump {
    transport: Box<dyn PointToPoint>,
    to_send: Receiver<Addressed>,
    /// `None` once ranks cannot be reached any more.
    inbox: Option<Sender<Result<Addressed>>>,
}

impl MessagePump {
    /// Moves messages on while they arrive at short intervals, for half a millisecond at most.
    pub fn pump(&mut self) {
        let start = Instant::now();
        let mut last = None;
        loop {
            if self.turn() {
                last = Some(Instant::now());
            }
            let is_quiet = last.is_none_or(|last| last.elapsed() > QUIET);
            if is_quiet || start.elapsed() > LONGEST {
                return;
            }
            yield_now();
        }
    }

    /// Moves messages on until `is_done` returns true on all ranks. Collective. If ranks can be reached no more, it
    /// returns once `is_done` returns true on this one.
    pub fn finish(&mut self, mut is_done: impl FnMut() -> bool) {
        let mut done = false;
        loop {
            // Messages that were sent before `is_done` returned true are moved on afterwards.
            done = done || is_done();
            let has_moved = self.turn();
            let have_met = done && self.meet();
            if have_met {
                return;
            }
            if !has_moved {
                sleep(NAP);
            }
        }
    }

    /// Drops all messages: calls of the team fail from now on.
    pub fn cut(&mut self) {
        self.inbox = None;
        self.to_send = crossbeam_channel::never();
    }

    fn meet(&mut self) -> bool {
        if self.inbox.is_none() {
            return true;
        }
        let met = self.transport.is_sent().and_then(|is_sent| Ok(is_sent && self.transport.try_meet()?));
        met.unwrap_or_else(|error| self.fail(error))
    }

    /// Moves messages on; returns whether there were any.
    fn turn(&mut self) -> bool {
        let Some(inbox) = &self.inbox else { return false };
        let turned = turn(&mut *self.transport, &self.to_send, inbox);
        turned.unwrap_or_else(|error| self.fail(error))
    }

    fn fail(&mut self, error: Error) -> bool {
        if let Some(inbox) = &self.inbox {
            // The receiver may have been dropped.
            let _ = inbox.send(Err(error));
        }
        self.cut();
        false
    }
}

impl std::fmt::Debug for MessagePump {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "pump of rank {} of {}", self.transport.rank(), self.transport.size())
    }
}

fn turn(
    transport: &mut dyn PointToPoint,
    to_send: &Receiver<Addressed>,
    inbox: &Sender<Result<Addressed>>,
) -> Result<bool> {
    if transport.is_gone() {
        return Err(gone());
    }
    let mut has_moved = false;
    for (to, bytes) in to_send.try_iter() {
        transport.send(to, bytes)?;
        has_moved = true;
    }
    transport.is_sent()?;
    while let Some(message) = transport.try_receive()? {
        // The team may have been dropped; its channel reports that.
        let _ = inbox.send(Ok(message));
        has_moved = true;
    }
    Ok(has_moved)
}

/// The team's end of the channels.
#[derive(Debug)]
pub(crate) struct Mailbox {
    rank: usize,
    size: usize,
    outbox: Sender<Addressed>,
    inbox: Receiver<Result<Addressed>>,
}

impl Messages for Mailbox {
    fn rank(&self) -> usize {
        self.rank
    }

    fn size(&self) -> usize {
        self.size
    }

    fn send(&mut self, to: usize, bytes: Vec<u8>) -> Result<()> {
        self.outbox.send((to, bytes)).map_err(|_| gone())
    }

    fn is_sent(&mut self) -> Result<bool> {
        Ok(true)
    }

    fn try_receive(&mut self) -> Result<Option<Addressed>> {
        match self.inbox.try_recv() {
            Ok(piece) => piece.map(Some),
            Err(TryRecvError::Empty) => Ok(None),
            Err(TryRecvError::Disconnected) => Err(gone()),
        }
    }

    fn receive(&mut self) -> Result<Addressed> {
        self.inbox.recv().map_err(|_| gone())?
    }
}

/// A team whose messages a [`MessagePump`] moves.
pub(crate) type PumpedTeam = Tree<Mailbox>;

#[cfg(test)]
mod tests;
