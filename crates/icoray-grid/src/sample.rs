//! The types of samples that models store.

mod vector;
pub use vector::{SampleVectors, VECTOR};

/// A sample type that a model stores.
pub trait Sample: Copy + Default + PartialOrd + Send + Sync + SampleVectors + 'static {
    /// The number in double precision.
    fn wide(self) -> f64;
    /// The finite number nearest to `value`.
    fn near(value: f64) -> Self;
    /// `value` as this type, if it is representable.
    #[inline]
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
}
