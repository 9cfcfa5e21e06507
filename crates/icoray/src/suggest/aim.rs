//! Chooses the place of the camera: over the side on which the field shows, or over the region that has data.

use super::look::{Kind, Look};
use super::numbers::to_step;
use super::sample::Sample;
use super::survey::Survey;
use super::{FILLED, FOV_DEG};
use glam::DVec3;
use icoray_grid::grid::unit_vector;
use std::f64::consts::PI;

/// Number of bands of latitude whose means are zonal means, and of sectors of longitude.
const BANDS: usize = 36;
const SECTORS: usize = 72;
/// Degrees between candidate places.
const APART_DEG: f64 = 5.0;
/// Minimum fraction of the variance in deviations from zonal means for a field to have a side to face.
const LEAST_VARIANCE: f64 = 1e-4;
/// Minimum ratio of the visible part of the field at a place to that at the usual one: below it the camera stays there.
const LEAST_GAIN: f64 = 1.1;
/// Fraction by which a pole counts less than the equator, as pictures with north upwards are read more easily.
const POLE: f64 = 0.3;
/// A mesh whose cells are all within this many degrees of one place is a region.
const WIDEST_REGION_DEG: f64 = 60.0;

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

    /// The place with the best view: of what is dense, or else of the field's differences from its zonal mean.
    pub fn new(survey: &Survey, look: &Look, exaggeration: f64) -> Self {
        let weights = match look.kind {
            Kind::Signed | Kind::Upper | Kind::Lower => {
                let opacity = |depth: &f64| 1.0 - (-depth / look.unit_length).exp();
                Some(look.depths(survey, exaggeration).iter().map(opacity).collect())
            }
            _ => deviations(survey),
        };
        weights.map_or(Self::DEFAULT, |weights: Vec<f64>| Self::over(survey, &weights))
    }

    fn over(survey: &Survey, weights: &[f64]) -> Self {
        let mut bins = vec![DVec3::ZERO; BANDS * SECTORS];
        for (column, weight) in survey.columns().zip(weights) {
            let direction = survey.direction(column);
            let sector = (direction.y.atan2(direction.x) / PI + 1.0) / 2.0;
            let sector = ((sector * SECTORS as f64) as usize).min(SECTORS - 1);
            bins[band(direction) * SECTORS + sector] += *weight * direction;
        }
        bins.retain(|bin| *bin != DVec3::ZERO);
        let seen = |aim: &Self| {
            let toward = unit_vector(aim.lon_deg.to_radians(), aim.lat_deg.to_radians());
            let sum: f64 = bins.iter().map(|bin| bin.dot(toward).max(0.0).powi(2) / bin.length()).sum();
            sum * (1.0 - POLE * (aim.lat_deg / 90.0).powi(2))
        };
        let (mut best, mut most) = (Self::DEFAULT, LEAST_GAIN * seen(&Self::DEFAULT));
        let steps = |end: f64| (0..=(2.0 * end / APART_DEG) as i32).map(move |i| f64::from(i) * APART_DEG - end);
        for lat_deg in steps(90.0) {
            // From the usual longitude to both sides: the nearest of equal places.
            for lon_deg in (0..=36).flat_map(|i| [f64::from(i), f64::from(-i)]).map(|i| i * APART_DEG + 0.0) {
                let aim = Aim { lon_deg, lat_deg, is_of_field: true };
                let shown = seen(&aim);
                // By more than rounding.
                if shown > most * (1.0 + 1e-3) {
                    (best, most) = (aim, shown);
                }
            }
        }
        best
    }
}

fn band(direction: DVec3) -> usize {
    let part = direction.z.clamp(-1.0, 1.0).asin() / PI + 0.5;
    ((part * BANDS as f64) as usize).min(BANDS - 1)
}

/// The squares of the differences of a column's values from their zonal means; `None` if these are almost 0.
fn deviations(survey: &Survey) -> Option<Vec<f64>> {
    let place = |column: usize| band(survey.direction(column));
    let count = survey.height.len();
    let mut means = vec![[0.0; 2]; BANDS * count];
    survey.each(|column, layer, value| {
        let [number, sum] = &mut means[place(column) * count + layer];
        (*number, *sum) = (*number + 1.0, *sum + value);
    });
    let mut variance = 0.0;
    survey.each(|_, layer, value| variance += (value - survey.means[layer]).powi(2));
    let from = |value: f64, [number, sum]: [f64; 2]| (value - sum / number).powi(2);
    let of_column = |column: usize| {
        let values = survey.shown.iter().map(|layer| (survey.value(column, *layer), *layer));
        let here = values.filter(|(value, _)| !value.is_nan());
        here.map(|(value, layer)| from(value, means[place(column) * count + layer])).sum::<f64>()
    };
    let found: Vec<f64> = survey.columns().map(of_column).collect();
    (found.iter().sum::<f64>() > LEAST_VARIANCE * variance).then_some(found)
}

/// The covered part of the sphere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Region {
    pub lon_deg: f64,
    pub lat_deg: f64,
    middle: DVec3,
    /// Width or height, planet radii, whichever is larger.
    pub across: f64,
}

impl Region {
    /// `None` if the mesh is global.
    pub fn of(sample: &Sample) -> Option<Self> {
        let cells = || sample.directions.iter().copied();
        let mut middle = cells().sum::<DVec3>().try_normalize()?;
        let least = cells().map(|cell| cell.dot(middle)).fold(1.0, f64::min);
        if least < WIDEST_REGION_DEG.to_radians().cos() {
            return None;
        }
        // Towards the middle of its bounding box, as the camera sees it.
        for _ in 0..4 {
            let [east, north] = axes(middle);
            let [[west, right], [south, top]] = [east, north].map(|axis| ends(cells().map(|cell| cell.dot(axis))));
            middle = (middle + 0.5 * (west + right) * east + 0.5 * (south + top) * north).normalize();
        }
        let width = |[low, high]: [f64; 2]| high - low;
        let across = axes(middle).map(|axis| width(ends(cells().map(|cell| cell.dot(axis)))));
        let across = across[0].max(across[1]).max(1e-6);
        let rounded = |angle: f64| to_step(angle.to_degrees(), 0.02 * across.to_degrees()) + 0.0;
        let (lon_deg, lat_deg) = (rounded(middle.y.atan2(middle.x)), rounded(middle.z.clamp(-1.0, 1.0).asin()));
        Some(Region { lon_deg, lat_deg, middle, across })
    }

    /// The distance of the camera from the planet's centre at which the region, up to radius `outer`, fills a picture
    /// with the ratio `aspect` of width to height.
    pub fn distance(&self, sample: &Sample, outer: f64, aspect: f64) -> f64 {
        let half = FILLED * (0.5 * FOV_DEG.to_radians()).tan();
        let [east, north] = axes(self.middle);
        let needed = |direction: &DVec3| {
            let aside = (direction.dot(east).abs() / aspect).max(direction.dot(north).abs());
            outer * (direction.dot(self.middle) + aside / half)
        };
        let farthest = sample.directions.iter().map(needed).fold(outer, f64::max);
        to_step(farthest, 0.02 * (farthest - outer).max(1e-6))
    }
}

/// Unit vectors to the east and to the north at a place.
fn axes(middle: DVec3) -> [DVec3; 2] {
    let east = DVec3::Z.cross(middle).try_normalize().unwrap_or(DVec3::Y);
    [east, middle.cross(east)]
}

fn ends(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)])
}
