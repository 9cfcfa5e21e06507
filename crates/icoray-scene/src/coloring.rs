//! A colour map over a range of values, with opacities: what a transfer function is made of, once the range is known.

use super::color::ColorMap;
use super::transfer::extinction_of;
use crate::transfer::{Knot, TransferFunction};
use std::fmt;

/// Maximum deviation of colour (linear, 0 to 1) and extinction (relative to the largest) between two knots. The
/// transfer function is linear in the value between knots, a logarithmic scale is not: knots are inserted where it
/// deviates by more.
const BEND: f64 = 1.0 / 255.0;

/// Along what colours are even.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Scale {
    /// The value.
    #[default]
    Linear,
    /// The logarithm of the value, which is positive.
    Log,
    /// The value up to `threshold` on either side of 0, its logarithm beyond; what lies within the threshold takes as
    /// much room on each side as a power of ten.
    SymLog {
        /// Where the logarithm begins, above 0.
        threshold: f64,
    },
}

impl Scale {
    /// Whether a value has a place on the scale.
    pub fn admits(&self, value: f64) -> bool {
        value.is_finite() && (*self != Scale::Log || value > 0.0)
    }

    /// Where a value stands: even steps of this are even steps of colour.
    pub fn forward(&self, value: f64) -> f64 {
        match *self {
            Scale::Linear => value,
            Scale::Log => value.log10(),
            Scale::SymLog { threshold } => {
                let times = value / threshold;
                if times.abs() <= 1.0 { times } else { (1.0 + times.abs().log10()).copysign(times) }
            }
        }
    }

    /// The value that stands at a place.
    pub fn backward(&self, place: f64) -> f64 {
        match *self {
            Scale::Linear => place,
            Scale::Log => 10f64.powf(place),
            Scale::SymLog { threshold } => {
                if place.abs() <= 1.0 {
                    place * threshold
                } else {
                    10f64.powf(place.abs() - 1.0).copysign(place) * threshold
                }
            }
        }
    }

    /// In a word, and the threshold.
    pub(crate) fn describe(&self) -> String {
        match self {
            Scale::Linear => "linear".into(),
            Scale::Log => "log".into(),
            Scale::SymLog { threshold } => format!("symlog beyond {threshold}"),
        }
    }
}

/// The range of values of a colour map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ColorRange {
    /// Always the same: pictures can be compared.
    Fixed([f64; 2]),
    /// Between two percentiles of the first frame that has values; from then on the same.
    Percentile([f64; 2]),
    /// Between two percentiles of all frames so far: an end that a frame leaves behind moves, and never comes back.
    Union {
        /// The percentiles of each frame.
        percentile: [f64; 2],
        /// Part of the range by which a frame may pass an end before that moves, and by which it then moves further
        /// than that frame needs: colours change seldom, not a little each step.
        hysteresis: f64,
    },
}

impl fmt::Display for ColorRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ColorRange::Fixed(_) => write!(f, "fixed"),
            ColorRange::Percentile([low, high]) => {
                write!(f, "percentiles {low} to {high} of the first frame")
            }
            ColorRange::Union { percentile: [low, high], hysteresis } => {
                write!(f, "percentiles {low} to {high} of all frames so far, hysteresis {hysteresis}")
            }
        }
    }
}

/// Opacities along the range where none are given: rising with the value, or about a centre clear there.
const DEFAULT_OPACITY: [&[(f64, f64)]; 2] = [&[(0.0, 0.0), (1.0, 0.9)], &[(0.0, 0.9), (0.5, 0.0), (1.0, 0.9)]];
/// The extinction of colours without opacity: above 0, so that no knot is dropped as invisible.
pub(super) const MEANINGLESS: f64 = 1.0;

/// The extinctions along the range where none are given.
pub(super) fn default_extinction(has_center: bool) -> Vec<Stop> {
    let stops = DEFAULT_OPACITY[usize::from(has_center)].iter();
    stops.map(|(part, opacity)| (*part, extinction_of(*opacity))).collect()
}

/// The extinction at a place: a value, or a part of the range.
pub(super) type Stop = (f64, f64);

