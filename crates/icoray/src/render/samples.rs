//! Rounds of more samples of pixels ([`crate::sampling`]), after the picture of one ray per pixel.

use super::context::FrameContext;
use super::round::{Drawn, Rounds};
use super::work::{Work, background_blend};
use crate::edges;
use crate::plan::budget::brightest;
use crate::ranks::{Ranks, TileAssignment};
use crate::raster::{Pixel, Raster};
use crate::sampling::{Sampled, SampledPicture, may_show_shell, rounds};
use crate::scattered::{PixelRays, ScatteredPixels};
use crate::time_budget::Deadline;
use icoray_grid::Result;
use icoray_output::SamplingError;
use icoray_scene::Scene;
use rayon::prelude::*;

impl Rounds<'_, '_, '_> {
    /// Adds the scene's samples to the pixels of a picture of one ray per pixel, as long as there is time. If the scene
    /// requests none, or there is no time for the first round, draws pixels at edges again. Collective.
    pub fn samples(&mut self, ranks: &mut Ranks, drawn: Option<Drawn>) -> Result<Option<Sampled>> {
        let Work { context: FrameContext { scene, .. }, edges, radius: [_, outer], .. } = self.work;
        let (raster, tolerance) = (self.raster, self.quality.tolerance);
        if self.quality.pixel_step > 1 {
            return self.at_root(ranks, Ok(drawn), |drawn| interpolated(scene, *outer, raster, drawn));
        }
        if scene.samples <= 1 {
            return self.unsampled(ranks, drawn);
        }
        let begin = |drawn: Drawn| {
            let found = if edges.is_none() { Vec::new() } else { edges.find(scene, &drawn.0) };
            SampledPicture::new(scene, tolerance, *outer, drawn, &found)
        };
        let picture = self.at_root(ranks, Ok(drawn), begin)?;
        let (rays, picture) = self.add_rounds(ranks, picture)?;
        let sampled = picture.map(SampledPicture::finish);
        if rays == 1 { self.unsampled(ranks, sampled.map(|sampled| sampled.drawn)) } else { Ok(sampled) }
    }

    /// The picture of one ray per pixel, except for pixels at edges.
    fn unsampled(&mut self, ranks: &mut Ranks, drawn: Option<Drawn>) -> Result<Option<Sampled>> {
        let (edge_pixels, drawn) = self.edges(ranks, drawn)?;
        let sampled = |drawn| Sampled { drawn, edge_pixels, rays_per_pixel: 1.0, error: Vec::new(), summary: None };
        Ok(drawn.map(sampled))
    }

    /// Draws one round after another, and returns the final number of rays per pixel. Collective.
    fn add_rounds<'s>(
        &mut self,
        ranks: &mut Ranks,
        mut picture: Option<SampledPicture<'s>>,
    ) -> Result<(u32, Option<SampledPicture<'s>>)> {
        let FrameContext { renderer, scene, .. } = *self.work.context;
        let Rounds { raster, quality, deadline, render_s, .. } = *self;
        let least_at_edges = if self.work.edges.is_none() { 0 } else { edges::RAYS as u32 };
        let mut rays = 1;
        for end in rounds(scene.samples, least_at_edges) {
            let wanted = picture.as_mut().map_or_else(Vec::new, |picture| picture.wanted(end));
            let times = f64::from(end - rays) / f64::from(raster.width * raster.height);
            // `render_s` seconds are those of the rays of all pixels.
            let has_time = |deadline: Deadline| deadline.has_time_for(render_s * wanted.len() as f64 * times);
            let goes_on = !renderer.is_stopped() && deadline.is_none_or(has_time);
            let wanted = ranks.hear_root(Ok(if goes_on { wanted } else { Vec::new() }))?;
            if wanted.is_empty() {
                break;
            }
            let round = ScatteredPixels::new(raster, wanted, PixelRays::Samples(rays..end));
            let assignment = TileAssignment::in_turn(quality, &round, ranks);
            picture = self.trace(ranks, &round, &assignment, None, |tiles| {
                picture.expect("rank 0 has the picture").with(&round, rays..end, tiles)
            })?;
            rays = end;
        }
        Ok((rays, picture))
    }
}

/// A picture with pixels between traced ones. A pixel between that shows the background is exact if its ray misses the
/// shell. For others the error bound is the largest value of a channel, and their actual error is estimated separately.
fn interpolated(scene: &Scene, outer: f64, raster: Raster, (mut pixels, counts): Drawn) -> Sampled {
    let brightest = brightest(scene);
    let (background, unknown) = (background_blend(scene, brightest, None).color, brightest.max(1.0) as f32);
    let estimate = |(number, pixel): (usize, &mut Pixel)| {
        let number = number as u32;
        if raster.is_traced(number) {
            return None;
        }
        let is_right = pixel.color == background && !may_show_shell(scene, outer, number);
        let estimate = std::mem::replace(&mut pixel.error, if is_right { 0.0 } else { unknown });
        (!is_right).then(|| estimate.min(unknown))
    };
    let estimates: Vec<Option<f32>> = pixels.par_iter_mut().enumerate().map(estimate).collect();
    let known = || estimates.iter().flatten();
    let sum: f64 = known().map(|error| f64::from(*error)).sum();
    let max = known().fold(0.0f32, |max, error| max.max(*error));
    let summary = SamplingError { max: f64::from(max), mean: sum / known().count().max(1) as f64 };
    let error = estimates.into_iter().map(Option::unwrap_or_default).collect();
    let rays_per_pixel = raster.part();
    Sampled { drawn: (pixels, counts), edge_pixels: 0, rays_per_pixel, error, summary: Some(summary) }
}
