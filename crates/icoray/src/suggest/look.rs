//! Chooses the transfer function.

use super::Options;
use super::numbers::{round, to_step};
use super::shells::{Shell, shells};
use super::survey::{Survey, of};
use icoray_scene::Scale;

/// The way to show a field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// All values are equal.
    Constant,
    /// Both signs: shows the tails of the magnitude.
    Signed,
    /// Shows thin shells.
    Stratified,
    /// Shows all values, behind a cut, as each layer has one value.
    Layered,
    /// Shows the upper end.
    Upper,
    /// Shows the lower end.
    Lower,
    /// Shows all values on a surface; `is_signed` if they have both signs.
    Surface { is_signed: bool },
}

/// Colour map, range and opacities.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Look {
    pub kind: Kind,
    /// Whether the values are differences from the mean of their layer.
    pub is_of_anomaly: bool,
    pub map: String,
    pub scale: Scale,
    pub range: [f64; 2],
    /// Values with the opacity of a unit length.
    pub opacity: Vec<(f64, f64)>,
    /// In planet radii after exaggeration.
    pub unit_length: f64,
    /// Whether a sector is cut away, as otherwise the inside would be hidden.
    pub is_cut: bool,
    /// Precision to which values are rounded.
    step: f64,
}

/// Values count as equal if they differ by less, as a fraction of the largest: a few times the resolution of f32.
const SAME: f64 = 1e-6;
/// A field has both signs if one end is at least this fraction of the other.
const BOTH_SIGNS: f64 = 0.2;
/// Minimum fraction of the variance between layers for a field to be stratified.
const STRATIFIED: f64 = 0.5;
/// Minimum difference between two shells, as a fraction of the range of all values.
const SHELLS_APART: f64 = 0.02;
/// Percentiles are ends of the range if they leave this fraction of it; otherwise few values differ from the others.
const LEAST_RANGE: f64 = 0.02;
/// Percent of the columns in which a tail is visible.
const SEEN: f64 = 30.0;
/// Fraction of these columns that may be beyond the range.
const BEYOND: f64 = 0.1;
/// Limits of the place from which a tail is visible, between its base (0) and its dense end (1).
const CLEAR: [f64; 2] = [0.15, 0.8];
/// Optical depth of the columns with much of the tail.
const DEPTH: f64 = 1.5;
/// Maximum fraction of dense columns without cutting a sector away.
const MOST_DENSE: f64 = 0.6;
/// Ratio of the largest value to the least, and to the median, for which the scale is logarithmic.
const DECADES: std::ops::Range<f64> = 1e3..1e12;
const SKEWED: f64 = 50.0;
/// Minimum fraction of the largest value that the middle half of the values spans on a linear scale.
const EVEN: f64 = 0.1;
/// Length, in planet radii after exaggeration, that has the opacities of a volume: a fraction of the shell's thickness.
const UNIT_LENGTH: f64 = 0.04;
/// Limits of unit lengths that follow from a measured depth.
const UNIT_LENGTHS: [f64; 2] = [1e-5, 1.0];
/// Thickness of a shell in planet radii after exaggeration, if its neighbours leave room for it.
const SHELL: f64 = 0.006;
/// Unit length of opacities, as a fraction of a shell's thickness.
const UNIT_PER_SHELL: f64 = 1.2;
/// Smallest magnitude in scenes.
const TINY: f64 = 1e-280;

/// The opacity of a shell over its value.
#[derive(Debug, Clone, Copy)]
struct Peak {
    value: f64,
    /// Half of the width, in units of the value.
    half: f64,
    dense: f64,
    gradient: f64,
}

