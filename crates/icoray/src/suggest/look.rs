//! The transfer function.

use super::Options;
use super::numbers::{round, to_step};
use super::shells::{Shell, shells};
use super::survey::Survey;

/// How a field is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// All values are the same.
    Constant,
    /// Both signs: the tails of the magnitude.
    Signed,
    /// Thin shells.
    Stratified,
    /// The upper end.
    UpperTail,
    /// The lower end.
    LowerTail,
    /// Both ends, and a little of what is between.
    Whole,
    /// All values, on a surface.
    Surface,
}

/// Colour map, range and opacities.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Look {
    pub kind: Kind,
    pub map: String,
    pub range: [f64; 2],
    /// Values with the opacity of a unit length.
    pub opacity: Vec<(f64, f64)>,
    /// Planet radii after exaggeration.
    pub unit_length: f64,
    /// A value to so much is as good as the value itself.
    pub step: f64,
}

/// A field has both signs where one end is at least this part of the other.
const BOTH_SIGNS: f64 = 0.2;
/// Part of the variance that lies between layers from which a field is stratified.
const STRATIFIED: f64 = 0.5;
/// How many times longer than the other a tail is that is shown alone.
const ONE_TAIL: f64 = 3.0;
/// Planet radii after exaggeration that have the opacities of a volume: part of the shell's thickness.
const UNIT_LENGTH: f64 = 0.04;
/// Thickness of a shell in planet radii after exaggeration, where its neighbours leave it room.
const SHELL: f64 = 0.006;
/// Unit length of opacities, of a shell's thickness.
const UNIT_PER_SHELL: f64 = 1.2;

/// The opacity of a shell over its value.
#[derive(Debug, Clone, Copy)]
struct Peak {
    value: f64,
    /// Half the width in the value.
    half: f64,
    dense: f64,
    gradient: f64,
}

impl Peak {
    fn new(shell: &Shell, dense: f64, exaggeration: f64) -> Self {
        let Shell { value, gradient } = *shell;
        Peak { value, half: 0.5 * gradient * SHELL / exaggeration, dense, gradient }
    }

    /// Planet radii after exaggeration.
    fn thickness(&self, exaggeration: f64) -> f64 {
        2.0 * self.half / self.gradient * exaggeration
    }

    fn stops(&self) -> [(f64, f64); 3] {
        [(self.value - self.half, 0.0), (self.value, self.dense), (self.value + self.half, 0.0)]
    }
}

impl Look {
    pub fn new(survey: &Survey, exaggeration: f64, options: &Options) -> Self {
        let (kind, shells) = match (kind(survey), options.surface) {
            ((Kind::UpperTail | Kind::LowerTail | Kind::Whole, _), Some(_)) => (Kind::Surface, Vec::new()),
            (found, _) => found,
        };
        let map = options.color_map.clone().unwrap_or_else(|| kind.map().to_owned());
        let mut look = Look { kind, map, range: [0.0; 2], opacity: Vec::new(), unit_length: UNIT_LENGTH, step: 0.0 };
        let p = |percent: f64| survey.percentile(percent);
        match kind {
            Kind::Constant => look.be_constant(p(50.0)),
            Kind::Signed => look.be_signed(survey),
            Kind::Stratified => look.be_shells(&shells, exaggeration),
            Kind::UpperTail => {
                look.ends(p(50.0), p(99.8));
                look.opacity = vec![(p(60.0), 0.0), (p(90.0), 0.25), (p(99.5), 0.9)];
            }
            Kind::LowerTail => {
                look.ends(p(0.2), p(50.0));
                look.opacity = vec![(p(0.5), 0.9), (p(10.0), 0.25), (p(40.0), 0.0)];
            }
            Kind::Surface => look.ends(p(0.5), p(99.5)),
            Kind::Whole => {
                look.ends(p(0.5), p(99.5));
                look.opacity = vec![(p(1.0), 0.9), (p(30.0), 0.5), (p(70.0), 0.5), (p(99.0), 0.9)];
            }
        }
        match options.range {
            Some(range) => look.stretch(range),
            None => look.range = look.range.map(|end| to_step(end, look.step)),
        }
        look.tidy();
        look
    }

    fn ends(&mut self, low: f64, high: f64) {
        (self.range, self.step) = ([low, high], (high - low) / 300.0);
    }

