use super::*;
use crate::power;
use fearless_simd::{Level, prelude::*};

/// All gathers of a machine against plain reads, indices beyond the end included.
#[inline(always)]
fn gathers_are_plain_reads<V: Machine>(simd: V) {
    let lanes = <Floats<V> as SimdBase<V>>::LEN;
    let floats: Vec<f32> = (0..100).map(|k| 0.5 * k as f32).collect();
    let doubles: Vec<f64> = (0..100).map(|k| 0.25 * f64::from(k)).collect();
    let numbers: Vec<u32> = (0..100).map(|k| 7 * k).collect();
    let longs: Vec<u64> = (0..100).map(|k| k << 33 | (k + 1)).collect();
    let few: Vec<f32> = floats[..32].to_vec();
    for start in [0u32, 3, 80, 95, 4_000_000_000] {
        let index = <Numbers<V> as SimdBase<V>>::from_fn(simd, |lane| start.wrapping_add((5 * lane as u32) % 13));
        let f = simd.gather_f32(Table::new(&floats).unwrap(), index);
        let d = simd.gather_f64(Table::new(&doubles).unwrap(), index);
        let u = simd.gather_u32(Table::new(&numbers).unwrap(), index);
        let (low, high) = simd.gather_u64(Table::new(&longs).unwrap(), index);
        let (first, second) = simd.gather_pair(Table::new(&floats).unwrap(), index);
        let seen = simd.look_up(Table::new(&floats).unwrap(), index);
        for lane in 0..lanes {
            let (at, pair) = (index[lane].min(99) as usize, index[lane].min(98) as usize);
            assert_eq!((f[lane], d.get(lane), u[lane]), (floats[at], doubles[at], numbers[at]));
            assert_eq!(u64::from(low[lane]) | u64::from(high[lane]) << 32, longs[at]);
            assert_eq!((first[lane], second[lane], seen[lane]), (floats[pair], floats[pair + 1], floats[at]));
        }
        if start < 20 {
            let seen = simd.look_up(Table::new(&few).unwrap(), index);
            (0..lanes).for_each(|lane| assert_eq!(seen[lane], few[index[lane] as usize]));
        }
    }
    for k in 1..1000 {
        let (x, y) = (k as f32 / 1000.0, 32.0);
        let found = power(simd, <Floats<V> as SimdBase<V>>::splat(simd, x), y);
        let exact = f64::from(x).powf(y.into());
        assert!((f64::from(found[lanes - 1]) - exact).abs() <= 4e-6 * exact + 1e-30, "{x}: {found:?} {exact}");
    }
}

#[test]
fn gathers_of_each_instruction_set_are_plain_reads() {
    let level = Level::new();
    let mut count = 0;
    #[cfg(target_arch = "x86_64")]
    {
        if let Some(simd) = level.as_avx2() {
            simd.vectorize(
                #[inline(always)]
                || gathers_are_plain_reads(simd),
            );
            count += 1;
        }
        if let Some(simd) = level.as_avx512() {
            simd.vectorize(
                #[inline(always)]
                || gathers_are_plain_reads(simd),
            );
            count += 1;
        }
    }
    #[cfg(target_arch = "aarch64")]
    if let Some(simd) = level.as_neon() {
        gathers_are_plain_reads(simd);
        count += 1;
    }
    println!("{count} instruction sets were checked ({level:?})");
}
