//! Memory of a node over a communicator: a file in memory that the node's first rank makes and all of its ranks map.

use super::communicator_team::pause;
use super::message_queue::{Communicator, MessageQueue};
use super::pump::gone;
use super::{Messages, NodeMemory, PointToPoint};
use icoray_grid::Result;
use icoray_shared_memory::SharedMemory;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Instant, SystemTime};

/// Environment variable: maximum number of ranks that share memory. 1 disables sharing; fewer than the ranks of a node
/// give one copy per NUMA domain.
const NODE_RANKS: &str = "ICORAY_NODE_RANKS";

/// The group of ranks that share memory to which the rank with number `host_rank` on its host belongs: all ranks of the
/// host are one group, or groups have the size that the environment sets.
pub(super) fn group_on_host(host_rank: usize) -> usize {
    let most = std::env::var(NODE_RANKS).ok().and_then(|most| most.parse::<usize>().ok());
    host_rank / most.filter(|most| *most > 0).unwrap_or(usize::MAX)
}

/// A name for a file that no other process has.
pub(super) fn new_name() -> String {
    static NUMBER: AtomicU64 = AtomicU64::new(0);
    let time = SystemTime::UNIX_EPOCH.elapsed().unwrap_or_default().as_nanos();
    format!("icoray-{}-{}-{time:x}", std::process::id(), NUMBER.fetch_add(1, Ordering::Relaxed))
}

impl NodeMemory for SharedMemory {
    fn begin(&mut self) -> Result<()> {
        SharedMemory::begin(self);
        Ok(())
    }

    fn put(&mut self, at: usize, bytes: &[u8]) {
        SharedMemory::put(self, at, bytes);
    }

    fn settle(&mut self) -> Result<()> {
        SharedMemory::settle(self);
        Ok(())
    }

    fn bytes(&self) -> &[u8] {
        SharedMemory::bytes(self)
    }
}

/// Memory of a team in which some ranks share theirs: all ranks meet before it is written and before it is read, as they
/// do so together; also those that have their own.
pub(super) struct MeetingMemory<C: Communicator> {
    pub memory: Box<dyn NodeMemory>,
    pub meeting: Arc<Mutex<MessageQueue<C>>>,
}

impl<C: Communicator> MeetingMemory<C> {
    /// Waits for all ranks.
    fn meet(&self) -> Result<()> {
        let mut meeting = self.meeting.lock().unwrap_or_else(PoisonError::into_inner);
        let start = Instant::now();
        while !meeting.try_meet()? {
            if meeting.is_gone() {
                return Err(gone());
            }
            pause(start);
        }
        Ok(())
    }
}

impl<C: Communicator> NodeMemory for MeetingMemory<C> {
    fn begin(&mut self) -> Result<()> {
        // No rank that is here holds a slice of it, as this borrows it mutably.
        self.meet()?;
        self.memory.begin()
    }

    fn put(&mut self, at: usize, bytes: &[u8]) {
        self.memory.put(at, bytes);
    }

    fn settle(&mut self) -> Result<()> {
        let met = self.meet();
        self.memory.settle()?;
        met
    }

    fn bytes(&self) -> &[u8] {
        self.memory.bytes()
    }
}
