//! Ranks that are threads of one process: for tests, and to study the work of ranks without MPI.

use super::pieces::Addressed;
use super::tree::Tree;
use super::{JoinBytes, Messages, NodeMemory, NodeShare, PointToPoint, RankMessages, Team, Traffic};
use crossbeam_channel::{Receiver, Sender, unbounded};
use icoray_grid::{Error, ErrorKind, Result};
use std::collections::BTreeMap;
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};
use std::sync::{Arc, Barrier, Mutex, MutexGuard, PoisonError};
use std::thread;

/// One rank of [`local_nodes`].
#[derive(Debug)]
pub struct LocalTeam<M = LocalMessages> {
    tree: Tree<M>,
    /// `None` once [`Team::point_to_point`] has returned it.
    beside: Option<LocalMessages>,
    node: Arc<LocalNode>,
}

/// State that the threads of a node share.
#[derive(Debug)]
struct LocalNode {
    leader: usize,
    /// What its ranks wrote last. Contents that a rank still reads are not changed, but copied.
    written: Mutex<Arc<Vec<u64>>>,
    meet: Barrier,
}

impl LocalNode {
    /// What is written, of `words` words at least.
    fn lock(&self, words: usize) -> MutexGuard<'_, Arc<Vec<u64>>> {
        let mut written = self.written.lock().unwrap_or_else(PoisonError::into_inner);
        if written.len() < words {
            Arc::make_mut(&mut written).resize(words, 0);
        }
        written
    }
}

/// The results of `work` on each rank of [`local_nodes`], a thread each.
///
/// # Panics
/// If `work` panics on a rank.
pub fn on_local_nodes<R: Send>(node_of: &[usize], work: impl Fn(LocalTeam) -> R + Sync) -> Vec<R> {
    let work = &work;
    thread::scope(|scope| {
        let threads: Vec<_> = local_nodes(node_of).into_iter().map(|team| scope.spawn(move || work(team))).collect();
        threads.into_iter().map(|thread| thread.join().unwrap_or_else(|panic| resume_unwind(panic))).collect()
    })
}

/// Makes `size` ranks on one node, as [`local_nodes`] does.
pub fn local_team(size: usize) -> Vec<LocalTeam> {
    local_nodes(&vec![0; size])
}

/// Makes ranks on nodes, each to be moved to a thread of its own: `node_of` has a number for each rank, equal for the
/// ranks of a node.
pub fn local_nodes(node_of: &[usize]) -> Vec<LocalTeam> {
    local_nodes_over(node_of, |messages| messages)
}

/// As [`local_nodes`], over messages that `wrap` makes of those between threads: delayed or counted ones, for example.
pub fn local_nodes_over<M: Messages>(node_of: &[usize], mut wrap: impl FnMut(LocalMessages) -> M) -> Vec<LocalTeam<M>> {
    let mut members: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    node_of.iter().enumerate().for_each(|(rank, node)| members.entry(*node).or_default().push(rank));
    let node =
        |ranks: &Vec<usize>| LocalNode { leader: ranks[0], written: Mutex::default(), meet: Barrier::new(ranks.len()) };
    let nodes: BTreeMap<usize, Arc<LocalNode>> = members.iter().map(|(n, ranks)| (*n, Arc::new(node(ranks)))).collect();
    let [messages, beside] = [(); 2].map(|()| local_messages(node_of.len()));
    let team = messages.into_iter().zip(beside).zip(node_of).map(|((messages, beside), node)| {
        let node_rank = members[node].binary_search(&messages.rank).unwrap_or(0);
        LocalTeam { tree: Tree::new(wrap(messages), node_rank), beside: Some(beside), node: nodes[node].clone() }
    });
    team.collect()
}

fn gone(of: &str) -> Error {
    Error::new(ErrorKind::Mpi, format!("{of} is gone"))
}

impl<M: Messages> Team for LocalTeam<M> {
    fn rank(&self) -> usize {
        self.tree.rank()
    }

    fn size(&self) -> usize {
        self.tree.size()
    }

    fn reduce(&mut self, mine: Vec<u8>, join: JoinBytes) -> Result<Vec<u8>> {
        self.tree.reduce(mine, join)
    }

    fn broadcast(&mut self, mine: Vec<u8>) -> Result<Vec<u8>> {
        self.tree.broadcast(mine)
    }

    fn send(&mut self, bytes: Vec<u8>) -> Result<()> {
        self.tree.send(bytes)
    }

    fn is_sent(&mut self) -> Result<bool> {
        Ok(true)
    }

