//! A frame of which nothing has changed since the last one is not drawn again.
//!
//! A model rewrites its arrays in place, so that only what they hold tells: four sums of 64 bits over all bytes between the field's
//! first and last value, each of which misses a change once in 2⁶⁴ times.

use super::Renderer;
use crate::error::Result;
use crate::field::{Field, Location};
use crate::frame::Frame;
use crate::grid::{Grid, Reals};
use crate::layers::Layers;
use crate::scene::Scene;
use crate::shape::Shape;
use rayon::prelude::*;
use std::sync::{Mutex, PoisonError, Weak};
use std::time::Instant;

/// The last frame, and all that it depends on.
#[derive(Debug, Default)]
pub(super) struct Last(Mutex<Option<(Key, Frame)>>);

#[derive(Debug, PartialEq)]
struct Key {
    scene: Scene,
    layers: Layers,
    grid: Life,
    values: Values,
}

#[derive(Debug)]
struct Life(Weak<()>);

impl PartialEq for Life {
    fn eq(&self, other: &Self) -> bool {
        self.0.ptr_eq(&other.0)
    }
}

#[derive(Debug, PartialEq)]
struct Values {
    shape: Shape,
    location: Location,
    /// As bits: a NaN is equal to itself.
    fill: Option<u64>,
    is_wide: bool,
    sums: [u64; LANES],
}

const LANES: usize = 4;
/// Bytes that a thread takes at a time.
const PIECE: usize = 1 << 18;

impl Values {
    fn of(field: &Field) -> Self {
        let shape = *field.shape();
        let reached = shape.extent().map_or(0..0, |(low, high)| low as usize..high as usize + 1);
        let (is_wide, sums) = match field.samples() {
            Reals::F32(values) => (false, sums(bytemuck::cast_slice(&values[reached]))),
            Reals::F64(values) => (true, sums(bytemuck::cast_slice(&values[reached]))),
        };
        let fill = field.fill().map(f64::to_bits);
        Values { shape, location: field.location(), fill, is_wide, sums }
    }
}

/// Four sums over bytes, which depend on the place of each.
fn sums(bytes: &[u8]) -> [u64; LANES] {
    let pieces: Vec<[u64; LANES]> = bytes.par_chunks(PIECE).map(sums_of_piece).collect();
    let flat: Vec<u8> = pieces.iter().flatten().flat_map(|sum| sum.to_le_bytes()).collect();
    sums_of_piece(&flat)
}

fn sums_of_piece(bytes: &[u8]) -> [u64; LANES] {
    // Digits of π, as good as any.
    let mut sums =
        [0x243f_6a88_85a3_08d3, 0x1319_8a2e_0370_7344, 0xa409_3822_299f_31d0, 0x082e_fa98_ec4e_6c89];
    let mut take = |words: &[[u8; 8]]| {
        for (sum, word) in sums.iter_mut().zip(words) {
            *sum = mixed(*sum ^ u64::from_le_bytes(*word));
        }
    };
    let (words, rest) = bytes.as_chunks::<8>();
    words.chunks(LANES).for_each(&mut take);
    let mut last = [[0; 8]; LANES];
    last[0][..rest.len()].copy_from_slice(rest);
    last[LANES - 1] = (bytes.len() as u64).to_le_bytes();
    take(&last);
    sums
}

/// Both halves of a product: each bit of the result depends on all of `value`.
#[inline(always)]
fn mixed(value: u64) -> u64 {
    let product = u128::from(value) * 0x9e37_79b9_7f4a_7c15;
    (product >> 64) as u64 ^ product as u64
}

impl Renderer {
    /// [`Self::render`], but for the last frame's where nothing has changed.
    pub(super) fn render_if_changed(
        &self,
        scene: &Scene,
        grid: &Grid,
        layers: &Layers,
        field: &Field,
    ) -> Result<Frame> {
        let start = Instant::now();
        let key = Key {
            scene: scene.clone(),
            layers: layers.clone(),
            grid: Life(grid.life()),
            values: self.run(|| Values::of(field)),
        };
        let last = || self.last.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, frame)) = last().as_ref().filter(|(known, _)| *known == key) {
            let mut frame = frame.clone();
            (frame.report.prepare_s, frame.report.render_s) = (start.elapsed().as_secs_f64(), 0.0);
            frame.report.left_out.push("the picture: nothing has changed since the last one".into());
            return Ok(frame);
        }
        let looked_s = start.elapsed().as_secs_f64();
        let mut frame = self.render_anew(scene, grid, layers, &field.into())?;
        frame.report.prepare_s += looked_s;
        *last() = Some((key, frame.clone()));
        Ok(frame)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every bit of every word, two sign bits at once, places exchanged, lengths: all change the sums.
    #[test]
    fn sums_tell_what_changes() {
        let bytes: Vec<u8> = (0..3000u32).map(|i| (i * i % 251) as u8).collect();
        let known = sums(&bytes);
        assert_eq!(sums(&bytes.clone()), known);
        for bit in 0..8 * bytes.len() {
            let mut other = bytes.clone();
            other[bit / 8] ^= 1 << (bit % 8);
            assert_ne!(sums(&other), known, "bit {bit}");
            other[(bit / 8 + 32) % bytes.len()] ^= 1 << (bit % 8);
            assert_ne!(sums(&other), known, "bit {bit} and the one 32 bytes on");
        }
        let mut turned = bytes.clone();
        turned.rotate_left(32);
        assert_ne!(sums(&turned), known);
        assert_ne!(sums(&bytes[..2999]), known);
        assert_ne!(sums(&[0; 64]), sums(&[0; 96]));
        assert_ne!(sums(&[5, 0]), sums(&[5]));
        let long = vec![7; 3 * PIECE];
        let mut swapped = long.clone();
        swapped[5] = 8;
        let first = sums(&swapped);
        swapped.swap(5, PIECE + 5);
        assert_ne!(sums(&swapped), first);
    }
}