impl Look {
    pub fn new(survey: &Survey, exaggeration: f64, options: &Options) -> Self {
        let (kind, shells) = kind(survey, options.surface.is_some());
        if kind == Kind::Layered
            && options.range.is_none()
            && !options.is_underived
            && options.isosurface.is_none()
            && let Some(anomaly) = survey.anomaly().filter(|anomaly| largest(anomaly) > 10.0 * SAME * largest(survey))
        {
            return Look { is_of_anomaly: true, ..Look::new(&anomaly, exaggeration, options) };
        }
        let map = options.color_map.clone().unwrap_or_else(|| kind.map().to_owned());
        let takes_decades = matches!(kind, Kind::Upper | Kind::Surface { is_signed: false });
        let is_log = takes_decades && !options.is_length && has_decades(survey);
        let scale = if is_log { Scale::Log } else { Scale::Linear };
        let mut look = Look {
            kind,
            is_of_anomaly: false,
            map,
            scale,
            range: [0.0; 2],
            opacity: Vec::new(),
            unit_length: UNIT_LENGTH,
            is_cut: kind == Kind::Layered,
            step: 0.0,
        };
        match kind {
            Kind::Constant => look.be_constant(survey, exaggeration),
            Kind::Stratified => look.be_shells(&shells, exaggeration),
            Kind::Signed | Kind::Upper | Kind::Lower => look.be_tail(survey, exaggeration),
            Kind::Surface { .. } => look.be_surface(survey),
            Kind::Layered => {
                look.ends(survey.percentile(0.5), survey.percentile(99.5));
                look.opacity = vec![(look.range[0], 0.9), (look.range[1], 0.9)];
            }
        }
        match options.range {
            Some(range) => look.stretch(range),
            None => look.range = look.range.map(|end| look.rounded(end)),
        }
        look.is_cut &= options.isosurface.is_none();
        // Opacities are at rounded values, which must rise.
        let mut stops = std::mem::take(&mut look.opacity);
        stops.iter_mut().for_each(|(value, _)| *value = look.rounded(*value));
        stops.dedup_by(|b, a| b.0 <= a.0);
        Look { opacity: stops, ..look }
    }

    fn ends(&mut self, low: f64, high: f64) {
        (self.range, self.step) = ([low, high], (high - low) / 300.0);
    }

    fn be_constant(&mut self, survey: &Survey, exaggeration: f64) {
        let value = survey.percentile(50.0);
        let half = if value.abs() < TINY { 1.0 } else { 0.1 * value.abs() };
        self.ends(value - half, value + half);
        self.opacity = vec![(value, 0.5)];
        let [low, high] = [f64::min, f64::max].map(|end| survey.height.iter().copied().reduce(end).unwrap_or(0.0));
        self.unit_length = round((exaggeration * (high - low)).clamp(UNIT_LENGTHS[0], UNIT_LENGTHS[1]));
    }

    fn be_surface(&mut self, survey: &Survey) {
        let values = if self.scale == Scale::Log { survey.positive() } else { &[] };
        let [low, high] = match values {
            [] => ends(survey, 0.5),
            values => [of(values, 1.0), of(values, 99.5)],
        };
        match self.kind {
            Kind::Constant => (),
            Kind::Surface { is_signed: true } => self.ends(-high.max(-low), high.max(-low)),
            _ => self.ends(low, high),
        }
    }

