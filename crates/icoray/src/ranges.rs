//! Colour ranges that follow the data: percentiles of the first frame, or of all frames so far.
//!
//! A renderer stores the range of each field and colour map, so that views of the same field have the same colours. All
//! ranks find the same range to the last bit, for any distribution of the grid: they sum integers.

use crate::ranks::{CountedColumns, Ranks};
use icoray_grid::threads::Threads;
use icoray_grid::{Field, Location, Result};
use icoray_scene::{ColorRange, Coloring, Scale, Scene};
use rayon::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::sync::{Mutex, PoisonError};

/// Bins of a histogram; the resolution of percentiles is the range over the square of this number, along the scale.
const BINS: usize = 4096;
/// Maximum number of stored ranges: bounds the memory if a host generates ever new maps.
const MAX_RANGES: usize = 64;

/// The ranges that a renderer has found.
#[derive(Debug, Default)]
pub(crate) struct Ranges(Mutex<Vec<RecentRange>>);

#[derive(Debug)]
struct RecentRange {
    field: String,
    coloring: Coloring,
    range: [f64; 2],
}

/// A field's values on this rank.
#[derive(Clone, Copy)]
pub(crate) struct FieldValues<'f> {
    pub threads: &'f Threads,
    pub field: &'f Field<'f>,
    /// The cells that count on this rank.
    pub counted: CountedColumns<'f>,
}

/// What `work` returns of the `counted` columns, joined by `join` over the ranks that divide them. Collective.
pub(crate) fn reduce_parts<T: Serialize + DeserializeOwned>(
    ranks: &mut Ranks,
    counted: CountedColumns,
    work: impl FnOnce() -> Result<T>,
    join: impl Fn(T, T) -> T,
) -> Result<T> {
    if counted.is_divided() { ranks.reduce_work(work, join) } else { ranks.collective_work(work) }
}

/// A range of values, of which `None` is empty, and a number of missing ones.
pub(crate) type RangeAndMissing = (Option<[f64; 2]>, u64);

/// The range of the values of both, and the sum of the missing ones.
pub(crate) fn both_ranges((a, missing): RangeAndMissing, (b, others): RangeAndMissing) -> RangeAndMissing {
    (a.zip(b).map(|(a, b)| around(a, b)).or(a).or(b), missing + others)
}

/// The range that contains both.
pub(crate) fn around([low, high]: [f64; 2], [l, h]: [f64; 2]) -> [f64; 2] {
    [low.min(l), high.max(h)]
}

impl Ranges {
    /// The scene with the range of each colour map in this frame; `values` returns the field of a name. `None` if the
    /// scene specifies all ranges. Collective: all ranks request the same fields in the same order.
    pub fn resolve<'v>(
        &self,
        ranks: &mut Ranks,
        scene: &Scene,
        values: &dyn Fn(&str) -> FieldValues<'v>,
    ) -> Result<Option<Scene>> {
        let mut found: Vec<RecentRange> = Vec::new();
        scene.over_each(|field, coloring| {
            // Equal colorings of a field share one range.
            if let Some(known) = found.iter().find(|known| known.is_of(field, coloring)) {
                return Ok(Some(known.range));
            }
            let range = self.range_of(ranks, field, coloring, values)?;
            found.extend(range.map(|range| RecentRange { field: field.into(), coloring: coloring.clone(), range }));
            Ok(range)
        })
    }

    /// The range in this frame; `None` if it is fixed. Collective.
    fn range_of<'v>(
        &self,
        ranks: &mut Ranks,
        field: &str,
        coloring: &Coloring,
        values: &dyn Fn(&str) -> FieldValues<'v>,
    ) -> Result<Option<[f64; 2]>> {
        let known = self.known(field, coloring);
        let (percentile, hysteresis) = match coloring.range() {
            ColorRange::Fixed(_) => return Ok(None),
            ColorRange::Percentile(percentile) => (percentile, None),
            ColorRange::Union { percentile, hysteresis } => (percentile, Some(hysteresis)),
        };
        let scale = coloring.scale();
        let range = match (known, hysteresis) {
            (Some(known), None) => known,
            (known, _) => {
                let seen = values(field).percentiles(ranks, scale, percentile)?;
                let range = match (known, seen) {
                    (Some(known), Some(seen)) => widened(scale, known, seen, hysteresis.unwrap_or(0.0)),
                    (Some(known), None) => known,
                    (None, Some(seen)) => seen,
                    (None, None) => return Ok(Some(coloring.unknown())),
                };
                // A single value is no range: the next frame searches again.
                if range[0] < range[1] {
                    self.keep(field, coloring, range);
                }
                range
            }
        };
        Ok(Some(coloring.about_center(apart(scale, range))))
    }

    fn known(&self, field: &str, coloring: &Coloring) -> Option<[f64; 2]> {
        let all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        all.iter().find(|known| known.is_of(field, coloring)).map(|known| known.range)
    }

    fn keep(&self, field: &str, coloring: &Coloring, range: [f64; 2]) {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        all.retain(|known| !known.is_of(field, coloring));
        if all.len() == MAX_RANGES {
            all.remove(0);
        }
        all.push(RecentRange { field: field.to_owned(), coloring: coloring.clone(), range });
    }
}

impl RecentRange {
    fn is_of(&self, field: &str, coloring: &Coloring) -> bool {
        self.field == field && self.coloring == *coloring
    }
}

/// Updates a range after a frame: an end that the frame exceeds by more than a fraction of the range moves, and as far
/// beyond.
fn widened(scale: Scale, known: [f64; 2], seen: [f64; 2], hysteresis: f64) -> [f64; 2] {
    let [low, high] = known.map(|end| scale.forward(end));
    let [least, most] = seen.map(|end| scale.forward(end));
    let slack = hysteresis * (high - low);
    [
        if least < low - slack { scale.backward(least - slack) } else { known[0] },
        if most > high + slack { scale.backward(most + slack) } else { known[1] },
    ]
}

