//! Ranks that are threads of one process: for tests, and to study the work of ranks without MPI.

use super::messages::{Messages, gone};
use super::node::Sharing;
use super::pieces::Addressed;
use super::team::{Place, Team};
use crossbeam_channel::{Receiver, Sender, unbounded};
use icoray_grid::Result;
use std::collections::BTreeMap;
use std::panic::resume_unwind;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError, Weak};
use std::thread;

/// The results of `work` on each rank of [`local_nodes`], a thread each.
///
/// # Panics
/// If `work` panics on a rank.
pub fn on_local_nodes<R: Send>(node_of: &[usize], work: impl Fn(Team) -> R + Sync) -> Vec<R> {
    on_threads(local_nodes(node_of), work)
}

/// The results of `work` on each of the `ranks`, a thread each.
///
/// # Panics
/// If `work` panics on a rank.
pub fn on_threads<T: Send, R: Send>(ranks: Vec<T>, work: impl Fn(T) -> R + Sync) -> Vec<R> {
    let work = &work;
    thread::scope(|scope| {
        let threads: Vec<_> = ranks.into_iter().map(|rank| scope.spawn(move || work(rank))).collect();
        threads.into_iter().map(|thread| thread.join().unwrap_or_else(|panic| resume_unwind(panic))).collect()
    })
}

/// Makes `size` ranks on one node, as [`local_nodes`] does.
pub fn local_team(size: usize) -> Vec<Team> {
    local_nodes(&vec![0; size])
}

/// Makes ranks on nodes, each to be moved to a thread of its own: `node_of` has a number for each rank, equal for the
/// ranks of a node.
pub fn local_nodes(node_of: &[usize]) -> Vec<Team> {
    local_nodes_over(node_of, |messages| messages)
}

/// As [`local_nodes`], over messages that `wrap` makes of those between threads: delayed or counted ones, for example.
pub fn local_nodes_over<M: Messages + 'static>(
    node_of: &[usize],
    mut wrap: impl FnMut(LocalMessages) -> M,
) -> Vec<Team> {
    let mut nodes = BTreeMap::new();
    let team = local_messages(node_of.len()).into_iter().zip(node_of).map(|(messages, node)| {
        let rank = messages.rank;
        let (node_leader, ranks, memories) = nodes.entry(*node).or_insert_with(|| (rank, 0, ThreadMemories::default()));
        let node_size = node_of.iter().filter(|other| *other == node).count();
        let place = Place { rank, size: node_of.len(), node_rank: *ranks, node_size, node_leader: *node_leader };
        *ranks += 1;
        Team::new(Box::new(wrap(messages)), place, Sharing::Threads(memories.clone()))
    });
    team.collect()
}

/// The memory of a node's threads: each allocates the same ones in the same order.
#[derive(Debug, Clone, Default)]
pub(super) struct ThreadMemories {
    by_number: Arc<Mutex<BTreeMap<u64, Weak<Written>>>>,
    /// Number of the next allocation.
    next: u64,
}

/// What threads have written. Contents that a thread still reads are not changed, but copied.
type Written = Mutex<Arc<Vec<u64>>>;

impl ThreadMemories {
    /// Those of a team of the same ranks for other threads.
    pub fn of_others(&self) -> Self {
        ThreadMemories { by_number: Arc::clone(&self.by_number), next: self.next | 1 << 32 }
    }

    pub fn allocate(&mut self, bytes: usize) -> ThreadMemory {
        let mut known = self.by_number.lock().unwrap_or_else(PoisonError::into_inner);
        known.retain(|_, written| written.strong_count() > 0);
        let written = known.get(&self.next).and_then(Weak::upgrade).unwrap_or_default();
        known.insert(self.next, Arc::downgrade(&written));
        self.next += 1;
        ThreadMemory::new(written, bytes)
    }
}

/// A node's memory, whose contents a thread sees from [`Self::settle`] on.
pub(super) struct ThreadMemory {
    written: Arc<Written>,
    words: usize,
    seen: Arc<Vec<u64>>,
}

impl ThreadMemory {
    fn new(written: Arc<Written>, bytes: usize) -> Self {
        let mut memory = ThreadMemory { written, words: bytes.div_ceil(8), seen: Arc::default() };
        memory.settle();
        memory
    }

