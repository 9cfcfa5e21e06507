//! Anti-aliasing of edges: a pixel with the edge of a surface in it shows the mean of [`RAYS`] rays instead of one.
//!
//! Edge pixels are found in the finished picture of one ray per pixel: those that the silhouette of a sphere passes
//! through, and, in scenes of more than one volume and a core, those next to a pixel whose ray meets other surfaces, or
//! the same ones at another depth ([`BoundarySignature`]). A pixel that differs from its neighbours by no more than
//! [`FAINTEST`] remains unchanged. So edge pixels depend on the picture alone: not on tiles, threads, ranks or devices,
//! and on the tolerance only through the pictures' errors.

use crate::raster::{Pixel, SamplePoint};
use glam::DVec3;
use icoray_kernel::FAINTEST;
use icoray_kernel::signature::BoundarySignature;
use icoray_scene::{Heights, Scene};
use rayon::prelude::*;
use std::f64::consts::SQRT_2;

/// Rays of an edge pixel.
pub(crate) const RAYS: usize = 8;
/// Offsets of their sample points from the pixel's middle, in sixteenths of its side. No two share a row or a column,
/// so that vertical and horizontal edges are resolved to an eighth.
pub(crate) const PATTERN: [[i8; 2]; RAYS] = [[1, -3], [-1, 3], [5, 1], [-3, -5], [-5, 5], [-7, -1], [3, 7], [7, -7]];
/// A surface has a step where its depth differs from that of a plane by more than this many pixel widths.
const STEP: f64 = 4.0;
/// The top of the shell has an edge where pixels differ by more than this: thin matter fades out there by itself.
const JAG: f64 = 1.0 / 32.0;
/// Pixels of a row that are excluded together.
const RUN: u32 = 16;

/// The silhouette of a sphere, or of the facets of a layer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Silhouette {
    /// Least and greatest radius.
    pub radius: [f64; 2],
    /// Minimum contrast between pixels at which it is an edge.
    pub contrast: f64,
}

/// The test for pixels that may contain an edge; the default finds none.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Edges {
    silhouettes: Vec<Silhouette>,
    surfaces: bool,
}

impl Edges {
    /// Finds the pixels that the silhouette of the core, of the least `radius`, may pass through or, if matter is dense
    /// up to the top, that of the shell; and in scenes with surfaces those next to a pixel whose ray meets other
    /// surfaces. Finds none if the scene requests one ray per pixel. `lowest_facet` returns the least radius of the
    /// facets of a layer that is a unit sphere.
    pub fn new(scene: &Scene, radius: [f64; 2], lowest_facet: impl FnOnce() -> f64) -> Self {
        if !scene.antialias {
            return Edges::default();
        }
        let (surfaces, lowest) = (scene.has_boundaries(), lowest_facet());
        let silhouette = |radius: f64, contrast| Silhouette { radius: [radius * lowest, radius], contrast };
        let core = (scene.core.is_some() && !surfaces).then(|| silhouette(radius[0], 0.0));
        let shell = (scene.scenery.heights == Heights::Mean).then(|| silhouette(radius[1], JAG));
        Edges { silhouettes: core.into_iter().chain(shell).collect(), surfaces }
    }

    pub fn is_none(&self) -> bool {
        self.silhouettes.is_empty() && !self.surfaces
    }

    /// The numbers of the edge pixels of a picture, rising.
    pub fn find(&self, scene: &Scene, picture: &[Pixel]) -> Vec<u32> {
        let view = View { scene, pixel: scene.camera.pixel_width(scene.height), picture };
        let may_show = |silhouette: &Silhouette, x: u32, y: u32, pixels: u32| {
            may_show_limb(scene, view.pixel, silhouette.radius, [x, y], pixels)
        };
        let is_edge = |x: u32, y: u32| {
            let contrast = |least: f64| view.has_contrast(x, y, least.max(FAINTEST));
            self.surfaces && view.has_step(x, y) && contrast(0.0)
                || self.silhouettes.iter().any(|of| may_show(of, x, y, 1) && contrast(of.contrast))
        };
        let row = |y: u32| {
            let may_have_edge =
                move |x: &u32| self.surfaces || self.silhouettes.iter().any(|of| may_show(of, x + RUN / 2, y, RUN));
            let runs = (0..scene.width).step_by(RUN as usize).filter(may_have_edge);
            let xs = runs.flat_map(|x| x..(x + RUN).min(scene.width));
            xs.filter(move |x| is_edge(*x, y)).map(move |x| y * scene.width + x).collect::<Vec<_>>()
        };
        (0..scene.height).into_par_iter().flat_map_iter(row).collect()
    }
}

