//! Tiles that a device traces; what it leaves is for the CPU.

use super::devices::Found;
use super::work::{brightest, shown};
use crate::compose::TileFragments;
use crate::device::{Band, Device, Fragments, Job, Own, Passed, Reason, Rect, Spent, Traced};
use crate::error::Error;
use crate::frame::{Counts, FrameReport};
use crate::kernel::piece::Light;
use crate::quality::Quality;
use crate::raster::{Raster, Tile};
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};

/// A picture on a device.
pub(super) struct OnDevice<'f> {
    /// Or why it is left to the CPU, if there is a reason: from the start, or since it has left something.
    device: Result<&'f dyn Device, Option<Reason>>,
    job: Job<'f>,
    spent: Spent,
    /// The device that has traced tiles of the last call.
    drew: Option<String>,
}

impl<'f> OnDevice<'f> {
    /// The picture of `job` on a device, or on none: for a reason, or as nobody asked for one.
    pub fn new(device: &'f Found, job: Job<'f>) -> Self {
        let device = device.as_deref().map_err(Clone::clone);
        OnDevice { device, job, spent: Spent::default(), drew: None }
    }

    /// Whether a device is asked first.
    pub fn is_there(&self) -> bool {
        self.device.is_ok()
    }

    /// Has the device upload what it needs, so that the next call takes the time of its rays.
    pub fn get_ready(&mut self, quality: &Quality, raster: Raster) {
        self.trace(quality, raster, &[], &|_| ());
    }

    /// Traces tiles, each given away when it is done, and returns those that are left to the CPU.
    pub fn trace(
        &mut self,
        quality: &Quality,
        raster: Raster,
        tiles: &[u32],
        give: &(dyn Fn(Tile) + Sync),
    ) -> Vec<u32> {
        self.ask(quality, raster, tiles, |device, job, is_new| {
            let take = |band: Band| {
                made_of(job, &band).into_par_iter().enumerate().for_each(|(i, tile)| {
                    if is_new(band.first + i) {
                        give(tile);
                    }
                });
            };
            device.trace(job, &take)
        })
    }

    /// As [`Self::trace`], through the own part of the cells: each tile's fragments, and what its rays met.
    pub fn fragments(
        &mut self,
        quality: &Quality,
        raster: Raster,
        tiles: &[u32],
        own: &Own,
        give: &(dyn Fn(u32, &TileFragments, Counts) + Sync),
    ) -> Vec<u32> {
        self.ask(quality, raster, tiles, |device, job, is_new| {
            let take = |band: Fragments| {
                put_together(job, &band).into_par_iter().enumerate().for_each(|(i, (fragments, counts))| {
                    if is_new(band.first + i) {
                        give(job.numbers()[band.first + i], &fragments, counts);
                    }
                });
            };
            device.fragments(job, own, &take)
        })
    }

    /// Has `trace` trace tiles on the device, which asks of each place among them whether it is given for the first time.
    fn ask(
        &mut self,
        quality: &Quality,
        raster: Raster,
        tiles: &[u32],
        trace: impl FnOnce(&dyn Device, &Job, &(dyn Fn(usize) -> bool + Sync)) -> Result<Spent, Reason>,
    ) -> Vec<u32> {
        self.drew = None;
        let Ok(device) = self.device else { return tiles.to_vec() };
        self.job.ask(quality, raster, tiles);
        let job = &self.job;
        let is_given: Vec<AtomicBool> = tiles.iter().map(|_| AtomicBool::new(false)).collect();
        let is_new = |place: usize| !is_given[place].swap(true, Ordering::Relaxed);
        // A device that breaks is no reason for a picture to fail.
        let traced = Error::of_panics(|| Ok(trace(device, job, &is_new)));
        match traced.unwrap_or_else(|panic| Err(Reason::new(format!("{}: {panic}", device.name())))) {
            Ok(spent) => self.spent += spent,
            Err(reason) => self.device = Err(Some(reason)),
        }
        let is_given = is_given.into_iter().map(AtomicBool::into_inner);
        let left: Vec<u32> =
            tiles.iter().zip(is_given).filter(|(_, is)| !is).map(|(tile, _)| *tile).collect();
        self.drew = (left.len() < tiles.len()).then(|| device.name());
        left
    }

    /// Puts what became of it into a report.
    pub fn tell(self, report: &mut FrameReport) {
        let Spent { upload_s, device_s, bytes_uploaded, field_bytes, unread_bytes, passes } = self.spent;
        (report.upload_s, report.device_s, report.bytes_uploaded) = (upload_s, device_s, bytes_uploaded);
        report.device = self.drew;
        if let (Some(device), 2..) = (&mut report.device, passes) {
            *device += &format!(", in {passes} passes, as the values that rays read exceed its memory");
        } else if unread_bytes > 0 {
            report.left_out.push(format!("{unread_bytes} of {field_bytes} bytes of the field on the device"));
        }
        report.left_to_cpu = self.device.err().flatten().map(|reason| reason.to_string());
    }
}

/// Rays by the tiles that they are of, the last of which may be left out.
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

/// The fragments of each tile of a band, and what its rays met.
fn put_together(job: &Job, band: &Fragments) -> Vec<(TileFragments, Counts)> {
    let mut rest = band.all;
    let tile = |rays: &[Passed]| {
        let (mut fragments, mut counts) = (TileFragments::default(), Counts::default());
        for ray in rays {
            let [columns, frusta, void_frusta] = ray.counts.map(u64::from);
            counts += Counts { columns, frusta, void_frusta, ..Counts::default() };
            let (of_ray, others) = rest.split_at(ray.fragments as usize);
            fragments.ray(|all| all.extend_from_slice(of_ray));
            rest = others;
        }
        (fragments, counts)
    };
    rays_of_tiles(job.tiles().skip(band.first), band.rays).into_iter().map(tile).collect()
}

/// The tiles of a band. Its seconds are shared out by what rays met, and a tile off the globe takes some too.
fn made_of(job: &Job, band: &Band) -> Vec<Tile> {
    let rays = rays_of_tiles(job.tiles().skip(band.first), band.rays);
    let numbers = job.numbers()[band.first..].par_iter();
    let mut tiles: Vec<Tile> =
        rays.par_iter().zip(numbers).map(|(rays, number)| made(job, *number, rays)).collect();
    let weight = |tile: &Tile| (1 + tile.counts.frusta) as f64;
    let second = band.seconds / tiles.iter().map(weight).sum::<f64>();
    tiles.iter_mut().for_each(|tile| tile.seconds = second * weight(tile));
    tiles
}

fn made(job: &Job, number: u32, rays: &[Traced]) -> Tile {
    let scene = job.scene();
    let brightest = brightest(scene);
    let mut counts = Counts::default();
    let pixel = |ray: &Traced| {
        let Traced { color, absorbed, error, variance, counts: [columns, frusta, void_frusta] } = *ray;
        if error == Traced::MISSED {
            return shown(scene, brightest, None);
        }
        let [columns, frusta, void_frusta] = [columns, frusta, void_frusta].map(u64::from);
        counts += Counts { rays: 1, columns, frusta, void_frusta, ..Counts::default() };
        shown(scene, brightest, Some(Light { color, absorbed, error, variance }.wide()))
    };
    let pixels = rays.iter().map(pixel).collect();
    Tile { number, seconds: 0.0, counts, pixels }
}
