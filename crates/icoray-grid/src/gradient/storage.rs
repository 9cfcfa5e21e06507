//! Storage of gradients: three floats, or packed into 8 bytes.

use crate::array::MapInline;

/// Gradients at the vertices, a row of layers per cell.
#[derive(Debug)]
pub enum Gradients {
    /// In single precision: 12 bytes.
    Whole(Vec<[f32; 3]>),
    /// In 8 bytes: the largest component to 1e-5, the others as near as that one. Below 1e-32 they are less exact.
    Packed(Vec<u64>),
}

impl Gradients {
    /// No gradients, for a picture without lighting.
    pub fn none() -> Self {
        Gradients::Whole(Vec::new())
    }

    /// Gradient number `i`.
    #[inline(always)]
    pub fn at(&self, i: usize) -> [f32; 3] {
        match self {
            Gradients::Whole(all) => all[i],
            Gradients::Packed(all) => Packed(all[i]).unpack(),
        }
    }

    /// All gradients; none where they are packed.
    pub fn whole(&self) -> &[[f32; 3]] {
        match self {
            Gradients::Whole(all) => all,
            Gradients::Packed(_) => &[],
        }
    }

    /// [`Self::whole`], to be modified.
    pub fn whole_mut(&mut self) -> &mut [[f32; 3]] {
        match self {
            Gradients::Whole(all) => all,
            Gradients::Packed(_) => &mut [],
        }
    }

    /// Packed gradients as they are stored.
    pub fn words(&self) -> Option<&[u64]> {
        match self {
            Gradients::Whole(_) => None,
            Gradients::Packed(all) => Some(all),
        }
    }

    /// Bytes of memory.
    pub fn bytes(&self) -> usize {
        match self {
            Gradients::Whole(all) => size_of_val(all.as_slice()),
            Gradients::Packed(all) => size_of_val(all.as_slice()),
        }
    }

    /// A buffer of `count` gradients, packed or not; reuses this memory, with its old values, if it is of that kind.
    pub fn with_room(self, count: usize, packed: bool) -> Self {
        match (self, packed) {
            (Gradients::Whole(memory), false) => Gradients::Whole(resized(memory, count, [0.0; 3])),
            (Gradients::Packed(memory), true) => Gradients::Packed(resized(memory, count, 0)),
            (other, packed) => {
                // Freed before the new buffer is allocated.
                drop(other);
                let new = if packed { Gradients::Packed(Vec::new()) } else { Gradients::none() };
                new.with_room(count, packed)
            }
        }
    }
}

fn resized<V: Copy>(mut memory: Vec<V>, count: usize, zero: V) -> Vec<V> {
    memory.reserve_exact(count.saturating_sub(memory.len()));
    memory.resize(count, zero);
    memory
}

/// A stored gradient.
pub(super) trait GradientFormat: Copy + Send {
    fn of(gradient: [f32; 3]) -> Self;
}

impl GradientFormat for [f32; 3] {
    fn of(gradient: [f32; 3]) -> Self {
        gradient
    }
}

/// Three whole numbers of 18 bits and the exponent of their unit, which is that of an `f32`, from the lowest bit up.
#[derive(Debug, Clone, Copy)]
pub struct Packed(u64);

/// Bits of a component.
const BITS: u32 = 18;
/// The largest component.
const MAX_COMPONENT: f32 = ((1 << (BITS - 1)) - 1) as f32;
const MASK: u64 = (1 << BITS) - 1;

impl GradientFormat for u64 {
    /// A gradient that is not finite becomes zero.
    fn of(gradient: [f32; 3]) -> Self {
        let largest = gradient.iter().fold(0.0f32, |most, g| most.max(g.abs()));
        if !gradient.iter().all(|g| g.is_finite()) || largest == 0.0 {
            return 0;
        }
        // The largest component is below 2^(exponent - 126), and so below 2^17 units.
        let exponent = (largest.to_bits() >> 23).max(BITS - 1) - (BITS - 2);
        let units = f32::from_bits((254 - exponent) << 23);
        // Numbers of this size have no fraction: added to them a number is rounded, without a call.
        const ROUNDS: f32 = 12_582_912.0;
        let number = |g: f32| {
            let rounded = (g * units).clamp(-MAX_COMPONENT, MAX_COMPONENT) + ROUNDS;
            u64::from(rounded.to_bits().wrapping_sub(ROUNDS.to_bits())) & MASK
        };
        let [x, y, z] = gradient.map_inline(number);
        x | y << BITS | z << (2 * BITS) | u64::from(exponent) << (3 * BITS)
    }
}

impl Packed {
    #[inline(always)]
    fn unpack(self) -> [f32; 3] {
        const TOP: u32 = u64::BITS - BITS;
        let unit = f32::from_bits(((self.0 >> (3 * BITS)) as u32) << 23);
        [TOP, TOP - BITS, TOP - 2 * BITS].map_inline(|shift| ((self.0 << shift) as i64 >> TOP) as f32 * unit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Components of any size and sign, alone and together: none is off by more than 1e-5 of the largest.
    #[test]
    fn packed_gradients_are_near() {
        let mut sizes = vec![0.0f32, 1.0, 1.999_999_9, 131_071.5, 131_072.0, 0.1, 3e-30, 1e30, 2e-33, 0.7e-3];
        sizes.extend((0..200).map(|i| 1.37f32.powi(i - 100)));
        let mut worst = 0.0f32;
        for (i, x) in sizes.iter().enumerate() {
            for part in [-1.0, -0.500_01, -1e-3, 0.0, 1e-6, 0.333, 1.0] {
                let gradient = [*x, part * x, -part * sizes[(i * 7) % sizes.len()].min(*x)];
                let near = Packed(u64::of(gradient)).unpack();
                let off = gradient.iter().zip(near).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                worst = worst.max(off / x.max(f32::MIN_POSITIVE));
                assert!(off <= 1e-5 * x, "{gradient:?} becomes {near:?}");
            }
        }
        assert!(worst > 1e-6, "{worst}");
    }

    #[test]
    fn what_has_no_direction_is_zero() {
        for gradient in [[0.0; 3], [f32::NAN, 1.0, 0.0], [f32::INFINITY, 0.0, 1.0], [1e-44, 0.0, 0.0]] {
            assert_eq!(Packed(u64::of(gradient)).unpack(), [0.0; 3], "{gradient:?}");
        }
    }

    #[test]
    fn memory_of_the_kind_is_used_again() {
        let room = Gradients::none().with_room(9, true);
        let place = |gradients: &Gradients| match gradients {
            Gradients::Packed(all) => all.as_ptr() as usize,
            Gradients::Whole(all) => all.as_ptr() as usize,
        };
        let before = place(&room);
        let room = room.with_room(5, true);
        assert_eq!((place(&room), room.bytes()), (before, 40));
        assert_eq!(room.with_room(5, false).bytes(), 60);
    }
}
