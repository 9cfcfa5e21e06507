//! Tiles as they are sent, one by one, and what is sent behind the last.

use super::words::{Reader, Words};
use crate::error::{Error, ErrorKind, Result};
use crate::frame::Counts;
use crate::raster::{Pixel, Raster, Tile};

/// What a rank sends.
#[derive(Debug)]
pub(super) enum Sent {
    Tile(Tile),
    /// Nothing more: the seconds that it drew, or why it could not.
    End(Result<f64>),
}

const TILE: u64 = 0;
const DRAWN: u64 = 1;
const FAILED: u64 = 2;

/// Whether pixels are the same to the bit.
fn same(a: &Pixel, b: &Pixel) -> bool {
    a.error.to_bits() == b.error.to_bits() && a.color.map(f32::to_bits) == b.color.map(f32::to_bits)
}

/// A tile. One of a single colour, which most off the globe are, is a single pixel.
pub(super) fn tile(tile: &Tile) -> Vec<u8> {
    let Tile { number, seconds, counts, pixels } = tile;
    let mut words = Words::default();
    words.put(TILE).put(u64::from(*number)).put_f64(*seconds);
    for count in [counts.rays, counts.columns, counts.frusta, counts.void_frusta] {
        words.put(count);
    }
    let is_even = pixels.iter().all(|pixel| same(pixel, &pixels[0]));
    let pixels = if is_even { &pixels[..1] } else { pixels };
    words.put(pixels.len() as u64);
    for pixel in pixels {
        for value in pixel.color.iter().chain([&pixel.error]) {
            words.put_f32(*value);
        }
    }
    words.0
}

/// That a rank has drawn all, in so many seconds, or why not.
pub(super) fn end(outcome: &Result<f64>) -> Vec<u8> {
    let mut words = Words::default();
    match outcome {
        Ok(seconds) => words.put(DRAWN).put_f64(*seconds),
        Err(e) => words.put(FAILED).put(e.kind().number() as u64).put_bytes(e.context().as_bytes()),
    };
    words.0
}

/// What a rank has sent.
pub(super) fn read(bytes: &[u8], rank: usize, raster: Raster) -> Result<Sent> {
    let mut reader = Reader(bytes);
    match reader.get()? {
        TILE => read_tile(&mut reader, rank, raster).map(Sent::Tile),
        DRAWN => reader.get_f64().map(|seconds| Sent::End(Ok(seconds))),
        FAILED => {
            let kind = ErrorKind::of_number(reader.get()? as i32);
            Ok(Sent::End(Err(Error::new(kind, reader.get_text()?))))
        }
        other => Err(Error::new(ErrorKind::Mpi, format!("rank {rank} sent {other}, which says nothing"))),
    }
}

fn read_tile(reader: &mut Reader, rank: usize, raster: Raster) -> Result<Tile> {
    let (number, seconds) = (reader.get()?, reader.get_f64()?);
    let [rays, columns, frusta, void_frusta] = [reader.get()?, reader.get()?, reader.get()?, reader.get()?];
    let counts = Counts { rays, columns, frusta, void_frusta };
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
