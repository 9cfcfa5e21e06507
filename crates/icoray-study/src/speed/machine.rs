//! Peak read bandwidth of the machine's memory.

use icoray::{Renderer, Result};
use rayon::prelude::*;
use std::hint::black_box;
use std::time::Instant;

/// Much larger than caches.
const WORDS: usize = 1 << 25;
/// Runs, of which the fastest counts; the first one warms up.
const RUNS: usize = 6;

/// Bytes per second that so many threads read of a large array in order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bandwidth {
    pub threads: usize,
    pub bytes_per_s: f64,
}

/// Of each number of threads.
pub(super) fn read_bandwidths(threads: &[usize]) -> Result<Vec<Bandwidth>> {
    let words = vec![1u64; WORDS];
    threads.iter().map(|threads| read_bandwidth(&words, *threads)).collect()
}

fn read_bandwidth(words: &[u64], threads: usize) -> Result<Bandwidth> {
    let renderer = Renderer::new(threads)?;
    let sum = |part: &[u64]| part.iter().fold(0u64, |sum, word| sum.wrapping_add(*word));
    let part = words.len().div_ceil(renderer.threads());
    let once = |_| {
        let start = Instant::now();
        black_box(renderer.run(|| black_box(words).par_chunks(part).map(sum).sum::<u64>()));
        start.elapsed().as_secs_f64()
    };
    let seconds = (0..RUNS).map(once).fold(f64::INFINITY, f64::min);
    Ok(Bandwidth { threads, bytes_per_s: size_of_val(words) as f64 / seconds })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_large_array_is_read_at_the_speed_of_a_memory() {
        let words = vec![1u64; 1 << 22];
        let rate = read_bandwidth(&words, 2).unwrap();
        assert_eq!(rate.threads, 2);
        assert!((1e8..1e13).contains(&rate.bytes_per_s), "{rate:?}");
    }
}
