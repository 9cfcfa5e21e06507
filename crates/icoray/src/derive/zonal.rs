//! Means over the cells of the same latitude.
//!
//! The sphere is cut into bands of latitude of equal width, the widest that are no wider than requested. The mean of a
//! band is the mean of the values over its cells, or over the corners that are triangles, layer by layer and not
//! weighted by area. Between the middles of bands the mean is interpolated linearly in latitude, so that no step shows
//! at their boundaries; towards the poles it is that of the last band. A band without a value takes the mean of the
//! nearest band with values.
//!
//! Values are summed as integers, in units of 2⁻⁶² of the layer's largest value: sums do not depend on the order, so
//! means are equal to the last bit for any number of threads and ranks.

use super::run::load;
use crate::fields::FieldLayout;
use crate::ranges::reduce_parts;
use crate::ranks::Ranks;
use crate::render::RenderInputs;
use icoray_grid::threads::Threads;
use icoray_grid::{Error, ErrorKind, Field, Location, Reals, Result};
use rayon::prelude::*;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use std::ops::AddAssign;

/// Minimum width of a band, degrees.
const LEAST_DEG: f64 = 0.1;
/// Columns that are read together.
const RUN: usize = 32;

/// A field's zonal means.
#[derive(Debug)]
pub(super) struct Means<'m> {
    latitude_rad: Reals<'m>,
    bands: usize,
    layers: usize,
    /// Mean of each layer in each band, southernmost first.
    means: Vec<f64>,
}

/// The sum of the values of a band's layer.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
struct Sum {
    sum: i128,
    count: u64,
}

impl AddAssign for Sum {
    fn add_assign(&mut self, other: Self) {
        self.sum += other.sum;
        self.count += other.count;
    }
}

/// The columns of a field that enter the means.
struct Counted<'c> {
    threads: &'c Threads,
    given: &'c RenderInputs<'c>,
    field: &'c Field<'c>,
    latitude_rad: Reals<'c>,
    bands: usize,
}

/// Distance of a latitude from the south pole, in bands.
fn place(latitude_rad: f64, bands: usize) -> f64 {
    (latitude_rad / PI + 0.5) * bands as f64
}

impl<'m> Means<'m> {
    /// The zonal means of a field over a grid's cells or corners. Collective.
    pub fn of(
        ranks: &mut Ranks,
        threads: &'m Threads,
        given: &'m RenderInputs<'m>,
        field: &'m Field<'m>,
        band_deg: f64,
    ) -> Result<Self> {
        let counted = ranks.attempt(|| Counted::new(threads, given, field, band_deg));
        // All ranks exchange the same number of values.
        let counted = ranks.agree_all(counted, |counted| {
            let FieldLayout { location, layers, .. } = FieldLayout::of(counted.field);
            vec![("takes means of a field of", format!("{layers} layers at {location:?}"))]
        })?;
        let scale: Vec<f64> = counted.most(ranks)?.into_iter().map(scale).collect();
        let sums = counted.sums(ranks, &scale)?;
        let layers = scale.len();
        let mean = |(i, sum): (usize, &Sum)| match sum.count {
            0 => f64::NAN,
            count => sum.sum as f64 / count as f64 / scale[i % layers],
        };
        let mut means: Vec<f64> = sums.iter().enumerate().map(mean).collect();
        (0..layers).for_each(|layer| fill_gaps(&mut means[layer..], layers));
        let Counted { latitude_rad, bands, .. } = counted;
        Ok(Means { latitude_rad, bands, layers, means })
    }

    /// Subtracts the interpolated zonal means from a column's values.
    #[inline(always)]
    pub fn take_off(&self, column: usize, row: &[f64], to: &mut [f64]) {
        let place = place(self.latitude_rad.get(column), self.bands) - 0.5;
        let below = (place as usize).min(self.bands.saturating_sub(2));
        let above = (below + 1).min(self.bands - 1);
        let w = (place - below as f64).clamp(0.0, 1.0);
        let [south, north] = [below, above].map(|band| &self.means[band * self.layers..][..self.layers]);
        for (((to, value), south), north) in to.iter_mut().zip(row).zip(south).zip(north) {
            *to = value - (south + w * (north - south));
        }
    }
}

/// Gives bands without a mean that of the nearest one that has one, the southern of two; bands are `step` apart.
fn fill_gaps(means: &mut [f64], step: usize) {
    let known: Vec<(usize, f64)> =
        means.iter().copied().step_by(step).enumerate().filter(|(_, mean)| !mean.is_nan()).collect();
    for (band, mean) in means.iter_mut().step_by(step).enumerate().filter(|(_, mean)| mean.is_nan()) {
        let nearest = known.iter().min_by_key(|(other, _)| other.abs_diff(band));
        *mean = nearest.map_or(f64::NAN, |(_, mean)| *mean);
    }
}

