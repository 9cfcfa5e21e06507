//! A frame's tiles: who draws which, how they come to rank 0, and what all ranks hear of it.

use super::Ranks;
use super::deal::{Costs, deal};
use super::words::{Reader, Words};
use crate::error::{Error, ErrorKind, Result};
use crate::frame::{Certainty, Counts, ErrorSummary};
use crate::quality::{Lights, Quality};
use crate::raster::{Pixel, Raster, Tile};
use std::time::Instant;

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

    /// Brings tiles to rank 0, with the seconds that they took. There, a failure of any rank is the result; elsewhere the
    /// result is of sending only, and what came of it is told by [`Self::conclude`].
    pub(crate) fn gather(
        &mut self,
        mine: Result<Vec<Tile>>,
        seconds: f64,
        raster: Raster,
    ) -> Result<Gathered> {
        let start = Instant::now();
        let Some(team) = &mut self.team else {
            let tiles = mine?;
            return Ok(Gathered { tiles, gather_s: 0.0, balance: 1.0, bytes_received: 0 });
        };
        let nothing = Gathered { tiles: Vec::new(), gather_s: 0.0, balance: 1.0, bytes_received: 0 };
        if team.rank() != 0 {
            team.gather(&packed(&mine, seconds), &mut |_, _| ())?;
            return Ok(nothing);
        }
        let ranks = team.size();
        let mut parts: Vec<Option<(f64, Result<Vec<Tile>>)>> = (0..ranks).map(|_| None).collect();
        parts[0] = Some((seconds, mine));
        let mut bytes_received = 0;
        team.gather(&[], &mut |rank, bytes| {
            bytes_received += bytes.len() as u64;
            parts[rank] = Some(unpacked(&bytes, rank, raster));
        })?;
        let gather_s = start.elapsed().as_secs_f64();
        let (mut sum, mut most) = (0.0, 0.0f64);
        let mut tiles = Vec::with_capacity(raster.tiles() as usize);
        let mut costs = Costs::new(raster);
        // In order of rank, so that of several failures the lowest rank's is told.
        for (rank, part) in parts.into_iter().enumerate() {
            let missing = || Error::new(ErrorKind::Mpi, format!("rank {rank} sent no tiles"));
            let (seconds, part) = part.ok_or_else(missing)?;
            let part = part.map_err(|e| e.of_rank(rank, ranks))?;
            (sum, most) = (sum + seconds, most.max(seconds));
            part.iter().for_each(|tile| costs.set(tile.number, tile.seconds));
            tiles.extend(part);
        }
        self.costs = Some(costs);
        let balance = if most > 0.0 { sum / ranks as f64 / most } else { 1.0 };
        Ok(Gathered { tiles, gather_s, balance, bytes_received })
    }

    /// Rank 0's outcome of a frame becomes everybody's. That of other ranks matters only where the transport has failed.
    pub(crate) fn conclude(&mut self, mine: Result<Told>) -> Result<Told> {
        let Some(team) = &mut self.team else {
            return mine;
        };
        let mut words = Words::default();
        match &mine {
            Ok(told) => {
                words.put(0).put(u64::from(told.error.certainty == Certainty::Bound));
                words.put_counts(&told.counts).put(told.bytes_received);
                let error = &told.error;
                for number in [error.max, error.mean, error.p999, told.gather_s, told.balance] {
                    words.put_f64(number);
                }
            }
            Err(e) => {
                words.put(e.kind().number() as u64).put_bytes(e.context().as_bytes());
            }
        }
        let said = team.broadcast(words.0)?;
        let mut reader = Reader(&said);
        match reader.get()? {
            0 => {
                // What this rank itself could not send is its own error, if rank 0 has not heard of it.
                mine?;
                heard(&mut reader)
            }
            number => Err(Error::new(ErrorKind::of_number(number as i32), reader.get_text()?)),
        }
    }
}

fn heard(reader: &mut Reader) -> Result<Told> {
    let certainty = if reader.get()? == 1 { Certainty::Bound } else { Certainty::Estimate };
    let counts = reader.get_counts()?;
    let bytes_received = reader.get()?;
    let [max, mean, p999] = [reader.get_f64()?, reader.get_f64()?, reader.get_f64()?];
    let error = ErrorSummary { max, mean, p999, certainty };
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

/// Whether pixels are the same to the bit.
fn same(a: &Pixel, b: &Pixel) -> bool {
    a.error.to_bits() == b.error.to_bits() && a.color.map(f32::to_bits) == b.color.map(f32::to_bits)
}

/// Tiles as they are sent. One of a single colour, which most off the globe are, is a single pixel.
fn packed(tiles: &Result<Vec<Tile>>, seconds: f64) -> Vec<u8> {
    let mut words = Words::default();
    let tiles = match tiles {
        Ok(tiles) => tiles,
        Err(e) => {
            words.put(e.kind().number() as u64).put_bytes(e.context().as_bytes());
            return words.0;
        }
    };
    words.put(0).put_f64(seconds).put(tiles.len() as u64);
    for Tile { number, seconds, counts, pixels } in tiles {
        words.put(u64::from(*number)).put_f64(*seconds).put_counts(counts);
        let is_even = pixels.iter().all(|pixel| same(pixel, &pixels[0]));
        let pixels = if is_even { &pixels[..1] } else { pixels };
        words.put(pixels.len() as u64);
        for pixel in pixels {
            for value in pixel.color.iter().chain([&pixel.error]) {
                words.put_f32(*value);
            }
        }
    }
    words.0
}

/// The seconds and tiles, or the failure, that a rank sent.
fn unpacked(bytes: &[u8], rank: usize, raster: Raster) -> (f64, Result<Vec<Tile>>) {
    let mut reader = Reader(bytes);
    let mut seconds = 0.0;
    let mut read = || -> Result<Vec<Tile>> {
        let number = reader.get()?;
        if number != 0 {
            return Err(Error::new(ErrorKind::of_number(number as i32), reader.get_text()?));
        }
        seconds = reader.get_f64()?;
        let count = reader.get()?;
        (0..count).map(|_| tile(&mut reader, rank, raster)).collect()
    };
    let tiles = read();
    (seconds, tiles)
}

fn tile(reader: &mut Reader, rank: usize, raster: Raster) -> Result<Tile> {
    let (number, seconds) = (reader.get()?, reader.get_f64()?);
    let counts = reader.get_counts()?;
    let sent = reader.get()?;
    let odd = || Error::new(ErrorKind::Mpi, format!("rank {rank} sent {sent} pixels of tile {number}"));
    let number = u32::try_from(number).ok().filter(|number| *number < raster.tiles()).ok_or_else(odd)?;
    let size = raster.pixels_of(number);
    if sent != 1 && sent != size as u64 {
        return Err(odd());
    }
    let mut pixels = Vec::with_capacity(size);
    for _ in 0..sent {
        let mut value = || reader.get_f32();
        let color = [value()?, value()?, value()?, value()?];
        pixels.push(Pixel { color, error: value()? });
    }
    pixels.resize(size, pixels[0]);
    Ok(Tile { number, seconds, counts, pixels })
}
