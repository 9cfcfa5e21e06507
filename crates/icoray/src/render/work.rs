//! What rays of a frame have in common, and what a pixel shows.

use super::{Derived, OnDevice, Renderer};
use crate::edges::Edges;
use crate::frame::{Certainty, Counts};
use crate::gradient::Gradients;
use crate::grid::Grid;
use crate::ground::Ground;
use crate::kernel::Real;
use crate::kernel::column::Shell;
use crate::kernel::leap::Visible;
use crate::kernel::piece::{Light, Method};
use crate::kernel::ray::{Budget, Caster, Casts, Start};
use crate::kernel::sample::AnySamples;
use crate::kernel::signature::Signature;
use crate::kernel::transfer::Spans;
use crate::plan::Plan;
use crate::quality::{Deadline, Lights, Quality};
use crate::raster::{self, Pixel, Place, Raster, Tile, Tiling};
use crate::scene::{Paint, Precision, Scene};
use glam::DVec3;
use rayon::prelude::*;

/// What the scene asks for.
pub(super) fn asked(scene: &Scene) -> Quality {
    let lights = if scene.lighting.is_some() { Lights::Full } else { Lights::Off };
    Quality { pixel_step: 1, tolerance: scene.tolerance, lights }
}

/// What traces the rays of a picture.
pub(super) trait Rays: Sync {
    /// Makes what rays are traced with, where that is not done yet.
    fn get_ready(&self);
    /// What traces rays at a quality.
    fn caster(&self, quality: &Quality) -> Box<dyn Casts + '_>;
}

/// A picture's work: its rays, on the thread pool and on a device.
pub(super) struct Work<'f> {
    pub renderer: &'f Renderer,
    pub scene: &'f Scene,
    pub plan: &'f Plan,
    /// Radii of the innermost and outermost layer.
    pub radius: [f64; 2],
    /// What the core looks like where it has more than one colour.
    pub ground: Option<&'f Ground>,
    pub rays: &'f dyn Rays,
    /// Which pixels may have an edge in them.
    pub edges: Edges,
}

/// Rays through one field alone.
pub(super) struct Plain<'f, T> {
    pub renderer: &'f Renderer,
    pub scene: &'f Scene,
    pub plan: &'f Plan,
    pub grid: &'f Grid<'f>,
    pub shell: &'f Shell<T>,
    pub spans: &'f Spans<T>,
    pub samples: AnySamples<'f>,
    pub visible: &'f Derived<'f, Visible>,
    pub gradients: &'f Derived<'f, Gradients>,
    pub ground: Option<&'f Ground>,
}

impl Work<'_> {
    /// The whole picture's, each pixel traced.
    pub(super) fn raster(&self) -> Raster {
        Raster { width: self.scene.width, height: self.scene.height, step: 1 }
    }

    /// The quality that is asked, or the best one that keeps the deadline on whoever draws.
    pub(super) fn pick(
        &self,
        asked: Quality,
        deadline: Option<Deadline>,
        on_device: &mut OnDevice,
    ) -> Quality {
        let Some(deadline) = deadline else { return asked };
        on_device.get_ready(&asked, self.raster());
        if !on_device.is_there() {
            // No probe's time.
            self.rays.get_ready();
        }
        deadline.pick(asked, self.raster(), on_device.is_there(), |quality, raster| {
            let all: Vec<u32> = (0..raster.tiles()).collect();
            self.trace(quality, &raster, &all, on_device, &|_| ());
        })
    }

    /// Traces tiles, those of a raster on the device as far as that goes, each given away when it is done.
    pub(super) fn trace(
        &self,
        quality: &Quality,
        tiling: &dyn Tiling,
        tiles: &[u32],
        on_device: &mut OnDevice,
        give: &(dyn Fn(Tile) + Sync),
    ) {
        let raster = tiling.raster();
        let left = match raster {
            Some(raster) => on_device.trace(quality, raster, tiles, give),
            None => tiles.to_vec(),
        };
        if left.is_empty() {
            return;
        }
        let caster = self.rays.caster(quality);
        let draw = |places: &[Place], counts: &mut Counts| {
            if raster.is_some()
                && self.renderer.savings.tiles
                && passes_by(self.scene, places, caster.outer())
            {
                vec![shown(self.scene, caster.budget().brightest, None); places.len()]
            } else {
                pixels(self.scene, &*caster, places, counts)
            }
        };
        raster::trace(tiling, &left, draw).for_each(give);
    }
}

/// The same, N values carried along: 1 without light, else 4.
pub(super) struct Carrying<'p, 'f, T, const N: usize>(pub &'p Plain<'f, T>);

