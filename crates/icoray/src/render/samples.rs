//! Rounds of more samples of pixels ([`crate::sampling`]), after the picture of one ray per pixel.

use super::context::FrameContext;
use super::round::{Drawn, Rounds};
use super::work::Work;
use crate::edges;
use crate::ranks::{Ranks, TileAssignment};
use crate::raster::{Raster, Tile};
use crate::sampling::{SampleRound, SampledPicture, rounds};
use crate::time_budget::Deadline;
use icoray_grid::Result;
use icoray_output::SamplingError;
use icoray_scene::Quality;

/// A picture with its samples, at rank 0.
pub(super) struct Sampled {
    pub drawn: Drawn,
    pub edge_pixels: u64,
    /// Mean number of rays of the pixels that may show the shell.
    pub rays_per_pixel: f64,
    /// The estimated sampling error of each pixel; empty where pixels are one ray each.
    pub error: Vec<f32>,
    pub summary: Option<SamplingError>,
}

/// How a picture of one ray per pixel was drawn.
#[derive(Clone, Copy)]
pub(super) struct Manner {
    pub raster: Raster,
    pub quality: Quality,
    pub deadline: Option<Deadline>,
}

impl Rounds<'_, '_, '_> {
    /// Adds the scene's samples to the pixels of a picture of one ray per pixel, as long as there is time. Where that is
    /// not asked for, or there is none for the first round, draws pixels at edges again. Collective, and as
    /// [`Self::trace`].
    pub fn samples(
        &mut self,
        ranks: &mut Ranks,
        manner: Manner,
        drawn: Result<Option<Drawn>>,
    ) -> Result<Result<Option<Sampled>>> {
        if self.work.context.scene.samples <= 1 || manner.quality.pixel_step > 1 {
            return self.unsampled(ranks, manner, drawn);
        }
        let work = self.work;
        let picture = drawn.and_then(|drawn| drawn.map(|drawn| begin(work, ranks, manner, drawn)).transpose());
        let (rays, picture) = self.add_rounds(ranks, manner, picture)?;
        let finish = |picture: SampledPicture| {
            let (edge_pixels, rays_per_pixel) = (picture.edge_pixels(), picture.rays_per_pixel());
            let (drawn, error, summary) = picture.finish();
            Sampled { drawn, edge_pixels, rays_per_pixel, error, summary: Some(summary) }
        };
        let sampled = picture.map(|picture| picture.map(finish));
        match rays {
            1 => self.unsampled(ranks, manner, sampled.map(|sampled| sampled.map(|sampled| sampled.drawn))),
            _ => Ok(sampled),
        }
    }

    /// The picture of one ray per pixel, but for pixels at edges.
    fn unsampled(
        &mut self,
        ranks: &mut Ranks,
        manner: Manner,
        drawn: Result<Option<Drawn>>,
    ) -> Result<Result<Option<Sampled>>> {
        let Manner { raster, quality, deadline } = manner;
        let (edge_pixels, drawn) = self.edges(ranks, raster, quality, deadline, drawn)?;
        let sampled =
            |drawn: Drawn| Sampled { drawn, edge_pixels, rays_per_pixel: 1.0, error: Vec::new(), summary: None };
        Ok(drawn.map(|drawn| drawn.map(sampled)))
    }

    /// Draws round after round, and says how many rays its pixels have at the end. Collective.
    fn add_rounds<'s>(
        &mut self,
        ranks: &mut Ranks,
        manner: Manner,
        mut picture: Result<Option<SampledPicture<'s>>>,
    ) -> Result<(u32, Result<Option<SampledPicture<'s>>>)> {
        let FrameContext { renderer, scene, .. } = *self.work.context;
        let Manner { raster, quality, deadline } = manner;
        // What the rays of all pixels took.
        let render_s = self.cost.render_s;
        let least_at_edges = if self.work.edges.is_none() { 0 } else { edges::RAYS as u32 };
        let mut rays = 1;
        for end in rounds(scene.samples, least_at_edges) {
            let wanted = picture.as_mut().map_err(|e| e.clone()).map(|picture| {
                let wanted = picture.as_mut().map_or_else(Vec::new, |picture| picture.wanted(end));
                let times = f64::from(end - rays) / f64::from(raster.width * raster.height);
                let has_time = |deadline: Deadline| deadline.has_time_for(render_s * wanted.len() as f64 * times);
                if !renderer.is_stopped() && deadline.is_none_or(has_time) { wanted } else { Vec::new() }
            });
            let wanted = ranks.hear_root(wanted)?;
            if wanted.is_empty() {
                break;
            }
            let round = SampleRound::new(raster, wanted, rays..end);
            let tiles = self.trace(ranks, &round, &TileAssignment::in_turn(quality, &round, ranks), None)?;
            let with_tiles = |picture: SampledPicture<'s>, tiles: &[Tile]| {
                ranks.attempt(|| renderer.run(|| Ok(picture.with(&round, tiles))))
            };
            picture = tiles.and_then(|tiles| picture?.map(|picture| with_tiles(picture, &tiles)).transpose());
            rays = end;
        }
        Ok((rays, picture))
    }
}

/// The picture to whose pixels samples are added.
fn begin<'w>(work: &Work<'w>, ranks: &Ranks, manner: Manner, drawn: Drawn) -> Result<SampledPicture<'w>> {
    let FrameContext { renderer, scene, .. } = *work.context;
    let (edges, tolerance) = (&work.edges, manner.quality.tolerance);
    let begin = || {
        let found = if edges.is_none() { Vec::new() } else { edges.find(scene, tolerance, &drawn.0) };
        Ok(SampledPicture::new(scene, tolerance, work.radius[1], drawn, &found))
    };
    ranks.attempt(|| renderer.run(begin))
}
