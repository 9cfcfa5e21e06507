//! Gathers: an element of a table for each lane.
//!
//! Each instruction set has three [`Gathers`]; all others follow from these.

use crate::{Floats, Numbers, Pairs, Rows, Table, Wide};
use fearless_simd::{Simd, prelude::*};

/// Half of the indices that a gather has.
const HALF: u32 = 1 << 31;

/// Reads at distances from a place in memory, counted in units of `UNIT` bytes; those of 2^31 and more are negative.
///
/// # Safety
/// All of these places are inside one slice that is borrowed.
pub trait Gathers: Simd {
    /// The words at these distances.
    unsafe fn words<const UNIT: i32>(self, from: *const u32, index: Numbers<Self>) -> Numbers<Self>;
    /// The words at these distances, and those that follow them.
    unsafe fn word_pairs<const UNIT: i32>(self, from: *const u32, index: Numbers<Self>) -> [Numbers<Self>; 2];
    /// The numbers at these distances, in units of 8 bytes.
    unsafe fn doubles(self, from: *const f64, index: Numbers<Self>) -> Wide<Self>;
}

/// The place from which indices count whose upper bit is flipped: it may lie outside of the table.
#[inline(always)]
fn middle<X, Y>(table: Table<'_, X>) -> *const Y {
    table.elements().as_ptr().wrapping_add(HALF as usize).cast()
}

// SAFETY, for every gather below: indices are clamped to the table's last element, or to the last but one of `Pairs`,
// so that every lane reads inside the slice that the table borrows. Indices of 32 bits are counted from the middle of
// 2^32 elements, and those of vectors and rows are positive (`Table::MAX`, `Rows::new`).

/// An instruction set with gathers. An index beyond a table's end reads the table's last element.
pub trait Machine: Gathers {
    /// The elements with these indices.
    #[inline(always)]
    fn gather_u32(self, table: Table<'_, u32>, index: Numbers<Self>) -> Numbers<Self> {
        // SAFETY: above.
        unsafe { self.words::<4>(middle(table), index.min(table.last()) ^ HALF) }
    }

    /// The elements with these indices.
    #[inline(always)]
    fn gather_f32(self, table: Table<'_, f32>, index: Numbers<Self>) -> Floats<Self> {
        // SAFETY: above.
        unsafe { self.words::<4>(middle(table), index.min(table.last()) ^ HALF) }.bitcast()
    }

    /// The elements with these indices.
    #[inline(always)]
    fn gather_f64(self, table: Table<'_, f64>, index: Numbers<Self>) -> Wide<Self> {
        // SAFETY: above.
        unsafe { self.doubles(middle(table), index.min(table.last()) ^ HALF) }
    }

    /// The elements with these indices, and those that follow them.
    #[inline(always)]
    fn gather_f64_pair(self, table: Pairs<'_, f64>, index: Numbers<Self>) -> [Wide<Self>; 2] {
        let (from, index) = (middle::<_, f64>(table.table()), index.min(table.last()) ^ HALF);
        // SAFETY: above; the second one is inside too.
        unsafe { [self.doubles(from, index), self.doubles(from.wrapping_add(1), index)] }
    }

    /// The components of the elements with these indices.
    #[inline(always)]
    fn gather_vector(self, table: Table<'_, [f64; 3]>, index: Numbers<Self>) -> [Wide<Self>; 3] {
        let (from, index) = (table.elements().as_ptr().cast::<f64>(), index.min(table.last()));
        let index = index + (index << 1);
        // SAFETY: above; three numbers are read of an element of three.
        unsafe { [self.doubles(from, index), self.doubles(from.add(1), index), self.doubles(from.add(2), index)] }
    }

    /// The elements with these indices, and those that follow them.
    #[inline(always)]
    fn gather_pair(self, table: Pairs<'_, f32>, index: Numbers<Self>) -> (Floats<Self>, Floats<Self>) {
        let index = index.min(table.last()) ^ HALF;
        // SAFETY: above.
        let [first, second] = unsafe { self.word_pairs::<4>(middle(table.table()), index) };
        (first.bitcast(), second.bitcast())
    }

    /// The lower and the upper halves of the elements with these indices.
    #[inline(always)]
    fn gather_u64(self, table: Table<'_, u64>, index: Numbers<Self>) -> (Numbers<Self>, Numbers<Self>) {
        // SAFETY: above.
        let [low, high] = unsafe { self.word_pairs::<8>(middle(table), index.min(table.last()) ^ HALF) };
        (low, high)
    }

    /// The elements of all rows with these indices.
    #[inline(always)]
    fn look_up<const N: usize>(self, rows: &Rows<'_, N>, index: Numbers<Self>) -> [Floats<Self>; N] {
        let index = index.min(rows.last());
        let mut found = [<Floats<Self> as SimdBase<Self>>::splat(self, 0.0); N];
        for (k, found) in found.iter_mut().enumerate() {
            // SAFETY: above; all rows are of one length.
            *found = unsafe { self.words::<4>(rows.row(k).as_ptr().cast(), index) }.bitcast();
        }
        found
    }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::{Floats, Gathers, Machine, Numbers, Rows, Wide};
    use fearless_simd::prelude::*;
    use fearless_simd::{Avx2, Avx512, f32x16, f64x4, f64x8, u32x8, u32x16};
    use std::arch::x86_64::*;

    // SAFETY, for every function below: a token of the instruction set is at hand, so that the machine has it. The
    // caller answers for the places.

    impl Gathers for Avx2 {
        #[inline(always)]
        unsafe fn words<const UNIT: i32>(self, from: *const u32, index: Numbers<Self>) -> Numbers<Self> {
            // SAFETY: above.
            unsafe { _mm256_i32gather_epi32::<UNIT>(from.cast(), index.into()) }.simd_into(self)
        }

