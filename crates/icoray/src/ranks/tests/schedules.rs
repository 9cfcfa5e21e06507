//! Random schedules: messages of different ranks arrive in any order and late, a rank is slower than the others, and
//! ranks fail anywhere in a frame.

use super::node_ranks::NodeRanks;
use super::*;
use icoray_test_support::{Random, runs_long};
use std::collections::VecDeque;

/// Messages that arrive in the order of each sender, but otherwise in a random one, some of them late.
struct Shuffled {
    messages: LocalMessages,
    random: Random,
    /// How often other threads run before the rank goes on: 1, or 10 for a slow rank.
    slowness: usize,
    waiting: BTreeMap<usize, VecDeque<Vec<u8>>>,
}

impl Shuffled {
    fn delay(&mut self) {
        (0..self.random.below(2 * self.slowness)).for_each(|_| thread::yield_now());
    }

    fn wait_for(&mut self, (from, bytes): (usize, Vec<u8>)) {
        self.waiting.entry(from).or_default().push_back(bytes);
    }

    fn collect(&mut self) -> Result<()> {
        while let Some(message) = self.messages.try_receive()? {
            self.wait_for(message);
        }
        Ok(())
    }

    /// The next message of a random sender.
    fn take(&mut self) -> Option<(usize, Vec<u8>)> {
        let senders: Vec<usize> = self.waiting.keys().copied().collect();
        let from = *senders.get(self.random.below(senders.len().max(1)))?;
        let messages = self.waiting.get_mut(&from)?;
        let message = messages.pop_front();
        if messages.is_empty() {
            self.waiting.remove(&from);
        }
        Some((from, message?))
    }
}

impl Messages for Shuffled {
    fn send(&mut self, to: usize, bytes: Vec<u8>) -> Result<()> {
        self.delay();
        self.messages.send(to, bytes)
    }

    fn try_receive(&mut self) -> Result<Option<(usize, Vec<u8>)>> {
        self.collect()?;
        Ok(if self.random.below(2 * self.slowness) == 0 { self.take() } else { None })
    }

    fn receive(&mut self) -> Result<(usize, Vec<u8>)> {
        self.collect()?;
        while self.waiting.is_empty() {
            let message = self.messages.receive()?;
            self.wait_for(message);
            self.delay();
            self.collect()?;
        }
        Ok(self.take().expect("a message is waiting"))
    }

    fn meet(&mut self) -> Result<()> {
        self.messages.meet()
    }
}

/// The phases of a frame at which a rank can fail.
const PHASES: usize = 5;

/// A frame of tiles, with what ranks put into their node's memory and fragments before them. The rank that fails does so in its phase.
fn frame(ranks: &mut Ranks, threads: &Threads, fails: Option<usize>) -> Result<u64> {
    let fail = |phase: usize| match fails {
        Some(at) if at == phase => Err(Error::new(ErrorKind::Memory, format!("phase {phase}"))),
        _ => Ok(()),
    };
    let (rank, size) = (ranks.rank(), ranks.size());
    let raster = Raster { width: 60, height: 30, step: 1 };
    let owners: Vec<u32> = (0..raster.tiles()).map(|tile| tile * 7 % size as u32).collect();
    ranks.collective(fail(0))?;
    let sum = ranks.reduce_work(|| fail(1).map(|()| rank as u64), |a, b| a + b)?;
    assert_eq!(sum as usize, size * (size - 1) / 2);
    let nodes = NodeRanks::find(ranks)?;
    let mut node = ranks.take_node(8 * size)?;
    node.begin(ranks.team.as_mut())?;
    let written = fail(2).map(|()| node.put(8 * rank, &rank.to_le_bytes()));
    node.settle(ranks.team.as_mut())?;
    ranks.collective(written)?;
    assert!(nodes.mates().iter().all(|mate| node.bytes()[8 * mate..8 * mate + 8] == mate.to_le_bytes()));
    ranks.keep_node(node);
    // Each rank has fragments of some tiles.
    let tiles = || (0..raster.tiles()).filter(|tile| (*tile as usize + rank).is_multiple_of(3));
    let mut traced = Traced { tiles: tiles().map(|tile| (tile, vec![rank as u8])).collect(), ..Traced::default() };
    let messages = traced.messages(ranks, &owners);
    let messages = ranks.collective(fail(3).map(|()| messages))?;
    let received = ranks.exchange(messages)?;
    let mut found = 0;
    read_fragments(&received, |tile, unread| {
        let (sender, rest) = unread.split_first().expect("a byte per tile");
        *unread = rest;
        found += 1;
        assert!((tile as usize + usize::from(*sender)).is_multiple_of(3) && owners[tile as usize] as usize == rank);
        Ok(())
    })?;
    ranks.share_part_costs(raster, nodes.mates(), &[(rank as u32, 1.0)])?;
    let share = TileShare { earlier_counts: Counts { rays: found, ..Counts::default() }, ..share(&raster, &owners) };
    let mine: Vec<u32> = (0..raster.tiles()).filter(|tile| owners[*tile as usize] as usize == rank).collect();
    let gathered = ranks.gather(threads, &share, |give| {
        mine.par_iter().enumerate().for_each(|(k, number)| {
            assert!(fails != Some(4) || 2 * k < mine.len(), "phase 4");
            let pixels = vec![Pixel::default(); raster.pixels_of(*number)];
            give(Tile { number: *number, seconds: 0.0, counts: Counts::default(), pixels });
        });
        assert!(fails != Some(4), "phase 4");
    });
    let summary = gathered.map(|gathered| {
        let mut counts = Counts::default();
        gathered.tiles.iter().for_each(|tile| counts += tile.counts);
        assert_eq!(gathered.tiles.len(), if rank == 0 { raster.tiles() as usize } else { 0 });
        counts.rays
    });
    ranks.hear_root(summary)
}

