//! The place of the camera.

use super::survey::Survey;
use glam::DVec3;
use icoray_grid::Grid;
use std::f64::consts::PI;

/// Bands of latitude whose means are zonal means.
const BANDS: usize = 36;
/// A field whose deviations are less than this part of its variance has none to face.
const LEAST_VARIANCE: f64 = 1e-4;
/// Where deviations are spread more evenly than this there is no side to face: 0 is even, 1 a single place.
const LEAST_SIDED: f64 = 0.1;
/// Latitudes beyond which the camera does not go by itself, degrees.
const STEEPEST_DEG: f64 = 45.0;

/// A place below the camera, degrees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Aim {
    pub lon_deg: f64,
    pub lat_deg: f64,
    /// Whether the field has a side to face.
    pub is_of_field: bool,
}

impl Aim {
    const DEFAULT: Self = Aim { lon_deg: 0.0, lat_deg: 25.0, is_of_field: false };

    /// The middle of where the field differs from its zonal mean.
    pub fn new(grid: &Grid, survey: &Survey) -> Self {
        let direction = |column: usize| grid.direction(column as u32);
        let band = |column: usize| {
            let part = direction(column).z.clamp(-1.0, 1.0).asin() / PI + 0.5;
            ((part * BANDS as f64) as usize).min(BANDS - 1)
        };
        let places: Vec<usize> = (0..grid.cells()).map(band).collect();
        let count = survey.height.len();
        let mut means = vec![[0.0; 2]; BANDS * count];
        let mut layers = vec![[0.0; 2]; count];
        survey.each(|column, layer, value| {
            let [number, sum] = &mut means[places[column] * count + layer];
            (*number, *sum) = (*number + 1.0, *sum + value);
            let [number, sum] = &mut layers[layer];
            (*number, *sum) = (*number + 1.0, *sum + value);
        });
        let (mut toward, mut deviations, mut variance) = (DVec3::ZERO, 0.0, 0.0);
        survey.each(|column, layer, value| {
            let [number, sum] = means[places[column] * count + layer];
            let deviation = (value - sum / number).powi(2);
            let [number, sum] = layers[layer];
            variance += (value - sum / number).powi(2);
            deviations += deviation;
            toward += deviation * direction(column);
        });
        if !(deviations > LEAST_VARIANCE * variance && toward.length() > LEAST_SIDED * deviations) {
            return Self::DEFAULT;
        }
        let toward = toward / deviations;
        // Not -0, nor -180.
        let to_five = |deg: f64| if deg < -177.5 { 180.0 } else { (deg / 5.0).round() * 5.0 + 0.0 };
        let has_lon = toward.x.hypot(toward.y) > 0.5 * LEAST_SIDED;
        let lon_deg = if has_lon { to_five(toward.y.atan2(toward.x).to_degrees()) } else { 0.0 };
        let lat_deg = to_five(toward.normalize().z.asin().to_degrees());
        Aim { lon_deg, lat_deg: lat_deg.clamp(-STEEPEST_DEG, STEEPEST_DEG), is_of_field: true }
    }
}
