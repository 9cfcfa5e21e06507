//! Selects the surfaces of equal value of a stratified field that are shown.

use super::survey::Survey;

/// Shares of the outermost or innermost layer that the shown surfaces cut off, percent, the smallest dome first.
const SHARES: [f64; 2] = [22.0, 48.0];
/// Minimum fraction of the columns that meet a shown surface.
const LEAST_MET: f64 = 0.02;

/// A surface on which the field has one value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Shell {
    pub value: f64,
    /// Mean change of the value per planet radius across it.
    pub gradient: f64,
}

/// Surfaces that end at the ground, or for an ocean at the sea surface, so that their edges are visible: domes of the
/// lowest values if values increase away from it, and of the highest if they decrease. The smallest dome first.
pub(super) fn shells(survey: &Survey) -> Vec<Shell> {
    // From the ground upwards, or for an ocean from the sea surface downwards.
    let mut path: Vec<usize> = (0..survey.height.len()).collect();
    path.sort_by(|a, b| survey.height[*a].total_cmp(&survey.height[*b]));
    if survey.height.iter().sum::<f64>() < 0.0 {
        path.reverse();
    }
    let (mut rises, mut ends) = (0.0, Vec::new());
    for column in survey.columns() {
        let mut values = path.iter().map(|layer| survey.value(column, *layer)).filter(|value| !value.is_nan());
        let Some(end) = values.next() else { continue };
        // A few layers away: an inversion at the ground is ignored.
        let inner = values.take(path.len() / 4 + 1).last().unwrap_or(end);
        rises += (inner - end).signum();
        ends.push(end);
    }
    ends.sort_unstable_by(f64::total_cmp);
    let value = |share: f64| {
        let share = if rises >= 0.0 { share } else { 100.0 - share };
        ends[(share / 100.0 * (ends.len() - 1) as f64).round() as usize]
    };
    let mut shells: Vec<Shell> = SHARES.iter().filter_map(|share| Shell::at(survey, &path, value(*share))).collect();
    shells.dedup_by(|b, a| a.value == b.value);
    shells
}

impl Shell {
    /// The surface of `value`; `None` if too few columns meet it.
    fn at(survey: &Survey, path: &[usize], value: f64) -> Option<Self> {
        let (mut met, mut columns, mut gradient) = (0.0, 0.0, 0.0);
        for column in survey.columns() {
            columns += 1.0;
            if let Some(slope) = slope(survey, path, column, value) {
                met += 1.0;
                gradient += slope;
            }
        }
        (met > LEAST_MET * columns).then(|| Shell { value, gradient: gradient / met })
    }
}

/// The change of the value with height at the first place of a column that has `value`.
fn slope(survey: &Survey, path: &[usize], column: usize, value: f64) -> Option<f64> {
    path.windows(2).find_map(|pair| {
        let [one, other] = [pair[0], pair[1]].map(|layer| survey.value(column, layer));
        let is_between = (one - value) * (other - value) <= 0.0 && one != other;
        let distance = survey.height[pair[0]] - survey.height[pair[1]];
        is_between.then(|| ((one - other) / distance).abs())
    })
}
