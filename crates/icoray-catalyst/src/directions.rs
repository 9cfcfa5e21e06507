//! Directions that are found again, although rounded otherwise.

use glam::DVec3;
use std::collections::HashMap;

/// Unit vectors, numbered as they were added.
pub struct Directions {
    pub all: Vec<[f64; 3]>,
    /// Directions that are no farther apart are one, radians.
    within: f64,
    buckets: HashMap<[i64; 3], Vec<usize>>,
}

impl Directions {
    /// No directions yet.
    pub fn new(within: f64) -> Self {
        Directions { all: Vec::new(), within, buckets: HashMap::new() }
    }

    /// The number of a direction, which is added if there is none within the distance.
    pub fn find_or_add(&mut self, direction: [f64; 3]) -> usize {
        let known = self.buckets_around(direction).into_iter().filter_map(|key| self.buckets.get(&key)).flatten();
        let same = known.copied().find(|&i| apart(self.all[i], direction) <= self.within);
        same.unwrap_or_else(|| {
            let number = self.all.len();
            self.all.push(direction);
            self.buckets.entry(self.bucket(direction)).or_default().push(number);
            number
        })
    }

    /// The cube that a direction is in; it is so wide that few directions are near another one.
    fn bucket(&self, direction: [f64; 3]) -> [i64; 3] {
        direction.map(|x| (x / (16.0 * self.within)).floor() as i64)
    }

    /// The cubes that may have the same direction.
    fn buckets_around(&self, direction: [f64; 3]) -> Vec<[i64; 3]> {
        let mut keys: Vec<[i64; 3]> = Vec::new();
        for signs in 0..8 {
            let shift = |k: usize| if signs >> k & 1 == 0 { -self.within } else { self.within };
            let key = self.bucket([0, 1, 2].map(|k| direction[k] + shift(k)));
            if !keys.contains(&key) {
                keys.push(key);
            }
        }
        keys
    }
}

/// The distance of two unit vectors.
pub fn apart(a: [f64; 3], b: [f64; 3]) -> f64 {
    DVec3::from_array(a).distance(DVec3::from_array(b))
}
