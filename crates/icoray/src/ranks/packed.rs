//! Tiles as they are sent, one by one, and what is sent behind the last.

use super::words::{Reader, Words};
use crate::error::{Error, ErrorKind, Result};
use crate::kernel::signature::Signature;
use crate::raster::{Pixel, Tile, Tiling};

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

/// Values of a pixel: its channels, its error and what surfaces its ray met.
const VALUES: usize = 7;

fn values(pixel: &Pixel) -> [f32; VALUES] {
    let [r, g, b, a] = pixel.color;
    let [order, nearness] = pixel.surfaces.values();
    [r, g, b, a, pixel.error, order, nearness]
}

fn pixel([r, g, b, a, error, order, nearness]: [f32; VALUES]) -> Pixel {
    Pixel { color: [r, g, b, a], error, surfaces: Signature::of_values([order, nearness]) }
}

/// A tile, value by value, each once where all pixels have the same: opacity over a background, everything off the globe.
pub(super) fn tile(tile: &Tile) -> Vec<u8> {
    let Tile { number, seconds, counts, pixels } = tile;
    let mut words = Words::default();
    words.put(TILE).put(u64::from(*number)).put_f64(*seconds).put_counts(counts);
    let pixels: Vec<_> = pixels.iter().map(values).collect();
    let differs = |k: &usize| pixels.iter().any(|pixel| pixel[*k].to_bits() != pixels[0][*k].to_bits());
    let varying = (0..VALUES).filter(differs).fold(0, |varying, k| varying | 1 << k);
    words.put(varying);
    for k in 0..VALUES {
        let sent = if varying >> k & 1 == 1 { &pixels[..] } else { &pixels[..1] };
        for pixel in sent {
            words.put_f32(pixel[k]);
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
pub(super) fn read(bytes: &[u8], rank: usize, tiling: &dyn Tiling) -> Result<Sent> {
    let mut reader = Reader(bytes);
    match reader.get()? {
        TILE => read_tile(&mut reader, rank, tiling).map(Sent::Tile),
        DRAWN => reader.get_f64().map(|seconds| Sent::End(Ok(seconds))),
        FAILED => {
            let kind = ErrorKind::of_number(reader.get()? as i32);
            Ok(Sent::End(Err(Error::new(kind, reader.get_text()?))))
        }
        other => {
            Err(Error::new(ErrorKind::Mpi, format!("rank {rank} sent {other}, which is no kind of message")))
        }
    }
}

fn read_tile(reader: &mut Reader, rank: usize, tiling: &dyn Tiling) -> Result<Tile> {
    let (number, seconds) = (reader.get()?, reader.get_f64()?);
    let counts = reader.get_counts()?;
    let varying = reader.get()?;
    let odd =
        || Error::new(ErrorKind::Mpi, format!("rank {rank} sent a tile {number} of {}", tiling.tiles()));
    let number = u32::try_from(number).ok().filter(|number| *number < tiling.tiles()).ok_or_else(odd)?;
    let mut pixels = vec![[0.0; VALUES]; tiling.pixels_of(number)];
    for k in 0..VALUES {
        let mut value = 0.0;
        for (i, pixel) in pixels.iter_mut().enumerate() {
            if i == 0 || varying >> k & 1 == 1 {
                value = reader.get_f32()?;
            }
            pixel[k] = value;
        }
    }
    let pixels = pixels.into_iter().map(pixel).collect();
    Ok(Tile { number, seconds, counts, pixels })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::Raster;

    #[test]
    fn tiles_come_back_to_the_bit_and_what_is_alike_is_sent_once() {
        let raster = Raster { width: 40, height: 20, step: 1 };
        let pixels = raster.pixels_of(1);
        let counts = crate::Counts::of_numbers([1, 2, 3, 4, 5, 6]);
        let some = [true, true, true, false, true, false, false];
        for (varies, least) in [([false; 7], 28), ([true; 7], 28 * pixels), (some, 16 * pixels + 12)] {
            let value = |i: usize, k: usize| if varies[k] { i as f32 * 0.1 - k as f32 } else { -0.0 };
            let all = (0..pixels).map(|i| pixel([0, 1, 2, 3, 4, 5, 6].map(|k| value(i, k)))).collect();
            let sent = Tile { number: 1, seconds: 0.25, counts, pixels: all };
            let bytes = tile(&sent);
            assert!((least..=least + 80).contains(&bytes.len()), "{}", bytes.len());
            let Ok(Sent::Tile(came)) = read(&bytes, 3, &raster) else { panic!("no tile") };
            let bits =
                |tile: &Tile| tile.pixels.iter().map(|p| values(p).map(f32::to_bits)).collect::<Vec<_>>();
            assert_eq!((bits(&came), came.number, came.seconds), (bits(&sent), 1, 0.25));
            assert_eq!(came.counts, counts);
            assert!(read(&bytes[..bytes.len() - 1], 3, &raster).is_err());
            assert!(read(&bytes, 3, &Raster { width: 2, height: 2, step: 1 }).is_err(), "another raster's");
        }
    }
}
