//! Tiles cut into pieces, one per workgroup.

use crate::layout::Piece;
use crate::ray_entry_cache::RayEntries;
use icoray::device::{Job, Rect, locate};
use rayon::prelude::*;

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
