//! Traces tiles on a device; the CPU traces the tiles that the device returns.

use super::context::FrameContext;
use super::draw::BuiltScene;
use super::lazy::Lazy;
use super::prepare::FieldSummary;
use super::work::{Painter, background_blend, ray};
use crate::compose::TileFragments;
use crate::device::{
    Band, Device, DeviceCost, FallbackReason, Fragment, Fragments, Job, OwnedColumns, PaintedPlace, RayFragments, Rect,
    Scenery, Traced, TracedFragment,
};
use crate::plan::budget::brightest;
use crate::raster::{Pixel, Raster, Tile, sample_points};
use icoray_grid::{Error, Field};
use icoray_kernel::piece::Radiance;
use icoray_kernel::signature::BoundarySignature;
use icoray_kernel::transfer::KernelKnot;
use icoray_kernel::{Budget, Counts};
use icoray_output::{DeviceReport, FrameReport};
use icoray_scene::Quality;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};

/// A picture's job for a device.
pub(super) struct OnDevice<'f> {
    /// The device, or the reason why the CPU draws: there was none at the start, or it failed to trace a tile.
    device: Result<&'f dyn Device, Option<FallbackReason>>,
    job: Job<'f>,
    spent: DeviceCost,
    /// Name of the device that traced tiles of the last call.
    drew: Option<String>,
}

impl<'f> OnDevice<'f> {
    /// A job for the first field on the context's device, if it has one; `has_ground` if its core has a ground.
    pub fn new(
        context: &'f FrameContext<'f>,
        field: &'f Field<'f>,
        built: &'f Lazy<'_, BuiltScene<'_>>,
        summary: &FieldSummary,
        has_ground: bool,
    ) -> Self {
        let FrameContext { renderer, scene, plan, grid, part, .. } = *context;
        let job = Job::new(scene, plan, grid, field, built, summary.quality, part.is_some());
        let (mut device, mut scenery) = (context.device.as_deref().map_err(Clone::clone), None);
        if device.is_ok() && context.has_scenery() {
            let knots = KernelKnot::of(&scene.volumes[0].transfer, plan.thickness());
            let range = |source| context.range(source).0;
            match renderer.run(|| Scenery::new(&built.get().scene, &knots, summary.is_lit(), range)) {
                Ok(found) => scenery = Some(found),
                Err(reason) => device = Err(Some(reason)),
            }
        }
        OnDevice { device, job: job.with(scenery, has_ground), spent: DeviceCost::default(), drew: None }
    }

    pub fn is_there(&self) -> bool {
        self.device.is_ok()
    }

    /// Whether the device traces rays as fragments also where the grid is whole: see [`Job::is_painted`].
    pub fn is_painted(&self) -> bool {
        self.is_there() && self.job.is_painted()
    }

    /// Traces tiles, passes each on when it is done, and returns those that are left to the CPU.
    pub fn trace(
        &mut self,
        quality: &Quality,
        raster: Raster,
        tiles: &[u32],
        give: &(dyn Fn(Tile) + Sync),
    ) -> Vec<u32> {
        self.ask(quality, raster, tiles, |device, job, is_new| {
            let take = |band: Band| {
                tiles_of_band(job, &band).into_par_iter().enumerate().for_each(|(i, tile)| {
                    if is_new(band.first + i) {
                        give(tile);
                    }
                });
            };
            device.trace(job, &take)
        })
    }

    /// As [`Self::trace`], through own cells: passes on each tile's fragments, with the light of `painter` in them, and
    /// the counts of its rays.
    pub fn fragments(
        &mut self,
        quality: &Quality,
        raster: Raster,
        tiles: &[u32],
        (own, painter): (&OwnedColumns, &Painter),
        give: &(dyn Fn(u32, &TileFragments, Counts) + Sync),
    ) -> Vec<u32> {
        self.ask(quality, raster, tiles, |device, job, is_new| {
            let take = |band: Fragments| {
                let tiles = fragments_of_band(job, &band, painter).into_par_iter().enumerate();
                tiles.for_each(|(i, (fragments, counts))| {
                    if is_new(band.first + i) {
                        give(job.numbers()[band.first + i], &fragments, counts);
                    }
                });
            };
            device.fragments(job, own, &take)
        })
    }

    /// Runs `trace` on the device, with a predicate that is true once for each index into `tiles`. Returns the tiles
    /// that were not traced.
    fn ask(
        &mut self,
        quality: &Quality,
        raster: Raster,
        tiles: &[u32],
        trace: impl FnOnce(&dyn Device, &Job, &(dyn Fn(usize) -> bool + Sync)) -> Result<DeviceCost, FallbackReason>,
    ) -> Vec<u32> {
        self.drew = None;
        let Ok(device) = self.device else { return tiles.to_vec() };
        self.job.ask(quality, raster, tiles);
        let job = &self.job;
        let is_given: Vec<AtomicBool> = tiles.iter().map(|_| AtomicBool::new(false)).collect();
        let is_new = |place: usize| !is_given[place].swap(true, Ordering::Relaxed);
        // A panic of the device falls back to the CPU.
        let traced = Error::of_panics(|| Ok(trace(device, job, &is_new)));
        match traced.unwrap_or_else(|panic| Err(FallbackReason::new(format!("{}: {panic}", device.name())))) {
            Ok(spent) => self.spent += spent,
            Err(reason) => self.device = Err(Some(reason)),
        }
        let is_given = is_given.into_iter().map(AtomicBool::into_inner);
        let left: Vec<u32> = tiles.iter().zip(is_given).filter(|(_, is)| !is).map(|(tile, _)| *tile).collect();
        self.drew = (left.len() < tiles.len()).then(|| device.name());
        left
    }