    fn be_constant(&mut self, value: f64) {
        let half = if value == 0.0 { 1.0 } else { 0.1 * value.abs() };
        self.ends(value - half, value + half);
        self.opacity = vec![(value, 0.5)];
    }

    fn be_signed(&mut self, survey: &Survey) {
        let [most, full] = survey.percentiles_of_magnitude([88.0, 99.7]);
        let clear = most.max(0.3 * full).min(0.8 * full);
        let half = clear + 0.4 * (full - clear);
        self.ends(-full, full);
        self.opacity = vec![(-full, 0.95), (-half, 0.6), (-clear, 0.0), (clear, 0.0), (half, 0.6), (full, 0.95)];
    }

    /// Opacities in peaks, the smallest dome the densest.
    fn be_shells(&mut self, shells: &[Shell], exaggeration: f64) {
        const DENSE: [f64; 3] = [0.95, 0.7, 0.3];
        let mut peaks: Vec<Peak> = shells.iter().zip(DENSE).map(|(s, d)| Peak::new(s, d, exaggeration)).collect();
        peaks.sort_by(|a, b| a.value.total_cmp(&b.value));
        for i in 1..peaks.len() {
            // Peaks are apart.
            let room = 0.3 * (peaks[i].value - peaks[i - 1].value);
            peaks[i - 1].half = peaks[i - 1].half.min(room);
            peaks[i].half = peaks[i].half.min(room);
        }
        let (first, last) = (peaks[0], peaks[peaks.len() - 1]);
        let edge = 0.15 * (last.value - first.value) + first.half.max(last.half);
        self.ends(first.value - edge, last.value + edge);
        let least = peaks.iter().map(|peak| peak.half).fold(f64::INFINITY, f64::min);
        self.step = self.step.min(0.1 * least);
        let thickest = peaks.iter().map(|peak| peak.thickness(exaggeration)).fold(0.0, f64::max);
        self.unit_length = round(UNIT_PER_SHELL * thickest);
        self.opacity = peaks.iter().flat_map(Peak::stops).collect();
    }

    /// Takes the caller's range; opacities stretch with it.
    fn stretch(&mut self, range: [f64; 2]) {
        let times = (range[1] - range[0]) / (self.range[1] - self.range[0]);
        self.opacity.iter_mut().for_each(|(value, _)| *value = range[0] + times * (*value - self.range[0]));
        self.step *= times;
        self.range = range;
    }

    /// Rounds the values of opacities, which must rise.
    fn tidy(&mut self) {
        let step = self.step;
        self.opacity.iter_mut().for_each(|(value, _)| *value = to_step(*value, step));
        self.opacity.dedup_by(|b, a| b.0 <= a.0);
    }
}

impl Kind {
    fn map(self) -> &'static str {
        match self {
            Kind::Signed => "vik",
            Kind::Whole | Kind::Stratified => "rdylbu_r",
            _ => "viridis",
        }
    }

    /// In words, for the text's comment.
    pub fn describe(self) -> &'static str {
        match self {
            Kind::Constant => "all values are the same",
            Kind::Signed => "both signs: the strongest values of either, clear around 0",
            Kind::Stratified => "stratified: thin shells, domes that end at the ground",
            Kind::UpperTail => "a long upper tail: the highest values",
            Kind::LowerTail => "a long lower tail: the lowest values",
            Kind::Surface => "all values",
            Kind::Whole => "no long tail: dense at both ends, translucent between",
        }
    }
}

/// The kind of a field, and the shells of a stratified one.
fn kind(survey: &Survey) -> (Kind, Vec<Shell>) {
    let [low, middle, high] = [1.0, 50.0, 99.0].map(|p| survey.percentile(p));
    if survey.percentile(0.0) == survey.percentile(100.0) {
        return (Kind::Constant, Vec::new());
    }
    if survey.stratified >= STRATIFIED && survey.shown.len() > 2 {
        let shells = shells(survey);
        if shells.len() > 1 {
            return (Kind::Stratified, shells);
        }
    }
    let has_both = low < 0.0 && 0.0 < high && (-low).min(high) >= BOTH_SIGNS * (-low).max(high);
    let kind = match (high - middle, middle - low) {
        _ if has_both => Kind::Signed,
        (up, down) if up > ONE_TAIL * down => Kind::UpperTail,
        (up, down) if down > ONE_TAIL * up => Kind::LowerTail,
        _ => Kind::Whole,
    };
    (kind, Vec::new())
}
