//! Ranks that compute one after the other, so that each has a processor for itself on a machine with fewer processors.
//!
//! A rank has its turn until it waits for others: for a message that has not arrived, or to meet them.

use crossbeam_channel::{Receiver, Sender, bounded};
use icoray::Result;
use icoray::ranks::{LocalMessages, Messages, Team, local_nodes_over};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// The turns of a rank, and the time that it has computed so far.
pub(super) struct Turns {
    /// A channel of one item, taken by the rank whose turn it is.
    turn: (Sender<()>, Receiver<()>),
    busy: Mutex<Busy>,
}

#[derive(Default)]
struct Busy {
    before: Duration,
    /// Start of the current turn, outside of which it is `None`.
    since: Option<Instant>,
}

impl Turns {
    /// Waits for the rank's turn.
    pub fn begin(&self) {
        // All ranks have both ends.
        let _ = self.turn.1.recv();
        self.busy().since = Some(Instant::now());
    }

    fn end(&self) {
        let since = {
            let mut busy = self.busy();
            let since = busy.since.take();
            busy.before += since.map_or(Duration::ZERO, |since| since.elapsed());
            since
        };
        if since.is_some() {
            let _ = self.turn.0.send(());
        }
    }

    /// Waits for other ranks, outside of the rank's turn.
    fn outside<R>(&self, wait: impl FnOnce() -> R) -> R {
        self.end();
        let result = wait();
        self.begin();
        result
    }

    /// Seconds that the rank has computed.
    pub fn seconds(&self) -> f64 {
        let busy = self.busy();
        (busy.before + busy.since.map_or(Duration::ZERO, |since| since.elapsed())).as_secs_f64()
    }

    fn busy(&self) -> std::sync::MutexGuard<'_, Busy> {
        self.busy.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The ranks of a team, each to be used on a thread of its own from its first turn on; `node_of` is the node of each.
pub(super) fn sequential_team(node_of: &[usize]) -> Vec<(Team, Arc<Turns>)> {
    let turn = bounded(1);
    // The first to come has the first turn.
    let _ = turn.0.send(());
    let new = || Arc::new(Turns { turn: turn.clone(), busy: Mutex::default() });
    let turns: Vec<Arc<Turns>> = node_of.iter().map(|_| new()).collect();
    let wrap = |messages: LocalMessages| {
        let turns = Arc::clone(&turns[messages.rank()]);
        SequentialMessages { messages, turns }
    };
    local_nodes_over(node_of, wrap).into_iter().zip(turns.clone()).collect()
}

/// Messages of a rank that computes in its turn only.
struct SequentialMessages {
    messages: LocalMessages,
    turns: Arc<Turns>,
}

impl Messages for SequentialMessages {
    fn send(&mut self, to: usize, bytes: Vec<u8>) -> Result<()> {
        self.messages.send(to, bytes)
    }

    fn try_receive(&mut self) -> Result<Option<(usize, Vec<u8>)>> {
        self.messages.try_receive()
    }

    fn receive(&mut self) -> Result<(usize, Vec<u8>)> {
        match self.messages.try_receive()? {
            Some(message) => Ok(message),
            None => self.turns.outside(|| self.messages.receive()),
        }
    }

    fn meet(&mut self) -> Result<()> {
        self.turns.outside(|| self.messages.meet())
    }
}

impl Drop for SequentialMessages {
    fn drop(&mut self) {
        self.turns.end();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use icoray::ranks::on_threads;
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::thread;

    #[test]
    fn one_rank_at_a_time_computes() {
        let (start, at_work) = (Instant::now(), AtomicUsize::new(0));
        let seconds = on_threads(sequential_team(&[0; 4]), |(mut rank, turns)| {
            turns.begin();
            for _ in 0..3 {
                assert_eq!(at_work.fetch_add(1, Ordering::SeqCst), 0, "two at once");
                thread::sleep(Duration::from_millis(2));
                at_work.fetch_sub(1, Ordering::SeqCst);
                assert_eq!(rank.share(&[rank.rank() as u8]).unwrap().concat(), [0, 1, 2, 3]);
                rank.node(8).unwrap().begin(Some(&mut rank)).unwrap();
            }
            turns.seconds()
        });
        assert!(seconds.iter().all(|seconds| *seconds >= 0.006), "{seconds:?}");
        assert!(seconds.iter().sum::<f64>() <= start.elapsed().as_secs_f64(), "{seconds:?}: the turns of others count");
    }
}