impl<T: Real, const N: usize> Rays for Carrying<'_, '_, T, N> {
    fn get_ready(&self) {
        self.0.visible.get();
        self.0.gradients.get();
    }

    fn caster(&self, quality: &Quality) -> Box<dyn Casts + '_> {
        let Plain { renderer, scene, plan, grid, shell, spans, samples, visible, gradients, ground } =
            *self.0;
        let is_lit = quality.lights != Lights::Off;
        let visible = visible.get();
        let top = if renderer.savings.layers { visible.top.max(1) } else { shell.layers() - 1 };
        Box::new(Caster::<T, N> {
            grid,
            shell,
            spans,
            samples,
            visible,
            outer: plan.radius[top],
            gradients: gradients.get(),
            method: scene.method,
            budget: budget(renderer, scene, quality),
            shading: plan.shading.filter(|_| is_lit),
            is_coarse: quality.lights == Lights::Coarse,
            level: renderer.vectors().filter(|_| scene.method == Method::Exact),
            integrates: renderer.integrates,
            core: scene.core,
            ground,
        })
    }
}

/// How rays may spend the tolerance.
pub(super) fn budget(renderer: &Renderer, scene: &Scene, quality: &Quality) -> Budget {
    let mut budget = allowed(scene, quality);
    if !renderer.savings.ends {
        // Less than any transmittance.
        budget.rest = -1.0;
    }
    budget
}

/// How rays may spend the tolerance where they end as early as they may.
pub(crate) fn allowed(scene: &Scene, quality: &Quality) -> Budget {
    // The general kernel has one error of both.
    let is_apart = quality.lights != Lights::Off && scene.scenery.is_plain();
    let lit = scene.lighting.filter(|_| is_apart).map(|light| light.ambient + light.diffuse);
    Budget::new(quality.tolerance, brightest(scene), lit)
}

/// The most that a channel can hold behind a ray's end: the brightest of what is in the scene.
pub(crate) fn brightest(scene: &Scene) -> f64 {
    let most = |colors: &mut dyn Iterator<Item = [f64; 3]>| colors.flatten().fold(0.0, f64::max);
    let paints = scene.scenery.paints().filter_map(|paint| match paint {
        Paint::Plain(color) => Some(*color),
        Paint::Field { .. } => None,
    });
    let paintings = scene.paintings();
    let knots = paintings.iter().flat_map(|painting| &painting.transfer.knots);
    let field = most(&mut knots.map(|knot| knot.color).chain(paints));
    let lit = scene.lighting.map_or(field, |l| (l.ambient + l.diffuse) * field + l.specular);
    let ground = scene.scenery.ground;
    let lines = scene.scenery.lines.iter().map(|lines| lines.color);
    let solid = scene.core.into_iter().chain(ground.land).chain(ground.ocean).chain(lines);
    let solid = most(&mut { solid }) * scene.lighting.map_or(1.0, |l| l.ambient + l.diffuse);
    // A transparent picture has an opacity that goes to 1.
    let back = scene.background.map_or(1.0, |back| most(&mut [back].into_iter()));
    lit.max(solid).max(back).max(0.01)
}

/// Only an unlit integral in f64 is bounded throughout, where each pixel is traced.
pub(super) fn certainty(scene: &Scene, quality: &Quality) -> Certainty {
    let is_exact = scene.method == Method::Exact && scene.precision == Precision::F64;
    let is_bound =
        is_exact && scene.lighting.is_none() && quality.pixel_step == 1 && scene.scenery.is_plain();
    if is_bound { Certainty::Bound } else { Certainty::Estimate }
}

/// What a picture's text says of its scene.
pub(super) fn notes(scene: &Scene) -> Vec<(&'static str, String)> {
    let [low, high] = scene.transfer.range();
    vec![
        ("transfer range", format!("{low} to {high}")),
        ("camera", scene.camera.describe()),
        ("exaggeration", scene.exaggeration.to_string()),
    ]
}

/// Standard deviations of rounding that the error of a pixel counts. Each rounding's largest size, 1.7 times its standard
/// deviation, stands for the latter.
const DEVIATIONS: f64 = 4.0;

/// What rounding of positions may do to a ray that grazes an edge of the mesh.
const GEOMETRY: f64 = 1e-9;

/// The light of pixels, over the background.
fn pixels(scene: &Scene, caster: &dyn Casts, places: &[Place], counts: &mut Counts) -> Vec<Pixel> {
    let mut pixels = vec![Pixel::default(); places.len()];
    let mut rays = places.iter().enumerate().map(|(number, place)| {
        let (eye, dir) = ray(scene, place.at);
        Start { number, eye, dir, begins_row: place.begins_row }
    });
    let brightest = caster.budget().brightest;
    caster.cast(&mut rays, counts, &mut |number, light, surfaces| {
        pixels[number] = Pixel { surfaces, ..shown(scene, brightest, light) };
    });
    pixels
}

