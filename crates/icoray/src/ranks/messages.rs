//! Messages from one rank to another, and those over the non-blocking requests of MPI, over any binding. No call waits
//! in MPI, which would occupy a processor.

use super::NAP;
use icoray_grid::{Error, ErrorKind, Result};
use std::collections::VecDeque;
use std::fmt;
use std::mem::{forget, take};
use std::thread::{sleep, yield_now};
use std::time::{Duration, Instant};

/// Time for which a waiting rank yields the processor before it sleeps.
const EAGER: Duration = Duration::from_micros(100);

/// Yields the processor, or sleeps if this rank has waited for some time since `since`.
pub(super) fn pause(since: Instant) {
    if since.elapsed() < EAGER { yield_now() } else { sleep(NAP) }
}

/// The error of a call after MPI was finalised or a rank has left.
pub(super) fn gone() -> Error {
    Error::new(ErrorKind::Mpi, "ranks cannot be reached any more")
}

/// Messages between ranks. Messages from one rank to another arrive in order.
///
/// # Errors
/// All methods: [`ErrorKind::Mpi`] when the transport itself fails. Then it is unusable.
#[expect(clippy::missing_errors_doc, reason = "the trait has them")]
pub trait Messages: Send {
    /// Whether ranks can be reached no more. Not collective.
    fn is_gone(&self) -> bool {
        false
    }

    /// Marks that a rank has left. Not collective.
    fn give_up(&mut self) {}

    /// Starts to send a message of at most 2^31 - 1 bytes to another rank; returns at once.
    fn send(&mut self, to: usize, bytes: Vec<u8>) -> Result<()>;

    /// Progresses the messages that this rank is sending; returns whether all are sent, as by default at once.
    fn is_sent(&mut self) -> Result<bool> {
        Ok(true)
    }

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

    /// Whether [`Self::meet`] can be called.
    fn can_meet(&self) -> bool {
        true
    }

    /// Whether all ranks have called this since it last returned true. Called again until it does. By default ranks
    /// cannot meet: [`ErrorKind::Unsupported`].
    fn try_meet(&mut self) -> Result<bool> {
        Err(Error::new(ErrorKind::Unsupported, "these ranks cannot meet"))
    }

    /// Waits until all ranks have called this.
    fn meet(&mut self) -> Result<()> {
        let start = Instant::now();
        while !self.try_meet()? {
            if self.is_gone() {
                return Err(gone());
            }
            pause(start);
        }
        Ok(())
    }

    /// Messages between the same ranks, separate from these. Collective. By default there are none:
    /// [`ErrorKind::Unsupported`].
    fn duplicate(&mut self) -> Result<Box<dyn Messages>> {
        Err(Error::new(ErrorKind::Unsupported, "these ranks cannot render in the background"))
    }
}

/// The non-blocking calls of a communicator reserved for this queue, and the groups of its ranks.
///
/// # Errors
/// All methods: [`ErrorKind::Mpi`] when the call fails.
#[expect(clippy::missing_errors_doc, reason = "the trait has them")]
pub trait Communicator: fmt::Debug + Send + Sized + 'static {
    /// A request, with the bytes that are read or written until it is complete.
    type Pending: fmt::Debug + Send;

    /// This process's number, from 0.
    fn rank(&self) -> usize;

    /// Number of processes, at least 1.
    fn size(&self) -> usize;

    /// Whether ranks can be reached no more. Not collective.
    fn is_gone(&self) -> bool;

    /// Starts to send a message to rank `to` (`MPI_Isend`).
    fn start_send(&self, to: usize, bytes: Vec<u8>) -> Result<Self::Pending>;

    /// Starts to receive the next message from any rank, if there is one (`MPI_Improbe`, `MPI_Imrecv`); returns the
    /// rank that sent it.
    fn start_receive(&self) -> Result<Option<(usize, Self::Pending)>>;

    /// Enters a barrier (`MPI_Ibarrier`).
    fn start_barrier(&self) -> Result<Self::Pending>;

    /// Whether a request is complete (`MPI_Test`). Not called again for a complete request.
    fn is_done(&self, pending: &mut Self::Pending) -> Result<bool>;

    /// The bytes of a complete request.
    fn bytes_of(&self, complete: Self::Pending) -> Result<Vec<u8>>;

    /// A duplicate communicator of the same ranks, with separate messages. Collective.
    fn duplicate(&self) -> Result<Self>;

    /// Marks that a rank has left: nothing is freed any more, here and of duplicates and groups, as freeing is
    /// collective.
    fn give_up(&self);

    /// This process's number among those of its host, from 0, their number, and the rank of the first of them.
    /// Collective.
    fn place_on_host(&self) -> Result<[usize; 3]>;
}

/// Messages in flight on a communicator.
#[derive(Debug)]
pub(super) struct MessageQueue<C: Communicator> {
    comm: C,
    sending: VecDeque<C::Pending>,
    /// Messages being received, in the order in which each rank sent them.
    receiving: VecDeque<(usize, C::Pending)>,
    /// The barrier that this rank has entered, until all ranks have entered it.
    barrier: Option<C::Pending>,
}

impl<C: Communicator> MessageQueue<C> {
    pub fn new(comm: C) -> Self {
        MessageQueue { comm, sending: VecDeque::new(), receiving: VecDeque::new(), barrier: None }
    }
}

impl<C: Communicator> Messages for MessageQueue<C> {
    fn is_gone(&self) -> bool {
        self.comm.is_gone()
    }

    fn give_up(&mut self) {
        self.comm.give_up();
    }

    fn send(&mut self, to: usize, bytes: Vec<u8>) -> Result<()> {
        self.sending.push_back(self.comm.start_send(to, bytes)?);
        Ok(())
    }

    fn is_sent(&mut self) -> Result<bool> {
        // MPI progresses the others in this call.
        while let Some(first) = self.sending.front_mut() {
            if !self.comm.is_done(first)? {
                return Ok(false);
            }
            self.sending.pop_front();
        }
        Ok(true)
    }

    fn try_receive(&mut self) -> Result<Option<(usize, Vec<u8>)>> {
        while let Some(receiving) = self.comm.start_receive()? {
            self.receiving.push_back(receiving);
        }
        let Some((_, first)) = self.receiving.front_mut() else { return Ok(None) };
        let is_done = self.comm.is_done(first)?;
        let complete = is_done.then(|| self.receiving.pop_front()).flatten();
        complete.map(|(rank, first)| Ok((rank, self.comm.bytes_of(first)?))).transpose()
    }

    fn try_meet(&mut self) -> Result<bool> {
        let mut barrier = match self.barrier.take() {
            Some(barrier) => barrier,
            None => self.comm.start_barrier()?,
        };
        let have_met = self.comm.is_done(&mut barrier)?;
        self.barrier = (!have_met).then_some(barrier);
        Ok(have_met)
    }

    fn duplicate(&mut self) -> Result<Box<dyn Messages>> {
        Ok(Box::new(MessageQueue::new(self.comm.duplicate()?)))
    }
}

impl<C: Communicator> Drop for MessageQueue<C> {
    /// Leaks incomplete requests: MPI may still read or write their memory.
    fn drop(&mut self) {
        forget((take(&mut self.sending), take(&mut self.receiving), self.barrier.take()));
    }
}