    /// Shows the values that only some of the columns reach.
    fn be_tail(&mut self, survey: &Survey, exaggeration: f64) {
        let (kind, scale) = (self.kind, self.scale);
        let sign = if kind == Kind::Lower { -1.0 } else { 1.0 };
        let measure = |value: f64| match kind {
            Kind::Signed => value.abs(),
            _ if scale.admits(value) => scale.forward(sign * value),
            _ => f64::NAN,
        };
        let [values, columns] = survey.measured(measure);
        let base = match (kind, scale) {
            (Kind::Signed, _) => 0.0,
            (_, Scale::Log) => of(&values, 1.0),
            _ => of(&values, 50.0),
        };
        let most = columns[columns.len() - 1];
        // Few columns may differ from the others.
        let differ = columns.len() - columns.partition_point(|place| *place <= base + LEAST_RANGE * (most - base));
        let share = SEEN.min(100.0 * differ as f64 / columns.len() as f64);
        let usual = of(&values, 99.7).max(of(&columns, 100.0 - BEYOND * share));
        let full = if usual - base > LEAST_RANGE * (most - base) { usual } else { most };
        let [least, clearest] = CLEAR.map(|part| base + part * (full - base));
        let clear = of(&columns, 100.0 - share).clamp(least, clearest);
        let value = |place: f64| if scale == Scale::Log { scale.backward(place) } else { sign * place };
        let along = [0.0, 0.35, 0.7, 1.0].map(|part| value(clear + part * (full - clear)));
        let rising: Vec<(f64, f64)> = along.into_iter().zip([0.0, 0.3, 0.65, 0.95]).collect();
        let falling = rising.iter().rev().map(|(value, opacity)| (-value, *opacity));
        self.opacity = match kind {
            Kind::Signed => falling.chain(rising.iter().copied()).collect(),
            Kind::Lower => rising.iter().rev().copied().collect(),
            _ => rising,
        };
        match kind {
            Kind::Signed => self.ends(-full, full),
            Kind::Lower => self.ends(value(full), value(base)),
            _ => self.ends(value(base), value(full)),
        }
        self.step = self.step.min((full - clear) / 30.0);
        let depths = self.depths(survey, exaggeration);
        let mut seen: Vec<f64> = depths.iter().copied().filter(|depth| *depth > 0.0).collect();
        seen.sort_unstable_by(f64::total_cmp);
        if !seen.is_empty() {
            self.unit_length = round((of(&seen, 80.0) / DEPTH).clamp(UNIT_LENGTHS[0], UNIT_LENGTHS[1]));
        }
        let dense = seen.iter().filter(|depth| **depth > self.unit_length).count();
        self.is_cut = dense as f64 > MOST_DENSE * depths.len() as f64;
    }

    /// Optical depth of each column, times the unit length.
    pub fn depths(&self, survey: &Survey, exaggeration: f64) -> Vec<f64> {
        const STEPS: usize = 4;
        let mut layers = survey.shown.clone();
        layers.sort_by(|a, b| survey.height[*a].total_cmp(&survey.height[*b]));
        let depth = |column: usize| {
            let between = |pair: &[usize]| {
                let [low, high] = [pair[0], pair[1]].map(|layer| survey.value(column, layer));
                let part = |i: usize| (i as f64 + 0.5) / STEPS as f64;
                let sum: f64 = (0..STEPS).map(|i| self.extinction(low + part(i) * (high - low))).sum();
                let thickness = survey.height[pair[1]] - survey.height[pair[0]];
                if low.is_nan() || high.is_nan() { 0.0 } else { sum / STEPS as f64 * thickness * exaggeration }
            };
            layers.windows(2).map(between).sum()
        };
        survey.columns().map(depth).collect()
    }

    /// Optical depth of a unit length at a value.
    fn extinction(&self, value: f64) -> f64 {
        let of = |opacity: f64| -(-opacity).ln_1p();
        let above = self.opacity.partition_point(|(stop, _)| *stop <= value);
        match (above.checked_sub(1).map(|i| self.opacity[i]), self.opacity.get(above)) {
            (Some((low, from)), Some((high, to))) => of(from) + (value - low) / (high - low) * (of(*to) - of(from)),
            (Some((_, end)), None) | (None, Some(&(_, end))) => of(end),
            (None, None) => 0.0,
        }
    }

    /// Places opacities in peaks; the smallest dome is the densest.
    fn be_shells(&mut self, shells: &[Shell], exaggeration: f64) {
        const DENSE: [f64; 2] = [0.95, 0.35];
        let peak = |(&Shell { value, gradient }, dense)| {
            let half = 0.5 * gradient * SHELL / exaggeration;
            Peak { value, half, dense, gradient }
        };
        let mut peaks: Vec<Peak> = shells.iter().zip(DENSE).map(peak).collect();
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
        // In planet radii after exaggeration.
        let thickness = |peak: &Peak| 2.0 * peak.half / peak.gradient * exaggeration;
        let thickest = peaks.iter().map(thickness).fold(0.0, f64::max);
        self.unit_length = round((UNIT_PER_SHELL * thickest).clamp(UNIT_LENGTHS[0], UNIT_LENGTHS[1]));
        let stops = |p: &Peak| [(p.value - p.half, 0.0), (p.value, p.dense), (p.value + p.half, 0.0)];
        self.opacity = peaks.iter().flat_map(stops).collect();
    }

