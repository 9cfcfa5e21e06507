//! The precision of the inner loop: f32 or f64.

/// A floating-point type that the kernel is instantiated with.
pub(crate) trait Real: num_traits::Float + Send + Sync + 'static {
    /// A ray stops once less than this much light comes through.
    const OPAQUE: f64;
    /// Normalised field values are held within ± this, so that products of two of them stay finite.
    const LARGEST: f64;

    /// Rounds a double.
    fn of(value: f64) -> Self;
    /// Widens.
    fn wide(self) -> f64;
}

impl Real for f32 {
    const OPAQUE: f64 = 1e-6;
    const LARGEST: f64 = 1e15;

    #[inline]
    fn of(value: f64) -> Self {
        value as f32
    }

    #[inline]
    fn wide(self) -> f64 {
        f64::from(self)
    }
}

impl Real for f64 {
    const OPAQUE: f64 = 1e-14;
    const LARGEST: f64 = 1e100;

    #[inline]
    fn of(value: f64) -> Self {
        value
    }

    #[inline]
    fn wide(self) -> f64 {
        self
    }
}

/// `a + w·(b - a)`: exactly `a` at `w = 0` and wherever `a = b`.
#[inline]
pub(crate) fn lerp<T: Real>(a: T, b: T, w: T) -> T {
    a + w * (b - a)
}
