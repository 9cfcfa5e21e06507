//! The types of samples that models store.

use crate::gradient::{GradientInput, Gradients, MissingCells};
use crate::samples::{Outside, Samples};

mod vector;
pub use vector::{SampleVectors, VECTOR};

/// A sample type that a model stores.
pub trait Sample: Copy + Default + PartialOrd + Send + Sync + SampleVectors + 'static {
    /// The number in double precision.
    fn wide(self) -> f64;
    /// The finite number nearest to `value`.
    fn near(value: f64) -> Self;
    /// The number that is `value`, if there is one.
    #[inline]
    fn exact(value: f64) -> Option<Self> {
        Some(Self::near(value)).filter(|near| near.wide() == value)
    }
    /// The next larger number.
    fn next_up(self) -> Self;
    /// The next smaller number.
    fn next_down(self) -> Self;
    /// Computes gradients of samples of this type. As a function of the type this is compiled in this crate, and not
    /// again, with other optimisations, in those that have fields.
    fn fill_gradients(input: &GradientInput<Self>, gradients: &mut Gradients, missing: Option<MissingCells>);
    /// Finds samples of this type outside of ranges, and is compiled in this crate, too.
    fn find_outside(samples: &Samples<Self>, outside: Outside<Self>);
}

impl Sample for f32 {
    #[inline]
    fn wide(self) -> f64 {
        f64::from(self)
    }

    #[inline]
    fn near(value: f64) -> Self {
        value.clamp(Self::MIN.into(), Self::MAX.into()) as Self
    }

    #[inline]
    fn next_up(self) -> Self {
        self.next_up()
    }

    #[inline]
    fn next_down(self) -> Self {
        self.next_down()
    }

    fn fill_gradients(input: &GradientInput<Self>, gradients: &mut Gradients, missing: Option<MissingCells>) {
        input.fill_all(gradients, missing);
    }

    fn find_outside(samples: &Samples<Self>, outside: Outside<Self>) {
        samples.find(outside);
    }
}

impl Sample for f64 {
    #[inline]
    fn wide(self) -> f64 {
        self
    }

    #[inline]
    fn near(value: f64) -> Self {
        value.clamp(Self::MIN, Self::MAX)
    }

    #[inline]
    fn next_up(self) -> Self {
        self.next_up()
    }

    #[inline]
    fn next_down(self) -> Self {
        self.next_down()
    }

    fn fill_gradients(input: &GradientInput<Self>, gradients: &mut Gradients, missing: Option<MissingCells>) {
        input.fill_all(gradients, missing);
    }

    fn find_outside(samples: &Samples<Self>, outside: Outside<Self>) {
        samples.find(outside);
    }
}
