//! Places of a pixel's samples: Sobol's (0, 2)-sequence with Owen's scrambling, different for each pixel.
//!
//! Of the first 2ᵏ samples one lies in each of the 2ᵏ columns of a pixel, one in each of its 2ᵏ rows, and one in each
//! rectangle of that area between them. The first sample is the middle. Neighbouring pixels have other places, so that
//! matter finer than pixels produces noise and no pattern.
//!
//! The scrambling is that of Burley, "Practical Hash-based Owen Scrambling", JCGT 9 (4), 2020.

use std::ops::Range;

/// The samples of one pixel.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pattern {
    seeds: [u32; 2],
    /// Digital shifts that move sample 0 to the middle.
    shifts: [u32; 2],
}

impl Pattern {
    /// The pattern of the pixel in this column and row.
    pub fn of([x, y]: [u32; 2]) -> Self {
        let hash = mixed(mixed(x).wrapping_add(y));
        let seeds = [mixed(hash ^ 0x9E37_79B9), mixed(hash ^ 0x85EB_CA6B)];
        // Either neighbour of the middle: the strata of sample 0 lie on both sides of it equally.
        let shift = |axis: usize| {
            let middle = if hash >> axis & 1 == 0 { 0x8000_0000 } else { 0x7FFF_FFFF };
            scrambled(0, seeds[axis]) ^ middle
        };
        Pattern { seeds, shifts: [shift(0), shift(1)] }
    }

    /// The place of a sample to the right of and below the pixel's middle, in pixels: -0.5 to 0.5.
    pub fn place(&self, sample: u32) -> [f64; 2] {
        if sample == 0 {
            return [0.0; 2];
        }
        let points = [sample.reverse_bits(), sobol(sample)];
        [0, 1].map(|axis| {
            let place = scrambled(points[axis], self.seeds[axis]) ^ self.shifts[axis];
            (f64::from(place) + 0.5) / 2f64.powi(32) - 0.5
        })
    }

    pub fn mean_place(&self, samples: Range<u32>) -> [f64; 2] {
        let count = f64::from(samples.end - samples.start);
        samples
            .map(|sample| self.place(sample))
            .fold([0.0; 2], |mean, place| [0, 1].map(|k| mean[k] + place[k] / count))
    }
}

/// A hash of all bits: the finalizer of MurmurHash3.
fn mixed(mut x: u32) -> u32 {
    x ^= x >> 16;
    x = x.wrapping_mul(0x85EB_CA6B);
    x ^= x >> 13;
    x = x.wrapping_mul(0xC2B2_AE35);
    x ^ x >> 16
}

/// The second coordinate of a point of Sobol's sequence, in 2⁻³².
fn sobol(index: u32) -> u32 {
    let (mut direction, mut point) = (1u32 << 31, 0);
    let mut left = index;
    while left != 0 {
        point ^= if left & 1 == 1 { direction } else { 0 };
        direction ^= direction >> 1;
        left >>= 1;
    }
    point
}

/// A nested uniform scramble: each bit depends on the bits above it.
fn scrambled(x: u32, seed: u32) -> u32 {
    let mut x = x.reverse_bits().wrapping_add(seed);
    for factor in [0x6C50_B47C, 0xB82F_1E52, 0xC7AF_E638, 0x8D22_F6E6u32] {
        x ^= x.wrapping_mul(factor);
    }
    x.reverse_bits()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    const PIXELS: [[u32; 2]; 5] = [[0, 0], [1, 0], [0, 1], [511, 77], [16383, 16383]];

    /// The square that contains a sample, in a pixel divided into `many` squares in each direction.
    fn square(place: [f64; 2], many: [f64; 2]) -> [u32; 2] {
        [0, 1].map(|axis| ((place[axis] + 0.5) * many[axis]) as u32)
    }

    #[test]
    fn each_rectangle_of_equal_area_has_one_sample() {
        for pixel in PIXELS {
            let pattern = Pattern::of(pixel);
            for power in 0..=6 {
                for across in 0..=power {
                    let many = [2f64.powi(across), 2f64.powi(power - across)];
                    // The middle lies on the border of rectangles, and counts for the one that no other sample has.
                    let found: HashSet<_> = (1..1 << power).map(|i| square(pattern.place(i), many)).collect();
                    assert_eq!(found.len(), (1 << power) - 1, "{pixel:?}: {many:?}");
                    let near_middle = [-1e-9, 1e-9].map(|x| [-1e-9, 1e-9].map(|y| square([x, y], many)));
                    assert!(near_middle.iter().flatten().any(|square| !found.contains(square)), "{pixel:?}");
                }
            }
        }
    }

    #[test]
    fn pixels_have_patterns_of_their_own_around_the_middle() {
        let all: HashSet<_> = PIXELS.map(|pixel| Pattern::of(pixel).place(1).map(f64::to_bits)).into();
        assert_eq!(all.len(), PIXELS.len());
        // The mean place of a few samples over many pixels.
        let mut mean = [0.0; 2];
        for pixel in 0..10_000 {
            let pattern = Pattern::of([pixel % 100, pixel / 100]);
            for place in (0..4).map(|sample| pattern.place(sample)) {
                assert!(place.iter().all(|at| at.abs() < 0.5));
                mean = [0, 1].map(|axis| mean[axis] + place[axis] / 4e4);
            }
        }
        assert!(mean.iter().all(|at: &f64| at.abs() < 2e-3), "{mean:?}");
    }
}