/// All ranks have the same outcome of each frame, and a frame after a failure is as any other: 10,000 schedules where
/// long tests run, else 300.
#[test]
fn no_schedule_makes_ranks_wait_or_differ() {
    let threads = Threads::new(2).unwrap();
    for seed in 0..if runs_long() { 10_000 } else { 300 } {
        let mut random = Random::new(seed);
        let size = [2, 3, 5, 8, 40][random.below(5)];
        let nodes = 1 + random.below(3);
        let node_of: Vec<usize> = (0..size).map(|rank| rank * nodes / size).collect();
        let failing: Vec<Option<[usize; 2]>> =
            (0..3).map(|_| (random.below(2) == 0).then(|| [random.below(size), random.below(PHASES)])).collect();
        let slow = random.below(2 * size);
        let team = local_nodes_over(&node_of, |messages| Shuffled {
            slowness: if messages.rank() == slow { 10 } else { 1 },
            random: Random::new(seed * 1000 + messages.rank() as u64),
            messages,
            waiting: BTreeMap::new(),
        });
        let of_ranks: Vec<Vec<std::result::Result<u64, String>>> = on_threads(team, |team| {
            let mut ranks = Ranks::new(team);
            let rank = ranks.rank();
            let frame = |fails: &Option<[usize; 2]>| {
                let fails = fails.filter(|[odd, _]| *odd == rank).map(|[_, phase]| phase);
                frame(&mut ranks, &threads, fails).map_err(|error| error.to_string())
            };
            failing.iter().map(frame).collect()
        });
        for (number, fails) in failing.iter().enumerate() {
            for outcomes in &of_ranks {
                match (fails, &outcomes[number]) {
                    (None, outcome) => assert_eq!(*outcome, of_ranks[0][number], "seed {seed}"),
                    (Some([odd, phase]), Err(error)) => {
                        assert!(error.ends_with(&format!("rank {odd}: phase {phase}")), "seed {seed}: {error}");
                    }
                    (Some(_), Ok(_)) => panic!("seed {seed}: frame {number} has failed on a rank only"),
                }
            }
            // Every third tile of each rank.
            if fails.is_none() {
                assert!(of_ranks[0][number].as_ref().is_ok_and(|rays| *rays > 0), "seed {seed}");
            }
        }
    }
}

/// A frame of four times as many ranks and nodes takes no more messages of a rank in the mean, and fewer bytes: each has fewer
/// tiles.
#[test]
fn messages_of_a_rank_do_not_grow_with_the_number_of_ranks() {
    let threads = Threads::new(2).unwrap();
    let mean = |size: usize| {
        let node_of: Vec<usize> = (0..size).map(|rank| rank / 8).collect();
        let sent = on_nodes(&node_of, |ranks| {
            frame(ranks, &threads, None).unwrap();
            ranks.traffic()
        });
        let sum = |of: fn(&Traffic) -> u64| sent.iter().map(of).sum::<u64>() as f64 / size as f64;
        [sum(|sent| sent.messages), sum(|sent| sent.bytes)]
    };
    let ([messages, bytes], [of_four, bytes_of_four]) = (mean(40), mean(160));
    assert!(
        messages > 5.0 && of_four < messages && bytes_of_four < bytes,
        "{:?}",
        [messages, of_four, bytes, bytes_of_four]
    );
}
