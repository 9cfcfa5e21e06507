//! Statistics of a field for conditions, computed in one pass.

use super::Statistic;
use icoray_grid::Field;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Number of columns that are summed separately: fixed, so that sums do not depend on the number of threads, and small,
/// so that rounding errors stay small.
const PIECE: usize = 1024;

/// Tests whether a column is included.
pub(crate) type Counted<'c> = &'c (dyn Fn(usize) -> bool + Sync);

/// The statistics of a field that were asked for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    low: f64,
    high: f64,
    sum: f64,
    count: u64,
}

impl Summary {
    /// The statistics of an empty set of values.
    pub const NOTHING: Summary = Summary { low: f64::INFINITY, high: f64::NEG_INFINITY, sum: 0.0, count: 0 };

    /// The statistics in `asked` over the columns that count; `None` counts all.
    pub fn of(field: &Field, counts: Option<Counted>, asked: &[Statistic]) -> Self {
        let mut summary = Self::NOTHING;
        if asked.iter().any(|statistic| *statistic != Statistic::Mean)
            && let (Some([low, high]), _) = field.range_over(counts)
        {
            summary.low = low;
            summary.high = high;
        }
        if asked.contains(&Statistic::Mean) {
            (summary.sum, summary.count) = sum(field, counts);
        }
        summary
    }

    /// A statistic that was asked for; `None` if all values are missing.
    pub fn get(&self, statistic: Statistic) -> Option<f64> {
        let is_known = self.low <= self.high;
        match statistic {
            Statistic::Min => is_known.then_some(self.low),
            Statistic::Max => is_known.then_some(self.high),
            Statistic::Mean => (self.count > 0).then(|| self.sum / self.count as f64),
        }
    }

    /// The statistics of both sets of values together.
    pub fn joined(self, other: Self) -> Self {
        Summary {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            sum: self.sum + other.sum,
            count: self.count + other.count,
        }
    }
}

/// The sum of the values that are not missing, and their number.
fn sum(field: &Field, counts: Option<Counted>) -> (f64, u64) {
    let shape = field.shape();
    let of_column = |column: usize| {
        let known = (0..shape.layers).map(|layer| field.value(column, layer)).filter(|v| !v.is_nan());
        known.fold((0.0, 0), |(sum, n), value| (sum + value, n + 1))
    };
    let added = |(a, n): (f64, u64), (b, m): (f64, u64)| (a + b, n + m);
    let of_piece = |piece: usize| {
        let columns = piece * PIECE..((piece + 1) * PIECE).min(shape.columns);
        let counted = columns.filter(|column| counts.is_none_or(|counts| counts(*column)));
        counted.map(of_column).fold((0.0, 0), added)
    };
    let pieces: Vec<_> = (0..shape.columns.div_ceil(PIECE)).into_par_iter().map(of_piece).collect();
    pieces.into_iter().fold((0.0, 0), added)
}
