//! Reads the model's array: its layout, normalisation to the transfer function's range, missing values.

use crate::field::Field;
use crate::real::Real;
use crate::sample::Sample;
use crate::shape::ElementIndexer;

mod clear;
pub use clear::{Outside, Stored};

/// The layout of a field's array, and the normalisation of its values: `(value - shift) * scale`.
#[derive(Debug, Clone, Copy)]
pub struct SampleMapping {
    /// The positions of values in the array.
    pub elements: ElementIndexer,
    has_fill: bool,
    fill: f64,
    /// The value that is normalised to 0.
    pub shift: f64,
    /// Inverse of the range.
    pub scale: f64,
}

impl SampleMapping {
    /// The layout of `field`; values become `(value - range[0]) / (range[1] - range[0])`.
    pub fn new(field: &Field, range: [f64; 2]) -> Self {
        let (has_fill, fill) = (field.fill().is_some(), field.fill().unwrap_or(f64::NAN));
        let scale = 1.0 / (range[1] - range[0]);
        SampleMapping { elements: *field.elements(), has_fill, fill, shift: range[0], scale }
    }

    /// The mark of missing values, if the array's type can represent it.
    pub fn fill<S: Sample>(&self) -> Option<S> {
        S::exact(self.fill).filter(|_| self.has_fill)
    }

    /// A value, normalised in f64: a field of 1e30, or of 1e6 + 1, keeps its digits in an f32 kernel. NaN if it is
    /// missing.
    #[inline(always)]
    pub fn normal<T: Real>(&self, value: f64) -> T {
        let (normal, is_usual) = self.usual(value);
        if is_usual { normal } else { T::of(self.rare(value, T::LARGEST)) }
    }

    /// [`Self::normal`] without a branch, and whether the result is valid: the value is neither missing nor beyond the
    /// largest normalised value.
    #[inline(always)]
    fn usual<T: Real>(&self, value: f64) -> (T, bool) {
        let normalised = (value - self.shift) * self.scale;
        let is_fill = self.has_fill & (value == self.fill);
        (T::of(normalised), (normalised.abs() <= T::LARGEST) & !is_fill)
    }

    /// A value that is not normalised, NaN if it is missing.
    #[inline(always)]
    fn unscaled(&self, value: f64) -> f64 {
        let (_, is_usual) = self.usual::<f64>(value);
        if is_usual { value } else { self.rare(value, f64::LARGEST) / self.scale + self.shift }
    }

    #[cold]
    fn rare(&self, value: f64, largest: f64) -> f64 {
        if value == self.fill || !value.is_finite() {
            return f64::NAN;
        }
        ((value - self.shift) * self.scale).clamp(-largest, largest)
    }
}

/// A field in the model's memory, seen as normalised values on layers that rise.
#[derive(Debug, Clone, Copy)]
pub struct Samples<'a, S> {
    data: &'a [S],
    /// The layout of the array, from the innermost layer on.
    pub mapping: SampleMapping,
}

impl<'a, S: Sample> Samples<'a, S> {
    /// `data` is the field's array; values become `(value - range[0]) / (range[1] - range[0])`. If `falling` is set,
    /// the field's first layer is the outermost, and layers are read in reverse.
    pub fn new(data: &'a [S], field: &Field, falling: bool, range: [f64; 2]) -> Self {
        let field = if falling { field.upside_down() } else { *field };
        Samples { data, mapping: SampleMapping::new(&field, range) }
    }

    /// The base of the column over `cell`, for [`Self::get`].
    #[inline(always)]
    pub fn base(&self, cell: u32) -> isize {
        self.mapping.elements.base(cell as usize)
    }

    /// The sample at `layer` (counted from the innermost) over the cell of `base`.
    #[inline(always)]
    pub(crate) fn sample(&self, base: isize, layer: usize) -> S {
        self.data[self.mapping.elements.at(base, layer)]
    }

    /// The normalised value at `layer` over the cell of `base`; NaN if it is missing.
    #[inline(always)]
    pub fn get<T: Real>(&self, base: isize, layer: usize) -> T {
        self.mapping.normal(self.sample(base, layer).wide())
    }

    /// The value at `layer` over the cell of `base` as the model has it, so that differences between close values are
    /// exact; NaN if it is missing, and within the limits of normalised values.
    #[inline(always)]
    pub fn unscaled(&self, base: isize, layer: usize) -> f64 {
        self.mapping.unscaled(self.sample(base, layer).wide())
    }

    /// The `layers` samples over `cell` in the order of the array, from its lowest element on: outermost layer first if
    /// the stride from layer to layer is -1. It must be that or 1.
    #[inline(always)]
    pub fn column(&self, cell: u32, layers: usize) -> &'a [S] {
        let first = if self.mapping.elements.layer_stride() < 0 { layers - 1 } else { 0 };
        let start = self.mapping.elements.at(self.base(cell), first);
        &self.data[start..start + layers]
    }
}
