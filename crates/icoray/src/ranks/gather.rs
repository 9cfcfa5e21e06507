//! The tiles of a frame: their assignment to ranks, their gathering at rank 0, and the broadcast of the outcome.

use super::load_balance::{TileCosts, assign_tiles};
use super::packed;
use super::wire::{WireError, decode, encode};
use super::{NAP, Ranks, Team};
use crate::raster::{Raster, Tile, Tiling};
use crossbeam_channel::{Receiver, RecvTimeoutError, unbounded};
use icoray_grid::threads::Threads;
use icoray_grid::{Error, Result};
use icoray_kernel::Counts;
use icoray_output::{ErrorSummary, SamplingReport};
use icoray_scene::Quality;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Time for which the calling thread waits for a tile of its own before it polls messages again.
const TICK: Duration = Duration::from_millis(1);

/// The assignment of tiles to ranks, and the quality of the frame.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct TileAssignment {
    pub quality: Quality,
    /// The rank of each tile.
    pub owners: Vec<u32>,
}

impl TileAssignment {
    /// Assigns tiles in turn to all ranks; neighbouring tiles cost about the same.
    pub fn in_turn(quality: Quality, tiling: &dyn Tiling, ranks: &Ranks) -> Self {
        TileAssignment { quality, owners: (0..tiling.tiles()).map(|tile| tile % ranks.size() as u32).collect() }
    }

    /// The tiles of a rank.
    pub fn tiles_of(&self, rank: usize) -> Vec<u32> {
        (0..).zip(&self.owners).filter(|(_, owner)| **owner as usize == rank).map(|(tile, _)| tile).collect()
    }
}

/// This rank's share in a tiling.
pub(crate) struct TileShare<'t> {
    pub tiling: &'t dyn Tiling,
    /// The rank of each tile.
    pub owners: &'t [u32],
    /// Seconds of this rank's earlier drawing of the same picture, and the counts of its rays.
    pub earlier_s: f64,
    pub earlier_counts: Counts,
}

/// What ranks report to rank 0 beside their tiles.
#[derive(Serialize, Deserialize)]
struct RankSums {
    /// Sum and maximum of the ranks' seconds of drawing.
    render_s: f64,
    most_s: f64,
    /// Sums of the counts of their earlier rays.
    counts: [u64; 7],
    /// The error of the lowest rank that failed.
    failure: Option<(usize, WireError)>,
}

impl RankSums {
    fn join(a: Self, b: Self) -> Self {
        let mut counts = Counts::of_numbers(a.counts);
        counts += Counts::of_numbers(b.counts);
        RankSums {
            render_s: a.render_s + b.render_s,
            most_s: a.most_s.max(b.most_s),
            counts: counts.numbers(),
            failure: a.failure.into_iter().chain(b.failure).min_by_key(|(rank, _)| *rank),
        }
    }
}

/// The outcome of gathering tiles.
#[derive(Debug)]
pub(crate) struct GatheredTiles {
    /// All tiles at rank 0, in any order; none on other ranks.
    pub tiles: Vec<Tile>,
    /// Seconds that this rank spent drawing.
    pub render_s: f64,
    /// Seconds from rank 0's last tile to the last tile of all ranks.
    pub gather_s: f64,
    /// Mean over maximum of the ranks' seconds of drawing.
    pub balance: f64,
    /// Bytes that rank 0 received.
    pub bytes_received: u64,
}

/// The summary of a frame that rank 0 broadcasts.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
pub(crate) struct FrameSummary {
    pub error: ErrorSummary,
    /// As [`Counts::numbers`].
    pub counts: [u64; 7],
    pub edge_pixels: u64,
    pub sampling: SamplingReport,
    /// Seconds, balance and bytes of the gathering.
    pub gather_s: f64,
    pub balance: f64,
    pub bytes_received: u64,
}

impl Default for GatheredTiles {
    fn default() -> Self {
        GatheredTiles { tiles: Vec::new(), render_s: 0.0, gather_s: 0.0, balance: 1.0, bytes_received: 0 }
    }
}

impl Ranks {
    /// Agrees on the cheapest of the qualities that ranks have picked, each for its own part.
    pub(crate) fn agree_on_cheapest(&mut self, mine: Result<Quality>) -> Result<Quality> {
        self.reduce_work(
            || mine,
            |mut cheapest: Quality, other| {
                cheapest.pixel_step = cheapest.pixel_step.max(other.pixel_step);
                cheapest.tolerance = cheapest.tolerance.max(other.tolerance);
                cheapest.lights = cheapest.lights.min(other.lights);
                cheapest
            },
        )
    }

