//! Statistics of a field's values: percentiles, and the fraction of the variance that lies between layers.

use super::sample::Sample;
use glam::DVec3;
use icoray_grid::Layers;

/// Statistics of a field. Each value has the same weight: layers count most where the model has many of them.
pub(super) struct Survey<'s> {
    sample: &'s Sample,
    /// Height of each of the field's layers over the planet's surface, planet radii.
    pub height: Vec<f64>,
    /// Numbers of the layers that are shown.
    pub shown: Vec<usize>,
    /// Subtracted from the values of each layer.
    reference: Vec<f64>,
    /// Mean of each layer; 0 where all its values are missing.
    pub means: Vec<f64>,
    /// Values, rising; at least one.
    sorted: Vec<f64>,
    /// Fraction of the variance that the means of the layers explain, 0 to 1.
    pub stratified: f64,
}

impl<'s> Survey<'s> {
    /// Surveys all layers, or one; `None` if all values are missing.
    pub fn new(layers: &Layers, sample: &'s Sample, only: Option<usize>) -> Option<Self> {
        let planet = layers.planet_radius_m();
        let height: Vec<f64> = layers.radius_m().iter().map(|radius| radius / planet - 1.0).collect();
        let shown = only.map_or_else(|| (0..height.len()).collect(), |layer| vec![layer]);
        let reference = vec![0.0; height.len()];
        Self::less(sample, height, shown, reference)
    }

    /// The survey of the values minus the mean of their layer.
    pub fn anomaly(&self) -> Option<Self> {
        Self::less(self.sample, self.height.clone(), self.shown.clone(), self.means.clone())
    }

    fn less(sample: &'s Sample, height: Vec<f64>, shown: Vec<usize>, reference: Vec<f64>) -> Option<Self> {
        let (mut sorted, mut layers) = (Vec::new(), vec![[0.0; 2]; height.len()]);
        let (means, stratified) = (Vec::new(), 0.0);
        let mut survey = Survey { sample, height, shown, reference, means, sorted: Vec::new(), stratified };
        survey.each(|_, layer, value| {
            sorted.push(value);
            let [number, sum] = &mut layers[layer];
            (*number, *sum) = (*number + 1.0, *sum + value);
        });
        sorted.sort_unstable_by(f64::total_cmp);
        let (mut total, mut sum) = (0.0, 0.0);
        layers.iter().for_each(|[number, of_layer]| (total, sum) = (total + number, sum + of_layer));
        let mean = sum / total;
        survey.means = layers.iter().map(|[number, sum]| if *number > 0.0 { sum / number } else { 0.0 }).collect();
        let of_layers = layers.iter().zip(&survey.means);
        let between: f64 = of_layers.map(|([number, _], of_layer)| number * (of_layer - mean).powi(2)).sum();
        let all: f64 = sorted.iter().map(|value| (value - mean).powi(2)).sum();
        survey.stratified = if all > 0.0 { between / all } else { 0.0 };
        survey.sorted = sorted;
        (!survey.sorted.is_empty()).then_some(survey)
    }

    pub fn columns(&self) -> std::ops::Range<usize> {
        0..self.sample.columns()
    }

    pub fn direction(&self, column: usize) -> DVec3 {
        self.sample.directions[column]
    }

    /// The value of a column on a layer, NaN where it is missing.
    pub fn value(&self, column: usize, layer: usize) -> f64 {
        self.sample.value(column, layer) - self.reference[layer]
    }

    /// Calls `take(column, layer, value)` for each value that is not missing.
    pub fn each(&self, mut take: impl FnMut(usize, usize, f64)) {
        for column in self.columns() {
            for &layer in &self.shown {
                let value = self.value(column, layer);
                if !value.is_nan() {
                    take(column, layer, value);
                }
            }
        }
    }

    /// The value below which `percent` percent of all values are.
    pub fn percentile(&self, percent: f64) -> f64 {
        of(&self.sorted, percent)
    }

    /// Least and largest value.
    pub fn ends(&self) -> [f64; 2] {
        [0.0, 100.0].map(|percent| self.percentile(percent))
    }

    /// The values above 0, rising; empty if any is below 0.
    pub fn positive(&self) -> &[f64] {
        match self.sorted[0] < 0.0 {
            true => &[],
            false => &self.sorted[self.sorted.partition_point(|value| *value <= 0.0)..],
        }
    }

    /// `measure` of all values, and its largest in each column; both rising, without values for which it is `None`.
    pub fn measured(&self, measure: impl Fn(f64) -> f64) -> [Vec<f64>; 2] {
        let rising = |mut values: Vec<f64>| {
            values.retain(|value| value.is_finite());
            values.sort_unstable_by(f64::total_cmp);
            values
        };
        let most = |column: usize| {
            let values = self.shown.iter().map(|layer| measure(self.value(column, *layer)));
            values.fold(f64::NEG_INFINITY, f64::max)
        };
        let all = self.sorted.iter().map(|value| measure(*value)).collect();
        [rising(all), rising(self.columns().map(most).collect())]
    }
}

/// A percentile of values in rising order.
pub(super) fn of(sorted: &[f64], percent: f64) -> f64 {
    sorted[(percent / 100.0 * (sorted.len() - 1) as f64).round() as usize]
}
