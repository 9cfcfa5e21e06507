//! A field in the model's memory: a borrowed array, read in place through its [`Shape`] in any layout.
//!
//! `shape.rs` lists the layouts and the models that use them. A reader computes the base of a column once and moves
//! from layer to layer by one stride; only the base depends on blocks. Fields at corners, and fields on other layers,
//! are copied: they become a [`ComputedField`].

use crate::array::MapInline;
use crate::error::{Error, ErrorKind, Result};
use crate::hash::{self, GOLDEN};
use crate::reals::Reals;
use crate::sample::Sample;
use crate::shape::{ElementIndexer, Shape};
use fearless_simd::{Level, dispatch};
use rayon::prelude::*;
use std::slice;
use std::sync::atomic::{AtomicU64, Ordering};

/// The location of a field's values on the mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Location {
    /// At the cell centres.
    Center,
    /// At the cell corners, which are the dual triangles (MPAS vorticity); averaged to centres before rendering.
    Corner,
}

/// A scalar field over a borrowed array.
///
/// Values that are NaN, infinite or equal to `fill` are missing: a frustum with a missing value is empty.
///
/// ```
/// use icoray_grid::{Field, Location, Shape};
///
/// // Two columns of three layers; -999 marks a missing value.
/// let values = [1.0, 2.0, 3.0, 4.0, -999.0, 6.0f32];
/// let shape = Shape::level_fastest(2, 3);
/// let field = Field::new(values.as_slice().into(), shape, Location::Center, Some(-999.0))?;
/// assert_eq!(field.value(1, 2), 6.0);
/// assert_eq!(field.range(), (Some([1.0, 6.0]), 1));
/// # Ok::<(), icoray_grid::Error>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Field<'a> {
    samples: Reals<'a>,
    shape: Shape,
    elements: ElementIndexer,
    location: Location,
    fill: Option<f64>,
    number: u64,
}

impl<'a> Field<'a> {
    /// Wraps `samples`; every element that `shape` reaches must lie inside. A field without columns is valid: a rank
    /// without cells has one.
    ///
    /// # Errors
    /// [`ErrorKind::Field`] when the shape has no layer or reaches outside the array, or when 32 bits cannot number its
    /// blocked columns.
    pub fn new(samples: Reals<'a>, shape: Shape, location: Location, fill: Option<f64>) -> Result<Self> {
        let number = next_number();
        let bad = |context| Err(Error::new(ErrorKind::Field, context));
        if shape.columns == 0 && shape.layers > 0 {
            let shape = Shape::level_fastest(0, shape.layers);
            let elements = ElementIndexer::new(&shape).expect("nothing is in blocks");
            return Ok(Field { samples, shape, elements, location, fill, number });
        }
        let Some((low, high)) = shape.extent() else {
            return bad(format!(
                "{} columns of {} layers, expected layers and strides that 64 bits can hold",
                shape.columns, shape.layers
            ));
        };
        if low < 0 || high >= samples.len() as i128 {
            return bad(format!(
                "the strides reach elements {low} to {high}, expected 0 to {}",
                samples.len() as i128 - 1
            ));
        }
        let Some(elements) = ElementIndexer::new(&shape) else {
            return bad(format!("{} columns in blocks, expected at most 2^32", shape.columns));
        };
        Ok(Field { samples, shape, elements, location, fill, number })
    }

