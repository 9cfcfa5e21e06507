//! Ranks that compute one after the other: on a machine with fewer processors than ranks, each has one for itself.
//!
//! Turns change in the calls that all ranks make. Between two of them rank 0 has its turn last, so that all that others send
//! it has come and nobody waits in his turn.

use icoray::Result;
use icoray::ranks::{LocalTeam, NodeMemory, NodeShare, Team, local_nodes};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// What the ranks of a team share.
#[derive(Debug)]
struct Table {
    /// The turn that is now, counted over all ranks.
    now: Mutex<u64>,
    changed: Condvar,
}

impl Table {
    fn now(&self) -> MutexGuard<'_, u64> {
        self.now.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// What a rank has computed so far, to be looked at in its turn.
#[derive(Debug, Clone, Default)]
pub(super) struct Busy(Arc<Mutex<Duration>>);

impl Busy {
    pub fn seconds(&self) -> f64 {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).as_secs_f64()
    }
}

/// A rank of a local team that computes in its turn only.
#[derive(Debug)]
pub(super) struct InTurn {
    team: LocalTeam,
    turns: Arc<Mutex<Turns>>,
}

/// A rank's turns.
#[derive(Debug)]
struct Turns {
    table: Arc<Table>,
    /// Number of ranks.
    size: u64,
    turn: u64,
    since: Instant,
    busy: Busy,
}

impl InTurn {
    /// A team on nodes, each to be moved to a thread of its own and begun there; `node_of` has a number for each rank.
    pub fn team(node_of: &[usize]) -> Vec<Self> {
        let (table, size) =
            (Arc::new(Table { now: Mutex::new(0), changed: Condvar::new() }), node_of.len() as u64);
        let rank = |team: LocalTeam| {
            let turn = size - 1 - team.rank() as u64;
            let (table, since, busy) = (Arc::clone(&table), Instant::now(), Busy::default());
            InTurn { team, turns: Arc::new(Mutex::new(Turns { table, size, turn, since, busy })) }
        };
        local_nodes(node_of).into_iter().map(rank).collect()
    }

    /// Waits for the rank's first turn.
    pub fn begin(&mut self) -> Busy {
        let mut turns = turns(&self.turns);
        turns.wait();
        turns.busy.clone()
    }

    /// Makes a call in which ranks wait for each other.
    fn aside<R>(&mut self, call: impl FnOnce(&mut LocalTeam) -> R) -> R {
        turns(&self.turns).aside(|| call(&mut self.team))
    }
}

/// Only the rank's own thread takes them.
fn turns(of: &Mutex<Turns>) -> MutexGuard<'_, Turns> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Turns {
    fn wait(&mut self) {
        let now = self.table.now();
        let turn = self.turn;
        drop(self.table.changed.wait_while(now, |now| *now < turn).unwrap_or_else(PoisonError::into_inner));
        self.since = Instant::now();
    }

    /// Makes a call in which ranks wait for each other.
    fn aside<R>(&mut self, call: impl FnOnce() -> R) -> R {
        *self.busy.0.lock().unwrap_or_else(PoisonError::into_inner) += self.since.elapsed();
        self.pass(self.turn + 1);
        let result = call();
        self.turn += self.size;
        self.wait();
        result
    }

    fn pass(&self, turn: u64) {
        let mut now = self.table.now();
        *now = turn.max(*now);
        self.table.changed.notify_all();
    }
}

impl Drop for InTurn {
    /// Nobody waits for one who has left.
    fn drop(&mut self) {
        turns(&self.turns).pass(u64::MAX);
    }
}

/// Memory of a node whose ranks compute in their turns.
struct InTurnMemory {
    memory: Box<dyn NodeMemory>,
    turns: Arc<Mutex<Turns>>,
}

impl NodeMemory for InTurnMemory {
    fn begin(&mut self) -> Result<()> {
        turns(&self.turns).aside(|| self.memory.begin())
    }

    fn put(&mut self, at: usize, bytes: &[u8]) {
        self.memory.put(at, bytes);
    }

    fn settle(&mut self) -> Result<()> {
        turns(&self.turns).aside(|| self.memory.settle())
    }

    fn bytes(&self) -> &[u8] {
        self.memory.bytes()
    }
}

impl Team for InTurn {
    fn rank(&self) -> usize {
        self.team.rank()
    }

    fn size(&self) -> usize {
        self.team.size()
    }

    fn share(&mut self, mine: &[u8]) -> Result<Vec<Vec<u8>>> {
        self.aside(|team| team.share(mine))
    }

    fn broadcast(&mut self, mine: Vec<u8>) -> Result<Vec<u8>> {
        self.aside(|team| team.broadcast(mine))
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

    fn exchange(&mut self, mine: Vec<Vec<u8>>) -> Result<Vec<Vec<u8>>> {
        self.aside(|team| team.exchange(mine))
    }

    fn memory_leader(&mut self) -> Result<usize> {
        self.team.memory_leader()
    }

    fn node(&mut self, bytes: usize) -> Result<NodeShare> {
        let share = self.team.node(bytes)?;
        let memory = InTurnMemory { memory: share.memory, turns: Arc::clone(&self.turns) };
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
            for mut rank in InTurn::team(&[0; 4]) {
                let (order, at_work) = (&order, &at_work);
                scope.spawn(move || {
                    let busy = rank.begin();
                    for _ in 0..3 {
                        assert_eq!(at_work.fetch_add(1, Ordering::SeqCst), 0, "two at once");
                        thread::sleep(Duration::from_millis(2));
                        order.lock().unwrap().push(rank.rank());
                        at_work.fetch_sub(1, Ordering::SeqCst);
                        let said = rank.share(&[rank.rank() as u8]).unwrap();
                        assert_eq!(said.concat(), [0, 1, 2, 3]);
                    }
                    assert!(busy.seconds() >= 0.006, "{}", busy.seconds());
                });
            }
        });
        assert_eq!(order.into_inner().unwrap(), [3, 2, 1, 0].repeat(3));
    }
}
