//! Finds coincident points on the sphere.

use std::collections::HashMap;

/// Width of a bucket in tolerances: most points need one bucket, those near its sides several.
const BUCKET: f64 = 16.0;

/// Points, such as directions, that are found again although they were rounded otherwise; numbered as they were added.
pub struct DistinctPoints {
    /// All points.
    pub all: Vec<[f64; 3]>,
    tolerance: f64,
    buckets: HashMap<[i64; 3], Vec<u32>>,
}

impl DistinctPoints {
    /// No points yet; those that are no farther apart than `tolerance` will be one.
    pub fn new(tolerance: f64) -> Self {
        DistinctPoints { all: Vec::new(), tolerance, buckets: HashMap::new() }
    }

    /// The number of a point, which is added if there is none within the tolerance.
    pub fn find_or_add(&mut self, point: [f64; 3]) -> usize {
        let tolerance = self.tolerance;
        let bucket = |x: f64| (x / (BUCKET * tolerance)).floor() as i64;
        let range = point.map(|x| bucket(x - tolerance)..=bucket(x + tolerance));
        let is_same = |number: &&u32| {
            let other = self.all[**number as usize];
            let square: f64 = (0..3).map(|k| (point[k] - other[k]).powi(2)).sum();
            square <= tolerance * tolerance
        };
        let near = range[0].clone().flat_map(|x| {
            let range = &range;
            range[1].clone().flat_map(move |y| range[2].clone().map(move |z| [x, y, z]))
        });
        if let Some(number) = near.filter_map(|place| self.buckets.get(&place)?.iter().find(is_same)).next() {
            return *number as usize;
        }
        let number = self.all.len();
        self.all.push(point);
        self.buckets.entry(point.map(bucket)).or_insert_with(|| Vec::with_capacity(1)).push(number as u32);
        number
    }
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
        let mut points = DistinctPoints::new(tolerance);
        for (i, point) in all.iter().enumerate() {
            assert_eq!(points.find_or_add(*point), i % 8000);
        }
        assert_eq!(points.all, all[..8000]);
    }
}
