//! Rays per pixel, and their sampling errors.

use serde::{Deserialize, Serialize};
use std::fmt;

/// Rays per pixel, and their sampling errors.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct SamplingReport {
    /// Maximum number of rays of a pixel ([`samples`](icoray_scene::Scene::samples)).
    pub samples: u32,
    /// Mean number of rays whose mean a pixel shows, over the pixels that may show the shell, if the scene's
    /// [`samples`](icoray_scene::Scene::samples) were taken; less than 1 if not every pixel was traced; else 1,
    /// independent of the rays of pixels at edges.
    pub rays_per_pixel: f64,
    /// Estimated sampling errors; `None` if each pixel has one ray, which gives no estimate.
    pub error: Option<SamplingError>,
    /// Cells that fall into a pixel.
    pub cells_per_pixel: CellsPerPixel,
}

/// Estimated sampling errors of the pixels that may show the shell: the error of the mean of a pixel's rays against the
/// mean over its area, the largest of its channels, premultiplied linear 0 to 1. The errors of the integrals along the
/// rays ([`ErrorSummary`](super::ErrorSummary)) are not included.
///
/// Each is intended to be no less than the actual one in 95 % of pixels; details between all rays of a pixel are not
/// detected. If not every pixel was traced, it is the error of the pixels between traced ones against their rays,
/// estimated from the traced ones around.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct SamplingError {
    /// Largest over the picture.
    pub max: f64,
    /// Mean over the pixels.
    pub mean: f64,
}

/// Number of cells per pixel, over pixels whose rays meet the shell, of at most 16 × 16 evenly spaced pixels of the
/// picture: the area of a layer that the pixel covers where its ray meets the shell first, divided by that of a cell
/// there. The layer is the outermost one or, from within the shell, the outermost or innermost one; a cell has the area
/// of two triangles of the mesh. 0 if no ray meets the shell.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct CellsPerPixel {
    /// Largest over the pixels, which is at the limb.
    pub max: f64,
    /// Mean over the pixels.
    pub mean: f64,
}

impl CellsPerPixel {
    /// Cells per pixel from which one ray per pixel gives a random sample.
    const MANY: f64 = 4.0;

    /// The value of [`samples`](icoray_scene::Scene::samples) that gives each cell of a pixel about one ray, if a pixel
    /// has many cells.
    ///
    /// ```
    /// use icoray_output::CellsPerPixel;
    ///
    /// assert_eq!(CellsPerPixel { max: 9.0, mean: 3.0 }.suggested_samples(), None);
    /// assert_eq!(CellsPerPixel { max: 90.0, mean: 11.0 }.suggested_samples(), Some(16));
    /// ```
    pub fn suggested_samples(&self) -> Option<u32> {
        let max = f64::from(icoray_scene::Scene::MAX_SAMPLES);
        (self.mean >= Self::MANY).then(|| (self.mean.min(max) as u32).next_power_of_two())
    }
}

impl SamplingReport {
    /// The suggested setting if one ray stands for many cells, in words.
    pub fn hint(&self) -> Option<String> {
        let samples = self.cells_per_pixel.suggested_samples().filter(|_| self.samples <= 1)?;
        let CellsPerPixel { mean, .. } = self.cells_per_pixel;
        Some(format!(
            "{mean:.0} cells fall into a pixel in the mean, of which one ray shows a few; samples = {samples} in the \
             scene averages {samples} rays"
        ))
    }
}

impl fmt::Display for CellsPerPixel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "mean {:.2}, largest {:.2}", self.mean, self.max)
    }
}

impl fmt::Display for SamplingReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let SamplingReport { rays_per_pixel, error, .. } = self;
        match error {
            None => f.write_str("1 ray per pixel"),
            Some(SamplingError { max, mean }) => {
                let [max, mean] = [*max, *mean].map(super::two_digits_up);
                match rays_per_pixel {
                    ..1.0 => write!(f, "{rays_per_pixel:.3} rays per pixel, error of pixels between them")?,
                    _ => write!(f, "{rays_per_pixel:.1} rays per pixel, error of their mean")?,
                }
                write!(f, " {mean}, at most {max} (estimate)")
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_suggested_where_many_cells_fall_into_a_pixel_of_one_ray() {
        let report = |samples, mean| {
            let cells_per_pixel = CellsPerPixel { max: 5.0 * mean, mean };
            SamplingReport { samples, rays_per_pixel: 1.0, error: None, cells_per_pixel }
        };
        let hint = report(1, 21.4).hint().unwrap();
        assert!(hint.starts_with("21 cells fall into a pixel") && hint.contains("samples = 32 "), "{hint}");
        assert!(report(1, 1e9).hint().unwrap().contains("samples = 64 "));
        assert_eq!([report(1, 3.9).hint(), report(4, 21.4).hint()], [None, None]);
    }

    #[test]
    fn the_error_of_the_mean_is_reported_as_an_estimate() {
        let error = Some(SamplingError { max: 0.04, mean: 1.23e-3 });
        let report = SamplingReport { samples: 16, rays_per_pixel: 7.25, error, ..SamplingReport::default() };
        let expected = "7.2 rays per pixel, error of their mean 1.3e-3, at most 4.0e-2 (estimate)";
        assert_eq!(report.to_string(), expected);
        let expected = "0.111 rays per pixel, error of pixels between them 1.3e-3, at most 4.0e-2 (estimate)";
        assert_eq!(SamplingReport { rays_per_pixel: 1.0 / 9.0, ..report }.to_string(), expected);
        assert_eq!(SamplingReport::default().to_string(), "1 ray per pixel");
    }
}
