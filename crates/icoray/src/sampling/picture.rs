//! A picture while rounds of samples are added to its pixels, at rank 0.

use super::moments::{Moments, Places};
use super::pattern::Pattern;
use super::round::SampleRound;
use crate::edges;
use crate::raster::{Pixel, SamplePoint, Tile};
use glam::DVec3;
use icoray_kernel::Counts;
use icoray_output::SamplingError;
use icoray_scene::Scene;
use rayon::prelude::*;
use std::f64::consts::SQRT_2;

/// Rays of a pixel from which on a step beside it is taken to be none in it, where its rays do not find one: of steps
/// between the middles of two pixels, n even rays of one of them miss 1 / (2 n), 3 %.
const FOUND: u32 = 16;

/// The picture, its pixels' sampling errors, and the pixels to which samples are added.
pub(crate) struct SampledPicture<'s> {
    scene: &'s Scene,
    tolerance: f64,
    pixels: Vec<Pixel>,
    counts: Counts,
    /// Estimated sampling error of each pixel; 0 where a pixel shows nothing but the background.
    error: Vec<f32>,
    active: Vec<ActivePixel>,
    /// Rays that each active pixel has.
    rays: u32,
    /// Number of pixels that may show the shell, of those that have an edge in them, and of samples that were added.
    sampled: usize,
    edge_pixels: u64,
    samples: u64,
}

/// A pixel whose samples may not be all yet.
struct ActivePixel {
    number: u32,
    is_edge: bool,
    moments: Moments,
}

impl<'s> SampledPicture<'s> {
    /// The picture of one ray per pixel, whose shell ends at the radius `outer`, with pixels at `edges`, drawn to
    /// `tolerance`.
    pub fn new(
        scene: &'s Scene,
        tolerance: f64,
        outer: f64,
        (pixels, counts): (Vec<Pixel>, Counts),
        edges: &[u32],
    ) -> Self {
        let active = |number: u32| ActivePixel {
            number,
            is_edge: edges.binary_search(&number).is_ok(),
            moments: Moments::default(),
        };
        let all = (0..scene.width * scene.height).into_par_iter();
        let active: Vec<ActivePixel> = all.filter(|number| may_show_shell(scene, outer, *number)).map(active).collect();
        let edge_pixels = active.iter().filter(|pixel| pixel.is_edge).count() as u64;
        let (error, sampled) = (vec![0.0; pixels.len()], active.len());
        SampledPicture { scene, tolerance, pixels, counts, error, active, rays: 1, sampled, edge_pixels, samples: 0 }
    }

    /// The numbers of the pixels that take samples until they have `end` rays; others take no more.
    pub fn wanted(&mut self, end: u32) -> Vec<u32> {
        let (is_first, rays) = (self.rays == 1, self.rays);
        let (tolerance, error, samples) = (self.tolerance, &self.error, self.scene.samples);
        self.active.retain(|pixel| {
            let [least, most] = match pixel.is_edge {
                true => [edges::RAYS as u32, samples.max(edges::RAYS as u32)],
                false => [1, samples],
            };
            let is_off = is_first || f64::from(error[pixel.number as usize]) > tolerance;
            end <= most && (is_off || rays < least)
        });
        self.active.iter().map(|pixel| pixel.number).collect()
    }

    /// The same with the tiles of a round added to its pixels, which are those wanted.
    ///
    /// # Panics
    /// When a tile is missing or there twice.
    pub fn with(mut self, round: &SampleRound, tiles: &[Tile]) -> Self {
        let (tiles, counts) = round.pixels.in_order(tiles);
        self.counts += counts;
        let added: Vec<(&Pixel, &Moments)> =
            tiles.into_iter().flat_map(|tile| tile.pixels.iter().zip(&tile.moments)).collect();
        let (pixels, width, before) = (&self.pixels, self.scene.width, self.rays);
        let joined = self.active.par_iter_mut().zip(&added).map(|(active, (pixel, moments))| {
            let pattern = Pattern::of([active.number % width, active.number / width]);
            let places = [0..before, round.samples.clone()].map(|samples| Places::of(&pattern, samples));
            let mine = &pixels[active.number as usize];
            active.moments = active.moments.joined(&mine.color, &places[0], (moments, &pixel.color, &places[1]));
            edges::weighted_mean([(mine, f64::from(before)), (*pixel, round.samples.len() as f64)].into_iter())
        });
        let joined: Vec<Pixel> = joined.collect();
        for (active, pixel) in self.active.iter().zip(joined) {
            self.pixels[active.number as usize] = pixel;
        }
        self.samples += (self.active.len() * round.samples.len()) as u64;
        self.rays = round.samples.end;
        self.estimate();
        self
    }

