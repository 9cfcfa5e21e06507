//! Reading the model's array: its layout, normalisation to the transfer function's range, missing values.

use super::real::Real;
use crate::field::Field;
use crate::shape::Elements;

mod clear;
pub(crate) use clear::Stored;

/// A sample type that a model stores.
pub(crate) trait Sample: Copy + PartialOrd + Send + Sync + 'static {
    fn wide(self) -> f64;
    /// The finite number nearest to `value`.
    fn near(value: f64) -> Self;
    /// The number that is `value`, if there is one.
    fn exact(value: f64) -> Option<Self> {
        Some(Self::near(value)).filter(|near| near.wide() == value)
    }
    /// The next larger number.
    fn next_up(self) -> Self;
    /// The next smaller number.
    fn next_down(self) -> Self;
}

impl Sample for f32 {
    #[inline]
    fn wide(self) -> f64 {
        f64::from(self)
    }

    fn near(value: f64) -> Self {
        value.clamp(Self::MIN.into(), Self::MAX.into()) as Self
    }

    fn next_up(self) -> Self {
        self.next_up()
    }

    fn next_down(self) -> Self {
        self.next_down()
    }
}

impl Sample for f64 {
    #[inline]
    fn wide(self) -> f64 {
        self
    }

    fn near(value: f64) -> Self {
        value.clamp(Self::MIN, Self::MAX)
    }

    fn next_up(self) -> Self {
        self.next_up()
    }

    fn next_down(self) -> Self {
        self.next_down()
    }
}

/// A field in the model's memory, seen as normalised values on layers that rise.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Samples<'a, S> {
    data: &'a [S],
    elements: Elements,
    has_fill: bool,
    fill: f64,
    shift: f64,
    scale: f64,
}

impl<'a, S: Sample> Samples<'a, S> {
    /// `data` is the field's array; values become `(value - range[0]) / (range[1] - range[0])`. Layers are turned round
    /// where the field's first one is the outermost.
    pub fn new(data: &'a [S], field: &Field, falling: bool, range: [f64; 2]) -> Self {
        let elements = if falling { field.elements().upside_down() } else { *field.elements() };
        let (has_fill, fill) = (field.fill().is_some(), field.fill().unwrap_or(f64::NAN));
        Samples { data, elements, has_fill, fill, shift: range[0], scale: 1.0 / (range[1] - range[0]) }
    }

    /// Where the values over `cell` begin, for [`Self::get`].
    #[inline(always)]
    pub fn base(&self, cell: u32) -> isize {
        self.elements.base(cell as usize)
    }

    /// [`Self::base`] of three cells, which asks once whether columns are blocked.
    #[inline(always)]
    pub fn bases(&self, cells: [u32; 3]) -> [isize; 3] {
        self.elements.bases(cells.map(|cell| cell as usize))
    }

    /// Where the sample at `layer` is, for [`Self::at`].
    #[inline(always)]
    pub fn element(&self, base: isize, layer: usize) -> usize {
        self.elements.at(base, layer)
    }

    /// Elements from one layer to the next.
    #[inline(always)]
    pub fn layer_stride(&self) -> isize {
        self.elements.layer_stride()
    }

    /// The sample of that element.
    #[inline(always)]
    pub fn at(&self, element: usize) -> S {
        self.data[element]
    }

    /// The normalised value at `layer` (counted from the innermost) over the cell of `base`; NaN where it is missing.
    #[inline(always)]
    pub fn get<T: Real>(&self, base: isize, layer: usize) -> T {
        self.normal(self.at(self.element(base, layer)))
    }

    /// A sample, normalised in f64: a field of 1e30, or of 1e6 + 1, keeps its digits in an f32 kernel.
    #[inline(always)]
    pub fn normal<T: Real>(&self, sample: S) -> T {
        let (value, is_usual) = self.usual(sample);
        if is_usual { value } else { T::of(self.rare(sample.wide(), T::LARGEST)) }
    }

    /// The same without a branch, and whether it is right: the sample is neither missing nor beyond all bounds.
    #[inline(always)]
    pub fn usual<T: Real>(&self, sample: S) -> (T, bool) {
        let value = sample.wide();
        let normalised = (value - self.shift) * self.scale;
        let is_fill = self.has_fill & (value == self.fill);
        (T::of(normalised), (normalised.abs() <= T::LARGEST) & !is_fill)
    }

    #[cold]
    fn rare(&self, value: f64, largest: f64) -> f64 {
        if value == self.fill || !value.is_finite() {
            return f64::NAN;
        }
        ((value - self.shift) * self.scale).clamp(-largest, largest)
    }
}
