//! Changes owned arrays, in the precision in which the file stores them.

use icoray::OwnedReals;

/// An operation on an array after it has been read.
pub(crate) trait ChangeReals {
    /// Changes every element, in f64.
    fn each(&mut self, change: impl Fn(f64) -> f64);

    /// Sets an element to NaN.
    fn mask_element(&mut self, element: usize);

    /// Sets elements to NaN.
    fn mask(&mut self, is_missing: impl Fn(f64) -> bool) {
        self.each(|value| if is_missing(value) { f64::NAN } else { value });
    }
}

impl ChangeReals for OwnedReals {
    fn each(&mut self, change: impl Fn(f64) -> f64) {
        match self {
            OwnedReals::F32(v) => v.iter_mut().for_each(|x| *x = change(f64::from(*x)) as f32),
            OwnedReals::F64(v) => v.iter_mut().for_each(|x| *x = change(*x)),
        }
    }

    fn mask_element(&mut self, element: usize) {
        match self {
            OwnedReals::F32(v) => v[element] = f32::NAN,
            OwnedReals::F64(v) => v[element] = f64::NAN,
        }
    }
}