/// A picture of one ray per pixel.
#[derive(Clone, Copy)]
struct View<'v> {
    scene: &'v Scene,
    /// Width of a pixel at distance 1 in the middle of the picture, where it is widest.
    pixel: f64,
    picture: &'v [Pixel],
}

impl View<'_> {
    fn at(&self, x: u32, y: u32) -> &Pixel {
        &self.picture[y as usize * self.scene.width as usize + x as usize]
    }

    /// The pixels before and behind a pixel in its row and in its column, if they exist.
    fn beside(&self, x: u32, y: u32) -> [[Option<&Pixel>; 2]; 2] {
        let Scene { width, height, .. } = *self.scene;
        let [left, up] = [x.checked_sub(1).map(|x| (x, y)), y.checked_sub(1).map(|y| (x, y))];
        let [right, down] = [(x + 1 < width).then_some((x + 1, y)), (y + 1 < height).then_some((x, y + 1))];
        [[left, right], [up, down]].map(|pair| pair.map(|place| place.map(|(x, y)| self.at(x, y))))
    }

    /// Whether a pixel's ray meets other surfaces than those of its neighbours, or the same ones at another depth.
    fn has_step(&self, x: u32, y: u32) -> bool {
        let most = (STEP * self.pixel) as f32;
        let mine = &self.at(x, y).surfaces;
        let differs = |other: &BoundarySignature| !mine.is_alike(other);
        self.beside(x, y).iter().any(|pair| match pair.map(|pixel| pixel.map(|pixel| &pixel.surfaces)) {
            [Some(before), Some(behind)] => differs(before) || differs(behind) || mine.bend(before, behind) > most,
            [before, behind] => before.or(behind).is_some_and(differs),
        })
    }

    /// Whether a pixel differs from an adjacent one by more than `least`.
    fn has_contrast(&self, x: u32, y: u32, least: f64) -> bool {
        let mine = self.at(x, y).color;
        let differs =
            |other: &Pixel| mine.iter().zip(other.color).any(|(mine, other)| f64::from((mine - other).abs()) > least);
        self.beside(x, y).iter().flatten().flatten().any(|other| differs(other))
    }
}

/// Whether a ray within half of `pixels` of a pixel's middle, on both axes, may pass the centre at a distance between
/// these radii; `pixel` is the width of a pixel at distance 1 in the middle of the picture.
pub(crate) fn may_show_limb(scene: &Scene, pixel: f64, [low, high]: [f64; 2], [x, y]: [u32; 2], pixels: u32) -> bool {
    let eye = DVec3::from_array(scene.camera.eye());
    let middle = SamplePoint::middle(x, y, false);
    let dir = DVec3::from_array(scene.camera.direction_at(middle.at, scene.width, scene.height));
    // Turning a ray by an angle changes its distance from the centre by at most the angle times the distance of the
    // eye.
    let reach = 0.5 * SQRT_2 * f64::from(pixels) * pixel * eye.length();
    let along = -eye.dot(dir);
    let passes_at = (eye + along * dir).length();
    along + reach > 0.0 && passes_at + reach >= low && passes_at - reach <= high
}

/// The mean of pixels, each with its weight; its error is the mean of their errors plus rounding.
pub(crate) fn weighted_mean<'p>(pixels: impl Iterator<Item = (&'p Pixel, f64)>) -> Pixel {
    let (mut color, mut error, mut whole) = ([0.0; 4], 0.0, 0.0);
    for (pixel, weight) in pixels {
        for (sum, value) in color.iter_mut().zip(pixel.color) {
            *sum += f64::from(value) * weight;
        }
        error += f64::from(pixel.error) * weight;
        whole += weight;
    }
    let color = color.map(|sum| (sum / whole) as f32);
    let error = error / whole;
    let largest = color.iter().fold(0.0f32, |most, c| most.max(*c));
    // Only the background is exact.
    let stored = if error > 0.0 { 0.5 * f64::from(f32::EPSILON) * f64::from(largest) } else { 0.0 };
    Pixel { color, error: (error + stored) as f32, surfaces: BoundarySignature::default() }
}
