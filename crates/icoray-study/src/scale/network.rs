//! A network between threads: each rank has a clock, which messages advance. Nothing waits for real time.
//!
//! The model is LogGP (Alexandrov et al. 1995, doi:10.1145/215399.215427): sender and receiver spend an overhead for
//! each message and a time for each byte, and a message arrives a latency after it was sent. The ranks of a node share
//! its bandwidth in equal parts; rank 0, to which all tiles go, has all of its node's.

use icoray::Result;
use icoray::ranks::{LocalMessages, Messages};
use std::sync::{Arc, Mutex, PoisonError};

/// Times of messages between nodes; within a node a message takes [`WITHIN_NODE`] of them.
#[derive(Debug, Clone, Copy, clap::Args)]
pub struct Network {
    /// Microseconds from the end of sending a message to its arrival.
    #[arg(long, default_value_t = 2.0)]
    pub latency_us: f64,
    /// Microseconds that a rank spends on sending or receiving a message.
    #[arg(long, default_value_t = 1.0)]
    pub overhead_us: f64,
    /// Gigabytes per second of a node.
    #[arg(long, default_value_t = 12.5)]
    pub gb_per_s: f64,
    /// Ranks of a node.
    #[arg(long, default_value_t = 128)]
    pub node_ranks: usize,
}

/// The latency within a node, as a fraction of that between nodes. Its bandwidth is that between nodes.
const WITHIN_NODE: f64 = 0.25;

impl Network {
    pub fn node_of(&self, rank: usize) -> usize {
        rank / self.node_ranks
    }

    /// Seconds that a rank spends on a message of so many bytes.
    fn busy_s(&self, rank: usize, bytes: usize) -> f64 {
        let sharing = if rank == 0 { 1 } else { self.node_ranks };
        1e-6 * self.overhead_us + bytes as f64 * sharing as f64 / (1e9 * self.gb_per_s)
    }

    fn latency_s(&self, from: usize, to: usize) -> f64 {
        let part = if self.node_of(from) == self.node_of(to) { WITHIN_NODE } else { 1.0 };
        1e-6 * self.latency_us * part
    }
}

/// The time of a rank, in seconds, and the bytes that it has sent to other nodes.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Time {
    pub s: f64,
    pub link_bytes: u64,
}

pub(super) type Clock = Arc<Mutex<Time>>;

pub(super) fn read(clock: &Clock) -> Time {
    *clock.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Messages that take the time of a network. The time of its arrival is behind each message.
pub(super) struct TimedMessages {
    pub messages: LocalMessages,
    pub network: Network,
    pub clock: Clock,
}

impl TimedMessages {
    /// Advances the clock to the end of receiving a message.
    fn arrived(&self, (from, mut bytes): (usize, Vec<u8>)) -> (usize, Vec<u8>) {
        let arrival = bytes.split_off(bytes.len() - size_of::<f64>());
        let arrival = arrival.first_chunk().map_or(0.0, |arrival| f64::from_le_bytes(*arrival));
        let mut clock = self.clock.lock().unwrap_or_else(PoisonError::into_inner);
        clock.s = (clock.s + self.network.busy_s(self.messages.rank(), bytes.len()))
            .max(arrival + 1e-6 * self.network.overhead_us);
        (from, bytes)
    }
}

impl Messages for TimedMessages {
    fn send(&mut self, to: usize, mut bytes: Vec<u8>) -> Result<()> {
        let sent = {
            let mut clock = self.clock.lock().unwrap_or_else(PoisonError::into_inner);
            clock.s += self.network.busy_s(self.messages.rank(), bytes.len());
            let is_link = self.network.node_of(self.messages.rank()) != self.network.node_of(to);
            clock.link_bytes += if is_link { bytes.len() as u64 } else { 0 };
            clock.s
        };
        bytes.extend_from_slice(&(sent + self.network.latency_s(self.messages.rank(), to)).to_le_bytes());
        self.messages.send(to, bytes)
    }

    fn try_receive(&mut self) -> Result<Option<(usize, Vec<u8>)>> {
        Ok(self.messages.try_receive()?.map(|message| self.arrived(message)))
    }

    fn receive(&mut self) -> Result<(usize, Vec<u8>)> {
        self.messages.receive().map(|message| self.arrived(message))
    }

    fn meet(&mut self) -> Result<()> {
        self.messages.meet()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use icoray::ranks::{local_nodes_over, on_threads};

    /// One message between nodes: overhead and bytes at both ends, or the latency between.
    #[test]
    fn a_message_takes_the_time_of_the_network() {
        let network = Network { latency_us: 100.0, overhead_us: 10.0, gb_per_s: 1.0, node_ranks: 1 };
        let clocks: Vec<Clock> = (0..2).map(|_| Clock::default()).collect();
        let team = local_nodes_over(&[0, 1], |messages| {
            let clock = Arc::clone(&clocks[messages.rank()]);
            TimedMessages { messages, network, clock }
        });
        on_threads(team, |mut team| assert_eq!(team.broadcast(vec![7; 1_000_000]).unwrap().len(), 1_000_000));
        // 1,000,000 bytes, and the 9 of the message's end.
        let sent = 10e-6 + 1e-9 * 1_000_009.0;
        assert!((read(&clocks[0]).s - sent).abs() < 1e-12);
        assert_eq!(read(&clocks[0]).link_bytes, 1_000_009);
        let time = read(&clocks[1]);
        assert!((time.s - (sent + 110e-6)).abs() < 1e-12, "{time:?}");
    }
}