    /// Adds the device's name, costs and fallback reason to a report.
    pub fn report_to(self, report: &mut FrameReport) {
        let DeviceCost { upload_s, device_s, bytes_uploaded, field_bytes, unread_bytes, passes } = self.spent;
        let mut name = self.drew;
        if let (Some(device), 2..) = (&mut name, passes) {
            *device += &format!(", in {passes} passes, as the values that rays read exceed its memory");
        } else if unread_bytes > 0 {
            report.left_out.push(format!("{unread_bytes} of {field_bytes} bytes of the field on the device"));
        }
        let left_to_cpu = self.device.err().flatten().map(|reason| reason.to_string());
        report.device = DeviceReport { name, left_to_cpu, upload_s, device_s, bytes_uploaded };
    }
}

/// Splits rays by tiles; the last tiles may have none.
fn rays_of_tiles<R>(tiles: impl Iterator<Item = Rect>, mut rest: &[R]) -> Vec<&[R]> {
    let mut rays = Vec::new();
    for rect in tiles {
        if rest.is_empty() {
            break;
        }
        let (of_tile, others) = rest.split_at(rect.pixels());
        rays.push(of_tile);
        rest = others;
    }
    rays
}

/// The fragments of each tile of a band, and the counts of its rays.
fn fragments_of_band(job: &Job, band: &Fragments, painter: &Painter) -> Vec<(TileFragments, Counts)> {
    let mut rest = band.all;
    let rays = rays_of_tiles(job.tiles().skip(band.first), band.rays);
    let split = |rays: &&[RayFragments]| {
        let count = rays.iter().map(|ray| ray.fragments as usize).sum();
        rest.split_off(..count).expect("a device gives the fragments that it counts")
    };
    let found: Vec<_> = rays.iter().map(split).collect();
    let tile = |((rays, mut rest), number): ((&[RayFragments], &[TracedFragment]), &u32)| {
        let (mut fragments, mut counts) = (TileFragments::of_rays(rays.len()), Counts::default());
        for (k, (of_ray, place)) in rays.iter().zip(sample_points(job.raster(), *number)).enumerate() {
            let [columns, frusta, void_frusta] = of_ray.counts.map(u64::from);
            counts += Counts { columns, frusta, void_frusta, ..Counts::default() };
            let found =
                rest.split_off(..of_ray.fragments as usize).expect("a device gives the fragments that it counts");
            let (eye, dir) = ray(job.scene(), place.at);
            fragments.add(k, &joined(found, brightest(job.scene()), |place| painter(eye, dir, place)));
        }
        (fragments, counts)
    };
    let numbers = &job.numbers()[band.first..][..rays.len()];
    rays.into_par_iter().zip(found).zip(numbers).map(tile).collect()
}

/// The fragments of a ray with the light at painted places in them: a fragment that ends at one is joined with the
/// next.
fn joined(found: &[TracedFragment], brightest: f64, light: impl Fn(&PaintedPlace) -> Radiance<f64>) -> Vec<Fragment> {
    let mut joined = Vec::with_capacity(found.len());
    let mut front: Option<(f64, Radiance<f64>, BoundarySignature)> = None;
    for TracedFragment { fragment, painted } in found {
        let is_alone = front.is_none() && painted.is_none();
        let (start, mut met, mut surfaces) =
            front.take().unwrap_or((fragment.t[0], Radiance::none(), BoundarySignature::default()));
        if Budget::sees_behind(met.alpha) {
            surfaces.then(&fragment.surfaces);
        }
        met.over(&fragment.light());
        match painted {
            Some(place) => {
                if met.alpha < 1.0 {
                    met.over(&light(place));
                }
                front = Some((start, met, surfaces));
            }
            None if is_alone => joined.push(*fragment),
            None => joined.push(Fragment::new([start, fragment.t[1]], &met, surfaces, brightest)),
        }
    }
    joined
}

/// The tiles of a band. Its seconds are divided by the counts of rays; a tile off the globe gets a share too.
fn tiles_of_band(job: &Job, band: &Band) -> Vec<Tile> {
    let rays = rays_of_tiles(job.tiles().skip(band.first), band.rays);
    let numbers = job.numbers()[band.first..].par_iter();
    let mut tiles: Vec<Tile> =
        rays.par_iter().zip(numbers).map(|(rays, number)| tile_of_rays(job, *number, rays)).collect();
    let weight = |tile: &Tile| (1 + tile.counts.frusta) as f64;
    let second = band.seconds / tiles.iter().map(weight).sum::<f64>();
    tiles.iter_mut().for_each(|tile| tile.seconds = second * weight(tile));
    tiles
}

fn tile_of_rays(job: &Job, number: u32, rays: &[Traced]) -> Tile {
    let scene = job.scene();
    let brightest = brightest(scene);
    let mut counts = Counts::default();
    let pixel = |ray: &Traced| {
        let Traced { color, alpha: absorbed, error, variance, counts: [columns, frusta, void_frusta], surfaces } = *ray;
        if error == Traced::MISSED {
            return background_blend(scene, brightest, None);
        }
        let [columns, frusta, void_frusta] = [columns, frusta, void_frusta].map(u64::from);
        counts += Counts { rays: 1, columns, frusta, void_frusta, ..Counts::default() };
        let light = Radiance { color, alpha: absorbed, error, variance, shade_variance: 0.0 }.wide();
        let surfaces = BoundarySignature::of_values(surfaces);
        Pixel { surfaces, ..background_blend(scene, brightest, Some(light)) }
    };
    let pixels = rays.iter().map(pixel).collect();
    Tile { number, seconds: 0.0, counts, pixels }
}