    /// Agrees on rank 0's quality and assigns tiles to ranks; `facts` must be equal on all ranks.
    pub(crate) fn assign(
        &mut self,
        mine: Result<Quality>,
        raster: Raster,
        facts: impl FnOnce() -> Vec<(&'static str, String)>,
    ) -> Result<TileAssignment> {
        let raster = |quality: &Quality| Raster { step: quality.pixel_step, ..raster };
        if self.team.is_none() {
            return mine.map(|quality| TileAssignment { quality, owners: vec![0; raster(&quality).tiles() as usize] });
        }
        let (rank, ranks) = (self.rank(), self.size());
        let mine = mine.map(|quality| {
            let assigned = (rank == 0).then(|| assign_tiles(raster(&quality), ranks, self.costs.as_ref()));
            TileAssignment { quality, owners: assigned.unwrap_or_default() }
        });
        self.agree_on(mine, facts())
    }

    /// The tiles in which each of the ranks that share a part traces its rays, in the order of these ranks; tiles of a
    /// raster are assigned by their costs in the last frame.
    pub(crate) fn assign_part_tiles(&self, tiling: &dyn Tiling, ranks: usize) -> Vec<Vec<u32>> {
        let owners = match tiling.raster() {
            Some(raster) => assign_tiles(raster, ranks, self.part_costs.as_ref()),
            None => (0..tiling.tiles()).map(|tile| tile % ranks as u32).collect(),
        };
        let mut tiles = vec![Vec::new(); ranks];
        (0..).zip(owners).for_each(|(tile, owner)| tiles[owner as usize].push(tile));
        tiles
    }

    /// Stores the costs of a part's tiles for the next frame, given this rank's `seconds` of some of them: equal on all
    /// ranks that share the part, the `mates`. Collective.
    pub(crate) fn share_part_costs(&mut self, raster: Raster, mates: &[usize], seconds: &[(u32, f32)]) -> Result<()> {
        let mut costs = TileCosts::new(raster);
        for bytes in self.share_among(mates, encode(seconds))? {
            let seconds = decode::<Vec<(u32, f32)>>(&bytes)?.into_iter();
            seconds.for_each(|(tile, seconds)| costs.set(tile, seconds.into()));
        }
        self.part_costs = Some(costs);
        Ok(())
    }

    /// Calls `draw` for this rank's tiles on `threads`, and sends each tile to rank 0 as soon as it is drawn. On rank
    /// 0, a failure of any rank is the result; on other ranks the result covers sending only, and [`Self::hear_root`]
    /// returns the outcome. Rank 0 receives a message per tile and one per failure; seconds, counts and errors are joined
    /// on the way to it.
    pub(crate) fn gather(
        &mut self,
        threads: &Threads,
        share: &TileShare,
        draw: impl FnOnce(&(dyn Fn(Tile) + Sync)) + Send,
    ) -> Result<GatheredTiles> {
        let (start, tiling) = (Instant::now(), share.tiling);
        let (given, drawn) = unbounded();
        // The sender is dropped when all is drawn, also by a panic; then the receiver ends.
        let draw = move || {
            // The receiver is gone if ranks cannot be reached; that error is returned elsewhere.
            draw(&|tile| drop(given.send(tile)));
            share.earlier_s + start.elapsed().as_secs_f64()
        };
        let Some(team) = &mut self.team else {
            let render_s = threads.run(draw);
            let mut tiles: Vec<Tile> = drawn.try_iter().collect();
            tiles.iter_mut().take(1).for_each(|tile| tile.counts += share.earlier_counts);
            return Ok(GatheredTiles { tiles, render_s, ..GatheredTiles::default() });
        };
        let mut outcome = Ok(0.0);
        let on_threads = || outcome = Error::of_panics(|| Ok(draw()));
        let mut received = ReceivedTiles::new(share);
        let mut gather_s = 0.0;
        if team.rank() != 0 {
            let sent = threads.run_with(on_threads, || send(team, &drawn))?;
            if sent < share.owners.iter().filter(|owner| **owner as usize == team.rank()).count() {
                team.send(packed::end())?;
            }
            while !team.is_sent()? {
                sleep(NAP);
            }
        } else {
            threads.run_with(on_threads, || received.take(team, &drawn))?;
            let waiting = Instant::now();
            while received.all_missing > 0 {
                team.wait()?;
                received.take_all(team)?;
            }
            gather_s = waiting.elapsed().as_secs_f64();
        }
        let (rank, ranks, render_s) = (team.rank(), team.size(), *outcome.as_ref().unwrap_or(&0.0));
        let failure = outcome.as_ref().err().map(|error| (rank, error.into()));
        let mine = RankSums { render_s, most_s: render_s, counts: share.earlier_counts.numbers(), failure };
        let summed = team.reduce(encode(&mine), &|a, b| Ok(encode(&RankSums::join(decode(&a)?, decode(&b)?))))?;
        if team.rank() != 0 {
            return Ok(GatheredTiles { render_s, ..GatheredTiles::default() });
        }
        let ReceivedTiles { mut tiles, failures, bytes_received, .. } = received;
        let RankSums { render_s: sum, most_s, counts, failure } = decode(&summed)?;
        let failure = failure.map(|(rank, error)| (rank, error.received()));
        if let Some((rank, error)) = failures.into_iter().chain(failure).min_by_key(|(rank, _)| *rank) {
            return Err(error.of_rank(rank, ranks));
        }
        if let Some(raster) = tiling.raster() {
            let mut costs = TileCosts::new(raster);
            tiles.iter().for_each(|tile| costs.set(tile.number, tile.seconds));
            self.costs = Some(costs);
        }
        tiles.iter_mut().take(1).for_each(|tile| tile.counts += Counts::of_numbers(counts));
        let balance = if most_s > 0.0 { sum / ranks as f64 / most_s } else { 1.0 };
        Ok(GatheredTiles { tiles, render_s, gather_s, balance, bytes_received })
    }

    /// Broadcasts the value of rank 0, or its error. An error of another rank is that rank's result only if rank 0 has
    /// none: the transport has failed there. Only rank 0 sends, so tiles of other ranks may still be in flight.
    pub(crate) fn hear_root<T: Serialize + DeserializeOwned>(&mut self, mine: Result<T>) -> Result<T> {
        let Some(team) = &mut self.team else {
            return mine;
        };
        let bytes = team.broadcast(encode(&mine.as_ref().map_err(WireError::from)))?;
        let value = decode::<std::result::Result<T, WireError>>(&bytes)?.map_err(WireError::received)?;
        mine.map(|_| value)
    }
}

/// Sends tiles while they are drawn; returns their number.
fn send(team: &mut Team, drawn: &Receiver<Tile>) -> Result<usize> {
    let mut sent = 0;
    loop {
        // Only messages in flight need further calls.
        let next = match team.is_sent()? {
            true => drawn.recv().map_err(|_| RecvTimeoutError::Disconnected),
            false => drawn.recv_timeout(TICK),
        };
        match next {
            Ok(tile) => {
                team.send(packed::tile(&tile))?;
                sent += 1;
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return Ok(sent),
        }
    }
}

/// The tiles that rank 0 has received.
struct ReceivedTiles<'t> {
    tiling: &'t dyn Tiling,
    tiles: Vec<Tile>,
    /// Number of tiles that each rank has yet to send, and their sum.
    missing: BTreeMap<usize, usize>,
    all_missing: usize,
    /// Errors of messages that cannot be decoded, by the rank that sent them.
    failures: BTreeMap<usize, Error>,
    bytes_received: u64,
}

impl<'t> ReceivedTiles<'t> {
    fn new(share: &TileShare<'t>) -> Self {
        let mut missing = BTreeMap::new();
        // Rank 0 sends no message to itself.
        share
            .owners
            .iter()
            .filter(|owner| **owner > 0)
            .for_each(|owner| *missing.entry(*owner as usize).or_default() += 1);
        let all_missing = missing.values().sum();
        let (tiles, failures) = (Vec::new(), BTreeMap::new());
        ReceivedTiles { tiling: share.tiling, tiles, missing, all_missing, failures, bytes_received: 0 }
    }

    /// Collects this rank's tiles while they are drawn, and meanwhile those received from other ranks.
    fn take(&mut self, team: &mut Team, drawn: &Receiver<Tile>) -> Result<()> {
        loop {
            match drawn.recv_timeout(TICK) {
                Ok(tile) => self.tiles.push(tile),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Ok(()),
            }
            self.take_all(team)?;
        }
    }

    /// Collects all messages that have arrived.
    fn take_all(&mut self, team: &mut Team) -> Result<()> {
        while let Some((rank, bytes)) = team.try_receive()? {
            self.bytes_received += bytes.len() as u64;
            let sent = packed::read(&bytes, rank, self.tiling);
            let missing = self.missing.entry(rank).or_default();
            let arrived = if matches!(sent, Ok(None)) { *missing } else { 1.min(*missing) };
            *missing -= arrived;
            self.all_missing -= arrived;
            match sent {
                Ok(tile) => self.tiles.extend(tile),
                Err(error) => drop(self.failures.entry(rank).or_insert(error)),
            }
        }
        Ok(())
    }
}
