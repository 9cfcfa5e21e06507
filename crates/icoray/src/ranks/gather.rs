//! A frame's tiles: who draws which, how they come to rank 0, and what all ranks hear of it.

use super::deal::{Costs, deal};
use super::packed::{self, Sent};
use super::words::{Reader, Words};
use super::{NAP, Ranks, Team};
use crate::error::{Error, ErrorKind, Result};
use crate::frame::{Certainty, Counts, ErrorSummary};
use crate::quality::{Lights, Quality};
use crate::raster::{Raster, Tile, Tiling};
use crate::threads::Threads;
use crossbeam_channel::{Receiver, RecvTimeoutError, unbounded};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// How long the calling thread waits for a tile of its own before it looks after messages again.
const TICK: Duration = Duration::from_millis(1);

/// What this rank is to draw, and in which quality all draw.
#[derive(Debug)]
pub(crate) struct Share {
    pub quality: Quality,
    /// The rank of each tile.
    pub owners: Vec<u32>,
}

impl Share {
    /// The tiles of a rank.
    pub fn tiles_of(&self, rank: usize) -> Vec<u32> {
        (0..).zip(&self.owners).filter(|(_, owner)| **owner as usize == rank).map(|(tile, _)| tile).collect()
    }
}

/// What the tiles of all ranks came to, the same on all but for the tiles.
#[derive(Debug)]
pub(crate) struct Gathered {
    /// At rank 0 all tiles, in no order; elsewhere none.
    pub tiles: Vec<Tile>,
    /// Seconds that this rank drew.
    pub drawn_s: f64,
    /// Seconds from rank 0's last tile to everybody's.
    pub gather_s: f64,
    /// Mean over most of the seconds that ranks drew.
    pub balance: f64,
    /// Bytes that rank 0 received.
    pub bytes_received: u64,
}

/// What rank 0 tells of a frame.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Told {
    pub error: ErrorSummary,
    pub counts: Counts,
    pub gather_s: f64,
    pub balance: f64,
    pub bytes_received: u64,
}

impl Default for Gathered {
    fn default() -> Self {
        Gathered { tiles: Vec::new(), drawn_s: 0.0, gather_s: 0.0, balance: 1.0, bytes_received: 0 }
    }
}

impl Ranks {
    /// Agrees on a quality, which is rank 0's.
    pub(crate) fn agree_on_quality(&mut self, mine: Result<Quality>) -> Result<Quality> {
        if self.team.is_none() {
            return mine;
        }
        let mine = mine.map(|quality| {
            let mut words = Words::default();
            put_quality(&mut words, &quality);
            words.0
        });
        get_quality(&mut Reader(&self.agree_on(mine, Vec::new())?))
    }

    /// Agrees on the cheapest of the qualities that ranks have picked, each for its own part.
    pub(crate) fn agree_on_cheapest(&mut self, mine: Result<Quality>) -> Result<Quality> {
        if self.team.is_none() {
            return mine;
        }
        let mut cheapest = self.together(mine)?;
        let mut words = Words::default();
        put_quality(&mut words, &cheapest);
        for bytes in self.share(&words.0)? {
            let other = get_quality(&mut Reader(&bytes))?;
            cheapest.pixel_step = cheapest.pixel_step.max(other.pixel_step);
            cheapest.tolerance = cheapest.tolerance.max(other.tolerance);
            cheapest.lights = cheapest.lights.min(other.lights);
        }
        Ok(cheapest)
    }

