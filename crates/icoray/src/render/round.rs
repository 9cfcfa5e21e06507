//! A round of a picture: tiles are distributed over ranks, traced and gathered. A picture has one round, and another
//! one for the pixels at edges if there are any, or several for more samples of pixels (`samples.rs`).

use super::context::FrameContext;
use super::device::OnDevice;
use super::progress::{Progress, reported};
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
use std::time::Instant;

/// A picture's pixels, and the counts of its rays.
pub(super) type Drawn = (Vec<Pixel>, Counts);

/// Cost of rounds on this rank.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Cost {
    /// Seconds until all tiles were traced.
    pub render_s: f64,
    /// Seconds, balance and bytes of work between ranks.
    pub ranks: RanksReport,
}

/// The inputs of the rounds of a picture.
pub(super) struct Rounds<'p, 'f, 'd> {
    pub work: &'p Work<'p, 'f>,
    pub on_device: &'p mut OnDevice<'d>,
    pub cost: Cost,
}

impl Rounds<'_, '_, '_> {
    /// Traces the tiles of `tiling` and reports them to `progress`. The result is still to be agreed on: at rank 0 all
    /// tiles, or the error. Collective.
    ///
    /// # Errors
    /// The same on all ranks.
    pub(super) fn trace(
        &mut self,
        ranks: &mut Ranks,
        tiling: &dyn Tiling,
        assignment: &TileAssignment,
        progress: Option<&Progress>,
    ) -> Result<Result<Vec<Tile>>> {
        let FrameContext { renderer, part, .. } = *self.work.context;
        let (work, on_device) = (self.work, &mut *self.on_device);
        let start = Instant::now();
        let exchanged = part.map(|part| work.exchange(ranks, part, assignment, tiling, on_device)).transpose()?;
        let mine = assignment.tiles_of(ranks.rank());
        let fragments = exchanged.as_ref().map(|e| ranks.collective(e.tiles(tiling, &mine))).transpose()?;
        let trace = |give: &(dyn Fn(Tile) + Sync)| {
            reported(progress, mine.len(), give, |give| match &fragments {
                Some(fragments) => work.compose_tiles(&assignment.quality, tiling, fragments, give),
                None => work.trace(&assignment.quality, tiling, &mine, on_device, give),
            });
        };
        let (traced_s, earlier_counts) = exchanged.as_ref().map_or_else(Default::default, |e| (e.traced_s, e.counts));
        let ready_s = start.elapsed().as_secs_f64();
        let share = TileShare { tiling, owners: &assignment.owners, earlier_s: traced_s, earlier_counts };
        let gathered = ranks.gather(&renderer.threads, &share, trace);
        Ok(gathered.map(|gathered| {
            let cost = &mut self.cost;
            cost.render_s += ready_s + gathered.render_s - traced_s;
            cost.ranks.compose_s += if part.is_some() { gathered.render_s - traced_s } else { 0.0 };
            cost.ranks.gather_s += gathered.gather_s;
            cost.ranks.bytes_received += gathered.bytes_received;
            if tiling.raster().is_some() {
                cost.ranks.balance = gathered.balance;
            }
            gathered.tiles
        }))
    }

    /// Draws the whole picture, with one ray for each pixel of the raster. Collective, and as [`Self::trace`].
    pub fn whole(
        &mut self,
        ranks: &mut Ranks,
        raster: Raster,
        assignment: &TileAssignment,
    ) -> Result<Result<Option<Drawn>>> {
        let renderer = self.work.context.renderer;
        let tiles = self.trace(ranks, &raster, assignment, renderer.progress.as_ref())?;
        let is_root = ranks.is_root();
        let assemble = |tiles: Vec<Tile>| {
            is_root.then(|| ranks.attempt(|| renderer.run(|| Ok(raster.assemble(&tiles))))).transpose()
        };
        Ok(tiles.and_then(assemble))
    }

    /// Traces pixels of a level whose errors exceed the tolerance again, on the model's grid. Collective, and as
    /// [`Self::trace`].
    pub fn refined(
        &mut self,
        ranks: &mut Ranks,
        raster: Raster,
        quality: Quality,
        drawn: Result<Option<Drawn>>,
    ) -> Result<Result<Option<Drawn>>> {
        if quality.level == 0 {
            return Ok(drawn);
        }
        let exceeds = |pixel: &Pixel| f64::from(pixel.error) > quality.tolerance;
        let found = drawn.as_ref().map_err(Clone::clone).map(|drawn| match drawn {
            Some((picture, _)) => (0..).zip(picture).filter(|(_, p)| exceeds(p)).map(|(number, _)| number).collect(),
            None => Vec::new(),
        });
        let found = ScatteredPixels::new(raster, ranks.hear_root(found)?, PixelRays::Samples(0..1));
        let quality = Quality { level: 0, ..quality };
        self.replaced(ranks, quality, &found, drawn)
    }

    /// A picture with these pixels, traced again.
    fn replaced(
        &mut self,
        ranks: &mut Ranks,
        quality: Quality,
        found: &ScatteredPixels,
        drawn: Result<Option<Drawn>>,
    ) -> Result<Result<Option<Drawn>>> {
        if found.numbers().is_empty() {
            return Ok(drawn);
        }
        let tiles = self.trace(ranks, found, &TileAssignment::in_turn(quality, found, ranks), None)?;
        let replace = |(mut picture, mut counts): Drawn, tiles: &[Tile]| {
            let (pixels, its) = ranks.attempt(|| Ok(found.in_order(tiles)))?;
            found.numbers().iter().zip(pixels).for_each(|(at, pixel)| picture[*at as usize] = *pixel);
            counts += its;
            Ok((picture, counts))
        };
        Ok(tiles.and_then(|tiles| drawn?.map(|drawn| replace(drawn, &tiles)).transpose()))
    }

    /// Draws the pixels at edges again, with several rays each, if the scene and the time left permit it, and returns
    /// their number. Collective, and as [`Self::trace`].
    pub fn edges(
        &mut self,
        ranks: &mut Ranks,
        raster: Raster,
        quality: Quality,
        deadline: Option<Deadline>,
        drawn: Result<Option<Drawn>>,
    ) -> Result<(u64, Result<Option<Drawn>>)> {
        let FrameContext { renderer, scene, .. } = *self.work.context;
        if self.work.edges.is_none() || quality.pixel_step > 1 || quality.level > 0 {
            return Ok((0, drawn));
        }
        let render_s = self.cost.render_s;
        let found = drawn.as_ref().map_err(Clone::clone).and_then(|drawn| match drawn {
            Some((picture, _)) => ranks.attempt(|| {
                let find = || self.work.edges.find(scene, picture);
                let found = renderer.run(find);
                let rays = (found.len() * edges::RAYS) as f64 / picture.len() as f64;
                let has_time = deadline.is_none_or(|deadline| deadline.has_time_for(render_s * rays));
                Ok(if has_time { found } else { Vec::new() })
            }),
            None => Ok(Vec::new()),
        });
        let found = ScatteredPixels::new(raster, ranks.hear_root(found)?, PixelRays::Edge);
        let drawn = self.replaced(ranks, quality, &found, drawn)?;
        Ok((found.numbers().len() as u64, drawn))
    }
}
