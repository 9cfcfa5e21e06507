//! Storage of gradients: three floats, or packed into 8 bytes.

use crate::array::MapInline;
use crate::error::Result;
use crate::memory;
use crate::sample::VECTOR;
use fearless_simd::{Simd, f32x16, prelude::*, u32x16, u64x8};
use std::borrow::Cow;

/// Gradients at the vertices, a row of layers per cell, in memory of their own or of others.
#[derive(Debug)]
pub enum Gradients<'m> {
    /// In single precision: 12 bytes.
    Whole(Cow<'m, [[f32; 3]]>),
    /// In 8 bytes: the largest component to 1e-5, the others with the same error. Below 1e-32 they are less exact.
    /// Three integers of 18 bits and the exponent of their unit, which is that of an `f32`, from the lowest bit up.
    Packed(Cow<'m, [u64]>),
}

impl<'m> Gradients<'m> {
    /// Upper bound of the standard deviation of the angle by which packing turns a gradient in any one direction across
    /// it: the largest component has at least 2^16 units, and all are rounded to integers, by 1/√12 of a unit.
    pub const PACKED_TURN: f64 = 0.288_675_134_594_812_9 / (1u32 << (BITS - 2)) as f64;

    /// No gradients, for a picture without lighting.
    pub fn none() -> Self {
        Gradients::Whole(Cow::Borrowed(&[]))
    }

    /// Those of [`Self::bytes`]; `None` if they are not aligned.
    pub fn of_bytes(bytes: &'m [u8], packed: bool) -> Option<Self> {
        Some(match packed {
            true => Gradients::Packed(bytemuck::try_cast_slice(bytes).ok()?.into()),
            false => Gradients::Whole(bytemuck::try_cast_slice(bytes).ok()?.into()),
        })
    }

    /// Gradient number `i`.
    #[inline(always)]
    pub fn at(&self, i: usize) -> [f32; 3] {
        match self {
            Gradients::Whole(all) => all[i],
            Gradients::Packed(all) => unpack(all[i]),
        }
    }

    /// All gradients; empty if they are packed.
    pub fn whole(&self) -> &[[f32; 3]] {
        match self {
            Gradients::Whole(all) => all,
            Gradients::Packed(_) => &[],
        }
    }

    /// [`Self::whole`], to be modified in memory of their own.
    pub fn whole_mut(&mut self) -> &mut [[f32; 3]] {
        match self {
            Gradients::Whole(all) => all.to_mut(),
            Gradients::Packed(_) => &mut [],
        }
    }

    /// Packed gradients in their stored form.
    pub fn words(&self) -> Option<&[u64]> {
        match self {
            Gradients::Whole(_) => None,
            Gradients::Packed(all) => Some(all),
        }
    }

    /// All of them as they are stored.
    pub fn bytes(&self) -> &[u8] {
        match self {
            Gradients::Whole(all) => bytemuck::cast_slice(all),
            Gradients::Packed(all) => bytemuck::cast_slice(all),
        }
    }

    /// Bytes of memory of their own.
    pub fn own_bytes(&self) -> usize {
        match self {
            Gradients::Whole(Cow::Borrowed(_)) | Gradients::Packed(Cow::Borrowed(_)) => 0,
            own => own.bytes().len(),
        }
    }

    /// A buffer of `count` gradients, packed or not; reuses this memory, with its old values, if it is of that kind.
    /// Pages of new memory are not touched.
    ///
    /// # Errors
    /// [`ErrorKind::Memory`](crate::error::ErrorKind::Memory) if the system refuses them.
    pub fn with_room(self, count: usize, packed: bool) -> Result<Self> {
        Ok(match (self, packed) {
            (Gradients::Whole(Cow::Owned(mut memory)), false) if memory.capacity() >= count => {
                memory.resize(count, [0.0; 3]);
                Gradients::Whole(memory.into())
            }
            (Gradients::Packed(Cow::Owned(mut memory)), true) if memory.capacity() >= count => {
                memory.resize(count, 0);
                Gradients::Packed(memory.into())
            }
            (other, packed) => {
                // Freed before the new buffer is allocated.
                drop(other);
                match packed {
                    true => Gradients::Packed(memory::zeros("gradients", count)?.into()),
                    false => Gradients::Whole(memory::zeros("gradients", count)?.into()),
                }
            }
        })
    }
}

/// A stored gradient.
pub(super) trait GradientFormat: Copy + Default + Send {
    fn of(gradient: [f32; 3]) -> Self;

    /// Stores the components of 16 gradients, none of which exceeds the range of a float.
    fn store<V: Simd>(simd: V, gradients: [f32x16<V>; 3], stored: &mut [Self; VECTOR]);
}

impl GradientFormat for [f32; 3] {
    fn of(gradient: [f32; 3]) -> Self {
        gradient
    }

    #[inline(always)]
    fn store<V: Simd>(_simd: V, gradients: [f32x16<V>; 3], stored: &mut [Self; VECTOR]) {
        let [x, y, z] = gradients.map_inline(|component| component.to_array());
        for i in 0..VECTOR {
            stored[i] = [x[i], y[i], z[i]];
        }
    }
}

/// Bits of a component of a packed gradient.
const BITS: u32 = 18;
/// The largest component.
const MAX_COMPONENT: f32 = ((1 << (BITS - 1)) - 1) as f32;
const MASK: u32 = (1 << BITS) - 1;
/// Numbers of this size have no fraction: adding it rounds a number, without a call. Its lowest bits are 0.
const ROUNDS: f32 = 12_582_912.0;
/// Bits of an `f32` below its exponent.
const FRACTION: u32 = 23;

/// Packed gradients.
impl GradientFormat for u64 {
    /// A gradient that is not finite becomes zero.
    fn of(gradient: [f32; 3]) -> Self {
        let largest = gradient.iter().fold(0.0f32, |largest, g| largest.max(g.abs()));
        if !gradient.iter().all(|g| g.is_finite()) || largest == 0.0 {
            return 0;
        }
        // The largest component is below 2^(exponent - 126), and so below 2^17 units.
        let exponent = (largest.to_bits() >> FRACTION).max(BITS - 1) - (BITS - 2);
        let units = f32::from_bits((254 - exponent) << FRACTION);
        let number = |g: f32| {
            let rounded = (g * units).clamp(-MAX_COMPONENT, MAX_COMPONENT) + ROUNDS;
            u64::from(rounded.to_bits() & MASK)
        };
        let [x, y, z] = gradient.map_inline(number);
        x | y << BITS | z << (2 * BITS) | u64::from(exponent) << (3 * BITS)
    }

    #[inline(always)]
    fn store<V: Simd>(simd: V, gradients: [f32x16<V>; 3], stored: &mut [Self; VECTOR]) {
        let [x, y, z] = gradients.map_inline(|component| component.abs());
        let largest = x.max(y).max(z);
        let exponent: u32x16<V> = (largest.to_bits() >> FRACTION).max(BITS - 1) - (BITS - 2);
        let units = f32x16::from_bits((u32x16::splat(simd, 254) - exponent) << FRACTION);
        let [x, y, z] = gradients.map_inline(
            #[inline(always)]
            |g| {
                let rounded = (g * units).max(-MAX_COMPONENT).min(MAX_COMPONENT) + ROUNDS;
                rounded.to_bits() & MASK
            },
        );
        // A gradient of zero has no exponent.
        let none = u32x16::splat(simd, 0);
        let exponent = largest.simd_eq(0.0).select(none, exponent);
        // Each half has 32 bits.
        let low = x | (y << BITS);
        let high = (y >> (32 - BITS)) | (z << (2 * BITS - 32)) | (exponent << (3 * BITS - 32));
        let (first, second) = low.interleave(high);
        let (first, second): (u64x8<V>, u64x8<V>) = (first.bitcast(), second.bitcast());
        let (start, end) = stored.split_at_mut(VECTOR / 2);
        first.store_slice(start);
        second.store_slice(end);
    }
}

#[inline(always)]
fn unpack(packed: u64) -> [f32; 3] {
    const TOP: u32 = u64::BITS - BITS;
    let unit = f32::from_bits(((packed >> (3 * BITS)) as u32) << FRACTION);
    [TOP, TOP - BITS, TOP - 2 * BITS].map_inline(|shift| ((packed << shift) as i64 >> TOP) as f32 * unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Components of any size and sign, alone and together: none has an error above 1e-5 of the largest.
    #[test]
    fn packed_gradients_are_near() {
        let mut sizes = vec![0.0f32, 1.0, 1.999_999_9, 131_071.5, 131_072.0, 0.1, 3e-30, 1e30, 2e-33, 0.7e-3];
        sizes.extend((0..200).map(|i| 1.37f32.powi(i - 100)));
        let mut worst = 0.0f32;
        for (i, x) in sizes.iter().enumerate() {
            for part in [-1.0, -0.500_01, -1e-3, 0.0, 1e-6, 0.333, 1.0] {
                let gradient = [*x, part * x, -part * sizes[(i * 7) % sizes.len()].min(*x)];
                let near = unpack(u64::of(gradient));
                let error = gradient.iter().zip(near).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                worst = worst.max(error / x.max(f32::MIN_POSITIVE));
                assert!(error <= 1e-5 * x, "{gradient:?} becomes {near:?}");
            }
        }
        assert!(worst > 1e-6, "{worst}");
    }

    /// The turn of gradients whose largest component is just above a power of two equals the stated bound; that of
    /// others is smaller.
    #[test]
    fn packing_turns_gradients_by_the_stated_bound() {
        for (size, min, max) in [(1.01f32, 0.85, 1.0), (1.9, 0.4, 0.6)] {
            let mut sum = 0.0;
            let count = 20_000;
            for i in 0..count {
                let [a, b] = [0.618_034, 0.414_214].map(|step| (i as f32 * step).fract() * 0.2 - 0.1);
                let gradient = [size * (1.0 + 0.01 * a), size * a, size * b];
                let near = unpack(u64::of(gradient)).map(f64::from);
                let [x, y, z] = gradient.map(f64::from);
                // Across the gradient and the third axis.
                sum += ((near[0] * y - near[1] * x) / (x * x + y * y)).powi(2);
                assert!((near[2] - z).abs() < 1e-5);
            }
            let part = (sum / f64::from(count)).sqrt() / Gradients::PACKED_TURN;
            assert!((min..=max).contains(&part), "{size}: {part}");
        }
    }

    #[test]
    fn gradients_without_a_direction_are_zero() {
        for gradient in [[0.0; 3], [f32::NAN, 1.0, 0.0], [f32::INFINITY, 0.0, 1.0], [1e-44, 0.0, 0.0]] {
            assert_eq!(unpack(u64::of(gradient)), [0.0; 3], "{gradient:?}");
        }
    }

    #[test]
    fn memory_of_the_kind_is_used_again() {
        let room = Gradients::none().with_room(9, true).unwrap();
        let place = |gradients: &Gradients| match gradients {
            Gradients::Packed(all) => all.as_ptr() as usize,
            Gradients::Whole(all) => all.as_ptr() as usize,
        };
        let before = place(&room);
        let room = room.with_room(5, true).unwrap();
        assert_eq!((place(&room), room.own_bytes()), (before, 40));
        assert_eq!(room.with_room(5, false).unwrap().own_bytes(), 60);
    }
}
