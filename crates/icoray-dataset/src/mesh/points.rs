//! Finds coincident points on the sphere.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

/// Width of a bucket in tolerances: most points need one bucket, those near its sides several.
const BUCKET: f64 = 16.0;

/// Numbers points so that those nearer to each other than `tolerance` have the same number, from 0 in order of
/// occurrence; also returns, for each number, the index of its first point.
pub(crate) fn number(points: impl Iterator<Item = [f64; 3]>, tolerance: f64) -> (Vec<i32>, Vec<u32>) {
    let mut buckets: HashMap<[i64; 3], Vec<i32>> = HashMap::new();
    let (mut numbers, mut first, mut known): (_, _, Vec<[f64; 3]>) = (Vec::new(), Vec::new(), Vec::new());
    let width = BUCKET * tolerance;
    let bucket = |x: f64| (x / width).floor() as i64;
    for (i, point) in points.enumerate() {
        let range = point.map(|x| bucket(x - tolerance)..=bucket(x + tolerance));
        let is_same = |number: &&i32| {
            let other = known[**number as usize];
            let square: f64 = (0..3).map(|k| (point[k] - other[k]).powi(2)).sum();
            square <= tolerance * tolerance
        };
        let near = range[0].clone().flat_map(|x| {
            let range = &range;
            range[1].clone().flat_map(move |y| range[2].clone().map(move |z| [x, y, z]))
        });
        let same = near.filter_map(|place| buckets.get(&place)?.iter().find(is_same)).next().copied();
        numbers.push(same.unwrap_or_else(|| {
            let number = known.len() as i32;
            known.push(point);
            first.push(i as u32);
            match buckets.entry(point.map(bucket)) {
                Entry::Occupied(mut here) => here.get_mut().push(number),
                Entry::Vacant(here) => drop(here.insert(vec![number])),
            }
            number
        }));
    }
    (numbers, first)
}

#[cfg(test)]
mod tests {
    use super::*;
    use icoray_test_support::Random;

    #[test]
    fn points_are_the_same_within_the_tolerance_wherever_buckets_end() {
        let tolerance = 1e-3;
        let mut random = Random::new(1);
        let mut moved = |x: f64| x + 0.5 * tolerance * (random.unit() - 0.5);
        // Points of a lattice 0.04 wide, moved by less than half the tolerance.
        let lattice: Vec<[f64; 3]> =
            (0..8000).map(|i| [i % 20, i / 20 % 20, i / 400].map(|k| 0.04 * f64::from(k) - 0.4)).collect();
        let all: Vec<[f64; 3]> = (0..3).flat_map(|_| lattice.clone()).map(|point| point.map(&mut moved)).collect();
        let (numbers, first) = number(all.into_iter(), tolerance);
        assert_eq!(first, (0..8000).collect::<Vec<_>>());
        for (i, number) in numbers.iter().enumerate() {
            assert_eq!(*number as usize, i % 8000);
        }
    }
}
