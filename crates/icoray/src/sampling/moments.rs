//! Moments of the light of a pixel's samples and of their places, and the error of their mean.

use super::pattern::Pattern;
use crate::raster::Pixel;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Sums over some samples of a pixel.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Moments {
    /// Squares of what each channel is off its mean.
    squares: [f32; 4],
    /// Products of that with what the samples' places are off theirs: to the right, and downwards.
    products: [[f32; 4]; 2],
}

/// The places of some samples of a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Places {
    /// How many there are.
    count: f64,
    /// Their mean, from the pixel's middle.
    mean: [f64; 2],
    /// Sums of squares and of products of what they are off their mean: xx, xy, yy.
    squares: [f64; 3],
}

impl Places {
    /// Of these samples of a pixel.
    pub fn of(pattern: &Pattern, samples: Range<u32>) -> Self {
        let count = f64::from(samples.end - samples.start);
        let all = || samples.clone().map(|sample| pattern.place(sample));
        let mean = [0, 1].map(|axis| all().map(|place| place[axis]).sum::<f64>() / count);
        let squares = [[0, 0], [0, 1], [1, 1]].map(|[a, b]| {
            let product = |place: [f64; 2]| (place[a] - mean[a]) * (place[b] - mean[b]);
            all().map(product).sum()
        });
        Places { count, mean, squares }
    }
}

impl Moments {
    /// Of rays at these samples, whose mean is `mean`.
    pub fn of(rays: &[Pixel], mean: &[f32; 4], pattern: &Pattern, samples: Range<u32>) -> Self {
        let center = Places::of(pattern, samples.clone()).mean;
        let (mut squares, mut products) = ([0.0; 4], [[0.0; 4]; 2]);
        for (ray, sample) in rays.iter().zip(samples) {
            let place = pattern.place(sample);
            for k in 0..4 {
                let off = f64::from(ray.color[k]) - f64::from(mean[k]);
                squares[k] += off * off;
                for axis in 0..2 {
                    products[axis][k] += off * (place[axis] - center[axis]);
                }
            }
        }
        let short = |values: [f64; 4]| values.map(|value| value as f32);
        Moments { squares: short(squares), products: products.map(short) }
    }

    /// Of these and `other` samples of a pixel, each with its mean and places.
    ///
    /// The update of Chan, Golub and LeVeque, 1983.
    pub fn joined(&self, mean: &[f32; 4], places: &Places, other: (&Moments, &[f32; 4], &Places)) -> Self {
        let (others, other_mean, other_places) = other;
        let weight = places.count * other_places.count / (places.count + other_places.count);
        let off: [f64; 4] = std::array::from_fn(|k| f64::from(other_mean[k]) - f64::from(mean[k]));
        let sum = |mine: f32, others: f32, more: f64| (f64::from(mine) + f64::from(others) + weight * more) as f32;
        let product = |axis: usize| {
            let aside = other_places.mean[axis] - places.mean[axis];
            std::array::from_fn(|k| sum(self.products[axis][k], others.products[axis][k], off[k] * aside))
        };
        Moments {
            squares: std::array::from_fn(|k| sum(self.squares[k], others.squares[k], off[k] * off[k])),
            products: [product(0), product(1)],
        }
    }

    /// The estimated error of the mean, the largest of its channels, where the picture has these slopes per pixel to
    /// the right and downwards. No less than 95 % of means are meant to be nearer to the mean over the pixel.
    pub fn error(&self, places: &Places, slopes: &[[f32; 4]; 2]) -> f32 {
        let Places { count, mean, squares: [xx, xy, yy] } = *places;
        let channel = |k: usize| {
            let [right, down] = slopes.map(|slope| f64::from(slope[k]));
            let [along, across] = self.products.map(|products| f64::from(products[k]));
            let explained = 2.0 * (right * along + down * across)
                - (right * right * xx + 2.0 * right * down * xy + down * down * yy);
            let rest = (f64::from(self.squares[k]) - explained).max(0.0);
            student(count - 1.0) * (rest / (count * (count - 1.0))).sqrt() + (right * mean[0] + down * mean[1]).abs()
        };
        // A channel is 0 to 1, but for highlights.
        (0..4).map(channel).fold(0.0, f64::max).min(1.0) as f32
    }
}

/// Student's factor of a two-sided interval of 95 % for so many degrees of freedom; from 3 on the expansion of Cornish
/// and Fisher.
fn student(degrees: f64) -> f64 {
    match degrees {
        ..2.0 => 12.706,
        ..3.0 => 4.303,
        _ => 1.96 + 2.372 / degrees + 2.823 / (degrees * degrees) + 2.556 / degrees.powi(3),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::edges::mean;

    /// Rays of some light at samples of a pixel.
    fn rays(pattern: &Pattern, samples: Range<u32>, light: impl Fn([f64; 2]) -> f64) -> Vec<Pixel> {
        let color = |sample: u32| [light(pattern.place(sample)) as f32, 0.0, 0.0, 1.0];
        samples.map(|sample| Pixel { color: color(sample), ..Pixel::default() }).collect()
    }

    #[test]
    fn rounds_have_the_moments_of_all_samples() {
        let pattern = Pattern::of([3, 4]);
        let light = |[x, y]: [f64; 2]| 0.3 + 0.2 * x - 0.5 * y + (40.0 * x).sin() * 0.1;
        let of = |samples: Range<u32>| {
            let rays = rays(&pattern, samples.clone(), light);
            let mean = mean(&rays).color;
            (Moments::of(&rays, &mean, &pattern, samples.clone()), mean, Places::of(&pattern, samples))
        };
        let ([first, second], whole) = ([of(0..4), of(4..16)], of(0..16));
        let joined = first.0.joined(&first.1, &first.2, (&second.0, &second.1, &second.2));
        let near = |a: f32, b: f32| (a - b).abs() < 1e-6;
        assert!(near(joined.squares[0], whole.0.squares[0]) && joined.squares[3] == 0.0);
        assert!((0..2).all(|axis| near(joined.products[axis][0], whole.0.products[axis][0])), "{joined:?} {whole:?}");
    }

    #[test]
    fn linear_light_has_the_error_of_the_mean_place_alone() {
        let pattern = Pattern::of([10, 20]);
        let (slopes, samples) = ([[0.3f32, 0.0, 0.0, 0.0], [-0.2, 0.0, 0.0, 0.0]], 0..8);
        let light = |[x, y]: [f64; 2]| 0.5 + 0.3 * x - 0.2 * y;
        let rays = rays(&pattern, samples.clone(), light);
        let mean = mean(&rays).color;
        let places = Places::of(&pattern, samples.clone());
        let moments = Moments::of(&rays, &mean, &pattern, samples);
        let (told, actual) = (moments.error(&places, &slopes), (mean[0] - 0.5).abs());
        assert!((told - actual).abs() < 1e-3 && told < 0.02, "{told} and {actual}");
        // Without the slope, all of it is noise.
        assert!(moments.error(&places, &[[0.0; 4]; 2]) > 0.05);
    }

    #[test]
    fn students_factor_is_near_the_tables() {
        for (degrees, exact) in [(1.0, 12.706), (2.0, 4.303), (3.0, 3.182), (7.0, 2.365), (15.0, 2.131), (63.0, 1.998)]
        {
            assert!((student(degrees) / exact - 1.0).abs() < 0.01, "{degrees}");
        }
    }
}
