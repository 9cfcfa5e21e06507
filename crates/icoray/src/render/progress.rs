//! Reports finished tiles to the caller.

use crate::raster::Tile;
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The caller's function of the numbers of finished and of all tiles.
#[derive(Clone)]
pub(super) struct Progress(pub Arc<dyn Fn(usize, usize) + Send + Sync>);

impl fmt::Debug for Progress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Progress")
    }
}

/// Runs `draw` with `give`, and reports each of the `total` tiles that pass through it.
pub(super) fn reported(
    progress: Option<&Progress>,
    total: usize,
    give: &(dyn Fn(Tile) + Sync),
    draw: impl FnOnce(&(dyn Fn(Tile) + Sync)),
) {
    let Some(Progress(report)) = progress else { return draw(give) };
    let finished = AtomicUsize::new(0);
    draw(&|tile| {
        give(tile);
        report(finished.fetch_add(1, Ordering::Relaxed) + 1, total);
    });
}