/// Whether no ray through a rectangle of pixels, the first and the last of which are opposite corners, comes within `radius` of
/// the centre.
fn passes_by(scene: &Scene, places: &[Place], radius: f64) -> bool {
    /// More than rounding does to an angle.
    const SLACK: f64 = 1e-6;
    let (Some(first), Some(last)) = (places.first(), places.last()) else { return true };
    let ([left, top], [right, bottom]) = (first.at, last.at);
    let corners = [[left, top], [right, top], [left, bottom], [right, bottom]];
    let dirs = corners.map(|at| ray(scene, at).1);
    let eye = DVec3::from_array(scene.camera.eye());
    if eye.length() <= radius {
        return false;
    }
    let axis = (dirs[0] + dirs[1] + dirs[2] + dirs[3]).normalize();
    let half = dirs.map(|dir| dir.angle_between(axis)).into_iter().fold(0.0, f64::max);
    let globe = (radius / eye.length()).asin();
    axis.angle_between(-eye) > half + globe + SLACK
}

/// The ray through a place of the picture, in pixels from its upper left corner: the eye and a unit vector.
pub(super) fn ray(scene: &Scene, at: [f64; 2]) -> (DVec3, DVec3) {
    let dir = scene.camera.direction_at(at, scene.width, scene.height);
    (DVec3::from_array(scene.camera.eye()), DVec3::from_array(dir))
}

/// What light shows over the background; `None` where the ray misses the shell.
pub(super) fn shown(scene: &Scene, brightest: f64, met: Option<Light<f64>>) -> Pixel {
    let light = met.unwrap_or(Light::none());
    let (color, absorbed) = (light.color, light.absorbed);
    let color = match scene.background {
        None => [color[0], color[1], color[2], absorbed],
        Some(back) => {
            let [r, g, b] = [0, 1, 2].map(|k| color[k] + (1.0 - absorbed) * back[k]);
            [r, g, b, 1.0]
        }
    };
    let rounding = DEVIATIONS * light.variance.sqrt();
    // The picture itself is in f32.
    let stored = color.iter().fold(0.0f64, |most, c| most.max(*c)) * f64::from(f32::EPSILON) / 2.0;
    let error = if met.is_some() { light.error + rounding + stored + GEOMETRY } else { 0.0 };
    let error = error.min(brightest.max(1.0)) as f32;
    Pixel { color: color.map(|c| c as f32), error, surfaces: Signature::default() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::plane::RayLine;

    /// Tiles of several cameras: none that a ray of meets the globe is passed by, and most of the others are.
    #[test]
    fn tiles_that_pass_by_are_those_beside_the_globe() {
        let cameras = [
            "lon = 20\nlat = 35\ndistance = 3.2\nfov = 90",
            "eye = [2, 2, 0]\ntarget = [0, 2, 0.3]\nfov = 60",
            "eye = [0, 0, 1.01]\ntarget = [1, 0, 1.3]\nfov = 120",
            "eye = [1.3, 0, 0]\ntarget = [2, 0, 0]\nfov = 70",
            "eye = [0.5, 0, 0]\ntarget = [2, 0, 0]\nfov = 70",
        ];
        let (mut beside, mut passed) = (0, 0);
        for camera in cameras {
            for [width, height] in [[200, 130], [31, 250]] {
                let scene = Scene::parse(&format!(
                    "field = \"f\"\n[image]\nwidth = {width}\nheight = {height}\n[camera]\n{camera}\n\
                     [transfer]\nmap = \"viridis\"\nrange = [0, 1]\nopacity = [[0, 0.5], [1, 0.5]]\n"
                ))
                .unwrap();
                let raster = Raster { width, height, step: 1 };
                let all: Vec<u32> = (0..raster.tiles()).collect();
                let draw = |places: &[Place], counts: &mut Counts| {
                    let rays = places.iter().map(|place| ray(&scene, place.at));
                    let hits = rays.filter(|(eye, dir)| RayLine::new(*eye, *dir, 1.1).is_some()).count();
                    counts.columns = u64::from(hits == 0);
                    counts.frusta = u64::from(passes_by(&scene, places, 1.1));
                    vec![Pixel::default(); places.len()]
                };
                for tile in raster::trace(&raster, &all, draw).collect::<Vec<_>>() {
                    assert!(tile.counts.frusta <= tile.counts.columns, "{camera}: tile {}", tile.number);
                    (beside, passed) = (beside + tile.counts.columns, passed + tile.counts.frusta);
                }
            }
        }
        assert!(beside > 200 && passed * 10 > beside * 8, "{passed} of {beside}");
    }
}