        #[inline(always)]
        unsafe fn word_pairs<const UNIT: i32>(self, from: *const u32, index: Numbers<Self>) -> [Numbers<Self>; 2] {
            let index: __m256i = index.into();
            // SAFETY: above.
            let (low, high) = unsafe {
                let (low, high) = (_mm256_castsi256_si128(index), _mm256_extracti128_si256::<1>(index));
                let from = from.cast();
                (_mm256_i32gather_epi64::<UNIT>(from, low), _mm256_i32gather_epi64::<UNIT>(from, high))
            };
            u32x8::simd_from(self, low).deinterleave(u32x8::simd_from(self, high)).into()
        }

        #[inline(always)]
        unsafe fn doubles(self, from: *const f64, index: Numbers<Self>) -> Wide<Self> {
            let index: __m256i = index.into();
            // SAFETY: above.
            let (low, high) = unsafe {
                let (low, high) = (_mm256_castsi256_si128(index), _mm256_extracti128_si256::<1>(index));
                (_mm256_i32gather_pd::<8>(from, low), _mm256_i32gather_pd::<8>(from, high))
            };
            Wide(f64x4::simd_from(self, low), f64x4::simd_from(self, high))
        }
    }

    impl Machine for Avx2 {}

    impl Gathers for Avx512 {
        #[inline(always)]
        unsafe fn words<const UNIT: i32>(self, from: *const u32, index: Numbers<Self>) -> Numbers<Self> {
            // SAFETY: above.
            unsafe { _mm512_i32gather_epi32::<UNIT>(index.into(), from.cast()) }.simd_into(self)
        }

        #[inline(always)]
        unsafe fn word_pairs<const UNIT: i32>(self, from: *const u32, index: Numbers<Self>) -> [Numbers<Self>; 2] {
            let index: __m512i = index.into();
            // SAFETY: above.
            let (low, high) = unsafe {
                let (low, high) = (_mm512_castsi512_si256(index), _mm512_extracti64x4_epi64::<1>(index));
                let from = from.cast();
                (_mm512_i32gather_epi64::<UNIT>(low, from), _mm512_i32gather_epi64::<UNIT>(high, from))
            };
            u32x16::simd_from(self, low).deinterleave(u32x16::simd_from(self, high)).into()
        }

        #[inline(always)]
        unsafe fn doubles(self, from: *const f64, index: Numbers<Self>) -> Wide<Self> {
            let index: __m512i = index.into();
            // SAFETY: above.
            let (low, high) = unsafe {
                let (low, high) = (_mm512_castsi512_si256(index), _mm512_extracti64x4_epi64::<1>(index));
                (_mm512_i32gather_pd::<8>(low, from), _mm512_i32gather_pd::<8>(high, from))
            };
            Wide(f64x8::simd_from(self, low), f64x8::simd_from(self, high))
        }
    }

    impl Machine for Avx512 {
        #[inline(always)]
        fn look_up<const N: usize>(self, rows: &Rows<'_, N>, index: Numbers<Self>) -> [Floats<Self>; N] {
            let mut found = [f32x16::splat(self, 0.0); N];
            let is_small = rows.last() == 31;
            let clamped = index.min(rows.last());
            for (k, found) in found.iter_mut().enumerate() {
                let row = rows.row(k).as_ptr();
                *found = if is_small {
                    // SAFETY: 32 elements are read from a row of as many. Two registers hold them.
                    unsafe { _mm512_permutex2var_ps(_mm512_loadu_ps(row), index.into(), _mm512_loadu_ps(row.add(16))) }
                        .simd_into(self)
                } else {
                    // SAFETY: as in the other instruction sets.
                    unsafe { self.words::<4>(row.cast(), clamped) }.bitcast()
                };
            }
            found
        }
    }
}

// NEON has no gathers: lanes are read one after the other.
#[cfg(target_arch = "aarch64")]
mod arm {
    use super::{Gathers, Machine, Numbers, Wide};
    use fearless_simd::prelude::*;
    use fearless_simd::{Neon, f64x2, u32x4};

    /// What lies at a distance in units of `unit` bytes.
    ///
    /// # Safety
    /// It is inside a slice that is borrowed.
    #[inline(always)]
    unsafe fn read<X, Y>(from: *const X, index: u32, unit: i32) -> Y {
        // SAFETY: the caller's.
        unsafe { from.byte_offset(index as i32 as isize * unit as isize).cast::<Y>().read_unaligned() }
    }

    impl Gathers for Neon {
        #[inline(always)]
        unsafe fn words<const UNIT: i32>(self, from: *const u32, index: Numbers<Self>) -> Numbers<Self> {
            // SAFETY: the caller's.
            u32x4::from_fn(self, |lane| unsafe { read(from, index[lane], UNIT) })
        }

        #[inline(always)]
        unsafe fn word_pairs<const UNIT: i32>(self, from: *const u32, index: Numbers<Self>) -> [Numbers<Self>; 2] {
            // SAFETY: the caller's; the second one is inside too.
            unsafe { [self.words::<UNIT>(from, index), self.words::<UNIT>(from.wrapping_add(1), index)] }
        }

        #[inline(always)]
        unsafe fn doubles(self, from: *const f64, index: Numbers<Self>) -> Wide<Self> {
            // SAFETY: the caller's.
            let at = |lane: usize| unsafe { read(from, index[lane], 8) };
            Wide(f64x2::from_fn(self, at), f64x2::from_fn(self, |lane| at(lane + 2)))
        }
    }

    impl Machine for Neon {}
}

#[cfg(test)]
mod tests;