    /// Uses the caller's range; opacities stretch with it.
    fn stretch(&mut self, range: [f64; 2]) {
        // Values of both signs have no logarithm.
        self.scale = if range[0] > 0.0 { self.scale } else { Scale::Linear };
        let times = (range[1] - range[0]) / (self.range[1] - self.range[0]);
        self.opacity.iter_mut().for_each(|(value, _)| *value = range[0] + times * (*value - self.range[0]));
        self.step *= times;
        self.range = range;
    }

    fn rounded(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Log => to_step(value, 0.03 * value),
            _ => to_step(value, self.step),
        }
    }
}

impl Kind {
    /// A map whose dense colours stand out from dark ground.
    fn map(self) -> &'static str {
        match self {
            Kind::Signed | Kind::Surface { is_signed: true } => "coolwarm_bright",
            Kind::Lower => "viridis_bright_r",
            // A shell seen through another one has a hue between theirs, which is on the map.
            Kind::Stratified => "plasma_bright",
            _ => "viridis_bright",
        }
    }

    /// A description for the text's comment.
    pub fn describe(self) -> &'static str {
        match self {
            Kind::Constant => "all values are the same",
            Kind::Signed => "both signs: the strongest values of either, clear around 0",
            Kind::Stratified => "stratified: two thin shells, domes that end at the ground",
            Kind::Layered => "stratified: layers of one value each, behind a cut",
            Kind::Upper => "the highest values",
            Kind::Lower => "the lowest values",
            Kind::Surface { .. } => "all values",
        }
    }
}

/// The largest magnitude.
fn largest(survey: &Survey) -> f64 {
    let [low, high] = survey.ends();
    high.max(-low)
}

/// The range without `percent` of the values at each end, or with them if few values differ from the others.
fn ends(survey: &Survey, percent: f64) -> [f64; 2] {
    let ([least, most], found) = (survey.ends(), [percent, 100.0 - percent].map(|p| survey.percentile(p)));
    if found[1] - found[0] > LEAST_RANGE * (most - least) { found } else { [least, most] }
}

/// Whether the values span decades instead of reaching 0.
fn has_decades(survey: &Survey) -> bool {
    let values = survey.positive();
    let Some(high) = values.last().map(|_| of(values, 99.8)) else { return false };
    let is_even = of(values, 75.0) - of(values, 25.0) >= EVEN * high;
    DECADES.contains(&(high / of(values, 1.0))) && high > SKEWED * of(values, 50.0) && !is_even
}

/// The kind of a field, and the shells of a stratified one.
fn kind(survey: &Survey, is_surface: bool) -> (Kind, Vec<Shell>) {
    let [least, most] = survey.ends();
    if most - least <= SAME * largest(survey) || most - least < TINY {
        return (Kind::Constant, Vec::new());
    }
    let [low, high] = ends(survey, 1.0);
    let has_both = low < 0.0 && 0.0 < high && (-low).min(high) >= BOTH_SIGNS * (-low).max(high);
    if is_surface {
        return (Kind::Surface { is_signed: has_both }, Vec::new());
    }
    if survey.stratified >= STRATIFIED && survey.shown.len() > 2 {
        let shells = shells(survey);
        let is_apart = |pair: &[Shell]| (pair[1].value - pair[0].value).abs() > SHELLS_APART * (most - least);
        return match shells.len() > 1 && shells.windows(2).all(is_apart) {
            true => (Kind::Stratified, shells),
            false => (Kind::Layered, Vec::new()),
        };
    }
    let middle = survey.percentile(50.0);
    let kind = match () {
        () if has_both => Kind::Signed,
        () if middle - low > high - middle => Kind::Lower,
        () => Kind::Upper,
    };
    (kind, Vec::new())
}
