//! Ranks whose collective calls are made on another thread than their messages.
//!
//! A pumped team is that of a thread that must not call the transport (MPI allows one thread only). Its messages
//! lie in a channel until the thread that owns the transport moves them on, by calls of [`MessagePump::pump`] that
//! return at once; received ones return through another channel.

use super::messages::{Messages, gone};
use super::pieces::Addressed;
use super::{NAP, Team};
use crossbeam_channel::{Receiver, Sender, TryRecvError, unbounded};
use icoray_grid::{Error, Result};
use std::thread::{sleep, yield_now};
use std::time::{Duration, Instant};

/// Maximum time that [`MessagePump::pump`] takes.
const LONGEST: Duration = Duration::from_micros(500);
/// The time without any message after which it returns.
const QUIET: Duration = Duration::from_micros(100);

impl Team {
    /// A team of the same ranks for another thread, and the pump that moves its messages. Collective; so is dropping the
    /// pump, unless ranks are gone or the team was given up.
    pub(crate) fn pumped(&mut self) -> Result<(Team, MessagePump)> {
        let transport = self.point_to_point()?;
        let ((outbox, to_send), (inbox, received)) = (unbounded(), unbounded());
        let pump = MessagePump { transport, to_send, inbox: Some(inbox) };
        Ok((Team::new(Box::new(Mailbox { outbox, inbox: received }), self.place, self.sharing.of_others()), pump))
    }
}

/// The transport's end of the channels.
pub(crate) struct MessagePump {
    transport: Box<dyn Messages>,
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
        f.debug_struct("MessagePump").finish_non_exhaustive()
    }
}

fn turn(
    transport: &mut dyn Messages,
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
struct Mailbox {
    outbox: Sender<Addressed>,
    inbox: Receiver<Result<Addressed>>,
}

impl Messages for Mailbox {
    fn can_meet(&self) -> bool {
        false
    }

    fn send(&mut self, to: usize, bytes: Vec<u8>) -> Result<()> {
        self.outbox.send((to, bytes)).map_err(|_| gone())
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

#[cfg(test)]
mod tests;
