//! Heights that differ from column to column, and their means.

use super::MeanHeights;
use crate::field::FieldInfo;
use crate::source::SourceVariable;
use icoray::{ErrorKind, Result};

/// Maximum number of values in memory at one time.
const BLOCK: usize = 1 << 20;

/// The mean of each layer over the columns at the first time, and the max distance from it. `info` describes the
/// variable, whose values become heights by `to_height`.
pub(super) fn mean(
    found: SourceVariable,
    info: &FieldInfo,
    missing: &[f64],
    to_height: impl Fn(f64) -> f64,
) -> Result<MeanHeights> {
    if found.variable.dimensions.iter().any(|d| d.len == 0) {
        return Err(found.error(ErrorKind::Layers, format_args!("variable {} is empty", found.variable)));
    }
    let is_level_fastest = info.is_level_fastest();
    let (one, two) = if is_level_fastest { (info.columns, info.layers) } else { (info.layers, info.columns) };
    let mut all = Vec::new();
    let rows = (BLOCK / two).max(1);
    for first in (0..one).step_by(rows) {
        let (outer, inner) = (first..one.min(first + rows), 0..two);
        let (columns, layers) = if is_level_fastest { (outer, inner) } else { (inner, outer) };
        let (start, count) = info.axes.block(0, columns, layers);
        let block = found.decoded(&start, &count, missing)?;
        // Allocated after the first read, which fails if a damaged header has too many layers.
        all.resize(info.layers, HeightStatistics::default());
        let heights = block.as_reals();
        for i in 0..heights.len() {
            let (row, place, height) = (first + i / two, i % two, to_height(heights.get(i)));
            let (column, layer) = if is_level_fastest { (row, place) } else { (place, row) };
            if !height.is_finite() {
                let (name, number) = (found.name(), column + 1);
                let context =
                    format!("{name} of column {number}, layer {layer}: {height}, expected a height in metres");
                return Err(found.error(ErrorKind::Layers, context));
            }
            all[layer].add(height);
        }
    }
    Ok(means(&all))
}

/// Mean heights of layers, and the largest deviation.
pub(super) fn means(all: &[HeightStatistics]) -> MeanHeights {
    let deviation_m = all.iter().map(|layer| layer.deviation_from(layer.mean())).fold(0.0, f64::max);
    MeanHeights { height_m: all.iter().map(HeightStatistics::mean).collect(), deviation_m: Some(deviation_m) }
}

/// Mean, minimum and maximum of heights.
#[derive(Debug, Clone, Copy)]
pub(super) struct HeightStatistics {
    sum: f64,
    count: usize,
    min: f64,
    max: f64,
}

impl Default for HeightStatistics {
    fn default() -> Self {
        HeightStatistics { sum: 0.0, count: 0, min: f64::INFINITY, max: f64::NEG_INFINITY }
    }
}

impl HeightStatistics {
    pub(super) fn add(&mut self, height: f64) {
        self.sum += height;
        self.count += 1;
        self.min = height.min(self.min);
        self.max = height.max(self.max);
    }

    /// Equal heights have exactly this mean, without rounding of the sum.
    pub(super) fn mean(&self) -> f64 {
        if self.min == self.max { self.min } else { self.sum / self.count as f64 }
    }

    /// The max distance from `height`; 0 of none.
    pub(super) fn deviation_from(&self, height: f64) -> f64 {
        if self.count == 0 { 0.0 } else { (self.max - height).max(height - self.min) }
    }
}
