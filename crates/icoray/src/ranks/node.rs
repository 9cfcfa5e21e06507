//! Memory that the ranks of a node share, so that shared data is stored once: a file in memory that the node's first
//! rank makes and all of its ranks map, or memory of threads.

use super::local::{ThreadMemories, ThreadMemory};
use super::{Ranks, Team};
use icoray_grid::Result;
use icoray_shared_memory::SharedMemory;
use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::SystemTime;

/// Environment variable: maximum number of ranks that share memory. 1 disables sharing; fewer than the ranks of a node
/// give one copy per NUMA domain.
const NODE_RANKS: &str = "ICORAY_NODE_RANKS";

/// How the ranks of a node share memory.
pub(super) enum Sharing {
    /// In files that processes map.
    Files,
    /// As threads.
    Threads(ThreadMemories),
}

impl Sharing {
    /// How they do for a team of the same ranks on other threads.
    pub fn of_others(&self) -> Self {
        match self {
            Sharing::Files => Sharing::Files,
            Sharing::Threads(memories) => Sharing::Threads(memories.of_others()),
        }
    }
}

enum Memory {
    /// A rank's own; words, for the alignment.
    Own(Vec<u64>),
    File(SharedMemory),
    Threads(ThreadMemory),
}

/// Puts bytes at an offset, from any thread.
pub(crate) type PutBytes<'p> = &'p (dyn Fn(usize, &[u8]) + Sync);

/// Memory of a node. Its ranks write to it together, then read: writes are allowed between [`Self::begin`] and
/// [`Self::settle`], reads at all other times, and all ranks of the team make both calls together.
pub struct NodeMemory {
    memory: Memory,
    bytes: usize,
    /// Whether any ranks of the team share theirs: then all of them meet before it is written and before it is read.
    pub(super) is_shared: bool,
    /// The lowest rank of those that share the memory, which identifies them.
    pub leader: usize,
    /// Whether the ranks of this node have their own memory although they should share it.
    pub is_refused_here: bool,
    /// Whether those of any node do.
    pub(crate) is_refused: bool,
}

impl NodeMemory {
    /// Memory of a rank alone, not shared.
    pub(super) fn alone(rank: usize, bytes: usize) -> Self {
        NodeMemory::new(Memory::Own(vec![0; bytes.div_ceil(8)]), bytes, rank)
    }

    fn new(memory: Memory, bytes: usize, leader: usize) -> Self {
        NodeMemory { memory, bytes, is_shared: false, leader, is_refused_here: false, is_refused: false }
    }

    fn meet(&self, team: Option<&mut Team>) -> Result<()> {
        team.filter(|_| self.is_shared).map_or(Ok(()), Team::meet)
    }

    /// Waits until all ranks have finished reading. `team` is the one that allocated it.
    ///
    /// # Errors
    /// [`ErrorKind::Mpi`](icoray_grid::ErrorKind::Mpi) when the transport fails.
    pub fn begin(&mut self, team: Option<&mut Team>) -> Result<()> {
        match &mut self.memory {
            Memory::Own(_) => {}
            Memory::File(memory) => memory.begin(),
            Memory::Threads(memory) => memory.begin(),
        }
        // No rank that is here holds a slice of it, as this borrows it mutably.
        self.meet(team)
    }

    /// Writes bytes at offset `at`, which no other rank of the node writes to.
    ///
    /// # Panics
    /// Outside of [`Self::begin`] and [`Self::settle`], or beyond the memory.
    pub fn put(&mut self, at: usize, bytes: &[u8]) {
        match &mut self.memory {
            Memory::Own(words) => bytemuck::cast_slice_mut(words)[at..at + bytes.len()].copy_from_slice(bytes),
            Memory::File(memory) => memory.put(at, bytes),
            Memory::Threads(memory) => memory.put(at, bytes),
        }
    }

    /// Waits until all ranks have written, and makes their writes visible. `team` is the one that allocated it.
    ///
    /// # Errors
    /// As [`Self::begin`].
    pub fn settle(&mut self, team: Option<&mut Team>) -> Result<()> {
        let met = self.meet(team);
        match &mut self.memory {
            Memory::Own(_) => {}
            Memory::File(memory) => memory.settle(),
            Memory::Threads(memory) => memory.settle(),
        }
        met
    }

    /// All bytes, aligned to 8 bytes.
    ///
    /// # Panics
    /// Between [`Self::begin`] and [`Self::settle`].
    pub fn bytes(&self) -> &[u8] {
        match &self.memory {
            Memory::Own(words) => bytemuck::cast_slice(words),
            Memory::File(memory) => memory.bytes(),
            Memory::Threads(memory) => memory.bytes(),
        }
    }

