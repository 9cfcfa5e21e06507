//! Coasts and borders of countries: Natural Earth's at 1:110 million, or at 1:50 million for near pictures; and lines of
//! files. All are straight in longitude and latitude from point to point.
//!
//! Whether a place is land follows from the number of lines north of it on its meridian, as the North Pole is sea; so
//! neither the longitude at which polygons are cut nor the South Pole need edges of their own. For distances the lines
//! are cut into pieces that great circles follow to within 0.0003 degrees, and sorted into bins.

use super::screen_jacobian::{ScreenJacobian, View};
use glam::DVec3;
use icoray_grid::grid::unit_vector;
use icoray_scene::Outlines;
use std::f64::consts::FRAC_PI_2;
use std::ops::RangeInclusive;
use std::sync::{Arc, Mutex, OnceLock, PoisonError, Weak};

/// Runs of points, written by `data/outlines.py`, at 1:110 million and at 1:50 million.
pub(super) static COASTS: [&[u8]; 2] =
    [include_bytes!("../../data/land-110m.bin"), include_bytes!("../../data/land-50m.bin")];
/// The same of the borders between countries.
pub(super) static BORDERS: [&[u8]; 2] =
    [include_bytes!("../../data/borders-110m.bin"), include_bytes!("../../data/borders-50m.bin")];

/// The coasts at 1:110 million: runs of points, each of 16-bit numbers, their count first, then longitude and latitude of
/// each in steps of 1/180 degree, all of them little-endian.
pub fn coast_runs() -> &'static [u8] {
    COASTS[0]
}

/// Size of a pixel, degrees, below which lines have the larger scale.
const NEAR_DEG: f64 = 0.06;

/// Steps per degree in the encoding.
const STEPS: f64 = 180.0;

/// Number of strips of longitude.
const STRIPS: usize = 360;

/// Side of a bin in degrees, and numbers of bins from west to east and from south to north.
const BIN: f64 = 2.0;
const BINS: [usize; 2] = [180, 90];

/// From one longitude and latitude, in degrees, to another.
pub(super) type Segment = [[f64; 2]; 2];

/// Coasts, borders, or lines of a file, sorted by place.
#[derive(Debug)]
pub(super) struct LineMap {
    /// The lines over each degree of longitude.
    strips: Vec<Vec<Segment>>,
    /// The ends of pieces of lines in each bin.
    bins: Vec<Vec<[DVec3; 2]>>,
}

impl LineMap {
    /// The coasts of the Earth for a camera, sorted at the first request.
    pub fn of_coasts(view: &View) -> Arc<Self> {
        static SORTED: [OnceLock<Arc<LineMap>>; 2] = [OnceLock::new(), OnceLock::new()];
        Self::at_scale_of(view, COASTS, &SORTED)
    }

    /// The borders between countries for a camera, sorted at the first request.
    pub fn of_borders(view: &View) -> Arc<Self> {
        static SORTED: [OnceLock<Arc<LineMap>>; 2] = [OnceLock::new(), OnceLock::new()];
        Self::at_scale_of(view, BORDERS, &SORTED)
    }

    fn at_scale_of(view: &View, runs: [&[u8]; 2], sorted: &[OnceLock<Arc<Self>>; 2]) -> Arc<Self> {
        let scale = scale(view);
        Arc::clone(sorted[scale].get_or_init(|| Arc::new(Self::new(&segments(runs[scale])))))
    }

    /// The lines of a file, sorted once while it is in use.
    pub fn of_outlines(outlines: &Arc<Outlines>) -> Arc<Self> {
        static SORTED: Mutex<Vec<(Weak<Outlines>, Arc<LineMap>)>> = Mutex::new(Vec::new());
        let mut sorted = SORTED.lock().unwrap_or_else(PoisonError::into_inner);
        sorted.retain(|(of, _)| of.strong_count() > 0);
        if let Some((_, map)) = sorted.iter().find(|(of, _)| of.as_ptr() == Arc::as_ptr(outlines)) {
            return Arc::clone(map);
        }
        let pairs = outlines.runs().iter().flat_map(|run| run.windows(2));
        let map = Arc::new(LineMap::new(&pairs.map(|pair| [pair[0], pair[1]]).collect::<Vec<_>>()));
        sorted.push((Arc::downgrade(outlines), Arc::clone(&map)));
        map
    }

    fn new(segments: &[Segment]) -> Self {
        let mut strips = vec![Vec::new(); STRIPS];
        let mut bins = vec![Vec::new(); BINS[0] * BINS[1]];
        for segment in segments {
            for strip in range(segment.map(|end| end[0] + 180.0), 1.0, STRIPS) {
                strips[strip].push(*segment);
            }
            for piece in pieces(segment) {
                let ends = piece.map(|[lon, lat]| unit_vector(lon.to_radians(), lat.to_radians()));
                for row in rows(piece.map(|end| end[1])) {
                    for column in columns(piece.map(|end| end[0])) {
                        bins[row * BINS[0] + column].push(ends);
                    }
                }
            }
        }
        LineMap { strips, bins }
    }

