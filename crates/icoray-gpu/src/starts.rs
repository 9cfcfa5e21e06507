//! Where rays of the last picture entered: the next one's are sought from there. A camera that stands still, as it does beside a
//! model, leaves nothing to seek, and any other a few triangles.

use icoray::device::Job;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// Traced pixels from one kept triangle to the next.
const APART: u32 = 8;
/// Where none was found yet.
const NONE: u32 = u32::MAX;

/// Triangles of a picture's parts, to begin a search from: any will do, a near one is fast.
#[derive(Debug, Default)]
pub(crate) struct Starts {
    across: u32,
    /// How many the grid has.
    most: usize,
    triangles: Vec<AtomicU32>,
}

impl Starts {
    fn new(across: u32, count: u32, most: usize) -> Self {
        Starts { across, most, triangles: (0..count).map(|_| AtomicU32::new(NONE)).collect() }
    }

    /// Those of the last picture, if it was as large as that of `job`, and its grid too.
    pub fn of(last: &Mutex<Arc<Starts>>, job: &Job) -> Arc<Self> {
        let (scene, step) = (job.scene(), job.quality().pixel_step);
        let [across, down] =
            [scene.width, scene.height].map(|side| (side.div_ceil(step) + 1).div_ceil(APART));
        let mut last = last.lock().unwrap_or_else(PoisonError::into_inner);
        let most = job.grid().triangles() + job.grid().void_triangles();
        if (last.across, last.most, last.triangles.len() as u32) != (across, most, across * down) {
            *last = Arc::new(Starts::new(across, across * down, most));
        }
        Arc::clone(&last)
    }

    /// Finds the triangle of a traced pixel from the one that was found there before, or else from `hint`.
    pub fn find(&self, [x, y]: [u32; 2], hint: u32, find: impl FnOnce(u32) -> u32) -> u32 {
        let kept = &self.triangles[(y / APART * self.across + x / APART) as usize];
        let before = kept.load(Ordering::Relaxed);
        let found = find(if before == NONE { hint } else { before });
        kept.store(found, Ordering::Relaxed);
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_search_begins_where_the_last_one_ended() {
        let starts = Starts::new(3, 6, 1000);
        assert_eq!(starts.find([17, 8], 7, |from| from + 100), 107);
        assert_eq!(starts.find([23, 15], 7, |from| from + 1), 108);
        assert_eq!(starts.find([15, 15], 7, |from| from), 7);
    }
}