    /// Wraps all of `samples`, level-fastest, without a mark of missing values: the columns behind each other, each of
    /// `layers` values.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn level_fastest(samples: impl Into<Reals<'a>>, layers: usize, location: Location) -> Result<Self> {
        let samples = samples.into();
        let columns = samples.len().checked_div(layers).unwrap_or(0);
        Self::new(samples, Shape::level_fastest(columns, layers), location, None)
    }

    /// Repeats the values of a 2D field, which has one layer, on each of `layers`; other fields are returned unchanged.
    #[must_use]
    pub fn on_layers(self, layers: usize) -> Self {
        if self.shape.layers != 1 {
            return self;
        }
        let shape = Shape { layers, layer_stride: 0, ..self.shape };
        let spread = Field::new(self.samples, shape, self.location, self.fill);
        Field { number: self.number, ..spread.expect("its layers are the same elements") }
    }

    /// The same values with the last layer first.
    #[must_use]
    pub fn upside_down(self) -> Self {
        let Shape { layers, offset, layer_stride, .. } = self.shape;
        let offset = offset.wrapping_add_signed((layers as isize - 1) * layer_stride);
        let shape = Shape { offset, layer_stride: -layer_stride, ..self.shape };
        Field { shape, elements: self.elements.upside_down(), ..self }
    }

    /// The array as given.
    pub fn samples(&self) -> Reals<'a> {
        self.samples
    }

    /// A number that this field shares with its copies and with no other field of the process. The array is borrowed,
    /// so nothing can write to it while a copy lives: results that were computed from the number's field hold for
    /// all its copies.
    pub fn number(&self) -> u64 {
        self.number
    }

    /// The same field with the number of another one, with which it shares its values over another grid.
    #[must_use]
    pub fn numbered(self, number: u64) -> Self {
        Field { number, ..self }
    }

    /// The layout of the array.
    pub fn shape(&self) -> &Shape {
        &self.shape
    }

    /// The location of the values.
    pub fn location(&self) -> Location {
        self.location
    }

    /// The value that marks a missing sample, if any.
    pub fn fill(&self) -> Option<f64> {
        self.fill
    }

    /// Value of `column` at `layer`; NaN if it is missing.
    ///
    /// # Panics
    /// When the indices are out of range.
    #[inline]
    pub fn value(&self, column: usize, layer: usize) -> f64 {
        self.value_or_nan(self.samples.get(self.elements.at(self.elements.base(column), layer)))
    }

    /// Reads a column's values; NaN for a missing one.
    ///
    /// # Panics
    /// When the column is out of range, or there are fewer layers than `values`.
    pub fn read_column(&self, column: usize, values: &mut [f64]) {
        match self.samples {
            Reals::F32(samples) => self.read_column_in(samples, column, values),
            Reals::F64(samples) => self.read_column_in(samples, column, values),
        }
    }

    #[inline]
    fn read_column_in<S: Sample>(&self, samples: &[S], column: usize, values: &mut [f64]) {
        let base = self.elements.base(column);
        let start = self.elements.at(base, 0);
        if self.shape.layer_stride == 1 {
            let column = &samples[start..start + values.len()];
            values.iter_mut().zip(column).for_each(|(value, sample)| *value = self.value_or_nan(sample.wide()));
        } else {
            let layers = values.iter_mut().enumerate();
            layers.for_each(|(layer, value)| *value = self.value_or_nan(samples[self.elements.at(base, layer)].wide()));
        }
    }

    /// Values of three columns at `layer`; NaN for a missing one.
    ///
    /// # Panics
    /// When the indices are out of range.
    #[inline(always)]
    pub fn values(&self, columns: [usize; 3], layer: usize) -> [f64; 3] {
        let bases = self.elements.bases(columns);
        bases.map_inline(|base| self.value_or_nan(self.samples.get(self.elements.at(base, layer))))
    }

    /// A hash of `samples` values that are spread over all columns and layers, or of all values if there are no more.
    /// It depends on the values only, not on precision and layout: all missing values are equal, and so are 0 and -0.
    pub fn hash_of_samples(&self, samples: usize) -> u64 {
        let columns = self.shape.columns;
        let count = columns * self.shape.layers;
        // The upper bits of a multiple of the golden ratio, as a part of the count.
        let spread = |i: usize| (((i as u64).wrapping_mul(GOLDEN) as u128 * count as u128) >> 64) as usize;
        let terms = (0..count.min(samples)).map(|i| {
            let at = if count <= samples { i } else { spread(i) };
            hash::term(i, hash::bits(self.value(at % columns, at / columns)))
        });
        terms.fold(0, u64::wrapping_add)
    }

    /// The value, or NaN if it marks a missing one.
    #[inline]
    fn value_or_nan(&self, value: f64) -> f64 {
        if Some(value) == self.fill || !value.is_finite() { f64::NAN } else { value }
    }

    /// The positions of elements in the array.
    pub fn elements(&self) -> &ElementIndexer {
        &self.elements
    }

    /// The number of values in each of `bins` equal parts of the range from `low` to `high`, over those columns for
    /// which `counts` is true, or over all without it; values outside are in none. Parallel.
    pub fn histogram_over(
        &self,
        [low, high]: [f64; 2],
        bins: usize,
        counts: Option<&(dyn Fn(usize) -> bool + Sync)>,
    ) -> Vec<u64> {
        let per_value = bins as f64 / (high - low);
        let none = || vec![0u64; bins];
        let add = |mut numbers: Vec<u64>, column: usize| {
            for layer in 0..self.shape.layers {
                let value = self.value(column, layer);
                if (low..=high).contains(&value) {
                    // A range without an extent has one bin.
                    let bin = ((value - low) * per_value) as usize;
                    numbers[bin.min(bins - 1)] += 1;
                }
            }
            numbers
        };
        let both = |mut a: Vec<u64>, b: Vec<u64>| {
            a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
            a
        };
        let columns = (0..self.shape.columns).into_par_iter().with_min_len(4096);
        columns.filter(|column| counts.is_none_or(|counts| counts(*column))).fold(none, add).reduce(none, both)
    }

    /// Whether the field has any value. Stops at the first one.
    pub fn has_values(&self) -> bool {
        let Shape { columns, layers, .. } = self.shape;
        (0..columns).any(|column| (0..layers).any(|layer| !self.value(column, layer).is_nan()))
    }

    /// Least and greatest value, and the number of missing values; the range is `None` if all are missing. Parallel.
    pub fn range(&self) -> (Option<[f64; 2]>, u64) {
        self.range_over(None)
    }

    /// [`Self::range`] over those columns for which `counts` is true; over all without `counts`.
    pub fn range_over(&self, counts: Option<&(dyn Fn(usize) -> bool + Sync)>) -> (Option<[f64; 2]>, u64) {
        let (low, high, missing) = match self.samples {
            Reals::F32(samples) => self.range_in(samples, counts),
            Reals::F64(samples) => self.range_in(samples, counts),
        };
        ((low <= high).then_some([low, high]), missing)
    }

    fn range_in<S: Sample>(&self, samples: &[S], counts: Option<&(dyn Fn(usize) -> bool + Sync)>) -> Extremes {
        let fill = self.fill.and_then(S::exact);
        let level = Level::new();
        let range = |values: &[S]| dispatch!(level, _simd => range_of(values, fill));
        if let (None, Some((low, high))) = (counts, self.shape.packed()) {
            let pieces = samples[low..=high].par_chunks(1 << 15);
            return pieces.map(range).reduce(no_values, merged);
        }
        let columns = (0..self.shape.columns).into_par_iter().with_min_len(256);
        let counted = columns.filter(|column| counts.is_none_or(|counts| counts(*column)));
        let of_column = |column: usize| {
            let base = self.elements.base(column);
            if self.shape.layer_stride == 1 {
                let start = self.elements.at(base, 0);
                return range(&samples[start..start + self.shape.layers]);
            }
            let values = (0..self.shape.layers).map(|layer| &samples[self.elements.at(base, layer)]);
            values.map(|value| range_of(slice::from_ref(value), fill)).fold(no_values(), merged)
        };
        counted.map(of_column).reduce(no_values, merged)
    }
}