    /// Whether there is land, if these are coasts, at a longitude of -180 to 180 and a latitude, in degrees.
    pub fn is_land(&self, lon: f64, lat: f64) -> bool {
        let lon = if lon >= 180.0 { lon - 360.0 } else { lon };
        let strip = ((lon + 180.0) as usize).min(STRIPS - 1);
        let is_north = |segment: &&Segment| {
            let [[x0, y0], [x1, y1]] = **segment;
            // A point that two lines share counts for one of them.
            (x0 <= lon) != (x1 <= lon) && y0 + (y1 - y0) * ((lon - x0) / (x1 - x0)) > lat
        };
        self.strips[strip].iter().filter(is_north).count() % 2 == 1
    }

    /// Pixels to the nearest line if they are fewer than `reach`, and if `reach` pixels are no more than `widest`
    /// degrees.
    pub fn distance(&self, jacobian: &ScreenJacobian, reach: f64, widest: f64) -> Option<f64> {
        let around = reach / jacobian.min_stretch();
        if around > widest.to_radians() {
            return None;
        }
        let [lon, lat] = jacobian.place;
        // Half the range of longitudes of a circle of that radius; all longitudes if it contains a pole.
        let aside = if lat.abs() + around < FRAC_PI_2 { (around.sin() / lat.cos()).asin() } else { 4.0 };
        let about = |middle: f64, by: f64| [(middle - by).to_degrees(), (middle + by).to_degrees()];
        let mut nearest = f64::INFINITY;
        for row in rows(about(lat, around)) {
            for column in columns(about(lon, aside)) {
                let bin = &self.bins[row * BINS[0] + column];
                nearest = bin.iter().map(|[from, to]| jacobian.distance(*from, *to)).fold(nearest, f64::min);
            }
        }
        (nearest < reach).then_some(nearest)
    }
}

/// The numbers of the `parts`, each `width` wide from 0 on, that contain two places, and of those between them.
fn range(ends: [f64; 2], width: f64, parts: usize) -> RangeInclusive<usize> {
    let part = |place: f64| ((place / width) as usize).min(parts - 1);
    part(ends[0].min(ends[1]))..=part(ends[0].max(ends[1]))
}

fn rows(lat: [f64; 2]) -> RangeInclusive<usize> {
    range(lat.map(|lat| lat + 90.0), BIN, BINS[1])
}

/// Columns between two longitudes, which may lie beyond -180 and 180.
fn columns([a, b]: [f64; 2]) -> impl Iterator<Item = usize> {
    let column = |lon: f64| ((lon + 180.0) / BIN).floor() as i64;
    let (west, east) = (column(a.min(b)), column(a.max(b)));
    let count = BINS[0] as i64;
    (west..=east.min(west + count - 1)).map(move |column| column.rem_euclid(count) as usize)
}

/// The number of the scale for a camera, in [`COASTS`] and [`BORDERS`].
pub(super) fn scale(view: &View) -> usize {
    usize::from(view.least_pixel().to_degrees() < NEAR_DEG)
}

/// The lines of encoded runs of points.
pub(super) fn segments(runs: &[u8]) -> Vec<Segment> {
    let mut rest = runs;
    let mut segments = Vec::new();
    while let Some((count, points)) = rest.split_first_chunk::<2>() {
        let (points, others) = points.split_at(4 * usize::from(u16::from_le_bytes(*count)));
        let points = points
            .as_chunks::<4>()
            .0
            .iter()
            .map(|[a, b, c, d]| [[*a, *b], [*c, *d]].map(|number| f64::from(i16::from_le_bytes(number)) / STEPS));
        let points: Vec<[f64; 2]> = points.collect();
        segments.extend(points.windows(2).map(|pair| [pair[0], pair[1]]));
        rest = others;
    }
    segments
}

/// A line in pieces of at most half a degree of longitude and a degree of latitude.
fn pieces([from, to]: &Segment) -> impl Iterator<Item = Segment> {
    let [x, y] = [to[0] - from[0], to[1] - from[1]];
    let count = (2.0 * x.abs()).max(y.abs()).ceil().max(1.0);
    let [u, v] = *from;
    let at = move |i: f64| [u + x * (i / count), v + y * (i / count)];
    (0..count as usize).map(move |i| [at(i as f64), at(i as f64 + 1.0)])
}

#[cfg(test)]
mod tests;