/// A named colour map over a range, with opacities.
#[derive(Debug, Clone, PartialEq)]
pub struct Coloring {
    pub(super) map: ColorMap,
    /// The map's name, with its `_r` where it is turned round.
    pub(super) name: String,
    pub(super) scale: Scale,
    pub(super) range: ColorRange,
    /// The value that the map's middle stands at: ranges are widened to be even about it.
    pub(super) center: Option<f64>,
    /// Extinctions, rising in their places.
    pub(super) extinction: Vec<Stop>,
    /// Whether these places are parts of the range, 0 to 1 along the scale, and not values.
    pub(super) is_relative: bool,
    pub(super) unit_length: Option<f64>,
}

/// A sample of the coloring: its position on the scale, its value and its extinction.
#[derive(Clone, Copy)]
struct Sample {
    at: f64,
    value: f64,
    extinction: f64,
}

impl Coloring {
    /// Along what colours are even.
    pub fn scale(&self) -> Scale {
        self.scale
    }

    /// Over which values the map goes, as the scene says.
    pub fn range(&self) -> ColorRange {
        self.range
    }

    /// Whether the scene gives no opacity.
    pub(super) fn has_default_opacity(&self) -> bool {
        let default = default_extinction(self.center.is_some());
        self.is_relative && self.unit_length.is_none() && self.extinction == default
    }

    /// The same colours for a surface, which has an opacity of its own.
    pub(super) fn without_opacity(self) -> Self {
        Coloring { is_relative: true, extinction: vec![(0.0, MEANINGLESS)], unit_length: None, ..self }
    }

    /// Whether values have the same colours as in another, for any opacities.
    pub fn has_colors_of(&self, other: &Coloring) -> bool {
        let colors = |c: &Coloring| (c.map.clone(), c.scale, c.range, c.center);
        colors(self) == colors(other)
    }

    /// The ends of a fixed range, even about the centre where there is one.
    pub fn fixed(&self) -> Option<[f64; 2]> {
        if let ColorRange::Fixed(ends) = self.range { Some(self.about_center(ends)) } else { None }
    }

    /// A placeholder range, used until the range is known.
    pub fn unknown(&self) -> [f64; 2] {
        self.about_center(if self.scale == Scale::Log { [1.0, 10.0] } else { [0.0, 1.0] })
    }

    /// Map, scale and range in words.
    pub fn describe(&self) -> String {
        let center = self.center.map_or_else(String::new, |center| format!(", centred on {center}"));
        format!("{}, {}{center}, {}", self.name, self.scale.describe(), self.range)
    }

    /// A range, widened to be even about the centre where there is one.
    pub fn about_center(&self, ends: [f64; 2]) -> [f64; 2] {
        let Some(center) = self.center else { return ends };
        let middle = self.scale.forward(center);
        let [low, high] = ends.map(|end| self.scale.forward(end) - middle);
        let half = low.abs().max(high.abs());
        // An end that stays is not converted back, which would round it.
        [
            if half == -low { ends[0] } else { self.scale.backward(middle - half) },
            if half == high { ends[1] } else { self.scale.backward(middle + half) },
        ]
    }

    /// The transfer function over a range whose ends the scale admits, the lower first.
    ///
    /// Colour knots where nothing is to be seen are left out.
    pub fn transfer(&self, range: [f64; 2]) -> TransferFunction {
        let ends = range.map(|end| self.scale.forward(end));
        let along = |part: f64| ends[0] + (ends[1] - ends[0]) * part;
        let extinction: Vec<Stop> = match self.is_relative {
            true => self.extinction.iter().map(|(part, e)| (along(*part), *e)).collect(),
            false => self.extinction.iter().map(|(value, e)| (self.scale.forward(*value), *e)).collect(),
        };
        let color_at = |at: f64| self.map.at((at - ends[0]) / (ends[1] - ends[0]));
        let places = self.places(&extinction, along);
        let largest = extinction.iter().fold(f64::MIN_POSITIVE, |largest, (_, e)| largest.max(*e));
        let mut knots: Vec<Knot> = Vec::new();
        let knot = |p: &Sample| Knot { value: p.value, color: color_at(p.at), extinction: p.extinction };
        for (i, place) in places.iter().enumerate() {
            knots.push(knot(place));
            if let (Some(next), false) = (places.get(i + 1), self.scale == Scale::Linear) {
                let bends = |a: &Sample, b: &Sample| self.bend(a, b, &color_at, largest) > BEND;
                between(&self.scale, place, next, &bends, &mut |p| knots.push(knot(p)));
            }
        }
        TransferFunction { knots, unit_length: self.unit_length }
    }