    /// Agrees on rank 0's quality and on who draws which tiles; `facts` must be the same on all.
    pub(crate) fn deal(
        &mut self,
        mine: Result<Quality>,
        raster: Raster,
        facts: impl FnOnce() -> Vec<(&'static str, String)>,
    ) -> Result<Share> {
        let raster = |quality: &Quality| Raster { step: quality.pixel_step, ..raster };
        if self.team.is_none() {
            return mine.map(|quality| Share { quality, owners: vec![0; raster(&quality).tiles() as usize] });
        }
        let (rank, ranks) = (self.rank(), self.size());
        let mine = mine.map(|quality| {
            let mut words = Words::default();
            put_quality(&mut words, &quality);
            if rank == 0 {
                let owners = deal(raster(&quality), ranks, self.costs.as_ref());
                owners.iter().for_each(|owner| words.0.extend_from_slice(&owner.to_le_bytes()));
            }
            words.0
        });
        let said = self.agree_on(mine, facts())?;
        let mut reader = Reader(&said);
        let quality = get_quality(&mut reader)?;
        let owners = reader.0.as_chunks::<4>().0.iter().map(|owner| u32::from_le_bytes(*owner)).collect();
        Ok(Share { quality, owners })
    }

    /// The tiles in which each of the ranks that have a part together traces its rays, by their order; those of a raster by
    /// what they took in the last frame.
    pub(crate) fn deal_part(&self, tiling: &dyn Tiling, ranks: usize) -> Vec<Vec<u32>> {
        let owners = match tiling.raster() {
            Some(raster) => deal(raster, ranks, self.part_costs.as_ref()),
            None => (0..tiling.tiles()).map(|tile| tile % ranks as u32).collect(),
        };
        let mut tiles = vec![Vec::new(); ranks];
        (0..).zip(owners).for_each(|(tile, owner)| tiles[owner as usize].push(tile));
        tiles
    }

    /// Keeps what tiles of the part took for the next frame: the same on all ranks that have it together.
    pub(crate) fn keep_part_costs(&mut self, costs: Costs) {
        self.part_costs = Some(costs);
    }

    /// Has `draw` draw this rank's tiles on `threads`, and brings each to rank 0 as soon as it is given. There, a failure of
    /// any rank is the result; elsewhere the result is of sending only, and what came of it is told by [`Self::conclude`].
    /// `earlier_s` are seconds that this rank has drawn before.
    pub(crate) fn gather(
        &mut self,
        threads: &Threads,
        tiling: &dyn Tiling,
        earlier_s: f64,
        draw: impl FnOnce(&(dyn Fn(Tile) + Sync)) + Send,
    ) -> Result<Gathered> {
        let start = Instant::now();
        let (given, drawn) = unbounded();
        // `given` is gone when all is drawn, be it by a panic, and `drawn` ends then.
        let draw = move || {
            // Nobody takes them where ranks cannot be reached, which is told.
            draw(&|tile| drop(given.send(tile)));
            earlier_s + start.elapsed().as_secs_f64()
        };
        let Some(team) = &mut self.team else {
            let drawn_s = threads.run(draw);
            return Ok(Gathered { tiles: drawn.try_iter().collect(), drawn_s, ..Gathered::default() });
        };
        let mut outcome = Ok(0.0);
        let on_threads = || outcome = Error::of_panics(|| Ok(draw()));
        if team.rank() != 0 {
            threads.run_beside(on_threads, || send(&mut **team, &drawn))?;
            let drawn_s = *outcome.as_ref().unwrap_or(&0.0);
            team.send(packed::end(&outcome))?;
            while !team.is_sent()? {
                sleep(NAP);
            }
            return Ok(Gathered { drawn_s, ..Gathered::default() });
        }
        let mut parts = Parts::new(team.size(), tiling);
        threads.run_beside(on_threads, || parts.take(&mut **team, &drawn))?;
        let waiting = Instant::now();
        let drawn_s = *outcome.as_ref().unwrap_or(&0.0);
        parts.of[0].outcome = outcome.map(Some);
        while !parts.are_whole() {
            team.wait()?;
            parts.take_all(&mut **team)?;
        }
        let gather_s = waiting.elapsed().as_secs_f64();
        let Parts { of, bytes_received, .. } = parts;
        let (ranks, mut sum, mut most) = (of.len(), 0.0, 0.0f64);
        let mut tiles = Vec::with_capacity(tiling.tiles() as usize);
        let mut costs = tiling.raster().map(Costs::new);
        // In order of rank, so that of several failures the lowest rank's is told.
        for (rank, part) in of.into_iter().enumerate() {
            let seconds = part.outcome.map_err(|e| e.of_rank(rank, ranks))?.unwrap_or(0.0);
            (sum, most) = (sum + seconds, most.max(seconds));
            if let Some(costs) = &mut costs {
                part.tiles.iter().for_each(|tile| costs.set(tile.number, tile.seconds));
            }
            tiles.extend(part.tiles);
        }
        if costs.is_some() {
            self.costs = costs;
        }
        let balance = if most > 0.0 { sum / ranks as f64 / most } else { 1.0 };
        Ok(Gathered { tiles, drawn_s, gather_s, balance, bytes_received })
    }

    /// Rank 0's outcome of a frame becomes everybody's. That of other ranks matters only where the transport has failed.
    pub(crate) fn conclude(&mut self, mine: Result<Told>) -> Result<Told> {
        if self.team.is_none() {
            return mine;
        }
        let said = mine.map(|told| {
            let mut words = Words::default();
            words.put(u64::from(told.error.certainty == Certainty::Bound));
            words.put_counts(&told.counts).put(told.bytes_received).put(told.error.over);
            let error = &told.error;
            for number in [error.max, error.mean, error.p999, told.gather_s, told.balance] {
                words.put_f64(number);
            }
            words.0
        });
        heard(&mut Reader(&self.hear_root(said)?))
    }

    /// What rank 0 has to say, or its error, becomes everybody's; what others bring matters only where the transport has failed. No
    /// rank but 0 sends anything, so that tiles of others may still be on their way.
    pub(crate) fn hear_root(&mut self, mine: Result<Vec<u8>>) -> Result<Vec<u8>> {
        let Some(team) = &mut self.team else {
            return mine;
        };
        let mut words = Words::default();
        match &mine {
            Ok(said) => {
                words.put(0);
                words.0.extend_from_slice(said);
            }
            Err(e) => {
                words.put(e.kind().number() as u64).put_bytes(e.context().as_bytes());
            }
        }
        let said = team.broadcast(words.0)?;
        let mut reader = Reader(&said);
        match reader.get()? {
            // What this rank itself could not send is its own error, if rank 0 has not heard of it.
            0 => mine.map(|_| reader.0.to_vec()),
            number => Err(Error::new(ErrorKind::of_number(number as i32), reader.get_text()?)),
        }
    }
}

/// Sends tiles while they are drawn.
fn send(team: &mut dyn Team, drawn: &Receiver<Tile>) -> Result<()> {
    loop {
        match drawn.recv_timeout(TICK) {
            Ok(tile) => team.send(packed::tile(&tile))?,
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return Ok(()),
        }
        team.is_sent()?;
    }
}

/// What rank 0 has of each rank.
struct Parts<'t> {
    tiling: &'t dyn Tiling,
    of: Vec<Part>,
    bytes_received: u64,
}