    /// What is written, of all words at least.
    fn lock(&self) -> MutexGuard<'_, Arc<Vec<u64>>> {
        let mut written = self.written.lock().unwrap_or_else(PoisonError::into_inner);
        if written.len() < self.words {
            Arc::make_mut(&mut written).resize(self.words, 0);
        }
        written
    }

    pub fn begin(&mut self) {
        self.seen = Arc::default();
    }

    pub fn put(&mut self, at: usize, bytes: &[u8]) {
        let most = 8 * self.words;
        assert!(at + bytes.len() <= most, "bytes {at} to {} of {most}", at + bytes.len());
        let mut written = self.lock();
        bytemuck::cast_slice_mut(Arc::make_mut(&mut written).as_mut_slice())[at..at + bytes.len()]
            .copy_from_slice(bytes);
    }

    pub fn settle(&mut self) {
        let seen = Arc::clone(&self.lock());
        self.seen = seen;
    }

    pub fn bytes(&self) -> &[u8] {
        bytemuck::cast_slice(&self.seen[..self.words])
    }
}

/// Messages between threads.
#[derive(Debug)]
pub struct LocalMessages {
    rank: usize,
    to: Arc<[Sender<Addressed>]>,
    from: Receiver<Addressed>,
    meetings: Arc<Meetings>,
    /// The number of entries at which all ranks have entered this rank's current meeting.
    awaited: Option<usize>,
    /// This rank's entries.
    entered: usize,
    /// Those that [`Messages::duplicate`] has yet to return.
    duplicate: Option<Box<LocalMessages>>,
}

/// The meetings of all ranks.
#[derive(Debug, Default)]
struct Meetings {
    /// Entries of all ranks.
    entered: Mutex<usize>,
    /// All have entered one.
    met: Condvar,
}

impl Meetings {
    fn entered(&self) -> MutexGuard<'_, usize> {
        self.entered.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Messages with a duplicate each.
fn local_messages(size: usize) -> Vec<LocalMessages> {
    let one_of = || {
        let (to, from): (Vec<_>, Vec<_>) = (0..size).map(|_| unbounded()).unzip();
        let (to, meetings): (Arc<[_]>, _) = (to.into(), Arc::default());
        from.into_iter().enumerate().map(move |(rank, from)| LocalMessages {
            rank,
            to: Arc::clone(&to),
            from,
            meetings: Arc::clone(&meetings),
            awaited: None,
            entered: 0,
            duplicate: None,
        })
    };
    let with = |(messages, other)| LocalMessages { duplicate: Some(Box::new(other)), ..messages };
    one_of().zip(one_of()).map(with).collect()
}

impl LocalMessages {
    /// This thread's rank.
    pub fn rank(&self) -> usize {
        self.rank
    }

    /// The number of entries at which all ranks have entered the current meeting, which this rank enters.
    fn awaited(&mut self) -> usize {
        *self.awaited.get_or_insert_with(|| {
            let mut entered = self.meetings.entered();
            *entered += 1;
            if entered.is_multiple_of(self.to.len()) {
                self.meetings.met.notify_all();
            }
            self.entered += 1;
            self.entered * self.to.len()
        })
    }
}

impl Messages for LocalMessages {
    fn send(&mut self, to: usize, bytes: Vec<u8>) -> Result<()> {
        self.to[to].send((self.rank, bytes)).map_err(|_| gone())
    }

    fn try_receive(&mut self) -> Result<Option<(usize, Vec<u8>)>> {
        Ok(self.from.try_recv().ok())
    }

    fn receive(&mut self) -> Result<(usize, Vec<u8>)> {
        self.from.recv().map_err(|_| gone())
    }

    fn try_meet(&mut self) -> Result<bool> {
        let awaited = self.awaited();
        let have_met = *self.meetings.entered() >= awaited;
        if have_met {
            self.awaited = None;
        }
        Ok(have_met)
    }

    fn meet(&mut self) -> Result<()> {
        let awaited = self.awaited();
        let entered = self.meetings.met.wait_while(self.meetings.entered(), |entered| *entered < awaited);
        drop(entered.unwrap_or_else(PoisonError::into_inner));
        self.awaited = None;
        Ok(())
    }

    fn duplicate(&mut self) -> Result<Box<dyn Messages>> {
        Ok(self.duplicate.take().ok_or_else(gone)?)
    }
}
