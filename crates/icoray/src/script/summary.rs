//! What conditions may ask of a field, found in one go.

use super::Statistic;
use crate::error::Result;
use crate::field::Field;
use crate::ranks::{Reader, Words};
use rayon::prelude::*;

/// Columns that are added up on their own: so few that few roundings are as large as the whole sum's, and the same ones
/// whatever the threads.
const PIECE: usize = 1024;

/// Says of a column whether it counts.
pub(crate) type Counted<'c> = &'c (dyn Fn(usize) -> bool + Sync);

/// The statistics of a field that were asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Summary {
    low: f64,
    high: f64,
    sum: f64,
    count: u64,
}

impl Summary {
    const NOTHING: Summary = Summary { low: f64::INFINITY, high: f64::NEG_INFINITY, sum: 0.0, count: 0 };

    /// What `asked` needs of the columns that count, all of them where nothing says which.
    pub(crate) fn of(field: &Field, counts: Option<Counted>, asked: &[Statistic]) -> Self {
        let mut summary = Self::NOTHING;
        if asked.iter().any(|statistic| *statistic != Statistic::Mean)
            && let (Some([low, high]), _) = field.range_over(counts)
        {
            (summary.low, summary.high) = (low, high);
        }
        if asked.contains(&Statistic::Mean) {
            (summary.sum, summary.count) = sum(field, counts);
        }
        summary
    }

    /// One that was asked for; `None` where all values are missing.
    pub fn get(&self, statistic: Statistic) -> Option<f64> {
        let is_known = self.low <= self.high;
        match statistic {
            Statistic::Min => is_known.then_some(self.low),
            Statistic::Max => is_known.then_some(self.high),
            Statistic::Mean => (self.count > 0).then(|| self.sum / self.count as f64),
        }
    }

    /// That of a whole field, of what each rank has put: of its own columns where rank 0 has some only, else rank 0's.
    pub(crate) fn of_all(said: &[Vec<u8>]) -> Result<Self> {
        let mut all = Self::NOTHING;
        for bytes in said {
            let mut reader = Reader(bytes);
            let is_part = reader.get()? == 1;
            let (low, high) = (reader.get_f64()?, reader.get_f64()?);
            let (sum, count) = (reader.get_f64()?, reader.get()?);
            let (low, high) = (all.low.min(low), all.high.max(high));
            all = Summary { low, high, sum: all.sum + sum, count: all.count + count };
            if !is_part {
                break;
            }
        }
        Ok(all)
    }

    /// What this rank says, of its own columns or of all.
    pub(crate) fn words(&self, is_part: bool) -> Words {
        let mut words = Words::default();
        words.put(is_part.into()).put_f64(self.low).put_f64(self.high).put_f64(self.sum).put(self.count);
        words
    }
}

/// The sum of the values that are there, and how many they are.
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
