//! Encodes tiles, which are sent one by one, and the mark of a rank that has failed.

use super::wire::{decode, encode};
use crate::raster::{Pixel, Tile, Tiling};
use icoray_grid::{Error, ErrorKind, Result};
use icoray_kernel::Counts;
use icoray_kernel::signature::BoundarySignature;
use serde::{Deserialize, Serialize};

/// A message of a rank to rank 0: a tile, or the mark of a rank that has failed and sends no further ones.
type Packed = Option<PackedTile>;

#[derive(Debug, Serialize, Deserialize)]
struct PackedTile {
    number: u32,
    seconds: f64,
    counts: [u64; 7],
    /// The values of all pixels, or one value if all pixels have the same: opacity over a background, every channel off
    /// the globe.
    channels: [Vec<f32>; CHANNELS],
}

/// Values of a pixel: color and opacity, the error, and the surfaces that its ray meets.
const CHANNELS: usize = 7;

fn values(pixel: &Pixel) -> [f32; CHANNELS] {
    let [r, g, b, a] = pixel.color;
    let [order, nearness] = pixel.surfaces.values();
    [r, g, b, a, pixel.error, order, nearness]
}

fn pixel([r, g, b, a, error, order, nearness]: [f32; CHANNELS]) -> Pixel {
    Pixel { color: [r, g, b, a], error, surfaces: BoundarySignature::of_values([order, nearness]) }
}

/// Encodes a tile.
pub(super) fn tile(tile: &Tile) -> Vec<u8> {
    let pixels: Vec<_> = tile.pixels.iter().map(values).collect();
    let channels = std::array::from_fn(|k| {
        let is_uniform = pixels.iter().all(|pixel| pixel[k].to_bits() == pixels[0][k].to_bits());
        pixels.iter().map(|pixel| pixel[k]).take(if is_uniform { 1 } else { pixels.len() }).collect()
    });
    let (number, seconds, counts) = (tile.number, tile.seconds, tile.counts.numbers());
    encode(&Packed::Some(PackedTile { number, seconds, counts, channels }))
}

/// Encodes the mark of a rank that has failed before it had drawn all of its tiles.
pub(super) fn end() -> Vec<u8> {
    encode(&Packed::None)
}

/// Decodes a message of `rank`; `None` for the mark.
pub(super) fn read(bytes: &[u8], rank: usize, tiling: &dyn Tiling) -> Result<Option<Tile>> {
    let Some(PackedTile { number, seconds, counts, channels }) = decode::<Packed>(bytes)? else { return Ok(None) };
    let invalid = |what: String| Err(Error::new(ErrorKind::Mpi, format!("rank {rank} sent {what}")));
    if number >= tiling.tiles() {
        return invalid(format!("a tile {number} of {}", tiling.tiles()));
    }
    let count = tiling.pixels_of(number);
    let is_short = |channel: &Vec<f32>| channel.len() != count && channel.len() != 1;
    if channels.iter().any(is_short) {
        return invalid(format!("tile {number} has another number of pixels, expected {count}"));
    }
    let value = |channel: &Vec<f32>, i: usize| channel[if channel.len() == 1 { 0 } else { i }];
    let pixels = (0..count).map(|i| pixel(channels.each_ref().map(|channel| value(channel, i)))).collect();
    Ok(Some(Tile { number, seconds, counts: Counts::of_numbers(counts), pixels }))
}
