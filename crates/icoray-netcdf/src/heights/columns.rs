//! Heights that differ from column to column, and their means.

use crate::source::{Source, Variable};
use icoray::{ErrorKind, Result};

/// Values that are in memory at one time.
const BLOCK: usize = 1 << 20;

/// The last two dimensions of a variable are columns and layers, in this order where `is_level_fastest`; of dimensions
/// before them the first record is taken. Gives the mean of each layer over the columns, and the greatest distance from it.
pub(super) fn mean(source: &Source, variable: &Variable, is_level_fastest: bool) -> Result<(Vec<f64>, f64)> {
    let before = variable.dimensions.len().saturating_sub(2);
    let [one, two] = [0, 1].map(|i| variable.dimensions[before + i].len);
    let (columns, layers) = if is_level_fastest { (one, two) } else { (two, one) };
    if columns == 0 || layers == 0 || variable.dimensions[..before].iter().any(|d| d.len == 0) {
        return Err(source.error(ErrorKind::Layers, format_args!("variable {variable} is empty")));
    }
    let mut all = Vec::new();
    let rows = (BLOCK / two).max(1);
    for first in (0..one).step_by(rows) {
        let (mut start, mut count) = (vec![0; before], vec![1; before]);
        start.extend([first, 0]);
        count.extend([rows.min(one - first), two]);
        let block = source.reals(variable, &start, &count)?;
        // Only now is it known that a damaged header does not promise more layers than there can be.
        all.resize(layers, Spread::default());
        let heights = block.as_reals();
        for i in 0..heights.len() {
            let (row, place, height) = (first + i / two, i % two, heights.get(i));
            let (column, layer) = if is_level_fastest { (row, place) } else { (place, row) };
            if !height.is_finite() {
                let context = format!(
                    "{} of column {}, layer {layer}: {height}, expected a height in metres",
                    variable.name,
                    column + 1
                );
                return Err(source.error(ErrorKind::Layers, context));
            }
            all[layer].add(height);
        }
    }
    let mean: Vec<f64> = all.iter().map(Spread::mean).collect();
    Ok((mean, all.iter().map(Spread::deviation).fold(0.0, f64::max)))
}

/// Mean and ends of some heights.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spread {
    sum: f64,
    count: usize,
    least: f64,
    greatest: f64,
}

impl Default for Spread {
    fn default() -> Self {
        Spread { sum: 0.0, count: 0, least: f64::INFINITY, greatest: f64::NEG_INFINITY }
    }
}

impl Spread {
    pub(super) fn add(&mut self, height: f64) {
        self.sum += height;
        self.count += 1;
        self.least = height.min(self.least);
        self.greatest = height.max(self.greatest);
    }

    /// Equal heights keep their very value, without the sum's rounding.
    pub(super) fn mean(&self) -> f64 {
        if self.least == self.greatest { self.least } else { self.sum / self.count as f64 }
    }

    fn deviation(&self) -> f64 {
        self.deviation_from(self.mean())
    }

    /// The greatest distance from `height`; 0 of none.
    pub(super) fn deviation_from(&self, height: f64) -> f64 {
        if self.count == 0 { 0.0 } else { (self.greatest - height).max(height - self.least) }
    }
}
