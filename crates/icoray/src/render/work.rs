//! Tracing of tiles on the CPU and on a device, and the conversion of a ray's light to a pixel.

use super::context::FrameContext;
use super::device::OnDevice;
use super::draw::BuiltScene;
use super::lazy::Lazy;
use super::levels::{LevelChoice, LevelRays};
use super::renderer::Renderer;
use crate::edges::Edges;
use crate::plan::budget::allowed;
use crate::raster::{self, Pixel, Raster, SamplePoint, Tile, Tiling};
use crate::time_budget::{Deadline, probe};
use glam::DVec3;
use icoray_grid::array::MapInline;
use icoray_kernel::general::PaintedPlace;
use icoray_kernel::ground::Ground;
use icoray_kernel::piece::Radiance;
use icoray_kernel::signature::BoundarySignature;
use icoray_kernel::{Budget, Counts, PrimaryRay};
use icoray_output::Certainty;
use icoray_scene::{Lights, Method, Precision, Quality, Scene};
use rayon::prelude::*;
use std::sync::{Mutex, PoisonError};

/// The quality that the scene requests.
pub(super) fn requested_quality(scene: &Scene) -> Quality {
    let lights = if scene.lighting.is_some() { Lights::Full } else { Lights::Off };
    Quality { tolerance: scene.tolerance, lights, ..Quality::default() }
}

/// The light at a place that the ray from an eye along a direction meets.
pub(super) type Painter<'p> = dyn Fn(DVec3, DVec3, &PaintedPlace) -> Radiance<f64> + Sync + 'p;

/// A picture's work: its rays, on the thread pool and on a device.
pub(super) struct Work<'p, 'f> {
    pub context: &'p FrameContext<'f>,
    pub built: &'p Lazy<'f, BuiltScene<'f>>,
    /// Radii of the innermost and outermost layer.
    pub radius: [f64; 2],
    /// The ground, if the core has more than one colour.
    pub ground: Option<&'p Ground>,
    /// The test for pixels that may contain an edge.
    pub edges: Edges,
    /// The rays on coarser grids, the finest first.
    pub levels: &'p [&'p dyn LevelRays],
}

impl Work<'_, '_> {
    /// The raster of the whole picture, in which each pixel is traced.
    pub(super) fn raster(&self) -> Raster {
        Raster { width: self.context.scene.width, height: self.context.scene.height, step: 1 }
    }

    /// The requested quality, or the best one that keeps the deadline on the device that draws.
    pub(super) fn pick(&self, asked: Quality, deadline: Option<Deadline>, on_device: &mut OnDevice) -> Quality {
        if let LevelChoice::Fixed(level) = self.context.renderer.level_choice {
            return Quality { level: level.min(self.levels.len() as u32), ..asked };
        }
        let Some(deadline) = deadline else { return self.coarsest_within(asked, on_device) };
        // Without tiles the device only uploads its inputs: the time of a probe is that of its rays.
        self.trace(&asked, &self.raster(), &[], on_device, &|_| ());
        let levels = self.levels.len() as u32;
        deadline.pick(asked, self.raster(), (on_device.is_there(), levels), |quality, raster| {
            let all: Vec<u32> = (0..raster.tiles()).collect();
            self.trace(quality, &raster, &all, on_device, &|_| ());
        })
    }

    /// The level on which the picture takes the fewest steps, with the pixels that are traced again as their errors
    /// exceed the tolerance, by some pixels.
    fn coarsest_within(&self, asked: Quality, on_device: &mut OnDevice) -> Quality {
        /// Part of the steps of the model's grid that a level may take at most.
        const WORTHWHILE: f64 = 0.8;
        /// Steps of scattered pixels, which share nothing with their neighbours, of those of others.
        const SCATTERED: f64 = 2.0;
        if self.levels.is_empty() || asked.lights != Lights::Off || self.ground.is_some() {
            return asked;
        }
        let raster = probe(self.raster());
        let all: Vec<u32> = (0..raster.tiles()).collect();
        let mut measure = |level: u32| {
            let found = Mutex::new((Counts::default(), 0));
            self.trace(&Quality { level, ..asked }, &raster, &all, on_device, &|tile| {
                let exceeds = |pixel: &&Pixel| f64::from(pixel.error) > asked.tolerance;
                let mut found = found.lock().unwrap_or_else(PoisonError::into_inner);
                found.0 += tile.counts;
                found.1 += tile.pixels.iter().filter(exceeds).count();
            });
            let (counts, exceeding) = found.into_inner().unwrap_or_else(PoisonError::into_inner);
            let steps = (counts.columns + counts.frusta) as f64;
            (steps, exceeding as f64 / counts.rays.max(1) as f64)
        };
        let (whole, _) = measure(0);
        let costs = (1..=self.levels.len() as u32).map(|level| {
            let (steps, exceeding) = measure(level);
            (steps + SCATTERED * exceeding * whole, level)
        });
        let least = costs.min_by(|a, b| a.0.total_cmp(&b.0));
        let level = least.filter(|(cost, _)| *cost < WORTHWHILE * whole).map_or(0, |(_, level)| level);
        Quality { level, ..asked }
    }

