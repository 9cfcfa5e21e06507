//! Triangles where rays of the last picture entered the shell: start points for the search of the next picture's. Under
//! a fixed camera, as in most in-situ runs, they are the result; otherwise the search passes a few triangles.

use icoray::device::Job;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// Traced pixels from one cached triangle to the next, in each direction.
const SPACING: u32 = 8;
/// Marks a triangle that is not known yet.
const NONE: u32 = u32::MAX;

/// The entry triangles of the last picture.
#[derive(Debug, Default)]
pub(crate) struct RayEntryCache(Mutex<Arc<RayEntries>>);

impl RayEntryCache {
    /// The entry triangles of the last picture, or none if its size or its grid's size differs from that of `job`.
    pub fn get(&self, job: &Job) -> Arc<RayEntries> {
        let (scene, step) = (job.scene(), job.quality().pixel_step);
        let [across, down] = [scene.width, scene.height].map(|side| (side.div_ceil(step) + 1).div_ceil(SPACING));
        let mut last = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let grid_triangles = job.grid().triangles() + job.grid().void_triangles();
        let size = (across, grid_triangles, across * down);
        if (last.across, last.grid_triangles, last.triangles.len() as u32) != size {
            *last = Arc::new(RayEntries::new(across, across * down, grid_triangles));
        }
        Arc::clone(&last)
    }
}

/// Entry triangles, one per [`SPACING`] times [`SPACING`] traced pixels. Any triangle is a valid start of a search; a
/// near one makes it fast.
#[derive(Debug, Default)]
pub(crate) struct RayEntries {
    across: u32,
    grid_triangles: usize,
    triangles: Vec<AtomicU32>,
}

impl RayEntries {
    fn new(across: u32, count: u32, grid_triangles: usize) -> Self {
        let triangles = (0..count).map(|_| AtomicU32::new(NONE)).collect();
        RayEntries { across, grid_triangles, triangles }
    }

    /// Calls `find` with the cached triangle of a traced pixel, or else with `hint`, and caches the triangle that it
    /// returns.
    pub fn find(&self, [x, y]: [u32; 2], hint: u32, find: impl FnOnce(u32) -> u32) -> u32 {
        let cached = &self.triangles[(y / SPACING * self.across + x / SPACING) as usize];
        let before = cached.load(Ordering::Relaxed);
        let found = find(if before == NONE { hint } else { before });
        cached.store(found, Ordering::Relaxed);
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_search_starts_at_the_last_result() {
        let entries = RayEntries::new(3, 6, 1000);
        assert_eq!(entries.find([17, 8], 7, |from| from + 100), 107);
        assert_eq!(entries.find([23, 15], 7, |from| from + 1), 108);
        assert_eq!(entries.find([15, 15], 7, |from| from), 7);
    }
}
