//! The opaque core, for rays and for composed rays.

use super::{Ground, SurfaceHit};
use crate::piece::Radiance;
use crate::shade::RayShading;
use glam::DVec3;
use icoray_grid::Grid;
use icoray_grid::array::MapInline;
use icoray_grid::real::Real;

/// An opaque core of one colour, or with a ground of several colours.
#[derive(Debug, Clone, Copy)]
pub struct Core<'g> {
    color: [f64; 3],
    ground: Option<&'g Ground>,
}

impl<'g> Core<'g> {
    /// The core of linear RGB `color`, covered by `ground` if there is one; `None` if the core is hollow.
    #[inline]
    pub fn new(color: Option<[f64; 3]>, ground: Option<&'g Ground>) -> Option<Self> {
        color.map(|color| Core { color, ground })
    }

    /// The light at which a ray meets the core. `over` is the grid and the triangle above the place, if there is one;
    /// `body` is the factor of the colour that lighting gives, 1 without light.
    #[inline]
    pub fn light<T: Real>(&self, hit: &SurfaceHit, over: Option<(&Grid, u32)>, body: T) -> Radiance<T> {
        let color = self.ground.map_or(self.color, |ground| ground_color(ground, hit, over));
        let mut light = Radiance::plain(color.map_inline(|c| T::of(c) * body), T::one());
        // Colour, factor and product are rounded.
        let [r, g, b] = light.color;
        let rounded = T::of(T::ROUNDING) * r.max(g).max(b);
        light.variance = rounded * rounded;
        light
    }

    /// The light of a spherical core at `position`, in planet radii from the centre; `over` as for [`Self::light`].
    #[inline]
    pub fn round_light<T: Real>(
        &self,
        position: DVec3,
        over: Option<(&Grid, u32)>,
        shading: Option<&RayShading<T>>,
    ) -> Radiance<T> {
        let body = match shading {
            Some(shading) => shading.solid(position.normalize_or_zero()),
            None => T::one(),
        };
        self.light(&SurfaceHit::round(position), over, body)
    }
}

/// Out of line: most cores have one colour.
#[cold]
#[inline(never)]
fn ground_color(ground: &Ground, hit: &SurfaceHit, over: Option<(&Grid, u32)>) -> [f64; 3] {
    ground.color(hit, over)
}