/// A power of 2 that makes all numbers up to `most` less than 2⁶².
fn scale(most: f64) -> f64 {
    let exponent = (most.to_bits() >> 52) as i64 - 1022;
    let power = (62 - exponent).min(1023);
    f64::from_bits(((power + 1023) as u64) << 52)
}

impl<'c> Counted<'c> {
    fn new(threads: &'c Threads, given: &'c RenderInputs<'c>, field: &'c Field<'c>, band_deg: f64) -> Result<Self> {
        if !(LEAST_DEG..=180.0).contains(&band_deg) {
            let context = format!("bands of {band_deg} degrees, expected {LEAST_DEG} to 180");
            return Err(Error::new(ErrorKind::Scene, context));
        }
        let FieldLayout { location, columns, .. } = FieldLayout::of(field);
        let tables = given.grid.tables();
        let latitude_rad = match location {
            Location::Center => tables.center.lat_rad,
            Location::Corner => tables.corner.lat_rad,
        };
        if columns != latitude_rad.len() {
            let context = format!(
                "{columns} columns at {location:?}, expected {}: one for each of the grid's",
                latitude_rad.len()
            );
            return Err(Error::new(ErrorKind::Field, context));
        }
        Ok(Counted { threads, given, field, latitude_rad, bands: (180.0 / band_deg).ceil() as usize })
    }

    fn counts(&self, column: usize) -> bool {
        let location = self.field.location();
        let is_there = location == Location::Center || self.given.grid.is_triangle(column as u32);
        is_there && self.given.counted().has(location, column)
    }

    /// Reduces the counted columns of all ranks and their values in parallel: `take` accumulates a column, `add` merges
    /// two accumulators. Collective.
    fn added<V: Clone + Default + Send + Sync + Serialize + DeserializeOwned>(
        &self,
        ranks: &mut Ranks,
        size: usize,
        take: impl Fn(&mut [V], usize, &[f64]) + Sync,
        add: impl Fn(&mut V, V) + Sync,
    ) -> Result<Vec<V>> {
        let FieldLayout { columns, layers, .. } = FieldLayout::of(self.field);
        let runs = columns.div_ceil(RUN);
        let most = runs.div_ceil(4 * self.threads.count()).max(8);
        let nothing = || vec![V::default(); size];
        let of_run = |(mut all, mut values): (Vec<V>, Vec<f64>), run: usize| {
            let columns = run * RUN..(run * RUN + RUN).min(columns);
            load(self.field, columns.clone(), &mut values);
            for (column, row) in columns.zip(values.chunks_exact(layers)) {
                if self.counts(column) {
                    take(&mut all, column, row);
                }
            }
            (all, values)
        };
        let both = |mut a: Vec<V>, b: Vec<V>| {
            a.iter_mut().zip(b).for_each(|(a, b)| add(a, b));
            a
        };
        let runs = (0..runs).into_par_iter().with_min_len(most);
        let sum = || runs.fold(|| (nothing(), Vec::new()), of_run).map(|(all, _)| all).reduce(nothing, both);
        let mine = || Ok(self.threads.run(sum));
        reduce_parts(ranks, self.given.counted(), mine, both)
    }

    /// The largest of each layer's values, without sign.
    fn most(&self, ranks: &mut Ranks) -> Result<Vec<f64>> {
        let take = |most: &mut [f64], _: usize, row: &[f64]| {
            most.iter_mut().zip(row).for_each(|(most, value)| *most = most.max(value.abs()));
        };
        self.added(ranks, self.field.shape().layers, take, |most: &mut f64, other| *most = most.max(other))
    }

    /// Sums of each band's layers, times each layer's scale.
    fn sums(&self, ranks: &mut Ranks, scale: &[f64]) -> Result<Vec<Sum>> {
        let (bands, layers) = (self.bands, scale.len());
        let take = |sums: &mut [Sum], column: usize, row: &[f64]| {
            let band = (place(self.latitude_rad.get(column), bands) as usize).min(bands - 1);
            let sums = &mut sums[band * layers..][..layers];
            for ((sum, value), scale) in sums.iter_mut().zip(row).zip(scale) {
                // NaN converts to 0.
                sum.sum += i128::from((value * scale) as i64);
                sum.count += u64::from(!value.is_nan());
            }
        };
        self.added(ranks, bands * layers, take, |sum, other| *sum += other)
    }
}
