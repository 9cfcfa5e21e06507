//! A picture of parts: each rank traces all rays through its own cells, and each puts rays together in some of the tiles.

use super::device::OnDevice;
use super::work::{Work, brightest, ray, shown};
use crate::compose::{Came, Composer, TileFragments};
use crate::error::{Error, ErrorKind, Result};
use crate::kernel::ray::{Budget, Counts};
use crate::quality::{Lights, Quality};
use crate::ranks::{Part, Ranks, Reader, Share, Words};
use crate::raster::{Pixel, Raster, Tile};
use rayon::prelude::*;
use std::sync::OnceLock;
use std::time::Instant;

/// What ranks have sent of this rank's tiles.
pub(super) struct Exchanged {
    came: Vec<Vec<u8>>,
    /// Seconds of tracing before.
    pub traced_s: f64,
}

/// Tiles with what each rank has of them.
pub(super) struct Fragments<'e> {
    tiles: Vec<(u32, Vec<Came<'e>>)>,
    /// What rays met on all ranks, told to rank 0.
    met: Counts,
}

impl Exchanged {
    /// Finds this rank's tiles, `mine`, in what came.
    pub fn tiles(&self, raster: Raster, mine: &[u32]) -> Result<Fragments<'_>> {
        let mut readers = Vec::with_capacity(self.came.len());
        let mut met = Counts::default();
        for bytes in &self.came {
            let mut reader = Reader(bytes);
            met += reader.get_counts()?;
            readers.push(reader.0);
        }
        let mut tiles = Vec::with_capacity(mine.len());
        for tile in mine {
            let pixels = raster.pixels_of(*tile);
            let of_ranks = readers.iter_mut().map(|bytes| Came::take(bytes, pixels));
            tiles.push((*tile, of_ranks.collect::<Result<Vec<_>>>()?));
        }
        if let Some(rank) = readers.iter().position(|rest| !rest.is_empty()) {
            return Err(Error::new(ErrorKind::Mpi, format!("rank {rank} sent fragments of other tiles")));
        }
        Ok(Fragments { tiles, met })
    }
}

impl Work<'_> {
    /// Traces this rank's part of all tiles and exchanges fragments. Collective.
    pub(super) fn exchange(
        &self,
        ranks: &mut Ranks,
        part: &Part,
        share: &Share,
        on_device: &mut OnDevice,
    ) -> Result<Exchanged> {
        let start = Instant::now();
        let raster = Raster { step: share.quality.pixel_step, ..self.raster() };
        let traced = ranks.attempt(|| {
            let (tiles, counts) =
                self.renderer.run(|| self.fragments(part, &share.quality, raster, on_device));
            Ok(addressed(ranks, &tiles, &share.owners, counts))
        });
        let traced_s = start.elapsed().as_secs_f64();
        let messages = ranks.together(traced)?;
        Ok(Exchanged { came: ranks.exchange(messages)?, traced_s })
    }

    /// The fragments of each tile as bytes, and what rays met on the way: the device's, as far as that goes.
    fn fragments(
        &self,
        part: &Part,
        quality: &Quality,
        raster: Raster,
        on_device: &mut OnDevice,
    ) -> (Vec<Vec<u8>>, Counts) {
        let traced: Vec<OnceLock<(Vec<u8>, Counts)>> = (0..raster.tiles()).map(|_| OnceLock::new()).collect();
        let keep = |tile: u32, fragments: &TileFragments, counts: Counts| {
            let mut bytes = Vec::new();
            fragments.put(&mut bytes);
            traced[tile as usize].get_or_init(|| (bytes, counts));
        };
        let all: Vec<u32> = (0..raster.tiles()).collect();
        let own = part.own(self.radius[0], self.radius[1]);
        let left = on_device.fragments(quality, raster, &all, &own, &keep);
        if !left.is_empty() {
            let caster = self.rays.caster(quality);
            left.par_iter().with_max_len(1).for_each(|tile| {
                let (mut fragments, mut counts) = (TileFragments::default(), Counts::default());
                raster.visit(*tile, |x, y, hint| {
                    let (eye, dir) = ray(self.scene, x, y);
                    fragments.pixel(|found| caster.fragments(part, eye, dir, hint, &mut counts, found));
                });
                keep(*tile, &fragments, counts);
            });
        }
        let mut counts = Counts::default();
        let tiles = traced.into_iter().map(|tile| {
            let (bytes, of_tile) = tile.into_inner().unwrap_or_default();
            counts += of_tile;
            bytes
        });
        (tiles.collect(), counts)
    }

    /// Puts rays of this rank's tiles together, each tile given away when it is done.
    pub(super) fn put_together(
        &self,
        quality: &Quality,
        raster: Raster,
        fragments: &Fragments,
        give: &(dyn Fn(Tile) + Sync),
    ) {
        let composer = Composer {
            radius: self.radius,
            core: self.scene.core,
            ground: self.ground,
            shading: self.plan.shading.filter(|_| quality.lights != Lights::Off),
            budget: Budget::new(quality.tolerance, brightest(self.scene)),
        };
        fragments.tiles.par_iter().with_max_len(1).enumerate().for_each(|(i, (number, came))| {
            let mut tile = self.tile(&composer, raster, *number, &mut came.clone());
            if i == 0 {
                tile.counts += fragments.met;
            }
            give(tile);
        });
    }

    fn tile(&self, composer: &Composer, raster: Raster, number: u32, came: &mut [Came]) -> Tile {
        let start = Instant::now();
        let mut counts = Counts::default();
        let mut pixels: Vec<Pixel> = Vec::with_capacity(raster.pixels_of(number));
        let mut fragments = Vec::new();
        raster.visit(number, |x, y, _| {
            fragments.clear();
            came.iter_mut().for_each(|came| came.pixel(pixels.len(), &mut fragments));
            let (eye, dir) = ray(self.scene, x, y);
            let light = composer.ray(eye, dir, &mut fragments, &mut counts);
            pixels.push(shown(self.scene, composer.budget.brightest, light));
        });
        Tile { number, seconds: start.elapsed().as_secs_f64(), counts, pixels }
    }
}

/// What is sent to each rank: what rays met, which only rank 0 is told, and the rank's tiles.
fn addressed(ranks: &Ranks, tiles: &[Vec<u8>], owners: &[u32], mut counts: Counts) -> Vec<Vec<u8>> {
    let mut bodies = vec![Vec::new(); ranks.size()];
    for (tile, owner) in tiles.iter().zip(owners) {
        bodies[*owner as usize].extend_from_slice(tile);
    }
    let others = bodies.iter().enumerate().filter(|(rank, _)| *rank != ranks.rank());
    counts.fragment_bytes = others.map(|(_, bytes)| bytes.len() as u64).sum();
    let head = |rank: usize| {
        let mut words = Words::default();
        words.put_counts(&if rank == 0 { counts } else { Counts::default() });
        words.0
    };
    bodies.into_iter().enumerate().map(|(rank, body)| [head(rank), body].concat()).collect()
}