    /// The stops of opacity, and those of the map where something is to be seen.
    fn places(&self, extinction: &[Stop], along: impl Fn(f64) -> f64) -> Vec<Sample> {
        let place = |at: f64, extinction: f64| Sample { at, value: self.scale.backward(at), extinction };
        let (first, last) = (extinction[0], extinction[extinction.len() - 1]);
        let near = 1e-9 * (along(1.0) - along(0.0));
        let all = self.stops(&along, near);
        let stops = |low: f64, high: f64| all.iter().copied().filter(move |at| low + near < *at && *at < high - near);
        let mut places = Vec::new();
        if first.1 > 0.0 {
            places.extend(stops(f64::NEG_INFINITY, first.0).map(|at| place(at, first.1)));
        }
        places.push(place(first.0, first.1));
        for pair in extinction.windows(2) {
            let ((low, from), (high, to)) = (pair[0], pair[1]);
            if from > 0.0 || to > 0.0 {
                let extinction = |at: f64| from + (to - from) * (at - low) / (high - low);
                places.extend(stops(low, high).map(|at| place(at, extinction(at))));
            }
            places.push(place(high, to));
        }
        if last.1 > 0.0 {
            places.extend(stops(last.0, f64::INFINITY).map(|at| place(at, last.1)));
        }
        places
    }

    /// Where colours bend: the map's stops, and the scale's own. Two knots that only rounding keeps apart would be a
    /// step to the kernel.
    fn stops(&self, along: impl Fn(f64) -> f64, near: f64) -> Vec<f64> {
        let mut stops: Vec<f64> = self.map.places().map(&along).collect();
        if matches!(self.scale, Scale::SymLog { .. }) {
            let ends = [along(0.0), along(1.0)];
            stops.extend([-1.0, 1.0].into_iter().filter(|at| ends[0] < *at && *at < ends[1]));
            stops.sort_by(f64::total_cmp);
            stops.dedup_by(|b, a| *b - *a < near);
        }
        stops
    }

    /// How far a straight line in the value between two places leaves the scale.
    fn bend(&self, a: &Sample, b: &Sample, color_at: &impl Fn(f64) -> [f64; 3], largest: f64) -> f64 {
        if a.extinction == 0.0 && b.extinction == 0.0 || b.value <= a.value {
            return 0.0;
        }
        const SAMPLES: i32 = 16;
        let deviations = (1..SAMPLES).map(|i| {
            let part = f64::from(i) / f64::from(SAMPLES);
            let value = self.scale.backward(a.at + (b.at - a.at) * part);
            ((value - a.value) / (b.value - a.value) - part).abs()
        });
        let [one, other] = [a, b].map(|p| color_at(p.at));
        let turn = (0..3).map(|k| (other[k] - one[k]).abs()).fold(0.0, f64::max);
        deviations.fold(0.0, f64::max) * turn.max((b.extinction - a.extinction).abs() / largest)
    }
}

/// Halves what lies between two places until it does not bend.
fn between(
    scale: &Scale,
    a: &Sample,
    b: &Sample,
    bends: &impl Fn(&Sample, &Sample) -> bool,
    give: &mut impl FnMut(&Sample),
) {
    if !bends(a, b) {
        return;
    }
    let at = 0.5 * (a.at + b.at);
    let middle = Sample { at, value: scale.backward(at), extinction: 0.5 * (a.extinction + b.extinction) };
    // Where rounding leaves no value in between there is nothing to halve.
    if a.value < middle.value && middle.value < b.value {
        between(scale, a, &middle, bends, give);
        give(&middle);
        between(scale, &middle, b, bends, give);
    }
}

#[cfg(test)]
mod tests;
