//! Colours of the opaque planet, land and sea, and lines on it and on levels.
//!
//! A kernel describes the place at which a ray hits a surface by a [`SurfaceHit`]: position and normal. [`Ground`]
//! returns the planet's colour there, before lighting; a [`Painter`], made for one level, returns the premultiplied
//! light of all lines on it. The kernel lights both like the surface on which they lie.
//!
//! Lines are computed per pixel. A `ScreenJacobian` maps directions from the planet's centre to pixels: around the hit,
//! great circles are straight in the plane of longitude and latitude (gnomonic), and a linear map takes that plane to
//! the screen. So lines are as wide in pixels at the limb as in the middle, and their edges are smoothed over one
//! pixel. Lines closer to each other than `CROWDED` pixels, or than `CROWDED` times their width, fade out.

mod core;
mod graticule;
mod line_map;
mod mesh;
mod paint;
mod region;
mod screen_jacobian;
#[cfg(test)]
mod tests;

pub use core::Core;
pub use line_map::coast_runs;
pub use paint::Painter;
pub use screen_jacobian::SurfaceHit;

use icoray_grid::Grid;
use icoray_scene::{Level, Scene};
use line_map::LineMap;
use screen_jacobian::{ScreenJacobian, View};
use std::sync::Arc;

/// Distance of lines in pixels from which they are drawn in full; those closer than one pixel are not drawn.
const CROWDED: f64 = 3.0;

/// Degrees per pixel beyond which the edge between land and sea is not smoothed: only at the very limb.
const COARSEST: f64 = 3.0;

/// The opaque core of a scene in which it has more than one colour.
#[derive(Debug)]
pub struct Ground {
    eye: View,
    /// Linear RGB of land and sea, if they differ, and the coast between them.
    shores: Option<([f64; 3], [f64; 3], Arc<LineMap>)>,
    base: [f64; 3],
    painter: Option<Painter>,
}

impl Ground {
    /// The ground of `scene`; `None` if its core is hollow or has one colour.
    pub fn new(scene: &Scene) -> Option<Self> {
        let core = scene.core?;
        let ground = scene.scenery.ground;
        let [land, ocean] = [ground.land, ground.ocean].map(|color| color.unwrap_or(core));
        let eye = View::of(scene);
        let shores = (land != ocean).then(|| (land, ocean, LineMap::of_coasts(&eye)));
        let painter = Painter::new(scene, Level::Ground);
        let has_one_color = shores.is_none() && painter.is_none() && land == core;
        (!has_one_color).then_some(Ground { eye, shores, base: land, painter })
    }

    /// Linear RGB of the ground at a hit, before lighting. Cells and triangles are drawn if `triangle`, that over which
    /// the place lies, is given.
    pub fn color(&self, hit: &SurfaceHit, triangle: Option<(&Grid, u32)>) -> [f64; 3] {
        let Some(jacobian) = ScreenJacobian::new(&self.eye, hit) else { return self.base };
        let base = self.shores.as_ref().map_or(self.base, |shores| shore(&jacobian, shores));
        let Some(painter) = &self.painter else { return base };
        let [r, g, b, opacity] = painter.light(&jacobian, triangle);
        [0, 1, 2].map(|k| [r, g, b][k] + (1.0 - opacity) * base[k])
    }
}

/// The colour of land or sea, mixed within half a pixel of the coast.
fn shore(jacobian: &ScreenJacobian, (land, ocean, coast): &([f64; 3], [f64; 3], Arc<LineMap>)) -> [f64; 3] {
    let far = coast.distance(jacobian, 0.5, COARSEST).unwrap_or(0.5);
    let part = if coast.is_land(jacobian.lon_deg(), jacobian.lat_deg()) { 0.5 + far } else { 0.5 - far };
    [0, 1, 2].map(|k| ocean[k] + part * (land[k] - ocean[k]))
}
