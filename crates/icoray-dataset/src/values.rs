//! Values of a block: owned, or borrowed in place.

use icoray::{OwnedReals, Reals, Shape};
use std::fmt;
use std::sync::Arc;

/// Marks of missing values that are in use.
const USUAL_MARKS: [f64; 6] = [-999.0, -9999.0, -99999.0, -999_999.0, -32767.0, -32768.0];
/// Minimum magnitude of a value that may be taken for a mark: physical quantities in their usual units are smaller.
const HUGE: f64 = 1e15;

/// Borrowed memory with numbers, which must not change while this exists.
pub trait Memory: fmt::Debug + Send + Sync {
    /// All numbers.
    fn reals(&self) -> Reals<'_>;
}

/// The numbers of a block.
#[derive(Debug, Clone)]
pub enum Values {
    /// Read or converted: the last dimension of the block is the fastest.
    Owned(OwnedReals),
    /// Borrowed in place.
    Shared {
        /// The memory that contains them.
        memory: Arc<dyn Memory>,
        /// Element of the block's first number.
        offset: usize,
        /// Elements from one number to the next along each dimension of the block.
        strides: Vec<isize>,
    },
}

impl From<OwnedReals> for Values {
    fn from(reals: OwnedReals) -> Self {
        Values::Owned(reals)
    }
}

/// Values that were taken for a mark of missing values without an attribute or option that specifies it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AssumedMark {
    /// The value.
    pub value: f64,
    /// Number of samples that had it.
    pub count: usize,
}

/// Numbers in memory, with their layout.
#[derive(Debug, Clone)]
pub(crate) struct ShapedValues {
    pub(crate) shape: Shape,
    reals: Stored,
}

#[derive(Debug, Clone)]
enum Stored {
    Owned(OwnedReals),
    Shared(Arc<dyn Memory>),
}

impl ShapedValues {
    /// The values of a block. `shape` is their layout if they are owned; `column` and `layer` are the dimensions of the
    /// block along which columns and layers follow each other; the layers of a 2D field follow along none.
    pub(crate) fn new(values: Values, shape: Shape, [column, layer]: [Option<usize>; 2]) -> Self {
        match values {
            Values::Owned(reals) => ShapedValues { shape, reals: Stored::Owned(reals) },
            Values::Shared { memory, offset, strides } => {
                let along = |dimension: Option<usize>| dimension.map_or(0, |dimension| strides[dimension]);
                let (column_stride, layer_stride) = (along(column), along(layer));
                let shape = Shape { offset, column_stride, layer_stride, ..shape };
                ShapedValues { shape, reals: Stored::Shared(memory) }
            }
        }
    }

