//! Errors of pictures against the oracle's, and their bounds.

/// Error of a picture against the oracle's, in premultiplied linear channels, 0 to 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// Root-mean-square difference over all channels of all pixels.
    pub rmse: f64,
    /// Largest difference of a channel.
    pub max: f64,
    /// Largest difference over the channels of each pixel; infinite where a channel is not a number.
    pub pixel_errors: Vec<f64>,
}

impl Comparison {
    /// Compares pixel by pixel.
    pub fn new<P, T>(pixels: &[[P; 4]], truth: &[[T; 4]]) -> Self
    where
        P: Copy + Into<f64>,
        T: Copy + Into<f64>,
    {
        assert_eq!(pixels.len(), truth.len(), "pictures of one size");
        let (mut squares, mut pixel_errors) = (0.0, Vec::with_capacity(pixels.len()));
        for (pixel, true_pixel) in pixels.iter().zip(truth) {
            let mut worst = 0.0f64;
            for (a, b) in pixel.iter().zip(true_pixel) {
                let d = ((*a).into() - (*b).into()).abs();
                let d = if d.is_nan() { f64::INFINITY } else { d };
                squares += d * d;
                worst = worst.max(d);
            }
            pixel_errors.push(worst);
        }
        let rmse = (squares / (4 * pixels.len()).max(1) as f64).sqrt();
        Comparison { rmse, max: pixel_errors.iter().copied().fold(0.0, f64::max), pixel_errors }
    }
}

/// A picture's bounds against its errors, over the pixels that have a bound or an error above zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundCheck {
    /// Largest bound.
    pub max: f64,
    /// Median bound.
    pub median: f64,
    /// Median error.
    pub median_error: f64,
    /// Pixels whose error exceeds their bound, or whose bound is not a number.
    pub violations: usize,
    /// Largest error over bound; infinite where an error has no bound. 0 where there are no errors.
    pub worst: f64,
    /// Median bound over median error; `None` where the median error is 0.
    pub ratio: Option<f64>,
}

impl BoundCheck {
    /// Checks each pixel's bound against its error, to the last bit.
    pub fn new(bound: &[f32], pixel_errors: &[f64]) -> Self {
        assert_eq!(bound.len(), pixel_errors.len(), "a bound for each pixel");
        let pairs: Vec<(f64, f64)> = bound.iter().map(|b| f64::from(*b)).zip(pixel_errors.iter().copied()).collect();
        let is_over = |(b, e): &&(f64, f64)| e > b || b.is_nan();
        let active = |(b, e): &&(f64, f64)| *b != 0.0 || *e > 0.0;
        let median_bound = median(pairs.iter().filter(active).map(|p| p.0).collect());
        let median_error = median(pairs.iter().filter(active).map(|p| p.1).collect());
        let quotient = |(b, e): &(f64, f64)| if *e > 0.0 { e / b } else { 0.0 };
        BoundCheck {
            max: pairs.iter().map(|p| p.0).fold(0.0, f64::max),
            median: median_bound,
            median_error,
            violations: pairs.iter().filter(is_over).count(),
            worst: pairs.iter().map(quotient).fold(0.0, f64::max),
            ratio: (median_error > 0.0).then(|| median_bound / median_error),
        }
    }
}

/// The median; the mean of the two in the middle of an even number, 0 of none.
pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let half = values.len() / 2;
    match values.len() {
        0 => 0.0,
        n if n % 2 == 1 => values[half],
        _ => 0.5 * (values[half - 1] + values[half]),
    }
}

/// Error of `pixel` against `exact`, less half a unit in the last place of f32; infinite where a channel is not a
/// number.
pub fn pixel_error(pixel: [f32; 4], exact: &[f64; 4]) -> f64 {
    let channel = |k: usize| {
        let half = 0.5 * f64::from(pixel[k].next_up() - pixel[k]).abs();
        let error = (f64::from(pixel[k]) - exact[k]).abs() - half;
        if error.is_nan() { f64::INFINITY } else { error }
    };
    (0..4).map(channel).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_of_channels() {
        let truth = [[0.5, 0.5, 0.5, 1.0], [0.0; 4]];
        let found = Comparison::new(&[[0.5, 0.75, 0.5, 1.0], [0.0; 4]], &truth);
        assert_eq!((found.max, found.pixel_errors.as_slice()), (0.25, [0.25, 0.0].as_slice()));
        assert!((found.rmse - (0.0625f64 / 8.0).sqrt()).abs() < 1e-15);
        assert_eq!(Comparison::new(&[[f32::NAN; 4], [0.0; 4]], &truth).max, f64::INFINITY);
    }

    #[test]
    fn bounds_are_checked_where_there_is_something_to_check() {
        let check = BoundCheck::new(&[0.0, 0.0, 0.25, 0.5, 1.0], &[0.0, 0.0, 0.125, 0.125, 0.25]);
        assert_eq!((check.violations, check.max, check.median), (0, 1.0, 0.5));
        assert_eq!((check.worst, check.ratio), (0.5, Some(4.0)));
        let broken = BoundCheck::new(&[0.0, 0.25, f32::NAN], &[0.125, 0.5, 0.0]);
        assert_eq!((broken.violations, broken.worst), (3, f64::INFINITY));
        assert_eq!(BoundCheck::new(&[0.0], &[0.0]).ratio, None);
    }

    #[test]
    fn medians() {
        assert_eq!(median(vec![]), 0.0);
        assert_eq!(median(vec![3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(vec![4.0, 1.0, 2.0, 3.0]), 2.5);
    }
}