    /// Traces tiles, those of a raster on the device as far as it can, and passes each on when it is done.
    pub(super) fn trace(
        &self,
        quality: &Quality,
        tiling: &dyn Tiling,
        tiles: &[u32],
        on_device: &mut OnDevice,
        give: &(dyn Fn(Tile) + Sync),
    ) {
        let FrameContext { renderer, scene, .. } = *self.context;
        let raster = tiling.raster();
        let left = match raster {
            Some(raster) if on_device.is_painted() => self.trace_painted(quality, raster, tiles, on_device, give),
            Some(raster) => on_device.trace(quality, raster, tiles, give),
            None => tiles.to_vec(),
        };
        if left.is_empty() {
            return;
        }
        let level = quality.level.checked_sub(1).map(|level| self.levels[level as usize]);
        let tracer = match level {
            // Most of the tolerance is left to the level's own error.
            Some(level) => level.tracer(&Quality { tolerance: 0.25 * quality.tolerance, ..*quality }),
            None => self.tracer(quality),
        };
        let brightest = tracer.budget().brightest;
        let draw = |places: &[SamplePoint], counts: &mut Counts| {
            if raster.is_some() && renderer.savings.tiles && passes_by(scene, places, tracer.outer()) {
                return vec![background_blend(scene, brightest, None); places.len()];
            }
            let mut pixels = vec![Pixel::default(); places.len()];
            let mut rays = primary_rays(scene, places, || renderer.is_stopped());
            tracer.trace(&mut rays, counts, &mut |number, light, surfaces| {
                pixels[number] = Pixel { surfaces, ..background_blend(scene, brightest, light) };
            });
            if let Some(level) = level {
                for (pixel, place) in pixels.iter_mut().zip(places) {
                    let (eye, dir) = ray(scene, place.at);
                    let error = f64::from(pixel.error) + level.error(quality, eye, dir);
                    pixel.error = error.min(brightest.max(1.0)) as f32;
                }
            }
            pixels
        };
        raster::trace(tiling, &left, || renderer.is_stopped(), draw).for_each(give);
    }
}

/// The error budget of rays, without early ends if the renderer disables them.
pub(super) fn budget(renderer: &Renderer, scene: &Scene, quality: &Quality) -> Budget {
    let mut budget = allowed(scene, quality);
    if !renderer.savings.ends {
        // Less than any transmittance.
        budget.min_transmittance = -1.0;
    }
    budget
}

/// Only the unlit integral of one volume in f64 is bounded throughout, beside any surfaces, if each pixel is traced.
pub(super) fn certainty(scene: &Scene, quality: &Quality) -> Certainty {
    let is_exact = scene.method == Method::Exact && scene.precision == Precision::F64;
    let is_traced = scene.lighting.is_none() && quality.pixel_step == 1;
    let is_bound = is_exact && is_traced && scene.has_one_field_of_volume();
    if is_bound { Certainty::Bound } else { Certainty::Estimate }
}

/// Error bound of rounded positions for a ray that grazes an edge of the mesh; in single precision, in which a piece is
/// a part of its frustum, half a last digit is added.
const GEOMETRY: f64 = 1e-9;

/// Last digits of absorbed light by which a lit pixel in single precision may be off besides: neighbouring frusta share
/// the rounding of values and gradients at their vertices.
const SHARED_ROUNDING: f64 = 4.0;

