//! The division of the scene's tolerance among the errors of a ray.

use crate::lit::ADVANCE;
use crate::shade::Shading;
use icoray_grid::real::Real;

/// Transmittance above which a surface behind is seen, so that it may have an edge, and the difference of pixels above
/// which they have one between them: one for all tolerances, which so find the same edges.
pub const FAINTEST: f64 = 1e-3;

/// Division of the scene's tolerance along a ray: one half on the colour of pieces, the other on the light that an
/// early end leaves out. Where the shade of a piece has an error of its own, nine tenths are spent on colour, shade, and
/// what the shades of a ray's first pieces may spend in advance.
#[derive(Debug, Clone, Copy)]
pub struct Budget {
    /// Error of the colour that is allowed per absorbed light.
    pub color_tolerance: f64,
    /// Transmittance at which a ray ends; negative for rays that never end early.
    pub min_transmittance: f64,
    /// Largest linear value that a channel can have behind a ray's end.
    pub brightest: f64,
}

impl Budget {
    /// The budget of a picture with this tolerance, in which no channel is brighter than `brightest`. `lit` is the
    /// largest factor that lighting gives to a colour; `None` where the shade of a piece has no error of its own.
    #[inline]
    pub fn new(tolerance: f64, brightest: f64, lit: Option<f64>) -> Self {
        // The remainder covers parts of lit pieces that are too small to be refined.
        let [share, rest] = lit.map_or([0.5; 2], |lit| [0.89 / (1.0 + ADVANCE + lit), 0.1]);
        Budget { color_tolerance: share * tolerance, min_transmittance: rest * tolerance / brightest, brightest }
    }

    /// Error of the colour that is allowed per absorbed light in a precision: no less than the last digit, or than what
    /// rounding leaves of shades.
    #[inline]
    pub fn color_tolerance_in<T: Real>(&self, shading: Option<&Shading>) -> f64 {
        let least = shading.map_or(T::ROUNDING, |shading| shading.least_error::<T>(self.brightest));
        self.color_tolerance.max(least)
    }

    /// Whether a surface is seen behind matter that absorbs this part of the light.
    #[inline]
    pub fn sees_behind(absorbed: f64) -> bool {
        1.0 - absorbed > FAINTEST
    }

    /// This budget for rays that reach all surfaces that are seen, whatever the tolerance.
    #[inline]
    pub fn with_surfaces(self) -> Self {
        Budget { min_transmittance: self.min_transmittance.min(0.5 * FAINTEST), ..self }
    }
}