/// A number that no other field of the process has.
fn next_number() -> u64 {
    static NEXT: AtomicU64 = AtomicU64::new(0);
    NEXT.fetch_add(1, Ordering::Relaxed)
}

/// Least and greatest value, and the number of missing values.
type Extremes = (f64, f64, u64);

fn no_values() -> Extremes {
    (f64::INFINITY, f64::NEG_INFINITY, 0)
}

fn merged(a: Extremes, b: Extremes) -> Extremes {
    (a.0.min(b.0), a.1.max(b.1), a.2 + b.2)
}

/// Least and greatest of contiguous values, and the number of missing ones: in loops of fixed size, which compile to
/// vectors.
#[inline(always)]
fn range_of<S: Sample>(values: &[S], fill: Option<S>) -> Extremes {
    const SIDE: usize = 32;
    let [least, greatest] = [f64::NEG_INFINITY, f64::INFINITY].map(S::near);
    // Without a fill value: a value that counts as missing anyway.
    let fill = fill.unwrap_or(greatest.next_up());
    let (sides, rest) = values.as_chunks::<SIDE>();
    let mut last = [fill; SIDE];
    last[..rest.len()].copy_from_slice(rest);
    let (mut low, mut high, mut there) = ([greatest; SIDE], [least; SIDE], [0u32; SIDE]);
    for n in 0..=sides.len() {
        let side = sides.get(n).unwrap_or(&last);
        for i in 0..SIDE {
            let value = side[i];
            let is_there = (value >= least) & (value <= greatest) & (value != fill);
            let [lower, higher] = if is_there { [value; 2] } else { [greatest, least] };
            low[i] = if lower < low[i] { lower } else { low[i] };
            high[i] = if higher > high[i] { higher } else { high[i] };
            there[i] += u32::from(is_there);
        }
    }
    let there: u32 = there.iter().sum();
    let missing = (values.len() - there as usize) as u64;
    if there == 0 {
        return (f64::INFINITY, f64::NEG_INFINITY, missing);
    }
    let low = low.iter().fold(f64::INFINITY, |low, v| low.min(v.wide()));
    (low, high.iter().fold(f64::NEG_INFINITY, |high, v| high.max(v.wide())), missing)
}

mod computed;
mod corner_columns;
mod moved;
pub use computed::ComputedField;
pub use corner_columns::CornerColumns;
pub use moved::moved;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shape_that_leaves_the_array_is_refused() {
        let v = [0.0f32; 6];
        for shape in [
            Shape::level_fastest(3, 3),
            Shape { layer_stride: -1, ..Shape::level_fastest(3, 2) },
            Shape { column_stride: isize::MAX, ..Shape::level_fastest(3, 2) },
            Shape::level_fastest(2, 0),
        ] {
            let error = Field::new(v.as_slice().into(), shape, Location::Center, None).unwrap_err();
            assert_eq!(error.kind(), ErrorKind::Field, "{shape:?}");
        }
    }

    #[test]
    fn range_leaves_missing_values_out() {
        let v = [1.0f32, -9e33, f32::NAN, 4.0, f32::INFINITY, 2.0];
        let fill = Some(f64::from(-9e33f32));
        let field = Field::new(v.as_slice().into(), Shape::level_fastest(3, 2), Location::Center, fill).unwrap();
        assert_eq!(field.range(), (Some([1.0, 4.0]), 3));
    }
}