/// The rays through points of the picture, numbered from 0. A ray may be long: none starts once `is_stopped` is true.
pub(super) fn primary_rays(
    scene: &Scene,
    places: &[SamplePoint],
    is_stopped: impl Fn() -> bool,
) -> impl Iterator<Item = PrimaryRay> {
    let rays = places.iter().enumerate().map(|(number, place)| {
        let (eye, dir) = ray(scene, place.at);
        PrimaryRay { number, eye, dir, begins_row: place.begins_row }
    });
    rays.take_while(move |_| !is_stopped())
}

/// Whether no ray through a rectangle of pixels, given by two opposite corners as the first and last point, comes
/// within `radius` of the centre.
fn passes_by(scene: &Scene, places: &[SamplePoint], radius: f64) -> bool {
    /// More than the rounding of an angle.
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

/// The ray through a point of the picture, in pixels from its upper left corner: the eye and a unit vector.
pub(super) fn ray(scene: &Scene, at: [f64; 2]) -> (DVec3, DVec3) {
    let dir = scene.camera.direction_at(at, scene.width, scene.height);
    (DVec3::from_array(scene.camera.eye()), DVec3::from_array(dir))
}

/// Blends a ray's light over the background; `None` is a ray that misses the shell.
pub(super) fn background_blend(scene: &Scene, brightest: f64, met: Option<Radiance<f64>>) -> Pixel {
    let light = met.unwrap_or(Radiance::none());
    let (color, absorbed) = (light.color, light.alpha);
    let color = match scene.background {
        None => [color[0], color[1], color[2], absorbed],
        Some(back) => {
            let [r, g, b] = [0, 1, 2].map_inline(|k| color[k] + (1.0 - absorbed) * back[k]);
            [r, g, b, 1.0]
        }
    };
    let is_lit = scene.lighting.is_some();
    let geometry = GEOMETRY
        + match scene.precision {
            Precision::F64 => 0.0,
            Precision::F32 if is_lit => f64::from(f32::EPSILON) * (0.5 + SHARED_ROUNDING * absorbed),
            Precision::F32 => f64::from(f32::EPSILON) * 0.5,
        };
    // The picture itself is in f32.
    let stored = color.iter().fold(0.0f64, |most, c| most.max(*c)) * f64::from(f32::EPSILON) / 2.0;
    let error = if met.is_some() { light.total_error(is_lit) + stored + geometry } else { 0.0 };
    let error = error.min(brightest.max(1.0)) as f32;
    Pixel { color: color.map_inline(|c| c as f32), error, surfaces: BoundarySignature::default() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use icoray_kernel::plane::RayLine;
    use std::cell::Cell;

    /// For several cameras, no tile with a ray that meets the globe is skipped, and most other tiles are.
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
                let text = format!("field = 'f'\nimage = {{ width = {width}, height = {height} }}\n[camera]\n{camera}");
                let scene = Scene::parse(&text).unwrap();
                let raster = Raster { width, height, step: 1 };
                let all: Vec<u32> = (0..raster.tiles()).collect();
                let draw = |places: &[SamplePoint], counts: &mut Counts| {
                    let rays = places.iter().map(|place| ray(&scene, place.at));
                    let hits = rays.filter(|(eye, dir)| RayLine::new(*eye, *dir, 1.1).is_some()).count();
                    counts.columns = u64::from(hits == 0);
                    counts.frusta = u64::from(passes_by(&scene, places, 1.1));
                    vec![Pixel::default(); places.len()]
                };
                for tile in raster::trace(&raster, &all, || false, draw).collect::<Vec<_>>() {
                    assert!(tile.counts.frusta <= tile.counts.columns, "{camera}: tile {}", tile.number);
                    (beside, passed) = (beside + tile.counts.columns, passed + tile.counts.frusta);
                }
            }
        }
        assert!(beside > 200 && passed * 10 > beside * 8, "{passed} of {beside}");
    }

    #[test]
    fn a_stop_is_heard_between_the_rays_of_a_tile() {
        let scene = Scene::parse("field = 'f'").unwrap();
        let places = [SamplePoint::middle(0, 0, true); 256];
        let asked = Cell::new(0);
        let rays = primary_rays(&scene, &places, || asked.replace(asked.get() + 1) == 5);
        assert_eq!(rays.count(), 5);
    }
}
