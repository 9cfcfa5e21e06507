//! Ranks that compute one after the other, so that each has a processor for itself on a machine with fewer processors.
//!
//! Turns change in collective calls. Rank 0 has the last turn between two such calls: messages to it have arrived by
//! then, and no rank waits in its turn.

use icoray::Result;
use icoray::ranks::{JoinBytes, LocalTeam, NodeMemory, NodeShare, RankMessages, Team, local_nodes};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// State that the ranks of a team share.
struct Schedule {
    /// The current turn, counted over all ranks.
    now: Mutex<u64>,
    changed: Condvar,
}

/// Time that a rank has computed so far.
pub(super) type Busy = Arc<Mutex<Duration>>;

pub(super) fn seconds(busy: &Busy) -> f64 {
    lock(busy).as_secs_f64()
}

/// A rank of a local team that computes in its turn only.
pub(super) struct SequentialRank {
    team: LocalTeam,
    turns: Arc<Mutex<Turns>>,
}

struct Turns {
    schedule: Arc<Schedule>,
    size: u64,
    turn: u64,
    since: Instant,
    busy: Busy,
}

impl SequentialRank {
    /// The ranks of a team, each to be used on a thread of its own; `node_of` is the node of each rank.
    pub fn team(node_of: &[usize]) -> Vec<Self> {
        let (schedule, size) =
            (Arc::new(Schedule { now: Mutex::new(0), changed: Condvar::new() }), node_of.len() as u64);
        let rank = |team: LocalTeam| {
            let turn = size - 1 - team.rank() as u64;
            let (schedule, since, busy) = (Arc::clone(&schedule), Instant::now(), Busy::default());
            SequentialRank { team, turns: Arc::new(Mutex::new(Turns { schedule, size, turn, since, busy })) }
        };
        local_nodes(node_of).into_iter().map(rank).collect()
    }

    /// Waits for the rank's first turn.
    pub fn begin(&mut self) -> Busy {
        let mut turns = lock(&self.turns);
        turns.wait();
        turns.busy.clone()
    }

    /// Makes a collective call, outside of the rank's turn.
    fn outside_turn<R>(&mut self, call: impl FnOnce(&mut LocalTeam) -> R) -> R {
        lock(&self.turns).outside_turn(|| call(&mut self.team))
    }
}

/// Locks what ranks share, also after a panic of one; a rank's turns are locked by its own thread only.
fn lock<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Turns {
    fn wait(&mut self) {
        let (Schedule { now, changed }, turn) = (&*self.schedule, self.turn);
        drop(changed.wait_while(lock(now), |now| *now < turn).unwrap_or_else(PoisonError::into_inner));
        self.since = Instant::now();
    }

    /// Makes a collective call, outside of the rank's turn.
    fn outside_turn<R>(&mut self, call: impl FnOnce() -> R) -> R {
        *lock(&self.busy) += self.since.elapsed();
        self.pass(self.turn + 1);
        let result = call();
        self.turn += self.size;
        self.wait();
        result
    }

    fn pass(&self, turn: u64) {
        let mut now = lock(&self.schedule.now);
        *now = turn.max(*now);
        self.schedule.changed.notify_all();
    }
}

impl Drop for SequentialRank {
    fn drop(&mut self) {
        lock(&self.turns).pass(u64::MAX);
    }
}

struct SequentialMemory {
    memory: Box<dyn NodeMemory>,
    turns: Arc<Mutex<Turns>>,
}

impl NodeMemory for SequentialMemory {
    fn begin(&mut self) -> Result<()> {
        lock(&self.turns).outside_turn(|| self.memory.begin())
    }

    fn put(&mut self, at: usize, bytes: &[u8]) {
        self.memory.put(at, bytes);
    }

    fn settle(&mut self) -> Result<()> {
        lock(&self.turns).outside_turn(|| self.memory.settle())
    }

    fn bytes(&self) -> &[u8] {
        self.memory.bytes()
    }
}

impl Team for SequentialRank {
    fn rank(&self) -> usize {
        self.team.rank()
    }

    fn size(&self) -> usize {
        self.team.size()
    }

    fn reduce(&mut self, mine: Vec<u8>, join: JoinBytes) -> Result<Vec<u8>> {
        self.outside_turn(|team| team.reduce(mine, join))
    }

    fn broadcast(&mut self, mine: Vec<u8>) -> Result<Vec<u8>> {
        self.outside_turn(|team| team.broadcast(mine))
    }

    fn send(&mut self, bytes: Vec<u8>) -> Result<()> {
        self.team.send(bytes)
    }

    fn is_sent(&mut self) -> Result<bool> {
        self.team.is_sent()
    }

    fn try_receive(&mut self) -> Result<Option<(usize, Vec<u8>)>> {
        self.team.try_receive()
    }

    fn exchange(&mut self, mine: RankMessages) -> Result<RankMessages> {
        self.outside_turn(|team| team.exchange(mine))
    }

    fn share_among(&mut self, members: &[usize], mine: Vec<u8>) -> Result<Vec<Vec<u8>>> {
        self.outside_turn(|team| team.share_among(members, mine))
    }

    fn memory_mates(&mut self) -> Result<Vec<usize>> {
        self.outside_turn(LocalTeam::memory_mates)
    }

    fn node(&mut self, bytes: usize) -> Result<NodeShare> {
        let share = self.team.node(bytes)?;
        let memory = SequentialMemory { memory: share.memory, turns: Arc::clone(&self.turns) };
        Ok(NodeShare { memory: Box::new(memory), ..share })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::thread;

    #[test]
    fn one_rank_at_a_time_computes_and_rank_0_last() {
        let (order, at_work) = (Mutex::new(Vec::new()), AtomicUsize::new(0));
        thread::scope(|scope| {
            for mut rank in SequentialRank::team(&[0; 4]) {
                let (order, at_work) = (&order, &at_work);
                scope.spawn(move || {
                    let busy = rank.begin();
                    for _ in 0..3 {
                        assert_eq!(at_work.fetch_add(1, Ordering::SeqCst), 0, "two at once");
                        thread::sleep(Duration::from_millis(2));
                        order.lock().unwrap().push(rank.rank());
                        at_work.fetch_sub(1, Ordering::SeqCst);
                        let shared = rank.share(&[rank.rank() as u8]).unwrap();
                        assert_eq!(shared.concat(), [0, 1, 2, 3]);
                    }
                    assert!(seconds(&busy) >= 0.006, "{busy:?}");
                });
            }
        });
        assert_eq!(order.into_inner().unwrap(), [3, 2, 1, 0].repeat(3));
    }
}
