//! Stores a picture while rounds of samples are added to its pixels, at rank 0.

use super::pattern::Pattern;
use crate::edges::{self, may_show_limb};
use crate::raster::{Pixel, Tile};
use crate::scattered::ScatteredPixels;
use glam::DVec3;
use icoray_kernel::Counts;
use icoray_output::SamplingError;
use icoray_scene::Scene;
use rayon::prelude::*;
use std::ops::Range;

/// Number of first samples of a pixel from which they are spread evenly around its middle.
const EVEN: u32 = 4;
/// Ratio of the sampling error to the mean change by a round: a little more than Student's factor of 95 % for nine
/// changes, 2.26, as the smallest of them are no measure where a step passes through the pixel alone.
const FACTOR: f64 = 2.5;

/// A picture with its samples, at rank 0.
pub(crate) struct Sampled {
    pub drawn: (Vec<Pixel>, Counts),
    pub edge_pixels: u64,
    /// Mean number of rays of the pixels that may show the shell; of all pixels if not all are traced.
    pub rays_per_pixel: f64,
    /// The estimated sampling error of each pixel, or of those that were not traced; empty if each pixel has one ray.
    pub error: Vec<f32>,
    pub summary: Option<SamplingError>,
}

/// The picture, its pixels' sampling errors, and the pixels to which samples are added.
pub(crate) struct SampledPicture<'s> {
    scene: &'s Scene,
    tolerance: f64,
    pixels: Vec<Pixel>,
    counts: Counts,
    /// The scaled change of each pixel by its last round.
    change: Vec<f32>,
    /// Estimated sampling error of each pixel; 0 if a pixel shows only the background.
    error: Vec<f32>,
    active: Vec<ActivePixel>,
    /// Number of rays of each active pixel.
    rays: u32,
    /// Number of pixels that may show the shell, of those with an edge, and of samples that were added.
    sampled: usize,
    edge_pixels: u64,
    samples: u64,
}

/// A pixel that may still need samples.
struct ActivePixel {
    number: u32,
    is_edge: bool,
    /// The slopes of the picture of one ray per pixel, to the right and downwards, per pixel.
    slopes: [[f32; 4]; 2],
}

/// Weights of some samples of a pixel.
#[derive(Clone, Copy)]
struct Weights {
    sum: f64,
    squares: f64,
}

impl Weights {
    /// Weights of the first `rays` samples of a picture of at most `samples` per pixel.
    fn of(rays: u32, samples: u32) -> Self {
        let middle = if samples < EVEN { 2.0 } else { 1.0 };
        let others = f64::from(rays - 1);
        Weights { sum: middle + others, squares: middle * middle + others }
    }

