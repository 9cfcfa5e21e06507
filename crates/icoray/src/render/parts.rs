//! Sort-last rendering of grid parts: the ranks that share a part trace fragments through it, each in some tiles, and
//! every rank composites the rays of some tiles.

use super::context::FrameContext;
use super::device::OnDevice;
use super::work::{Work, background_blend, primary_rays, ray};
use crate::compose::{Composer, ReceivedTile, TileFragments};
use crate::device::{Marks, OwnedColumns};
use crate::plan::budget::allowed;
use crate::ranks::{Part, RankMessages, Ranks, TileAssignment, Traced, read_fragments};
use crate::raster::{Pixel, Raster, Tile, Tiling, sample_points};
use icoray_grid::{Error, ErrorKind, Result};
use icoray_kernel::Counts;
use icoray_kernel::ground::Core;
use icoray_scene::{Lights, Quality};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// The messages of all ranks with the fragments of this rank's tiles.
pub(super) struct Exchanged {
    received: RankMessages,
    /// Seconds of tracing before the exchange, and the counts of this rank's rays.
    pub traced_s: f64,
    pub counts: Counts,
}

/// Tiles with the fragments of each rank that has any.
pub(super) type Fragments<'e> = BTreeMap<u32, Vec<ReceivedTile<'e>>>;

impl Exchanged {
    /// Decodes the fragments of this rank's tiles, `mine`.
    pub fn tiles(&self, tiling: &dyn Tiling, mine: &[u32]) -> Result<Fragments<'_>> {
        let mut tiles: Fragments = mine.iter().map(|tile| (*tile, Vec::new())).collect();
        read_fragments(&self.received, |tile, unread| {
            let not_mine = || Error::new(ErrorKind::Mpi, format!("fragments of tile {tile}, which is another rank's"));
            let of_ranks = tiles.get_mut(&tile).ok_or_else(not_mine)?;
            of_ranks.push(ReceivedTile::take(unread, tiling.pixels_of(tile) * tiling.rays_per_pixel())?);
            Ok(())
        })?;
        Ok(tiles)
    }
}

impl Work<'_, '_> {
    /// Traces this rank's part of all tiles and exchanges fragments. Collective.
    pub(super) fn exchange(
        &self,
        ranks: &mut Ranks,
        part: &Part,
        assignment: &TileAssignment,
        tiling: &dyn Tiling,
        on_device: &mut OnDevice,
    ) -> Result<Exchanged> {
        let start = Instant::now();
        let tiles = ranks.assign_part_tiles(tiling, part.node().mates().len());
        let traced = ranks.attempt(|| {
            let mine = &tiles[part.node().place()];
            let mut traced =
                self.context.renderer.run(|| self.fragments(part, &assignment.quality, tiling, mine, on_device));
            let messages = traced.messages(ranks, &assignment.owners);
            Ok((messages, traced))
        });
        let traced_s = start.elapsed().as_secs_f64();
        let (messages, Traced { seconds, counts, .. }) = ranks.collective(traced)?;
        let received = ranks.exchange(messages)?;
        if let Some(raster) = tiling.raster() {
            ranks.share_part_costs(raster, part.node().mates(), &seconds)?;
        }
        Ok(Exchanged { received, traced_s, counts })
    }

