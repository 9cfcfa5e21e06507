//! Owned real numbers in the precision in which the file stores them.

use icoray::Reals;

/// An owned array in either precision.
#[derive(Debug, Clone)]
pub(crate) enum OwnedReals {
    F32(Vec<f32>),
    F64(Vec<f64>),
}

impl OwnedReals {
    pub(crate) fn as_reals(&self) -> Reals<'_> {
        match self {
            OwnedReals::F32(v) => v.as_slice().into(),
            OwnedReals::F64(v) => v.as_slice().into(),
        }
    }

    pub(crate) fn bytes(&self) -> usize {
        match self {
            OwnedReals::F32(v) => size_of_val(v.as_slice()),
            OwnedReals::F64(v) => size_of_val(v.as_slice()),
        }
    }

    /// `value` as an element of this array reads once widened again.
    pub(crate) fn rounded(&self, value: f64) -> f64 {
        match self {
            OwnedReals::F32(_) => f64::from(value as f32),
            OwnedReals::F64(_) => value,
        }
    }

    /// Puts NaN wherever `mark` stands.
    pub(crate) fn void(&mut self, mark: f64) {
        match self {
            OwnedReals::F32(v) => v.iter_mut().filter(|x| f64::from(**x) == mark).for_each(|x| *x = f32::NAN),
            OwnedReals::F64(v) => v.iter_mut().filter(|x| **x == mark).for_each(|x| *x = f64::NAN),
        }
    }

    /// Puts NaN wherever a value lies below the first of `ends` or above the second.
    pub(crate) fn void_outside(&mut self, [low, high]: [f64; 2]) {
        let is_outside = |x: f64| x < low || x > high;
        match self {
            OwnedReals::F32(v) => {
                v.iter_mut().filter(|x| is_outside(f64::from(**x))).for_each(|x| *x = f32::NAN);
            }
            OwnedReals::F64(v) => v.iter_mut().filter(|x| is_outside(**x)).for_each(|x| *x = f64::NAN),
        }
    }

    /// Changes every element, in f64.
    pub(crate) fn each(&mut self, change: impl Fn(f64) -> f64) {
        match self {
            OwnedReals::F32(v) => v.iter_mut().for_each(|x| *x = change(f64::from(*x)) as f32),
            OwnedReals::F64(v) => v.iter_mut().for_each(|x| *x = change(*x)),
        }
    }

    /// Appends an element, rounded to the array's precision.
    pub(crate) fn push(&mut self, value: f64) {
        match self {
            OwnedReals::F32(v) => v.push(value as f32),
            OwnedReals::F64(v) => v.push(value),
        }
    }

    /// Puts NaN at `index`.
    pub(crate) fn void_at(&mut self, index: usize) {
        match self {
            OwnedReals::F32(v) => v[index] = f32::NAN,
            OwnedReals::F64(v) => v[index] = f64::NAN,
        }
    }
}