    /// The ratio of the deviation of the mean of these samples to that of its difference from the mean of `fewer` of
    /// them, for samples that differ by chance.
    fn deviation(&self, fewer: &Weights) -> f64 {
        let variance = self.squares / self.sum.powi(2);
        let of_fewer = fewer.squares / fewer.sum.powi(2);
        (variance / (variance + of_fewer - 2.0 * fewer.squares / (fewer.sum * self.sum))).sqrt()
    }
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
            slopes: slopes(scene, &pixels, number),
        };
        let all = (0..scene.width * scene.height).into_par_iter();
        let active: Vec<ActivePixel> = all.filter(|number| may_show_shell(scene, outer, *number)).map(active).collect();
        let edge_pixels = active.iter().filter(|pixel| pixel.is_edge).count() as u64;
        let (error, sampled) = (vec![0.0; pixels.len()], active.len());
        let change = error.clone();
        SampledPicture {
            scene,
            tolerance,
            pixels,
            counts,
            change,
            error,
            active,
            rays: 1,
            sampled,
            edge_pixels,
            samples: 0,
        }
    }

    /// The numbers of the pixels that take samples until they have `end` rays; the other pixels take no more samples.
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

    /// Adds the tiles of a round of `samples` to the wanted pixels, `round`.
    ///
    /// # Panics
    /// If a tile is missing or occurs twice.
    pub fn with(mut self, round: &ScatteredPixels, samples: Range<u32>, tiles: &[Tile]) -> Self {
        let (added, counts) = round.in_order(tiles);
        self.counts += counts;
        let (pixels, width) = (&self.pixels, self.scene.width);
        let [before, after] = [self.rays, samples.end].map(|rays| Weights::of(rays, self.scene.samples));
        let deviation = after.deviation(&before);
        let joined = self.active.par_iter().zip(&added).map(|(active, pixel)| {
            let mine = &pixels[active.number as usize];
            let [x, y] = Pattern::of([active.number % width, active.number / width]).mean_place(samples.clone());
            let [right, down] = &active.slopes;
            let from_middle = |k: usize| f64::from(right[k]) * x + f64::from(down[k]) * y;
            let at_middle = |k: usize| (f64::from(pixel.color[k]) - from_middle(k)) as f32;
            let moved = Pixel { color: std::array::from_fn(at_middle), ..**pixel };
            let weighted = [(mine, before.sum), (&moved, after.sum - before.sum)];
            let mut joined = edges::weighted_mean(weighted.into_iter());
            // A slope may lead to negative light.
            joined.color = joined.color.map(|channel| channel.max(0.0));
            joined.color[3] = joined.color[3].min(1.0);
            let change = (0..4).map(|k| (joined.color[k] - mine.color[k]).abs()).fold(0.0, f32::max);
            (joined, (deviation * f64::from(change)) as f32)
        });
        let joined: Vec<(Pixel, f32)> = joined.collect();
        for (active, (pixel, change)) in self.active.iter().zip(joined) {
            self.pixels[active.number as usize] = pixel;
            self.change[active.number as usize] = change;
        }
        self.samples += (self.active.len() * samples.len()) as u64;
        self.rays = samples.end;
        self.estimate();
        self
    }

    /// Estimates the sampling errors of the active pixels.
    fn estimate(&mut self) {
        let Scene { width, height, .. } = *self.scene;
        let change = &self.change;
        let error = |active: &ActivePixel| {
            let [xs, ys] = [(active.number % width, width), (active.number / width, height)]
                .map(|(at, side)| at.saturating_sub(1)..(at + 2).min(side));
            let around = ys.flat_map(|y| xs.clone().map(move |x| change[(y * width + x) as usize]));
            let (count, sum) =
                around.fold((0, 0.0), |(count, sum), change| (count + 1, sum + f64::from(change).powi(2)));
            // A channel is 0 to 1, except for highlights.
            (FACTOR * (sum / f64::from(count)).sqrt()).min(1.0) as f32
        };
        let errors: Vec<f32> = self.active.par_iter().map(error).collect();
        for (active, error) in self.active.iter().zip(errors) {
            self.error[active.number as usize] = error;
        }
    }

    /// The picture after the last round.
    pub fn finish(self) -> Sampled {
        let sampled = self.sampled.max(1) as f64;
        let sum: f64 = self.error.iter().map(|error| f64::from(*error)).sum();
        let max = self.error.iter().fold(0.0f32, |max, error| max.max(*error));
        Sampled {
            drawn: (self.pixels, self.counts),
            edge_pixels: self.edge_pixels,
            rays_per_pixel: 1.0 + self.samples as f64 / sampled,
            error: self.error,
            summary: Some(SamplingError { max: f64::from(max), mean: sum / sampled }),
        }
    }
}

/// The slopes of a picture at a pixel, to the right and downwards, per pixel: the mean of the slopes on both sides, at
/// most twice the smaller one, and 0 at an extremum or the picture's border. So a step beside a pixel causes no slope
/// in it.
fn slopes(scene: &Scene, pixels: &[Pixel], number: u32) -> [[f32; 4]; 2] {
    let axis = |at: u32, side: u32, step: u32| {
        if at == 0 || at + 1 == side {
            return [0.0; 4];
        }
        let [before, mine, behind] = [number - step, number, number + step].map(|number| pixels[number as usize].color);
        std::array::from_fn(|k| {
            let (one, other) = (mine[k] - before[k], behind[k] - mine[k]);
            let most = if one * other > 0.0 { 2.0 * one.abs().min(other.abs()) } else { 0.0 };
            (0.5 * (one + other)).clamp(-most, most)
        })
    };
    [axis(number % scene.width, scene.width, 1), axis(number / scene.width, scene.height, scene.width)]
}