    /// The fragments of `tiles`. Those of a raster come from the device, as far as it traced them.
    fn fragments(
        &self,
        part: &Part,
        quality: &Quality,
        tiling: &dyn Tiling,
        tiles: &[u32],
        on_device: &mut OnDevice,
    ) -> Traced {
        let traced = Mutex::new(Traced::default());
        let keep = |tile: u32, fragments: &TileFragments, counts: Counts, seconds: f32| {
            let mut bytes = Vec::new();
            fragments.put(&mut bytes);
            let mut traced = traced.lock().unwrap_or_else(PoisonError::into_inner);
            traced.counts += counts;
            traced.seconds.push((tile, seconds));
            if !fragments.is_empty() {
                traced.tiles.insert(tile, bytes);
            }
        };
        let own = part.own(self.radius[0], self.radius[1]);
        // The device does not report seconds per tile.
        let of_device = |tile: u32, fragments: &TileFragments, counts: Counts| keep(tile, fragments, counts, 0.0);
        let left = match tiling.raster() {
            Some(raster) => on_device.fragments(quality, raster, tiles, (&own, &*self.painter(quality)), &of_device),
            None => tiles.to_vec(),
        };
        if !left.is_empty() {
            let tracer = self.tracer(quality);
            left.par_iter().with_max_len(1).for_each(|tile| {
                let start = Instant::now();
                let places = sample_points(tiling, *tile);
                let (mut fragments, mut counts) = (TileFragments::of_rays(places.len()), Counts::default());
                let mut rays = primary_rays(self.context.scene, &places, || false);
                tracer.fragments(part.region(), &mut rays, &mut counts, &mut |ray, of_ray| fragments.add(ray, of_ray));
                keep(*tile, &fragments, counts, start.elapsed().as_secs_f32());
            });
        }
        traced.into_inner().unwrap_or_else(PoisonError::into_inner)
    }

    /// Traces tiles of a whole grid on the device as fragments, with lines and grounds in them, and composites their
    /// rays. Returns the tiles that are left to the CPU.
    pub(super) fn trace_painted(
        &self,
        quality: &Quality,
        raster: Raster,
        tiles: &[u32],
        on_device: &mut OnDevice,
        give: &(dyn Fn(Tile) + Sync),
    ) -> Vec<u32> {
        let grid = self.context.grid;
        let triangles = Marks::new((0..grid.triangles() as u32).map(|triangle| grid.is_triangle(triangle)));
        let lowest_facet = self.context.lowest_facet();
        let own = OwnedColumns { triangles: &triangles, lowest_facet, middle: [0.0; 3], reach: f64::INFINITY };
        let composer = self.composer(quality);
        let compose = |number: u32, fragments: &TileFragments, counts: Counts| {
            let mut bytes = Vec::new();
            fragments.put(&mut bytes);
            let received = ReceivedTile::take(&mut &bytes[..], raster.pixels_of(number));
            let received = received.expect("the tile was just encoded");
            let mut tile = self.tile(&composer, &raster, number, &mut [received]);
            // Its fragments were not sent to another rank.
            tile.counts.fragments = 0;
            tile.counts += counts;
            give(tile);
        };
        on_device.fragments(quality, raster, tiles, (&own, &*self.painter(quality)), &compose)
    }

    pub(super) fn composer(&self, quality: &Quality) -> Composer<'_> {
        let FrameContext { scene, plan, .. } = *self.context;
        Composer {
            radius: self.radius,
            core: Core::new(scene.core, self.ground),
            shading: plan.shading.filter(|_| quality.lights != Lights::Off),
            budget: allowed(scene, quality),
        }
    }

    /// Composites the rays of a tile.
    pub(super) fn tile(
        &self,
        composer: &Composer,
        tiling: &dyn Tiling,
        number: u32,
        received: &mut [ReceivedTile],
    ) -> Tile {
        let start = Instant::now();
        let mut counts = Counts::default();
        let mut rays: Vec<Pixel> = Vec::with_capacity(tiling.pixels_of(number) * tiling.rays_per_pixel());
        let mut fragments = Vec::new();
        tiling.sample_points(number, &mut |place| {
            fragments.clear();
            received.iter_mut().for_each(|received| received.ray(rays.len(), &mut fragments));
            let (eye, dir) = ray(self.context.scene, place.at);
            let (light, surfaces) = composer.ray(eye, dir, &mut fragments, &mut counts).unzip();
            let pixel = background_blend(self.context.scene, composer.budget.brightest, light);
            rays.push(Pixel { surfaces: surfaces.unwrap_or_default(), ..pixel });
        });
        Tile::resolved(tiling, number, rays, start, counts)
    }
}