/// Two ends around the value if there is only one.
fn apart(scale: Scale, [low, high]: [f64; 2]) -> [f64; 2] {
    if low < high {
        return [low, high];
    }
    let at = scale.forward(low);
    let half = if scale == Scale::Linear && at != 0.0 { 0.05 * at.abs() } else { 0.5 };
    [scale.backward(at - half), scale.backward(at + half)]
}

/// The bin of `BINS` that contains a place, and the bin within that.
fn bins(place: f64, [low, high]: [f64; 2]) -> [usize; 2] {
    let at = (place - low) / (high - low) * BINS as f64;
    let bin = (at as usize).min(BINS - 1);
    [bin, (((at - bin as f64) * BINS as f64) as usize).min(BINS - 1)]
}

/// The bin of the value with index `rank` among all, and the number of values in bins before it.
fn bin_of(rank: u64, counts: &[u64]) -> (usize, u64) {
    let mut before = 0;
    for (bin, count) in counts.iter().enumerate() {
        if rank < before + count {
            return (bin, before);
        }
        before += count;
    }
    (counts.len() - 1, before)
}

/// The sums of counts, bin by bin.
pub(crate) fn added(mut a: Vec<u64>, b: Vec<u64>) -> Vec<u64> {
    a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
    a
}

impl FieldValues<'_> {
    /// Two percentiles of the values that the scale admits; the least and the greatest if they are equal. `None` if
    /// there is no value. Collective.
    fn percentiles(&self, ranks: &mut Ranks, scale: Scale, percentile: [f64; 2]) -> Result<Option<[f64; 2]>> {
        let (extent, count) = self.extent(ranks, scale)?;
        let Some(whole) = extent else { return Ok(None) };
        let ends = whole.map(|end| scale.forward(end));
        if percentile == [0.0, 100.0] || ends[0] == ends[1] {
            return Ok(Some(whole));
        }
        let coarse = self.histogram(ranks, BINS, scale, &|place, counts| counts[bins(place, ends)[0]] += 1)?;
        let sought = percentile.map(|p| (p / 100.0 * (count - 1) as f64).round() as u64);
        let [low, high] = sought.map(|rank| bin_of(rank, &coarse));
        let fine = self.histogram(ranks, 2 * BINS, scale, &|place, counts| {
            let [bin, part] = bins(place, ends);
            counts[part] += u64::from(bin == low.0);
            counts[BINS + part] += u64::from(bin == high.0);
        })?;
        let place = |(bin, before): (usize, u64), rank: u64, fine: &[u64]| {
            let part = bin_of(rank - before, fine).0 as f64 + 0.5;
            ends[0] + (ends[1] - ends[0]) * (bin as f64 + part / BINS as f64) / BINS as f64
        };
        let (below, above) = fine.split_at(BINS);
        let mut range = [place(low, sought[0], below), place(high, sought[1], above)].map(|at| scale.backward(at));
        if percentile[0] == 0.0 {
            range[0] = whole[0];
        }
        if percentile[1] == 100.0 {
            range[1] = whole[1];
        }
        Ok(Some(if range[0] < range[1] { range } else { whole }))
    }

    /// The values of a cell's column that the scale admits.
    fn column(&self, scale: Scale, column: usize, mut give: impl FnMut(f64)) {
        if self.counted.has(Location::Center, column) {
            let values = (0..self.field.shape().layers).map(|layer| self.field.value(column, layer));
            values.filter(|value| scale.admits(*value)).for_each(&mut give);
        }
    }

    /// Least and greatest value that the scale admits, and the number of such values. Collective.
    fn extent(&self, ranks: &mut Ranks, scale: Scale) -> Result<(Option<[f64; 2]>, u64)> {
        let one = |column| {
            let (mut low, mut high, mut count) = (f64::INFINITY, f64::NEG_INFINITY, 0u64);
            self.column(scale, column, |value| {
                (low, high, count) = (low.min(value), high.max(value), count + 1);
            });
            (low, high, count)
        };
        let columns = (0..self.field.shape().columns).into_par_iter().with_min_len(256);
        let nothing = || (f64::INFINITY, f64::NEG_INFINITY, 0);
        let both = |a: (f64, f64, u64), b: (f64, f64, u64)| (a.0.min(b.0), a.1.max(b.1), a.2 + b.2);
        let mine = || Ok(self.threads.run(|| columns.map(one).reduce(nothing, both)));
        let (low, high, count) = reduce_parts(ranks, self.counted, mine, both)?;
        Ok(((low <= high).then_some([low, high]), count))
    }

    /// Sums over all values of the `size` numbers that `count` adds for each value's place. Collective.
    fn histogram(
        &self,
        ranks: &mut Ranks,
        size: usize,
        scale: Scale,
        count: &(dyn Fn(f64, &mut [u64]) + Sync),
    ) -> Result<Vec<u64>> {
        let nothing = || vec![0u64; size];
        // A few histograms per thread, for any size of the grid.
        let columns = self.field.shape().columns;
        let most = columns.div_ceil(4 * self.threads.count()).max(256);
        let columns = (0..columns).into_par_iter().with_min_len(most);
        let add = |mut counts: Vec<u64>, column| {
            self.column(scale, column, |value| count(scale.forward(value), &mut counts));
            counts
        };
        let mine = || Ok(self.threads.run(|| columns.fold(nothing, add).reduce(nothing, added)));
        reduce_parts(ranks, self.counted, mine, added)
    }
}

#[cfg(test)]
mod tests;
