//! Changes of owned arrays, in the precision in which the file stores them.

use icoray::{OwnedReals, Shape};

/// An operation on an array after it has been read.
pub(crate) trait ChangeReals {
    /// `value` rounded to the array's precision.
    fn rounded(&self, value: f64) -> f64;

    /// Changes every element, in f64.
    fn each(&mut self, change: impl Fn(f64) -> f64);

    /// Sets an element of an array of this shape to NaN; `layer` counts the layers of the array.
    fn mask_at(&mut self, shape: &Shape, column: usize, layer: usize);

    /// Sets elements to NaN.
    fn mask(&mut self, is_missing: impl Fn(f64) -> bool) {
        self.each(|value| if is_missing(value) { f64::NAN } else { value });
    }
}

impl ChangeReals for OwnedReals {
    fn rounded(&self, value: f64) -> f64 {
        match self {
            OwnedReals::F32(_) => f64::from(value as f32),
            OwnedReals::F64(_) => value,
        }
    }

    fn each(&mut self, change: impl Fn(f64) -> f64) {
        match self {
            OwnedReals::F32(v) => v.iter_mut().for_each(|x| *x = change(f64::from(*x)) as f32),
            OwnedReals::F64(v) => v.iter_mut().for_each(|x| *x = change(*x)),
        }
    }

    fn mask_at(&mut self, shape: &Shape, column: usize, layer: usize) {
        let steps = column as isize * shape.column_stride + layer as isize * shape.layer_stride;
        let index = (shape.offset as isize + steps) as usize;
        match self {
            OwnedReals::F32(v) => v[index] = f32::NAN,
            OwnedReals::F64(v) => v[index] = f64::NAN,
        }
    }
}
