//! Changes owned arrays, in the precision in which the file stores them.

use icoray::OwnedReals;

/// Changes every element, in f64.
pub(crate) fn change_each(reals: &mut OwnedReals, change: impl Fn(f64) -> f64) {
    match reals {
        OwnedReals::F32(v) => v.iter_mut().for_each(|x| *x = change(f64::from(*x)) as f32),
        OwnedReals::F64(v) => v.iter_mut().for_each(|x| *x = change(*x)),
    }
}
