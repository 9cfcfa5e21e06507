//! The types of samples that models store, alone and 16 at a time in the machine's vectors.

use crate::array::MapInline;
use crate::real::Real;
use fearless_simd::{Simd, f32x16, f64x8, mask32x16, prelude::*};

/// Samples in a vector.
pub const VECTOR: usize = 16;

/// A sample type that a model stores.
pub trait Sample: Real + Default {
    /// [`VECTOR`] samples.
    type Vector<V: Simd>: Copy;

    /// Whether differences are formed in single precision, and scaled by the caller.
    const IS_SINGLE: bool;

    /// The finite number nearest to `value`.
    #[inline]
    fn near(value: f64) -> Self {
        Self::of(value.clamp(Self::min_value().wide(), Self::max_value().wide()))
    }

    /// `value` as this type, if it is representable.
    #[inline]
    fn exact(value: f64) -> Option<Self> {
        Some(Self::near(value)).filter(|near| near.wide() == value)
    }

    /// The next larger number.
    fn next_up(self) -> Self;
    /// The next smaller number.
    fn next_down(self) -> Self;

    /// The samples of an array.
    fn load<V: Simd>(simd: V, samples: &[Self; VECTOR]) -> Self::Vector<V>;

    /// `a - b`, rounded to single precision: times `scale`, unless [`Self::IS_SINGLE`].
    fn difference<V: Simd>(simd: V, a: Self::Vector<V>, b: Self::Vector<V>, scale: f64) -> f32x16<V>;

    /// A mask of the samples that equal `value`.
    fn equals<V: Simd>(simd: V, samples: Self::Vector<V>, value: Self) -> mask32x16<V>;

    /// A mask of the samples from `low` to `high`; false for NaN.
    fn within<V: Simd>(simd: V, samples: Self::Vector<V>, range: [Self; 2]) -> mask32x16<V>;

    /// The first sample, and all but the last one.
    fn preceding<V: Simd>(simd: V, samples: Self::Vector<V>) -> Self::Vector<V>;

    /// All but the first sample, and the last one.
    fn following<V: Simd>(simd: V, samples: Self::Vector<V>) -> Self::Vector<V>;
}

impl Sample for f32 {
    type Vector<V: Simd> = f32x16<V>;
    const IS_SINGLE: bool = true;

    #[inline]
    fn next_up(self) -> Self {
        self.next_up()
    }

    #[inline]
    fn next_down(self) -> Self {
        self.next_down()
    }

    #[inline(always)]
    fn load<V: Simd>(simd: V, samples: &[Self; VECTOR]) -> f32x16<V> {
        f32x16::load_array_ref(simd, samples)
    }

    #[inline(always)]
    fn difference<V: Simd>(_simd: V, a: f32x16<V>, b: f32x16<V>, _scale: f64) -> f32x16<V> {
        a - b
    }

    #[inline(always)]
    fn equals<V: Simd>(_simd: V, samples: f32x16<V>, value: Self) -> mask32x16<V> {
        samples.simd_eq(value)
    }

    #[inline(always)]
    fn within<V: Simd>(_simd: V, samples: f32x16<V>, [low, high]: [Self; 2]) -> mask32x16<V> {
        samples.simd_ge(low) & samples.simd_le(high)
    }

    #[inline(always)]
    fn preceding<V: Simd>(simd: V, samples: f32x16<V>) -> f32x16<V> {
        f32x16::splat(simd, samples[0]).slide::<15>(samples)
    }

    #[inline(always)]
    fn following<V: Simd>(simd: V, samples: f32x16<V>) -> f32x16<V> {
        samples.slide::<1>(f32x16::splat(simd, samples[VECTOR - 1]))
    }
}

impl Sample for f64 {
    type Vector<V: Simd> = [f64x8<V>; 2];
    const IS_SINGLE: bool = false;

    #[inline]
    fn next_up(self) -> Self {
        self.next_up()
    }

    #[inline]
    fn next_down(self) -> Self {
        self.next_down()
    }

    #[inline(always)]
    fn load<V: Simd>(simd: V, samples: &[Self; VECTOR]) -> [f64x8<V>; 2] {
        let (low, high) = samples.split_at(VECTOR / 2);
        [low, high].map_inline(
            #[inline(always)]
            |half| f64x8::from_slice(simd, half),
        )
    }

    #[inline(always)]
    fn difference<V: Simd>(_simd: V, a: [f64x8<V>; 2], b: [f64x8<V>; 2], scale: f64) -> f32x16<V> {
        ((a[0] - b[0]) * scale).narrow((a[1] - b[1]) * scale)
    }

    #[inline(always)]
    fn equals<V: Simd>(_simd: V, samples: [f64x8<V>; 2], value: Self) -> mask32x16<V> {
        samples[0].simd_eq(value).narrow(samples[1].simd_eq(value))
    }

    #[inline(always)]
    fn within<V: Simd>(_simd: V, samples: [f64x8<V>; 2], [low, high]: [Self; 2]) -> mask32x16<V> {
        let [a, b] = samples;
        (a.simd_ge(low) & a.simd_le(high)).narrow(b.simd_ge(low) & b.simd_le(high))
    }

    #[inline(always)]
    fn preceding<V: Simd>(simd: V, [low, high]: [f64x8<V>; 2]) -> [f64x8<V>; 2] {
        [f64x8::splat(simd, low[0]).slide::<7>(low), low.slide::<7>(high)]
    }

    #[inline(always)]
    fn following<V: Simd>(simd: V, [low, high]: [f64x8<V>; 2]) -> [f64x8<V>; 2] {
        [low.slide::<1>(high), high.slide::<1>(f64x8::splat(simd, high[VECTOR / 2 - 1]))]
    }
}
