//! A round of a picture: tiles are distributed over ranks, traced and gathered. A picture has one round, and another
//! one for the pixels at edges if there are any, or several for more samples of pixels (`samples.rs`).

use super::context::FrameContext;
use super::device::OnDevice;
use super::levels::LevelChoice;
use super::renderer::Progress;
use super::work::Work;
use crate::edges;
use crate::ranks::{Ranks, TileAssignment, TileShare};
use crate::raster::{Pixel, Raster, Tile, Tiling};
use crate::scattered::{PixelRays, ScatteredPixels};
use crate::time_budget::Deadline;
use icoray_grid::Result;
use icoray_kernel::Counts;
use icoray_output::RanksReport;
use icoray_scene::Quality;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

/// A picture's pixels, and the counts of its rays.
pub(super) type Drawn = (Vec<Pixel>, Counts);

/// The rounds of a picture. Results of its methods are at rank 0, and `None` elsewhere; errors are the same on all
/// ranks.
pub(super) struct Rounds<'p, 'f, 'd> {
    pub work: &'p Work<'p, 'f>,
    pub on_device: &'p mut OnDevice<'d>,
    /// Raster, quality and deadline of the picture of one ray per pixel.
    pub raster: Raster,
    pub quality: Quality,
    pub deadline: Option<Deadline>,
    /// Seconds until this rank had traced all its tiles.
    pub render_s: f64,
    /// Seconds, balance and bytes of work between ranks.
    pub between_ranks: RanksReport,
}

impl Rounds<'_, '_, '_> {
    /// Traces the tiles of `tiling`, reports them to `progress`, and passes all to `finish` at rank 0. Collective.
    pub(super) fn trace<R: Send>(
        &mut self,
        ranks: &mut Ranks,
        tiling: &dyn Tiling,
        assignment: &TileAssignment,
        progress: Option<&Progress>,
        finish: impl FnOnce(&[Tile]) -> R + Send,
    ) -> Result<Option<R>> {
        let FrameContext { renderer, part, .. } = *self.work.context;
        let (work, on_device) = (self.work, &mut *self.on_device);
        let start = Instant::now();
        let exchanged = part.map(|part| work.exchange(ranks, part, assignment, tiling, on_device)).transpose()?;
        let mine = assignment.tiles_of(ranks.rank());
        let fragments = exchanged.as_ref().map(|e| ranks.collective(e.tiles(tiling, &mine))).transpose()?;
        let trace = |give: &(dyn Fn(Tile) + Sync)| {
            reported(progress, mine.len(), give, |give| match &fragments {
                Some(fragments) => {
                    let composer = work.composer(&assignment.quality);
                    let tiles: Vec<_> = fragments.iter().collect();
                    tiles.into_par_iter().with_max_len(1).for_each(|(number, received)| {
                        give(work.tile(&composer, tiling, *number, &mut received.clone()));
                    });
                }
                None => work.trace(&assignment.quality, tiling, &mine, on_device, give),
            });
        };
        let (traced_s, earlier_counts) = exchanged.as_ref().map_or_else(Default::default, |e| (e.traced_s, e.counts));
        let ready_s = start.elapsed().as_secs_f64();
        let share = TileShare { tiling, owners: &assignment.owners, earlier_s: traced_s, earlier_counts };
        let gathered = ranks.gather(&renderer.threads, &share, trace);
        let is_root = ranks.is_root();
        let tiles = gathered.map(|gathered| {
            let cost = &mut self.between_ranks;
            self.render_s += ready_s + gathered.render_s - traced_s;
            cost.compose_s += if part.is_some() { gathered.render_s - traced_s } else { 0.0 };
            cost.gather_s += gathered.gather_s;
            cost.bytes_received += gathered.bytes_received;
            if tiling.raster().is_some() {
                cost.balance = gathered.balance;
            }
            is_root.then_some(gathered.tiles)
        });
        self.at_root(ranks, tiles, |tiles| finish(&tiles))
    }

    /// What `work` makes of a value of rank 0, on the renderer's threads. Collective.
    pub(super) fn at_root<V: Send, R: Send>(
        &self,
        ranks: &mut Ranks,
        value: Result<Option<V>>,
        work: impl FnOnce(V) -> R + Send,
    ) -> Result<Option<R>> {
        let renderer = self.work.context.renderer;
        let made = value.and_then(|value| ranks.attempt(|| renderer.run(|| Ok(value.map(work)))));
        ranks.hear_root(made.as_ref().map(drop).map_err(Clone::clone))?;
        made
    }

    /// Traces pixels of a level whose errors exceed the tolerance again, on the model's grid, if the level was chosen for
    /// the tolerance. Collective.
    pub fn refined(&mut self, ranks: &mut Ranks, drawn: Option<Drawn>) -> Result<Option<Drawn>> {
        let FrameContext { renderer, scene, .. } = *self.work.context;
        let is_within_tolerance = renderer.level_choice == LevelChoice::WithinTolerance;
        if self.quality.level == 0 || !is_within_tolerance || scene.time_budget_ms.is_some() {
            return Ok(drawn);
        }
        self.quality.level = 0;
        let exceeds = |pixel: &Pixel| f64::from(pixel.error) > self.quality.tolerance;
        let pixels = drawn.iter().flat_map(|(picture, _)| (0..).zip(picture));
        let found = pixels.filter(|(_, pixel)| exceeds(pixel)).map(|(number, _)| number).collect();
        let found = ScatteredPixels::new(self.raster, ranks.hear_root(Ok(found))?, PixelRays::Samples(0..1));
        self.replaced(ranks, &found, drawn)
    }

    /// A picture with these pixels, traced again. Collective.
    fn replaced(&mut self, ranks: &mut Ranks, found: &ScatteredPixels, drawn: Option<Drawn>) -> Result<Option<Drawn>> {
        if found.numbers().is_empty() {
            return Ok(drawn);
        }
        let assignment = TileAssignment::in_turn(self.quality, found, ranks);
        self.trace(ranks, found, &assignment, None, |tiles| {
            let (mut picture, mut counts) = drawn.expect("rank 0 has the picture");
            let (pixels, its) = found.in_order(tiles);
            found.numbers().iter().zip(pixels).for_each(|(at, pixel)| picture[*at as usize] = *pixel);
            counts += its;
            (picture, counts)
        })
    }

    /// Draws the pixels at edges again, with several rays each, if the scene and the time left permit it, and returns
    /// their number. Collective.
    pub fn edges(&mut self, ranks: &mut Ranks, drawn: Option<Drawn>) -> Result<(u64, Option<Drawn>)> {
        let FrameContext { renderer, scene, .. } = *self.work.context;
        if self.work.edges.is_none() || self.quality.level > 0 {
            return Ok((0, drawn));
        }
        let (test, render_s, deadline) = (&self.work.edges, self.render_s, self.deadline);
        let find = |(picture, _): &Drawn| {
            let found = test.find(scene, picture);
            let rays = (found.len() * edges::RAYS) as f64 / picture.len() as f64;
            let has_time = deadline.is_none_or(|deadline| deadline.has_time_for(render_s * rays));
            if has_time { found } else { Vec::new() }
        };
        let found = ranks.attempt(|| renderer.run(|| Ok(drawn.as_ref().map(find).unwrap_or_default())));
        let found = ScatteredPixels::new(self.raster, ranks.hear_root(found)?, PixelRays::Edge);
        let drawn = self.replaced(ranks, &found, drawn)?;
        Ok((found.numbers().len() as u64, drawn))
    }
}

/// Runs `draw` with `give`, and reports each of the `total` tiles that pass through it.
fn reported(
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