    pub(crate) fn as_reals(&self) -> Reals<'_> {
        match &self.reals {
            Stored::Owned(reals) => reals.as_reals(),
            Stored::Shared(memory) => memory.reals(),
        }
    }

    /// Bytes of memory that these values own.
    pub(crate) fn owned_bytes(&self) -> usize {
        match &self.reals {
            Stored::Owned(reals) => reals.bytes(),
            Stored::Shared(_) => 0,
        }
    }

    /// `value` rounded to the precision of the values.
    pub(crate) fn rounded(&self, value: f64) -> f64 {
        match self.as_reals() {
            Reals::F32(_) => f64::from(value as f32),
            Reals::F64(_) => value,
        }
    }

    /// Changes every value, in f64. Shared ones are copied first.
    pub(crate) fn each(&mut self, change: impl Fn(f64) -> f64) {
        change_each(self.owned(), change);
    }

    /// Sets values to NaN. Shared ones are copied first if any are affected.
    pub(crate) fn mask(&mut self, is_missing: impl Fn(f64) -> bool) {
        if matches!(self.reals, Stored::Owned(_)) || self.all().any(&is_missing) {
            self.each(|value| if is_missing(value) { f64::NAN } else { value });
        }
    }

    /// Sets a value to NaN that is neither NaN nor `fill`. Shared values are copied first.
    pub(crate) fn mask_at(&mut self, column: usize, layer: usize, fill: f64) {
        let value = self.as_reals().get(self.element(column, layer));
        if !value.is_nan() && value != fill {
            self.owned();
            let element = self.element(column, layer);
            match self.owned() {
                OwnedReals::F32(values) => values[element] = f32::NAN,
                OwnedReals::F64(values) => values[element] = f64::NAN,
            }
        }
    }

    fn element(&self, column: usize, layer: usize) -> usize {
        let Shape { offset, column_stride, layer_stride, .. } = self.shape;
        (offset as isize + column as isize * column_stride + layer as isize * layer_stride) as usize
    }

    /// These values minus others of the same columns and layers; NaN where either is its mark for missing values.
    pub(crate) fn less(&self, own_fill: f64, other: &Self, fill: f64) -> Self {
        self.made(self.shape.columns, |column| {
            move |layer| self.value(column, layer, own_fill) - other.value(column, layer, fill)
        })
    }

    /// A value, NaN if it is `fill`.
    pub(crate) fn value(&self, column: usize, layer: usize, fill: f64) -> f64 {
        let value = self.as_reals().get(self.element(column, layer));
        if value == fill { f64::NAN } else { value }
    }

    /// The values of some columns.
    pub(crate) fn of_columns(&self, rows: &[u32]) -> Self {
        self.copied(rows.len(), |column| rows[column] as usize)
    }

    /// The values of this number of columns, which are there in `row`.
    fn copied(&self, columns: usize, row: impl Fn(usize) -> usize) -> Self {
        let reals = self.as_reals();
        self.made(columns, |column| {
            let row = row(column);
            move |layer| reals.get(self.element(row, layer))
        })
    }

    /// Values over this number of columns and the same layers, in the same precision; `column` returns the function
    /// of a column from layer to value.
    pub(crate) fn made<V: Fn(usize) -> f64>(&self, columns: usize, column: impl Fn(usize) -> V) -> Self {
        let layers = self.stored_layers();
        let values = (0..columns).map(column).flat_map(|value| (0..layers).map(value));
        let reals = match self.as_reals() {
            Reals::F32(_) => OwnedReals::F32(values.map(|value| value as f32).collect()),
            Reals::F64(_) => OwnedReals::F64(values.collect()),
        };
        let layer_stride = self.shape.layer_stride.signum().abs();
        let shape = Shape { layers: self.shape.layers, layer_stride, ..Shape::level_fastest(columns, layers) };
        ShapedValues { shape, reals: Stored::Owned(reals) }
    }

    /// All values.
    pub(crate) fn all(&self) -> impl Iterator<Item = f64> {
        let (reals, layers) = (self.as_reals(), self.stored_layers());
        let places = (0..self.shape.columns).flat_map(move |column| (0..layers).map(move |layer| (column, layer)));
        places.map(move |(column, layer)| reals.get(self.element(column, layer)))
    }

    /// A value of several samples that looks like a mark: a huge one, if all others are at
    /// most a millionth of it, or a usual mark below all others, at least as far from them as these are apart.
    pub(crate) fn outlier(&self) -> Option<AssumedMark> {
        let [lowest, highest] = ends(self.all());
        let is_usual = USUAL_MARKS.contains(&lowest);
        let mark = if is_usual || lowest.abs() > highest.abs() { lowest } else { highest };
        if !is_usual && mark.abs() < HUGE {
            return None;
        }
        let [low, high] = ends(self.all().filter(|value| *value != mark));
        let is_far = if is_usual { low - mark >= high - low } else { low.abs().max(high.abs()) <= 1e-6 * mark.abs() };
        let count = self.all().filter(|value| *value == mark).count();
        (is_far && count > 1).then_some(AssumedMark { value: mark, count })
    }

    /// Number of layers that have values of their own.
    fn stored_layers(&self) -> usize {
        if self.shape.layer_stride == 0 { 1 } else { self.shape.layers }
    }

    /// The values in owned memory; shared ones are copied, the layers of a column behind each other.
    fn owned(&mut self) -> &mut OwnedReals {
        if matches!(self.reals, Stored::Shared(_)) {
            *self = self.copied(self.shape.columns, |column| column);
        }
        match &mut self.reals {
            Stored::Owned(reals) => reals,
            Stored::Shared(_) => unreachable!("they were copied"),
        }
    }
}

/// The least and the greatest value.
fn ends(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)])
}

/// Changes every element, in f64.
pub(crate) fn change_each(reals: &mut OwnedReals, change: impl Fn(f64) -> f64) {
    match reals {
        OwnedReals::F32(v) => v.iter_mut().for_each(|x| *x = change(f64::from(*x)) as f32),
        OwnedReals::F64(v) => v.iter_mut().for_each(|x| *x = change(*x)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug)]
    struct Numbers(Vec<f64>);

    impl Memory for Numbers {
        fn reals(&self) -> Reals<'_> {
            Reals::F64(&self.0)
        }
    }

    /// Three columns of two layers in an array that is read backwards: value 10 column + layer.
    fn shared() -> ShapedValues {
        let numbers = vec![99.0, 21.0, 11.0, 1.0, 20.0, 10.0, 0.0];
        let values = Values::Shared { memory: Arc::new(Numbers(numbers)), offset: 6, strides: vec![-3, -1] };
        ShapedValues::new(values, Shape::cell_fastest(3, 2), [Some(1), Some(0)])
    }

    fn read(values: &ShapedValues) -> Vec<f64> {
        (0..6).map(|i| values.as_reals().get(values.element(i / 2, i % 2))).collect()
    }

    #[test]
    fn shared_values_are_read_in_place_and_copied_when_they_change() {
        let mut values = shared();
        assert_eq!(read(&values), [0.0, 1.0, 10.0, 11.0, 20.0, 21.0]);
        values.mask(|value| value == 99.0);
        values.mask_at(1, 1, 11.0);
        assert_eq!(values.owned_bytes(), 0, "99 is no value of the block, and 11 is missing already");
        values.mask_at(1, 1, f64::NAN);
        assert_eq!(values.owned_bytes(), 48);
        let now = read(&values);
        assert!(now[3].is_nan());
        assert_eq!([now[0], now[1], now[2], now[4], now[5]], [0.0, 1.0, 10.0, 20.0, 21.0]);
        let mut values = shared();
        values.each(|value| value + 1.0);
        assert_eq!(read(&values), [1.0, 2.0, 11.0, 12.0, 21.0, 22.0]);
    }
}