    /// Estimates the sampling errors of the active pixels.
    fn estimate(&mut self) {
        let (rays, width) = (self.rays, self.scene.width);
        let error = |active: &ActivePixel| {
            let pattern = Pattern::of([active.number % width, active.number / width]);
            active.moments.error(&Places::of(&pattern, 0..rays), &self.slopes(active.number))
        };
        let errors: Vec<f32> = self.active.par_iter().map(error).collect();
        for (active, error) in self.active.iter().zip(errors) {
            self.error[active.number as usize] = error;
        }
    }

    /// The slopes of the picture at a pixel, to the right and downwards, per pixel.
    ///
    /// While a step may lie between a pixel's rays and its border, they are the mean of the slopes on both sides, which
    /// a step on one side is in; later they are the smaller one, or 0 at a maximum.
    fn slopes(&self, number: u32) -> [[f32; 4]; 2] {
        let Scene { width, height, .. } = *self.scene;
        let may_hide = self.rays < FOUND;
        let axis = |at: u32, side: u32, step: u32| {
            let color = |number: u32| self.pixels[number as usize].color;
            let before = (at > 0).then(|| color(number - step));
            let behind = (at + 1 < side).then(|| color(number + step));
            let mine = color(number);
            std::array::from_fn(|k| {
                let slopes = [before.map(|before| mine[k] - before[k]), behind.map(|behind| behind[k] - mine[k])];
                match slopes {
                    [Some(one), Some(other)] if may_hide => 0.5 * (one + other),
                    [Some(one), Some(other)] if one * other <= 0.0 => 0.0,
                    [Some(one), Some(other)] => {
                        if one.abs() < other.abs() {
                            one
                        } else {
                            other
                        }
                    }
                    [one, other] => one.or(other).unwrap_or(0.0),
                }
            })
        };
        [axis(number % width, width, 1), axis(number / width, height, width)]
    }

    /// Number of pixels that took several rays and have the edge of a surface in them.
    pub fn edge_pixels(&self) -> u64 {
        self.edge_pixels
    }

    /// Mean number of rays of the pixels that may show the shell.
    pub fn rays_per_pixel(&self) -> f64 {
        1.0 + self.samples as f64 / self.sampled.max(1) as f64
    }

    /// The pixels and what their rays met, their sampling errors, and the summary of these.
    pub fn finish(self) -> ((Vec<Pixel>, Counts), Vec<f32>, SamplingError) {
        let sum: f64 = self.error.iter().map(|error| f64::from(*error)).sum();
        let max = self.error.iter().fold(0.0f32, |max, error| max.max(*error));
        let summary = SamplingError { max: f64::from(max), mean: sum / self.sampled.max(1) as f64 };
        ((self.pixels, self.counts), self.error, summary)
    }
}

/// Whether a ray through a pixel may come within the radius `outer` of the centre.
fn may_show_shell(scene: &Scene, outer: f64, number: u32) -> bool {
    let eye = DVec3::from_array(scene.camera.eye());
    let middle = SamplePoint::middle(number % scene.width, number / scene.width, false);
    let dir = DVec3::from_array(scene.camera.direction_at(middle.at, scene.width, scene.height));
    // A ray that is turned by an angle passes the centre nearer by the angle times the distance, at most.
    let reach = 0.5 * SQRT_2 * scene.camera.pixel_width(scene.height) * eye.length();
    let along = -eye.dot(dir);
    let passes_at = (eye + along * dir).length();
    eye.length() <= outer || along + reach > 0.0 && passes_at - reach <= outer
}
