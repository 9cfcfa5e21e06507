//! What the opaque planet looks like, land and sea, and lines on it and on levels.
//!
//! A kernel that has met a surface asks with a [`Sight`]: where, and which way the surface faces. [`Ground`] answers with the
//! planet's colour, not yet lit; a [`Painter`], made for one level, with the light of all lines on it, premultiplied: the
//! kernel lights both like the surface that they lie on.
//!
//! All is drawn where it is seen. A [`spot::Spot`] takes directions from the planet's centre to pixels: around the place that
//! is looked at, great circles are straight in the plane of longitude and latitude ([gnomonic](spot)), and that plane is a
//! linear map away from the screen. So lines are as wide in pixels at the limb as in the middle, and their edges are
//! smoothed over one pixel. Lines closer to each other than [`CROWDED`] pixels, or than so many times their width, fade out.

mod coast;
mod graticule;
mod mesh;
mod paint;
mod region;
mod spot;
#[cfg(test)]
mod tests;

pub(crate) use paint::Painter;
pub(crate) use spot::Sight;

use crate::grid::Grid;
use crate::scene::{Level, Scene};
use coast::Coast;
use spot::{Eye, Spot};

/// Lines that are so many pixels apart are drawn in full; those closer than one pixel not at all.
const CROWDED: f64 = 3.0;

/// Beyond so many degrees per pixel the edge between land and sea is not smoothed: only at the very limb.
const COARSEST: f64 = 3.0;

/// The opaque core of a scene in which it has more than one colour.
#[derive(Debug)]
pub(crate) struct Ground {
    eye: Eye,
    /// Linear RGB of land and sea, where they differ.
    shores: Option<([f64; 3], [f64; 3])>,
    base: [f64; 3],
    painter: Option<Painter>,
}

impl Ground {
    /// The ground of `scene`; `None` where its core is hollow or has one colour.
    pub fn new(scene: &Scene) -> Option<Self> {
        let core = scene.core?;
        let ground = scene.scenery.ground;
        let [land, ocean] = [ground.land, ground.ocean].map(|color| color.unwrap_or(core));
        let shores = (land != ocean).then_some((land, ocean));
        let painter = Painter::new(scene, Level::Ground);
        let is_plain = shores.is_none() && painter.is_none() && land == core;
        (!is_plain).then(|| Ground { eye: Eye::of(scene), shores, base: land, painter })
    }

    /// Linear RGB of the ground where it is met, before it is lit. Cells and triangles are drawn where the triangle is told
    /// over which the place lies.
    pub fn color(&self, sight: &Sight, triangle: Option<(&Grid, u32)>) -> [f64; 3] {
        let Some(spot) = Spot::new(&self.eye, sight) else { return self.base };
        let base = self.shores.map_or(self.base, |shores| shore(&spot, shores));
        let Some(painter) = &self.painter else { return base };
        let [r, g, b, opacity] = painter.light(&spot, triangle);
        [0, 1, 2].map(|k| [r, g, b][k] + (1.0 - opacity) * base[k])
    }
}

/// The colour of land or sea, mixed within half a pixel of the coast.
fn shore(spot: &Spot, (land, ocean): ([f64; 3], [f64; 3])) -> [f64; 3] {
    let coast = Coast::get();
    let far = coast.distance(spot, 0.5, COARSEST).unwrap_or(0.5);
    let part = if coast.is_land(spot.lon_deg(), spot.lat_deg()) { 0.5 + far } else { 0.5 - far };
    [0, 1, 2].map(|k| ocean[k] + part * (land[k] - ocean[k]))
}
