//! The values at a triangle's three cells, read together.

use super::{Sample, Samples};
use crate::kernel::real::Real;

impl<S: Sample> Samples<'_, S> {
    /// [`Self::get`] of three columns, which asks once whether all are usual.
    #[inline(always)]
    pub fn three<T: Real>(&self, bases: [isize; 3], layer: usize) -> [T; 3] {
        let [a, b, c] = bases.map(|base| self.data[self.elements.at(base, layer)].wide());
        let normalised = [a, b, c].map(|value| (value - self.shift) * self.scale);
        let is_usual = |k: usize| normalised[k].abs() <= T::LARGEST;
        let is_fill = self.has_fill && ((a == self.fill) | (b == self.fill) | (c == self.fill));
        if is_usual(0) & is_usual(1) & is_usual(2) & !is_fill {
            return normalised.map(T::of);
        }
        self.rare_three(bases, layer)
    }

    #[cold]
    #[inline(never)]
    fn rare_three<T: Real>(&self, bases: [isize; 3], layer: usize) -> [T; 3] {
        bases.map(|base| self.get(base, layer))
    }
}