    /// Each rank's `write` puts bytes at offsets, to which no other one writes; all can be read afterwards. Collective.
    pub(crate) fn write(&mut self, ranks: &mut Ranks, write: impl FnOnce(PutBytes) -> Result<()>) -> Result<()> {
        self.begin(ranks.team.as_mut())?;
        let memory = Mutex::new(&mut *self);
        let put = |at: usize, bytes: &[u8]| memory.lock().unwrap_or_else(PoisonError::into_inner).put(at, bytes);
        let written = ranks.attempt(|| write(&put));
        // Ranks meet in that: all have written then.
        let written = ranks.collective(written);
        self.settle(None)?;
        written
    }
}

impl fmt::Debug for NodeMemory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} bytes of the node of rank {}", self.bytes, self.leader)
    }
}

impl Team {
    /// The ranks that share memory with this one, this one included, in rising order: all ranks of the node, or as many
    /// as the environment sets. Collective.
    pub(super) fn memory_mates(&mut self) -> Result<Vec<usize>> {
        let group = match self.sharing {
            Sharing::Threads(_) => 0,
            Sharing::Files => {
                let most = std::env::var(NODE_RANKS).ok().and_then(|most| most.parse::<usize>().ok());
                self.node_rank() / most.filter(|most| *most > 0).unwrap_or(usize::MAX)
            }
        };
        self.find_group(self.node_leader(), group)
    }

    /// Allocates `bytes` bytes of memory for each node, equal on all ranks. If memory cannot be shared, each rank has
    /// its own. Collective.
    ///
    /// # Errors
    /// [`ErrorKind::Mpi`](icoray_grid::ErrorKind::Mpi) when the transport fails.
    pub fn node(&mut self, bytes: usize) -> Result<NodeMemory> {
        let leader = self.node_leader();
        if let Sharing::Threads(memories) = &mut self.sharing {
            let memory = Memory::Threads(memories.allocate(bytes));
            return Ok(NodeMemory { is_shared: true, ..NodeMemory::new(memory, bytes, leader) });
        }
        let members = self.memory_mates()?;
        let (mapped, is_shared) = self.mapped(&members, bytes)?;
        let is_refused_here = mapped.is_none() && members.len() > 1;
        let memory = match mapped {
            Some(memory) => NodeMemory::new(Memory::File(memory), bytes, members[0]),
            None => NodeMemory::alone(self.rank(), bytes),
        };
        Ok(NodeMemory { is_shared, is_refused_here, ..memory })
    }

    /// Memory that these ranks have mapped, `None` on all of them if one of them cannot; and whether any ranks of the
    /// team have mapped memory. Collective.
    fn mapped(&mut self, members: &[usize], bytes: usize) -> Result<(Option<SharedMemory>, bool)> {
        static NUMBER: AtomicU64 = AtomicU64::new(0);
        // A name that no other process gives.
        let time = SystemTime::UNIX_EPOCH.elapsed().unwrap_or_default().as_nanos();
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let name = format!("icoray-{}-{number}-{time:x}", std::process::id());
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
}

impl Ranks {
    /// The memory of this rank's node, of at least `bytes` bytes, equal on all ranks; to be returned to
    /// [`Self::keep_node`], for the next frame. Collective.
    pub(crate) fn take_node(&mut self, bytes: usize) -> Result<NodeMemory> {
        let fitting = self.nodes.iter().enumerate().filter(|(_, node)| node.bytes >= bytes);
        if let Some((at, _)) = fitting.min_by_key(|(_, node)| node.bytes) {
            return Ok(self.nodes.remove(at));
        }
        // Free memory that is too small before the next allocation.
        self.nodes.clear();
        let Some(team) = &mut self.team else { return Ok(NodeMemory::alone(0, bytes)) };
        let made = team.node(bytes);
        let node = self.collective(made)?;
        let is_refused = self.reduce_values(node.is_refused_here, |a, b| a || b)?;
        Ok(NodeMemory { is_refused, ..node })
    }

    /// Returns freed memory of this rank's process to the system: joining parts takes several times what remains of it
    /// and of the rank's own grid ([`Grid::tables_only`](icoray_grid::Grid::tables_only)). Not collective.
    pub fn trim_heap(&self) {
        // Other threads of a process would wait.
        if self.team.as_ref().is_some_and(|team| matches!(team.sharing, Sharing::Files)) {
            icoray_shared_memory::trim_heap();
        }
    }

    /// Stores the memory for the next frame.
    pub(crate) fn keep_node(&mut self, node: NodeMemory) {
        self.nodes.push(node);
    }
}
