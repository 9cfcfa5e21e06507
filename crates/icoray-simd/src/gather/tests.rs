use super::*;
use crate::power;
use fearless_simd::Level;
use icoray_test_support::{Need, skip};

/// All gathers of a machine against plain reads, indices beyond the end included.
#[inline(always)]
fn gathers_are_plain_reads<V: Machine>(simd: V) {
    let lanes = <Floats<V> as SimdBase<V>>::LEN;
    let floats: Vec<f32> = (0..100).map(|k| 0.5 * k as f32).collect();
    let doubles: Vec<f64> = (0..100).map(|k| 0.25 * f64::from(k)).collect();
    let vectors: Vec<[f64; 3]> = (0..100).map(|k| [f64::from(k), -f64::from(k), 0.5]).collect();
    let numbers: Vec<u32> = (0..100).map(|k| 7 * k).collect();
    let longs: Vec<u64> = (0..100).map(|k| k << 33 | (k + 1)).collect();
    let (few, more) = (&floats[..32], &floats[1..33]);
    for start in [0u32, 3, 80, 95, 4_000_000_000] {
        let index = <Numbers<V> as SimdBase<V>>::from_fn(simd, |lane| start.wrapping_add((5 * lane as u32) % 13));
        let f = simd.gather_f32(Table::new(&floats).unwrap(), index);
        let w = simd.gather_f64(Table::new(&doubles).unwrap(), index);
        let d = simd.gather_f64_pair(Pairs::new(&doubles).unwrap(), index);
        let v = simd.gather_vector(Table::new(&vectors).unwrap(), index);
        let u = simd.gather_u32(Table::new(&numbers).unwrap(), index);
        let (low, high) = simd.gather_u64(Table::new(&longs).unwrap(), index);
        let (first, second) = simd.gather_pair(Pairs::new(&floats).unwrap(), index);
        let seen = simd.look_up(&Rows::new([&floats, &floats]).unwrap(), index);
        for lane in 0..lanes {
            let (at, pair) = (index[lane].min(99) as usize, index[lane].min(98) as usize);
            assert_eq!((f[lane], u[lane]), (floats[at], numbers[at]));
            assert_eq!(w.get(lane), doubles[at]);
            assert_eq!(d.map(|row| row.get(lane)), [doubles[pair], doubles[pair + 1]]);
            assert_eq!(v.map(|row| row.get(lane)), vectors[at]);
            assert_eq!(u64::from(low[lane]) | u64::from(high[lane]) << 32, longs[at]);
            assert_eq!((first[lane], second[lane]), (floats[pair], floats[pair + 1]));
            assert_eq!(seen.map(|row| row[lane]), [floats[at]; 2]);
        }
        if start < 20 {
            let seen = simd.look_up(&Rows::new([few, more]).unwrap(), index);
            let at = |lane: usize| index[lane] as usize;
            (0..lanes).for_each(|lane| assert_eq!(seen.map(|row| row[lane]), [few[at(lane)], more[at(lane)]]));
        }
    }
    for k in 1..1000 {
        let (x, y) = (k as f32 / 1000.0, 32.0);
        let all = |number| <Floats<V> as SimdBase<V>>::splat(simd, number);
        let found = power(simd, all(x), all(y));
        let exact = f64::from(x).powf(y.into());
        assert!((f64::from(found[lanes - 1]) - exact).abs() <= 4e-6 * exact + 1e-30, "{x}: {found:?} {exact}");
    }
}

/// Gathers from a table whose last elements an index of 31 bits does not reach.
#[inline(always)]
fn gathers_reach_the_end<V: Machine>(simd: V, floats: &[f32], doubles: &[f64]) {
    let (table, end) = (Table::new(floats).unwrap(), floats.len() as u32);
    let index = <Numbers<V> as SimdBase<V>>::from_fn(simd, |lane| if lane == 0 { 5 } else { end - 1 - lane as u32 });
    let found = simd.gather_f32(table, index);
    let (first, second) = simd.gather_pair(Pairs::new(floats).unwrap(), index);
    let wide = simd.gather_f64(Table::new(doubles).unwrap(), index);
    for lane in 0..<Floats<V> as SimdBase<V>>::LEN {
        let at = index[lane] as usize;
        assert_eq!((found[lane], first[lane], second[lane]), (floats[at], floats[at], floats[at + 1]));
        assert_eq!(wide.get(lane), doubles[at]);
    }
}

/// Pages of zeros take no memory until they are written to.
#[test]
fn tables_may_have_more_than_2_to_the_31_elements() {
    const COUNT: usize = (1 << 31) + 100;
    let layout = std::alloc::Layout::array::<f64>(COUNT).unwrap();
    // SAFETY: the layout is not empty.
    let memory = unsafe { std::alloc::alloc_zeroed(layout) };
    if memory.is_null() {
        return skip(Need::Memory);
    }
    // SAFETY: zeros are numbers, and nothing else refers to them.
    let doubles = unsafe { std::slice::from_raw_parts_mut(memory.cast::<f64>(), COUNT) };
    (0..12).chain(COUNT / 2 - 50..COUNT / 2).chain(COUNT - 50..COUNT).for_each(|i| doubles[i] = (i % 1000) as f64);
    let doubles = &*doubles;
    // SAFETY: half of the same bytes, which are only read from here on; those of numbers up to 1000 are finite floats.
    let floats = unsafe { std::slice::from_raw_parts(memory.cast::<f32>(), COUNT) };
    let level = Level::new();
    #[cfg(target_arch = "x86_64")]
    {
        if let Some(simd) = level.as_avx2() {
            simd.vectorize(
                #[inline(always)]
                || gathers_reach_the_end(simd, floats, doubles),
            );
        }
        if let Some(simd) = level.as_avx512() {
            simd.vectorize(
                #[inline(always)]
                || gathers_reach_the_end(simd, floats, doubles),
            );
        }
    }
    #[cfg(target_arch = "aarch64")]
    if let Some(simd) = level.as_neon() {
        gathers_reach_the_end(simd, floats, doubles);
    }
    // SAFETY: it was allocated with this layout, and the slice is not used again.
    unsafe { std::alloc::dealloc(memory, layout) };
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
