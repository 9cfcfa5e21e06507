//! Gathers: an element of a table for each lane.

use crate::{Floats, Numbers, Pairs, Rows, Table, Wide};
use fearless_simd::Simd;

/// An instruction set with gathers. An index beyond a table's end reads the table's last element.
pub trait Machine: Simd {
    /// The elements with these indices.
    fn gather_u32(self, table: Table<'_, u32>, index: Numbers<Self>) -> Numbers<Self>;
    /// The elements with these indices.
    fn gather_f32(self, table: Table<'_, f32>, index: Numbers<Self>) -> Floats<Self>;
    /// The elements with these indices.
    fn gather_f64(self, table: Table<'_, f64>, index: Numbers<Self>) -> Wide<Self>;
    /// The elements with these indices, and those that follow them.
    fn gather_f64_pair(self, table: Pairs<'_, f64>, index: Numbers<Self>) -> [Wide<Self>; 2];
    /// The components of the elements with these indices.
    fn gather_vector(self, table: Table<'_, [f64; 3]>, index: Numbers<Self>) -> [Wide<Self>; 3];
    /// The members of the elements with these indices.
    fn gather_record(self, table: Table<'_, [u32; 4]>, index: Numbers<Self>) -> [Numbers<Self>; 4];
    /// The elements with these indices, and those that follow them.
    fn gather_pair(self, table: Pairs<'_, f32>, index: Numbers<Self>) -> (Floats<Self>, Floats<Self>);
    /// The lower and the upper halves of the elements with these indices.
    fn gather_u64(self, table: Table<'_, u64>, index: Numbers<Self>) -> (Numbers<Self>, Numbers<Self>);
    /// The elements of all rows with these indices.
    fn look_up<const N: usize>(self, rows: &Rows<'_, N>, index: Numbers<Self>) -> [Floats<Self>; N];
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::{Floats, Machine, Numbers, Pairs, Rows, Table, Wide};
    use fearless_simd::prelude::*;
    use fearless_simd::{Avx2, Avx512, f32x8, f32x16, f64x4, f64x8, u32x8, u32x16};
    use std::arch::x86_64::*;

    // SAFETY, for every gather below: a token of the instruction set is at hand, so that the machine has it. Indices
    // are clamped to the table's last element, or to the last but one of `Pairs`, so that every lane reads inside the
    // slice that the table borrows. The machine takes an index for an i32: indices of 32 bits are counted from the
    // middle of 2^32 elements, and those of records, vectors and rows are positive (`Table::MAX`, `Rows::new`).

    /// Half of the indices that a gather has.
    const HALF: u32 = 1 << 31;

    /// The place from which indices count, which may lie outside of the table.
    #[inline(always)]
    fn middle<X>(table: Table<'_, X>) -> *const X {
        table.elements().as_ptr().wrapping_add(HALF as usize)
    }

    impl Machine for Avx2 {
        #[inline(always)]
        fn gather_u32(self, table: Table<'_, u32>, index: Numbers<Self>) -> Numbers<Self> {
            let index: __m256i = (index.min(u32x8::splat(self, table.last())) ^ HALF).into();
            // SAFETY: above.
            unsafe { _mm256_i32gather_epi32::<4>(middle(table).cast(), index) }.simd_into(self)
        }

        #[inline(always)]
        fn gather_f32(self, table: Table<'_, f32>, index: Numbers<Self>) -> Floats<Self> {
            let index: __m256i = (index.min(u32x8::splat(self, table.last())) ^ HALF).into();
            // SAFETY: above.
            unsafe { _mm256_i32gather_ps::<4>(middle(table), index) }.simd_into(self)
        }

        #[inline(always)]
        fn gather_f64(self, table: Table<'_, f64>, index: Numbers<Self>) -> Wide<Self> {
            let index: __m256i = (index.min(u32x8::splat(self, table.last())) ^ HALF).into();
            // SAFETY: above.
            unsafe { gather_256(self, middle(table), index) }
        }

        #[inline(always)]
        fn gather_f64_pair(self, table: Pairs<'_, f64>, index: Numbers<Self>) -> [Wide<Self>; 2] {
            let index: __m256i = (index.min(u32x8::splat(self, table.last())) ^ HALF).into();
            let from = middle(table.table());
            // SAFETY: above; the second one is inside too.
            unsafe { [gather_256(self, from, index), gather_256(self, from.wrapping_add(1), index)] }
        }

        #[inline(always)]
        fn gather_vector(self, table: Table<'_, [f64; 3]>, index: Numbers<Self>) -> [Wide<Self>; 3] {
            let index = index.min(u32x8::splat(self, table.last()));
            let index: __m256i = (index + (index << 1)).into();
            let from: *const f64 = table.elements().as_ptr().cast();
            // SAFETY: above; three numbers are read of an element of three.
            unsafe {
                [
                    gather_256(self, from, index),
                    gather_256(self, from.add(1), index),
                    gather_256(self, from.add(2), index),
                ]
            }
        }

        #[inline(always)]
        fn gather_record(self, table: Table<'_, [u32; 4]>, index: Numbers<Self>) -> [Numbers<Self>; 4] {
            let index: __m256i = (index.min(u32x8::splat(self, table.last())) << 1).into();
            let from: *const i32 = table.elements().as_ptr().cast();
            // SAFETY: above; four numbers are read of an element of four.
            unsafe {
                [
                    _mm256_i32gather_epi32::<8>(from, index).simd_into(self),
                    _mm256_i32gather_epi32::<8>(from.add(1), index).simd_into(self),
                    _mm256_i32gather_epi32::<8>(from.add(2), index).simd_into(self),
                    _mm256_i32gather_epi32::<8>(from.add(3), index).simd_into(self),
                ]
            }
        }

        #[inline(always)]
        fn look_up<const N: usize>(self, rows: &Rows<'_, N>, index: Numbers<Self>) -> [Floats<Self>; N] {
            let index: __m256i = index.min(u32x8::splat(self, rows.last())).into();
            let mut found = [f32x8::splat(self, 0.0); N];
            for (k, found) in found.iter_mut().enumerate() {
                // SAFETY: above; all rows are of one length.
                *found = unsafe { _mm256_i32gather_ps::<4>(rows.row(k).as_ptr(), index) }.simd_into(self);
            }
            found
        }

        #[inline(always)]
        fn gather_pair(self, table: Pairs<'_, f32>, index: Numbers<Self>) -> (Floats<Self>, Floats<Self>) {
            let index: __m256i = (index.min(u32x8::splat(self, table.last())) ^ HALF).into();
            let from = middle(table.table()).cast();
            // SAFETY: above.
            unsafe {
                let (low, high) = (_mm256_castsi256_si128(index), _mm256_extracti128_si256::<1>(index));
                let low = _mm256_castsi256_ps(_mm256_i32gather_epi64::<4>(from, low));
                let high = _mm256_castsi256_ps(_mm256_i32gather_epi64::<4>(from, high));
                let (first, second) = split(low, high);
                (f32x8::simd_from(self, first), f32x8::simd_from(self, second))
            }
        }

        #[inline(always)]
        fn gather_u64(self, table: Table<'_, u64>, index: Numbers<Self>) -> (Numbers<Self>, Numbers<Self>) {
            let index: __m256i = (index.min(u32x8::splat(self, table.last())) ^ HALF).into();
            let from = middle(table).cast();
            // SAFETY: above.
            unsafe {
                let (low, high) = (_mm256_castsi256_si128(index), _mm256_extracti128_si256::<1>(index));
                let low = _mm256_castsi256_ps(_mm256_i32gather_epi64::<8>(from, low));
                let high = _mm256_castsi256_ps(_mm256_i32gather_epi64::<8>(from, high));
                let (first, second) = split(low, high);
                let [first, second] = [_mm256_castps_si256(first), _mm256_castps_si256(second)];
                (u32x8::simd_from(self, first), u32x8::simd_from(self, second))
            }
        }
    }

    /// The elements of eight indices.
    ///
    /// # Safety
    /// The elements are inside an array that is borrowed, and the machine has AVX2, as the token says.
    #[inline(always)]
    unsafe fn gather_256(simd: Avx2, from: *const f64, index: __m256i) -> Wide<Avx2> {
        // SAFETY: the caller's.
        let (low, high) = unsafe {
            let (low, high) = (_mm256_castsi256_si128(index), _mm256_extracti128_si256::<1>(index));
            (_mm256_i32gather_pd::<8>(from, low), _mm256_i32gather_pd::<8>(from, high))
        };
        Wide(f64x4::simd_from(simd, low), f64x4::simd_from(simd, high))
    }

    /// The even and the odd elements of eight pairs.
    ///
    /// # Safety
    /// The machine has AVX2.
    #[inline(always)]
    unsafe fn split(low: __m256, high: __m256) -> (__m256, __m256) {
        // SAFETY: the caller's.
        unsafe {
            // Halves of 128 bits are shuffled each by itself: put in order first.
            let a = _mm256_permute2f128_ps::<0x20>(low, high);
            let b = _mm256_permute2f128_ps::<0x31>(low, high);
            (_mm256_shuffle_ps::<0x88>(a, b), _mm256_shuffle_ps::<0xdd>(a, b))
        }
    }

    impl Machine for Avx512 {
        #[inline(always)]
        fn gather_u32(self, table: Table<'_, u32>, index: Numbers<Self>) -> Numbers<Self> {
            let index: __m512i = (index.min(u32x16::splat(self, table.last())) ^ HALF).into();
            // SAFETY: above.
            unsafe { _mm512_i32gather_epi32::<4>(index, middle(table).cast()) }.simd_into(self)
        }

        #[inline(always)]
        fn gather_f32(self, table: Table<'_, f32>, index: Numbers<Self>) -> Floats<Self> {
            let index: __m512i = (index.min(u32x16::splat(self, table.last())) ^ HALF).into();
            // SAFETY: above.
            unsafe { _mm512_i32gather_ps::<4>(index, middle(table)) }.simd_into(self)
        }

        #[inline(always)]
        fn gather_f64(self, table: Table<'_, f64>, index: Numbers<Self>) -> Wide<Self> {
            let index: __m512i = (index.min(u32x16::splat(self, table.last())) ^ HALF).into();
            // SAFETY: above.
            unsafe { gather_512(self, middle(table), index) }
        }

        #[inline(always)]
        fn gather_f64_pair(self, table: Pairs<'_, f64>, index: Numbers<Self>) -> [Wide<Self>; 2] {
            let index: __m512i = (index.min(u32x16::splat(self, table.last())) ^ HALF).into();
            let from = middle(table.table());
            // SAFETY: above; the second one is inside too.
            unsafe { [gather_512(self, from, index), gather_512(self, from.wrapping_add(1), index)] }
        }

        #[inline(always)]
        fn gather_vector(self, table: Table<'_, [f64; 3]>, index: Numbers<Self>) -> [Wide<Self>; 3] {
            let index = index.min(u32x16::splat(self, table.last()));
            let index: __m512i = (index + (index << 1)).into();
            let from: *const f64 = table.elements().as_ptr().cast();
            // SAFETY: above; three numbers are read of an element of three.
            unsafe {
                [
                    gather_512(self, from, index),
                    gather_512(self, from.add(1), index),
                    gather_512(self, from.add(2), index),
                ]
            }
        }

        #[inline(always)]
        fn gather_record(self, table: Table<'_, [u32; 4]>, index: Numbers<Self>) -> [Numbers<Self>; 4] {
            let index: __m512i = (index.min(u32x16::splat(self, table.last())) << 1).into();
            let from: *const i32 = table.elements().as_ptr().cast();
            // SAFETY: above; four numbers are read of an element of four.
            unsafe {
                [
                    _mm512_i32gather_epi32::<8>(index, from).simd_into(self),
                    _mm512_i32gather_epi32::<8>(index, from.add(1)).simd_into(self),
                    _mm512_i32gather_epi32::<8>(index, from.add(2)).simd_into(self),
                    _mm512_i32gather_epi32::<8>(index, from.add(3)).simd_into(self),
                ]
            }
        }

        #[inline(always)]
        fn gather_pair(self, table: Pairs<'_, f32>, index: Numbers<Self>) -> (Floats<Self>, Floats<Self>) {
            let index: __m512i = (index.min(u32x16::splat(self, table.last())) ^ HALF).into();
            let from = middle(table.table()).cast();
            // SAFETY: above.
            unsafe {
                let (low, high) = (_mm512_castsi512_si256(index), _mm512_extracti64x4_epi64::<1>(index));
                let low = _mm512_i32gather_epi64::<4>(low, from);
                let high = _mm512_i32gather_epi64::<4>(high, from);
                let (first, second) = split_512(low, high);
                let [first, second] = [_mm512_castsi512_ps(first), _mm512_castsi512_ps(second)];
                (f32x16::simd_from(self, first), f32x16::simd_from(self, second))
            }
        }

        #[inline(always)]
        fn gather_u64(self, table: Table<'_, u64>, index: Numbers<Self>) -> (Numbers<Self>, Numbers<Self>) {
            let index: __m512i = (index.min(u32x16::splat(self, table.last())) ^ HALF).into();
            let from = middle(table).cast();
            // SAFETY: above.
            unsafe {
                let (low, high) = (_mm512_castsi512_si256(index), _mm512_extracti64x4_epi64::<1>(index));
                let low = _mm512_i32gather_epi64::<8>(low, from);
                let high = _mm512_i32gather_epi64::<8>(high, from);
                let (first, second) = split_512(low, high);
                (u32x16::simd_from(self, first), u32x16::simd_from(self, second))
            }
        }

        #[inline(always)]
        fn look_up<const N: usize>(self, rows: &Rows<'_, N>, index: Numbers<Self>) -> [Floats<Self>; N] {
            let mut found = [f32x16::splat(self, 0.0); N];
            if rows.last() == 31 {
                for (k, found) in found.iter_mut().enumerate() {
                    let row = rows.row(k).as_ptr();
                    // SAFETY: 32 elements are read from a row of as many; the machine has AVX-512. Two registers hold
                    // them.
                    let row = unsafe {
                        _mm512_permutex2var_ps(_mm512_loadu_ps(row), index.into(), _mm512_loadu_ps(row.add(16)))
                    };
                    *found = row.simd_into(self);
                }
                return found;
            }
            let index: __m512i = index.min(u32x16::splat(self, rows.last())).into();
            for (k, found) in found.iter_mut().enumerate() {
                // SAFETY: above; all rows are of one length.
                *found = unsafe { _mm512_i32gather_ps::<4>(index, rows.row(k).as_ptr()) }.simd_into(self);
            }
            found
        }
    }

    /// The elements of sixteen indices.
    ///
    /// # Safety
    /// The elements are inside an array that is borrowed, and the machine has AVX-512, as the token says.
    #[inline(always)]
    unsafe fn gather_512(simd: Avx512, from: *const f64, index: __m512i) -> Wide<Avx512> {
        // SAFETY: the caller's.
        let (low, high) = unsafe {
            let (low, high) = (_mm512_castsi512_si256(index), _mm512_extracti64x4_epi64::<1>(index));
            (_mm512_i32gather_pd::<8>(low, from), _mm512_i32gather_pd::<8>(high, from))
        };
        Wide(f64x8::simd_from(simd, low), f64x8::simd_from(simd, high))
    }

    /// The even and the odd elements of sixteen pairs.
    ///
    /// # Safety
    /// The machine has AVX-512.
    #[inline(always)]
    unsafe fn split_512(low: __m512i, high: __m512i) -> (__m512i, __m512i) {
        // SAFETY: the caller's.
        unsafe {
            let even = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
            let odd = _mm512_setr_epi32(1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29, 31);
            (_mm512_permutex2var_epi32(low, even, high), _mm512_permutex2var_epi32(low, odd, high))
        }
    }
}

#[cfg(target_arch = "aarch64")]
mod arm {
    use super::{Floats, Machine, Numbers, Pairs, Rows, Table, Wide};
    use fearless_simd::prelude::*;
    use fearless_simd::{Neon, f32x4, f64x2, u32x4};

    #[inline(always)]
    fn four(simd: Neon, of: impl Fn(usize) -> f64) -> Wide<Neon> {
        Wide(f64x2::simd_from(simd, [of(0), of(1)]), f64x2::simd_from(simd, [of(2), of(3)]))
    }

    // NEON has no gathers: lanes are read one after the other.
    impl Machine for Neon {
        #[inline(always)]
        fn gather_u32(self, table: Table<'_, u32>, index: Numbers<Self>) -> Numbers<Self> {
            let at = |lane: usize| table.elements()[index[lane].min(table.last()) as usize];
            u32x4::simd_from(self, [at(0), at(1), at(2), at(3)])
        }

        #[inline(always)]
        fn gather_f32(self, table: Table<'_, f32>, index: Numbers<Self>) -> Floats<Self> {
            let at = |lane: usize| table.elements()[index[lane].min(table.last()) as usize];
            f32x4::simd_from(self, [at(0), at(1), at(2), at(3)])
        }

        #[inline(always)]
        fn gather_f64(self, table: Table<'_, f64>, index: Numbers<Self>) -> Wide<Self> {
            four(self, |lane| table.elements()[index[lane].min(table.last()) as usize])
        }

        #[inline(always)]
        fn gather_f64_pair(self, table: Pairs<'_, f64>, index: Numbers<Self>) -> [Wide<Self>; 2] {
            let index = index.min(u32x4::splat(self, table.last()));
            let at = |lane: usize, next: usize| table.table().elements()[index[lane] as usize + next];
            [four(self, |lane| at(lane, 0)), four(self, |lane| at(lane, 1))]
        }

        #[inline(always)]
        fn gather_vector(self, table: Table<'_, [f64; 3]>, index: Numbers<Self>) -> [Wide<Self>; 3] {
            let at = |lane: usize, k: usize| table.elements()[index[lane].min(table.last()) as usize][k];
            [four(self, |lane| at(lane, 0)), four(self, |lane| at(lane, 1)), four(self, |lane| at(lane, 2))]
        }

        #[inline(always)]
        fn gather_record(self, table: Table<'_, [u32; 4]>, index: Numbers<Self>) -> [Numbers<Self>; 4] {
            let at = |lane: usize, k: usize| table.elements()[index[lane].min(table.last()) as usize][k];
            let member = |k: usize| u32x4::simd_from(self, [at(0, k), at(1, k), at(2, k), at(3, k)]);
            [member(0), member(1), member(2), member(3)]
        }

        #[inline(always)]
        fn look_up<const N: usize>(self, rows: &Rows<'_, N>, index: Numbers<Self>) -> [Floats<Self>; N] {
            let index = index.min(u32x4::splat(self, rows.last()));
            let mut found = [f32x4::splat(self, 0.0); N];
            for (k, found) in found.iter_mut().enumerate() {
                let at = |lane: usize| rows.row(k)[index[lane] as usize];
                *found = f32x4::simd_from(self, [at(0), at(1), at(2), at(3)]);
            }
            found
        }

        #[inline(always)]
        fn gather_pair(self, table: Pairs<'_, f32>, index: Numbers<Self>) -> (Floats<Self>, Floats<Self>) {
            let index = index.min(u32x4::splat(self, table.last()));
            (self.gather_f32(table.table(), index), self.gather_f32(table.table(), index + 1))
        }

        #[inline(always)]
        fn gather_u64(self, table: Table<'_, u64>, index: Numbers<Self>) -> (Numbers<Self>, Numbers<Self>) {
            let at = |lane: usize| table.elements()[index[lane].min(table.last()) as usize];
            let all = [at(0), at(1), at(2), at(3)];
            let low = u32x4::simd_from(self, [all[0] as u32, all[1] as u32, all[2] as u32, all[3] as u32]);
            let upper = |x: u64| (x >> 32) as u32;
            (low, u32x4::simd_from(self, [upper(all[0]), upper(all[1]), upper(all[2]), upper(all[3])]))
        }
    }
}

#[cfg(test)]
mod tests;
