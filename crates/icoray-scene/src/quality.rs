//! The quality of a frame.

use crate::scene::Scene;
use serde::{Deserialize, Serialize};
use std::fmt;

/// How light is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default, Serialize, Deserialize)]
pub enum Lights {
    /// None: the transfer function's own colours.
    #[default]
    Off,
    /// One mean shade per piece of a ray, however far the gradient turns in it.
    Coarse,
    /// To the tolerance.
    Full,
}

impl fmt::Display for Lights {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Lights::Off => "off",
            Lights::Coarse => "coarse",
            Lights::Full => "full",
        })
    }
}

/// The quality of a frame: that of the scene, or a lower one to meet its time budget.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Quality {
    /// Each how many-th pixel was traced, in both directions; those between are interpolated, and their errors are not
    /// known.
    pub pixel_step: u32,
    /// Largest error that was allowed in a traced pixel.
    pub tolerance: f64,
    /// Light.
    pub lights: Lights,
    /// The coarser grid on which pixels were traced, of those that the renderer has made; 0 is the model's own grid.
    pub level: u32,
}

impl Quality {
    /// The largest step between traced pixels: the coarsest raster that is still a picture.
    pub const LARGEST_STEP: u32 = 32;
}

impl fmt::Display for Quality {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "tolerance {:e}, light {}, ", self.tolerance, self.lights)?;
        if self.level > 0 {
            write!(f, "level {} of the grid, ", self.level)?;
        }
        match self.pixel_step {
            1 => f.write_str("every pixel traced"),
            step => write!(f, "one of {step} x {step} pixels traced"),
        }
    }
}

impl Default for Quality {
    fn default() -> Self {
        Quality { pixel_step: 1, tolerance: Scene::DEFAULT_TOLERANCE, lights: Lights::Off, level: 0 }
    }
}
