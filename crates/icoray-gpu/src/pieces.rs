//! Tiles cut into pieces, one per workgroup, and a cache of the triangles where their rays enter the shell.

use crate::layout::Piece;
use icoray::device::{Job, Rect, locate};
use rayon::prelude::*;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// Pixels along the sides of a workgroup.
const WORKGROUP: u32 = 8;

/// Number of tiles that a thread handles at a time, each search starting at the last result.
const CHUNK: usize = 16;

/// The pieces of each tile, each with the triangle over which the ray through its middle enters the shell.
/// `Piece::first` counts from the first ray of the tile.
pub(crate) fn pieces(job: &Job, entries: &RayEntries, tiles: &[Rect]) -> Vec<Vec<Piece>> {
    let of_chunk = |tiles: &[Rect]| {
        let mut hint = 0;
        tiles.iter().map(|tile| pieces_of_tile(job, tile, entries, &mut hint)).collect::<Vec<_>>()
    };
    tiles.par_chunks(CHUNK).flat_map_iter(of_chunk).collect()
}

fn pieces_of_tile(job: &Job, tile: &Rect, entries: &RayEntries, hint: &mut u32) -> Vec<Piece> {
    let side = WORKGROUP as usize;
    let origins = (0..tile.height).step_by(side).flat_map(|y| (0..tile.width).step_by(side).map(move |x| (x, y)));
    let piece = |(x, y): (u32, u32)| {
        let (width, height) = ((tile.width - x).min(WORKGROUP), (tile.height - y).min(WORKGROUP));
        let (left, top) = (tile.left + x, tile.top + y);
        let node = [left + width / 2, top + height / 2];
        *hint = entries.find(node, *hint, |from| entry_triangle(job, node, from));
        Piece { left, top, width, height, first: y * tile.width + x, stride: tile.width, hint: *hint }
    };
    origins.map(piece).collect()
}

/// The triangle over which the ray through a traced pixel enters the shell, or comes closest to it. The search starts
/// at triangle `from`.
fn entry_triangle(job: &Job, node: [u32; 2], from: u32) -> u32 {
    let (scene, [_, outer], step) = (job.scene(), job.extent(), job.quality().pixel_step);
    let (x, y) = ((node[0] * step).min(scene.width - 1), (node[1] * step).min(scene.height - 1));
    let eye = glam::DVec3::from_array(scene.camera.eye());
    let dir = glam::DVec3::from_array(scene.camera.direction(x, y, scene.width, scene.height));
    let closest = -eye.dot(dir);
    let b = (eye + closest * dir).length();
    let half = ((outer - b) * (outer + b)).max(0.0).sqrt();
    let place = eye + (closest - half).max(0.0) * dir;
    locate(job.grid(), from, place.try_normalize().unwrap_or(dir).to_array())
}

/// Traced pixels from one cached triangle to the next, in each direction.
const SPACING: u32 = 8;
/// Marks a triangle that is not known yet.
const NONE: u32 = u32::MAX;

/// Triangles where rays of the last picture entered the shell: start points for the search of the next picture's. Under
/// a fixed camera, as in most in-situ runs, they are the result; otherwise the search passes a few triangles.
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
