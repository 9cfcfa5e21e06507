//! Powers and logarithms of vectors, by Cephes's polynomials.

use crate::{Floats, Numbers};
use fearless_simd::{Simd, prelude::*};

/// Numbers of this size have no fraction: added and subtracted again, it rounds to the nearest whole number.
const ROUNDS: f32 = 12_582_912.0;
const ONE: u32 = 0x3f80_0000;

/// The binary logarithm of positive normal numbers; of zero it is some large negative number.
#[inline(always)]
pub fn log2<V: Simd>(simd: V, x: Floats<V>) -> Floats<V> {
    const HALF: u32 = 0x3f35_04f3;
    const C: [f32; 9] = [
        3.333_333e-1,
        -2.499_999_4e-1,
        2.000_071_5e-1,
        -1.666_805_8e-1,
        1.424_932_3e-1,
        -1.242_014_1e-1,
        1.167_699_9e-1,
        -1.151_461e-1,
        7.037_683_6e-2,
    ];
    let all = |x: f32| <Floats<V> as SimdBase<V>>::splat(simd, x);
    // The exponent that leaves a mantissa from the root of 1/2 to that of 2.
    let above = x.bitcast::<Numbers<V>>() - HALF;
    let exponent = (above.bitcast::<V::i32s>() >> 23).to_float::<Floats<V>>();
    let f = ((above & 0x007f_ffff) + HALF).bitcast::<Floats<V>>() - 1.0;
    let mut series = all(C[8]);
    for k in (0..8).rev() {
        series = series.mul_add(f, all(C[k]));
    }
    let log = f - f * f * (all(0.5) - f * series);
    log.mul_add(all(std::f32::consts::LOG2_E), exponent)
}

/// `2^x` for x from -126 to 127; smaller ones count as -126.
#[inline(always)]
pub fn exp2<V: Simd>(simd: V, x: Floats<V>) -> Floats<V> {
    const C: [f32; 7] =
        [1.0, 6.931_472e-1, 2.402_264_8e-1, 5.550_332_5e-2, 9.618_437e-3, 1.339_887_4e-3, 1.535_336_2e-4];
    let all = |x: f32| <Floats<V> as SimdBase<V>>::splat(simd, x);
    let x = x.max(all(-126.0));
    let rounded = x + ROUNDS;
    let fraction = x - (rounded - ROUNDS);
    let mut series = all(C[6]);
    for k in (0..6).rev() {
        series = series.mul_add(fraction, all(C[k]));
    }
    let whole = rounded.bitcast::<Numbers<V>>() - ROUNDS.to_bits();
    series * ((whole << 23) + ONE).bitcast::<Floats<V>>()
}

/// `x^y` for `0 <= x <= 1` and `y >= 0`.
#[inline(always)]
pub fn power<V: Simd>(simd: V, x: Floats<V>, y: Floats<V>) -> Floats<V> {
    exp2(simd, log2(simd, x) * y)
}