    fn try_receive(&mut self) -> Result<Option<(usize, Vec<u8>)>> {
        self.tree.try_receive()
    }

    fn exchange(&mut self, mine: RankMessages) -> Result<RankMessages> {
        self.tree.exchange(mine)
    }

    fn share_among(&mut self, members: &[usize], mine: Vec<u8>) -> Result<Vec<Vec<u8>>> {
        self.tree.share_among(members, mine)
    }

    fn traffic(&self) -> Traffic {
        self.tree.traffic()
    }

    fn point_to_point(&mut self) -> Result<Box<dyn PointToPoint>> {
        let taken = self.beside.take().ok_or_else(|| gone("what was taken once"))?;
        Ok(Box::new(taken))
    }

    fn node_rank(&mut self) -> Result<usize> {
        self.tree.node_rank()
    }

    fn node_leader(&mut self) -> Result<usize> {
        Ok(self.node.leader)
    }

    fn memory_mates(&mut self) -> Result<Vec<usize>> {
        self.find_group(self.node.leader, 0)
    }

    fn node(&mut self, bytes: usize) -> Result<NodeShare> {
        let words = bytes.div_ceil(8);
        let memory = LocalMemory { node: self.node.clone(), words, seen: Arc::clone(&self.node.lock(words)) };
        Ok(NodeShare { leader: self.node.leader, is_refused: false, memory: Box::new(memory) })
    }
}

/// A node's memory, whose contents a thread sees from [`NodeMemory::settle`] on.
struct LocalMemory {
    node: Arc<LocalNode>,
    words: usize,
    seen: Arc<Vec<u64>>,
}

impl NodeMemory for LocalMemory {
    fn begin(&mut self) -> Result<()> {
        self.seen = Arc::default();
        self.node.meet.wait();
        Ok(())
    }

    fn put(&mut self, at: usize, bytes: &[u8]) {
        let most = 8 * self.words;
        assert!(at + bytes.len() <= most, "bytes {at} to {} of {most}", at + bytes.len());
        let mut written = self.node.lock(self.words);
        bytemuck::cast_slice_mut(Arc::make_mut(&mut written).as_mut_slice())[at..at + bytes.len()]
            .copy_from_slice(bytes);
    }

    fn settle(&mut self) -> Result<()> {
        self.node.meet.wait();
        self.seen = Arc::clone(&self.node.lock(self.words));
        Ok(())
    }

    fn bytes(&self) -> &[u8] {
        bytemuck::cast_slice(&self.seen[..self.words])
    }
}

/// Messages between threads.
#[derive(Debug)]
pub struct LocalMessages {
    rank: usize,
    to: Arc<[Sender<Addressed>]>,
    from: Receiver<Addressed>,
    meeting: Arc<AtomicUsize>,
    /// The count of the meeting at which all ranks have entered this rank's current one.
    awaited: Option<usize>,
    meetings: usize,
}

fn local_messages(size: usize) -> Vec<LocalMessages> {
    let (to, from): (Vec<_>, Vec<_>) = (0..size).map(|_| unbounded()).unzip();
    let (to, meeting): (Arc<[_]>, _) = (to.into(), Arc::default());
    let one = |(rank, from)| {
        let (to, meeting) = (Arc::clone(&to), Arc::clone(&meeting));
        LocalMessages { rank, to, from, meeting, awaited: None, meetings: 0 }
    };
    from.into_iter().enumerate().map(one).collect()
}

impl Messages for LocalMessages {
    fn rank(&self) -> usize {
        self.rank
    }

    fn size(&self) -> usize {
        self.to.len()
    }

    fn send(&mut self, to: usize, bytes: Vec<u8>) -> Result<()> {
        self.to[to].send((self.rank, bytes)).map_err(|_| gone(&format!("rank {to}")))
    }

    fn is_sent(&mut self) -> Result<bool> {
        Ok(true)
    }

    fn try_receive(&mut self) -> Result<Option<(usize, Vec<u8>)>> {
        Ok(self.from.try_recv().ok())
    }

    fn receive(&mut self) -> Result<(usize, Vec<u8>)> {
        self.from.recv().map_err(|_| gone("every rank"))
    }
}

impl PointToPoint for LocalMessages {
    fn try_meet(&mut self) -> Result<bool> {
        let awaited = *self.awaited.get_or_insert_with(|| {
            self.meeting.fetch_add(1, SeqCst);
            self.meetings += 1;
            self.meetings * self.to.len()
        });
        let have_met = self.meeting.load(SeqCst) >= awaited;
        if have_met {
            self.awaited = None;
        }
        Ok(have_met)
    }
}
