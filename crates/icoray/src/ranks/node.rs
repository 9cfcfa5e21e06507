//! Memory that the ranks of a node share, so that shared data is stored once.

use super::Ranks;
use icoray_grid::{Error, Result};
use std::collections::BTreeMap;
use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Memory of a node. Its ranks write to it together, then read: writes are allowed between [`Self::begin`] and
/// [`Self::settle`], reads at all other times, and all ranks make both calls together.
///
/// # Errors
/// All methods: [`ErrorKind::Mpi`](icoray_grid::ErrorKind::Mpi) when the transport itself fails, as of a
/// [`Team`](super::Team).
///
/// # Panics
/// [`Self::put`] outside of these two or beyond the memory, [`Self::bytes`] between them.
#[expect(clippy::missing_errors_doc, reason = "the trait has them")]
pub trait NodeMemory: Send + Sync {
    /// Waits until all ranks have finished reading.
    fn begin(&mut self) -> Result<()>;

    /// Writes bytes at offset `at`, which no other rank of the node writes to.
    fn put(&mut self, at: usize, bytes: &[u8]);

    /// Waits until all ranks have written, and makes their writes visible.
    fn settle(&mut self) -> Result<()>;

    /// All bytes, aligned to 8 bytes.
    fn bytes(&self) -> &[u8];
}

/// Memory of a node, as allocated by a [`Team`](super::Team).
pub struct NodeShare {
    /// The lowest rank of those that share the memory, which identifies them.
    pub leader: usize,
    /// Whether ranks that could share memory have their own, as sharing failed.
    pub is_refused: bool,
    /// The memory.
    pub memory: Box<dyn NodeMemory>,
}

impl NodeShare {
    /// Memory of a rank alone, not shared.
    pub fn alone(rank: usize, bytes: usize) -> Self {
        let memory = OwnMemory { words: vec![0; bytes.div_ceil(8)] };
        NodeShare { leader: rank, is_refused: false, memory: Box::new(memory) }
    }
}

impl fmt::Debug for NodeShare {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "memory of the node of rank {}", self.leader)
    }
}

/// A rank's own memory.
struct OwnMemory {
    /// Words, for the alignment.
    words: Vec<u64>,
}

impl NodeMemory for OwnMemory {
    fn begin(&mut self) -> Result<()> {
        Ok(())
    }

    fn put(&mut self, at: usize, bytes: &[u8]) {
        bytemuck::cast_slice_mut(&mut self.words)[at..at + bytes.len()].copy_from_slice(bytes);
    }

    fn settle(&mut self) -> Result<()> {
        Ok(())
    }

    fn bytes(&self) -> &[u8] {
        bytemuck::cast_slice(&self.words)
    }
}

/// The memory of this rank's node.
pub(crate) struct Node {
    pub memory: Box<dyn NodeMemory>,
    bytes: usize,
    /// Whether this rank is the lowest of those that share it.
    is_leader: bool,
    /// Whether the ranks of this node have their own memory although they should share it.
    pub is_refused_here: bool,
    /// Whether those of any node do.
    pub is_refused: bool,
}

impl Node {
    /// Memory of `bytes` bytes for rank `rank`; `is_refused` is whether ranks of any node have their own.
    pub(super) fn new(share: NodeShare, rank: usize, bytes: usize, is_refused: bool) -> Self {
        let NodeShare { leader, is_refused: is_refused_here, memory } = share;
        Node { memory, bytes, is_leader: leader == rank, is_refused_here, is_refused }
    }

    /// The leader's `write` puts bytes at offsets; the others read them afterwards. Collective.
    pub fn write(
        &mut self,
        ranks: &mut Ranks,
        write: impl FnOnce(&mut dyn FnMut(usize, &[u8])) -> Result<()>,
    ) -> Result<()> {
        self.memory.begin()?;
        let memory = &mut self.memory;
        let written =
            ranks.attempt(|| if self.is_leader { write(&mut |at, bytes| memory.put(at, bytes)) } else { Ok(()) });
        self.memory.settle()?;
        ranks.collective(written)
    }
}

/// Memory of nodes that was lent and returned, by the numbers under which it was lent.
#[derive(Default)]
pub(super) struct Returned(Arc<Mutex<BTreeMap<u64, Node>>>);

impl Returned {
    fn lock(&self) -> MutexGuard<'_, BTreeMap<u64, Node>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Memory of a node that is lent until this is dropped, at any time and on any thread.
pub(crate) struct LentNode {
    number: u64,
    node: Option<Node>,
    returned: Returned,
}

impl LentNode {
    /// All bytes of the memory.
    pub fn bytes(&self) -> &[u8] {
        self.node.as_ref().map_or(&[], |node| node.memory.bytes())
    }
}

impl Drop for LentNode {
    fn drop(&mut self) {
        self.returned.lock().extend(self.node.take().map(|node| (self.number, node)));
    }
}

impl Ranks {
    /// Lends memory whose contents outlive frames; it can be used again once all ranks have dropped it. Collective.
    pub(crate) fn lend(&mut self, node: Node) -> LentNode {
        self.lent += 1;
        LentNode { number: self.lent, node: Some(node), returned: Returned(Arc::clone(&self.returned.0)) }
    }

    /// Takes back lent memory that all ranks have dropped. Collective.
    pub(crate) fn reclaim(&mut self) -> Result<()> {
        let mine: Vec<u64> = self.returned.lock().keys().copied().collect();
        let both = |mut a: Vec<u64>, b: Vec<u64>| {
            a.retain(|number| b.contains(number));
            a
        };
        for number in self.reduce_values(mine, both)? {
            let node = self.returned.lock().remove(&number);
            self.nodes.extend(node);
        }
        Ok(())
    }

    /// The memory of this rank's node, of at least `bytes` bytes, equal on all ranks; to be returned to
    /// [`Self::keep_node`], for the next frame. Collective.
    pub(crate) fn take_node(&mut self, bytes: usize) -> Result<Node> {
        let fitting = self.nodes.iter().enumerate().filter(|(_, node)| node.bytes >= bytes);
        if let Some((at, _)) = fitting.min_by_key(|(_, node)| node.bytes) {
            return Ok(self.nodes.remove(at));
        }
        // Free memory that is too small before the next allocation.
        self.nodes.clear();
        let rank = self.rank();
        let made = match &mut self.team {
            Some(team) => team.node(bytes),
            None => Ok(NodeShare::alone(rank, bytes)),
        };
        let agreed = self.collective(made.as_ref().map(drop).map_err(Error::clone));
        let share = match agreed {
            Ok(()) => made?,
            Err(error) => {
                // Freeing it may be collective, and some ranks have no memory.
                std::mem::forget(made);
                return Err(error);
            }
        };
        let is_refused = self.reduce_values(share.is_refused, |a, b| a || b)?;
        Ok(Node::new(share, rank, bytes, is_refused))
    }

    /// Stores the memory for the next frame.
    pub(crate) fn keep_node(&mut self, node: Node) {
        self.nodes.push(node);
    }
}