/// Whether a ray through a pixel may come within the radius `outer` of the centre.
pub(crate) fn may_show_shell(scene: &Scene, outer: f64, number: u32) -> bool {
    let place = [number % scene.width, number / scene.width];
    DVec3::from_array(scene.camera.eye()).length() <= outer
        || may_show_limb(scene, scene.camera.pixel_width(scene.height), [0.0, outer], place, 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::{Raster, SamplePoint, Tiling, sample_points};
    use crate::scattered::PixelRays;
    use std::time::Instant;

    const SIDE: u32 = 8;

    /// A picture of this light, of `samples` rays in each pixel. Its camera is in the shell.
    fn drawn(light: impl Fn([f64; 2]) -> f32 + Sync, samples: u32) -> (Vec<Pixel>, Vec<f32>) {
        let keys = format!("field = \"f\"\nsamples = {samples}\nimage = {{ width = {SIDE}, height = {SIDE} }}");
        let scene = Scene::parse(&keys).unwrap();
        let raster = Raster { width: SIDE, height: SIDE, step: 1 };
        let show = |points: &[SamplePoint]| -> Vec<Pixel> {
            points.iter().map(|point| Pixel { color: [light(point.at); 4], ..Pixel::default() }).collect()
        };
        let first = raster.draw(|points, _| show(points));
        let mut picture = SampledPicture::new(&scene, 0.0, f64::INFINITY, first, &[]);
        for end in crate::sampling::rounds(samples, 0) {
            let samples = picture.rays..end;
            let round = ScatteredPixels::new(raster, picture.wanted(end), PixelRays::Samples(samples.clone()));
            let tile = |number: u32| {
                let rays = show(&sample_points(&round, number));
                Tile::resolved(&round, number, rays, Instant::now(), Counts::default())
            };
            let tiles: Vec<Tile> = (0..round.tiles()).map(tile).collect();
            picture = picture.with(&round, samples, &tiles);
        }
        let Sampled { drawn: (pixels, _), error, .. } = picture.finish();
        (pixels, error)
    }

    #[test]
    fn linear_light_has_its_exact_mean_for_any_number_of_samples() {
        let light = |[x, y]: [f64; 2]| (0.3 + 0.02 * x + 0.04 * y) as f32;
        for samples in [2, 3, 4, 8, 11] {
            let (pixels, errors) = drawn(light, samples);
            for (x, y) in (1..SIDE - 1).flat_map(|y| (1..SIDE - 1).map(move |x| (x, y))) {
                let number = (y * SIDE + x) as usize;
                let off = (pixels[number].color[0] - light([f64::from(x) + 0.5, f64::from(y) + 0.5])).abs();
                assert!(off < 1e-6, "{samples} samples at {x}, {y}: {off} off");
            }
            // Pixels of the border have no slope, so that those beside them have an error.
            let inner = errors[(SIDE / 2 * SIDE + SIDE / 2) as usize];
            assert!(inner < 1e-6 && errors[0] > 1e-4, "{samples} samples: {inner} and {}", errors[0]);
        }
    }

    #[test]
    fn light_beside_a_step_stays_as_it_is() {
        let (pixels, errors) = drawn(|[x, _]| if x < 4.0 { 0.0 } else { 1.0 }, 8);
        assert!((0..).zip(&pixels).all(|(number, pixel)| pixel.color == [f32::from(u8::from(number % SIDE >= 4)); 4]));
        assert!(errors.iter().all(|error| *error == 0.0), "{errors:?}");
    }

    #[test]
    fn channels_stay_within_their_range() {
        let (pixels, _) = drawn(|[x, y]| f32::from(u8::from((x - 3.3) * (x - 3.3) + (y - 4.2) * (y - 4.2) < 6.0)), 2);
        assert!(pixels.iter().all(|pixel| pixel.color.iter().all(|channel| (0.0..=1.0).contains(channel))));
    }

    #[test]
    fn changes_by_chance_are_scaled_to_the_error_of_the_mean() {
        let deviation = |before: u32, after: u32| Weights::of(after, 64).deviation(&Weights::of(before, 64));
        assert!((deviation(8, 16) - 1.0).abs() < 1e-12, "half of the rays are new: the halves differ by twice as much");
        assert!((deviation(1, 4) - 3f64.sqrt().recip()).abs() < 1e-12);
        // The middle of two rays has 2/3 of the weight: sqrt(5)/3 of a ray's deviation, which changes by sqrt(2)/3.
        let two = Weights::of(2, 2).deviation(&Weights::of(1, 2));
        assert!((two - 2.5f64.sqrt()).abs() < 1e-12, "{two}");
    }
}
