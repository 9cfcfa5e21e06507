//! The division of the scene's tolerance among the errors of a ray.

use crate::lit::ADVANCE;
use crate::shade::Shading;
use icoray_grid::real::Real;

/// Transmittance above which a surface behind is visible, so that it may have an edge, and the contrast of pixels above
/// which there is an edge between them: equal for all tolerances, so that these find the same edges.
pub const FAINTEST: f64 = 1e-3;

/// Division of the scene's tolerance along a ray: one half for the colour of pieces, the other for the light that an
/// early end leaves out. If the shade of a piece has a separate error, nine tenths are for colour, shade, and the
/// advance that the shades of a ray's first pieces may spend.
#[derive(Debug, Clone, Copy)]
pub struct Budget {
    /// Allowed error of the colour per absorbed light.
    pub color_tolerance: f64,
    /// Transmittance at which a ray ends; negative for rays that never end early.
    pub min_transmittance: f64,
    /// Largest linear value that a channel can have behind a ray's end.
    pub brightest: f64,
}

impl Budget {
    /// The budget of a picture with this tolerance, in which no channel is brighter than `brightest`. `lit` is the
    /// largest factor that lighting gives to a colour; `None` if the shade of a piece has no separate error.
    #[inline]
    pub fn new(tolerance: f64, brightest: f64, lit: Option<f64>) -> Self {
        // The remainder covers parts of lit pieces that are too small to be refined.
        let [share, rest] = lit.map_or([0.5; 2], |lit| [0.89 / (1.0 + ADVANCE + lit), 0.1]);
        Budget { color_tolerance: share * tolerance, min_transmittance: rest * tolerance / brightest, brightest }
    }

    /// Allowed error of the colour per absorbed light in a precision: at least the last digit, or the rounding error of
    /// shades.
    #[inline]
    pub fn color_tolerance_in<T: Real>(&self, shading: Option<&Shading>) -> f64 {
        let least = shading.map_or(T::ROUNDING, |shading| shading.least_error::<T>(self.brightest));
        self.color_tolerance.max(least)
    }

    /// Whether a surface is visible behind matter that absorbs this part of the light.
    #[inline]
    pub fn sees_behind(absorbed: f64) -> bool {
        1.0 - absorbed > FAINTEST
    }

    /// This budget for rays that reach all visible surfaces, for any tolerance.
    #[inline]
    pub fn with_surfaces(self) -> Self {
        Budget { min_transmittance: self.min_transmittance.min(0.5 * FAINTEST), ..self }
    }
}