struct Part {
    tiles: Vec<Tile>,
    /// The seconds that it drew, once it has drawn all.
    outcome: Result<Option<f64>>,
    /// Whether nothing more will come, which what cannot be read does not say.
    has_ended: bool,
}

impl<'t> Parts<'t> {
    fn new(ranks: usize, tiling: &'t dyn Tiling) -> Self {
        // Rank 0 itself sends nothing.
        let part = |rank| Part { tiles: Vec::new(), outcome: Ok(None), has_ended: rank == 0 };
        Parts { tiling, of: (0..ranks).map(part).collect(), bytes_received: 0 }
    }

    /// Takes in tiles of this rank while they are drawn, and what comes from others meanwhile.
    fn take(&mut self, team: &mut dyn Team, drawn: &Receiver<Tile>) -> Result<()> {
        loop {
            match drawn.recv_timeout(TICK) {
                Ok(tile) => self.of[0].tiles.push(tile),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Ok(()),
            }
            self.take_all(team)?;
        }
    }

    /// Takes in all that has come.
    fn take_all(&mut self, team: &mut dyn Team) -> Result<()> {
        while let Some((rank, bytes)) = team.try_receive()? {
            self.bytes_received += bytes.len() as u64;
            let part = &mut self.of[rank];
            match packed::read(&bytes, rank, self.tiling) {
                Ok(Sent::Tile(tile)) => part.tiles.push(tile),
                Ok(Sent::End(outcome)) => {
                    part.has_ended = true;
                    // What could not be read before is what is told.
                    part.outcome = std::mem::replace(&mut part.outcome, Ok(None)).and(outcome.map(Some));
                }
                Err(e) => part.outcome = Err(e),
            }
        }
        Ok(())
    }

    /// Whether all has come.
    fn are_whole(&self) -> bool {
        self.of.iter().all(|part| part.has_ended)
    }
}

fn heard(reader: &mut Reader) -> Result<Told> {
    let certainty = if reader.get()? == 1 { Certainty::Bound } else { Certainty::Estimate };
    let counts = reader.get_counts()?;
    let [bytes_received, over] = [reader.get()?, reader.get()?];
    let [max, mean, p999] = [reader.get_f64()?, reader.get_f64()?, reader.get_f64()?];
    let error = ErrorSummary { max, mean, p999, over, certainty };
    Ok(Told { error, counts, gather_s: reader.get_f64()?, balance: reader.get_f64()?, bytes_received })
}

fn put_quality(words: &mut Words, quality: &Quality) {
    let lights = match quality.lights {
        Lights::Off => 0,
        Lights::Coarse => 1,
        Lights::Full => 2,
    };
    words.put(quality.pixel_step.into()).put_f64(quality.tolerance).put(lights);
}

fn get_quality(reader: &mut Reader) -> Result<Quality> {
    let (pixel_step, tolerance) = (reader.get()? as u32, reader.get_f64()?);
    let lights = match reader.get()? {
        0 => Lights::Off,
        1 => Lights::Coarse,
        _ => Lights::Full,
    };
    Ok(Quality { pixel_step, tolerance, lights })
}
