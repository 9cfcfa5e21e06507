//! Light of a part of a ray, accumulated front to back.

use icoray_grid::array::MapInline;
use icoray_grid::real::Real;

/// Colour and absorption of a piece of a ray, or of several.
#[derive(Debug, Clone, Copy)]
pub struct Radiance<T> {
    /// Premultiplied linear RGB.
    pub color: [T; 3],
    /// The part of the light from behind that is absorbed, 0 to 1.
    pub alpha: T,
    /// Largest error of a channel of `color`, without rounding.
    pub error: T,
    /// Variance of `color` and `absorbed` due to rounding, as if each piece were rounded independently.
    pub variance: T,
}

impl<T: Real> Radiance<T> {
    /// No light, nothing absorbed.
    #[inline]
    pub fn none() -> Self {
        Radiance { color: [T::zero(); 3], alpha: T::zero(), error: T::zero(), variance: T::zero() }
    }

    /// Light of one colour, without error.
    #[inline]
    pub fn plain(color: [T; 3], alpha: T) -> Self {
        Radiance { color: color.map_inline(|c| c * alpha), alpha, error: T::zero(), variance: T::zero() }
    }

    /// The light in double precision.
    #[inline]
    pub fn wide(&self) -> Radiance<f64> {
        Radiance {
            color: self.color.map_inline(T::wide),
            alpha: self.alpha.wide(),
            error: self.error.wide(),
            variance: self.variance.wide(),
        }
    }

    /// The fraction of the light from behind that passes, 0 to 1.
    #[inline(always)]
    pub fn transmittance(&self) -> T {
        T::one() - self.alpha
    }

    /// Whether a ray ends here: no more than `rest` of the light from behind passes. The light that the ray then omits,
    /// of at most `brightest` in a channel, is added to the error.
    #[inline(always)]
    pub fn ends(&mut self, rest: T, brightest: T) -> bool {
        let through = self.transmittance();
        if through > rest {
            return false;
        }
        self.error = self.error + through * brightest;
        true
    }

    /// Puts `behind` behind `self` (premultiplied `over`, front to back).
    #[inline]
    pub fn over(&mut self, behind: &Radiance<T>) {
        let through = self.transmittance();
        for k in 0..3 {
            self.color[k] = self.color[k] + through * behind.color[k];
        }
        self.alpha = self.alpha + through * behind.alpha;
        self.error = self.error + through * behind.error;
        self.variance = self.variance + through * through * behind.variance;
    }
}
