//! Sort-last rendering of grid parts: the ranks that share a part trace fragments through it, each in some tiles, and
//! every rank composites the rays of some tiles.

use super::context::FrameContext;
use super::device::OnDevice;
use super::work::{Work, background_blend, primary_rays, ray};
use crate::compose::{Composer, ReceivedTile, TileFragments};
use crate::device::OwnedColumns;
use crate::plan::budget::allowed;
use crate::ranks::{Part, Ranks, TileAssignment, TileCosts, decode_next, encode};
use crate::raster::{Pixel, Raster, Tile, Tiling, sample_points};
use icoray_grid::{Error, ErrorKind, Result};
use icoray_kernel::Counts;
use icoray_kernel::ground::Core;
use icoray_scene::{Lights, Quality};
use rayon::prelude::*;
use std::sync::OnceLock;
use std::time::Instant;

/// The head of a message between ranks: the seconds of tiles and the counts of rays. The fragments of tiles follow it.
type Head = (Vec<f32>, [u64; 7]);

/// The messages of all ranks with the fragments of this rank's tiles.
pub(super) struct Exchanged {
    received: Vec<Vec<u8>>,
    /// Seconds of tracing before the exchange.
    pub traced_s: f64,
}

/// Tiles with the fragments of each rank.
pub(super) struct Fragments<'e> {
    tiles: Vec<(u32, Vec<ReceivedTile<'e>>)>,
    /// Counts of rays on all ranks, at rank 0.
    met: Counts,
}

impl Exchanged {
    /// Decodes the fragments of this rank's tiles, `mine`.
    pub fn tiles(&self, tiling: &dyn Tiling, mine: &[u32]) -> Result<Fragments<'_>> {
        let mut readers = Vec::with_capacity(self.received.len());
        let mut met = Counts::default();
        for bytes in &self.received {
            let mut unread = &bytes[..];
            let (_, counts) = decode_next::<Head>(&mut unread)?;
            met += Counts::of_numbers(counts);
            readers.push(unread);
        }
        let mut tiles = Vec::with_capacity(mine.len());
        for tile in mine {
            let rays = tiling.pixels_of(*tile) * tiling.rays_per_pixel();
            let of_ranks = readers.iter_mut().map(|bytes| ReceivedTile::take(bytes, rays));
            tiles.push((*tile, of_ranks.collect::<Result<Vec<_>>>()?));
        }
        if let Some(rank) = readers.iter().position(|rest| !rest.is_empty()) {
            return Err(Error::new(ErrorKind::Mpi, format!("rank {rank} sent fragments of other tiles")));
        }
        Ok(Fragments { tiles, met })
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
        let tiles = ranks.assign_part_tiles(tiling, part.mates().len());
        let traced = ranks.attempt(|| {
            let mine = &tiles[part.place()];
            let traced =
                self.context.renderer.run(|| self.fragments(part, &assignment.quality, tiling, mine, on_device));
            Ok(addressed(ranks, part, &traced, mine, &assignment.owners))
        });
        let traced_s = start.elapsed().as_secs_f64();
        let messages = ranks.collective(traced)?;
        let received = ranks.exchange(messages)?;
        if let Some(raster) = tiling.raster() {
            let costs = costs(raster, part, &tiles, &received);
            let costs = ranks.collective(costs)?;
            ranks.keep_part_costs(costs);
        }
        Ok(Exchanged { received, traced_s })
    }

    /// The fragments of each tile as bytes; empty for tiles not in `tiles`. Those of a raster come from the device, as
    /// far as it traced them.
    fn fragments(
        &self,
        part: &Part,
        quality: &Quality,
        tiling: &dyn Tiling,
        tiles: &[u32],
        on_device: &mut OnDevice,
    ) -> Traced {
        let traced: Vec<OnceLock<(Vec<u8>, Counts, f32)>> = (0..tiling.tiles()).map(|_| OnceLock::new()).collect();
        let keep = |tile: u32, fragments: &TileFragments, counts: Counts, seconds: f32| {
            let mut bytes = Vec::new();
            fragments.put(&mut bytes);
            traced[tile as usize].get_or_init(|| (bytes, counts, seconds));
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
                let mut rays = primary_rays(self.context.scene, &places);
                tracer.fragments(part.region(), &mut rays, &mut counts, &mut |ray, of_ray| fragments.add(ray, of_ray));
                keep(*tile, &fragments, counts, start.elapsed().as_secs_f32());
            });
        }
        let none = || {
            let mut bytes = Vec::new();
            TileFragments::default().put(&mut bytes);
            (bytes, Counts::default(), 0.0)
        };
        let mut all = Traced::default();
        for tile in traced {
            let (bytes, counts, seconds) = tile.into_inner().unwrap_or_else(none);
            all.counts += counts;
            all.tiles.push(bytes);
            all.seconds.push(seconds);
        }
        all
    }

    /// Traces tiles of a whole grid on the device as fragments, with lines and grounds in them, and composites their rays.
    /// Returns the tiles that are left to the CPU.
    pub(super) fn trace_painted(
        &self,
        quality: &Quality,
        raster: Raster,
        tiles: &[u32],
        on_device: &mut OnDevice,
        give: &(dyn Fn(Tile) + Sync),
    ) -> Vec<u32> {
        let grid = self.context.grid;
        let triangles: Vec<bool> = (0..grid.triangles() as u32).map(|triangle| grid.is_triangle(triangle)).collect();
        let lowest_facet = self.context.renderer.run(|| grid.lowest_facet());
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

    fn composer(&self, quality: &Quality) -> Composer<'_> {
        let FrameContext { scene, plan, .. } = *self.context;
        Composer {
            radius: self.radius,
            core: Core::new(scene.core, self.ground),
            shading: plan.shading.filter(|_| quality.lights != Lights::Off),
            budget: allowed(scene, quality),
        }
    }

    /// Composites the rays of this rank's tiles and passes each tile on when it is done.
    pub(super) fn compose_tiles(
        &self,
        quality: &Quality,
        tiling: &dyn Tiling,
        fragments: &Fragments,
        give: &(dyn Fn(Tile) + Sync),
    ) {
        let composer = self.composer(quality);
        fragments.tiles.par_iter().with_max_len(1).enumerate().for_each(|(i, (number, received))| {
            let mut tile = self.tile(&composer, tiling, *number, &mut received.clone());
            if i == 0 {
                tile.counts += fragments.met;
            }
            give(tile);
        });
    }

    fn tile(&self, composer: &Composer, tiling: &dyn Tiling, number: u32, received: &mut [ReceivedTile]) -> Tile {
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

/// The fragments that a rank traced through its part.
#[derive(Debug, Default)]
struct Traced {
    /// Fragments of each tile, as bytes.
    tiles: Vec<Vec<u8>>,
    /// Seconds of each tile.
    seconds: Vec<f32>,
    /// Counts of rays.
    counts: Counts,
}

/// The message to each rank: the seconds of tiles, which only ranks with the same part need; the counts of rays, which
/// only rank 0 needs; and the rank's tiles.
fn addressed(ranks: &Ranks, part: &Part, traced: &Traced, mine: &[u32], owners: &[u32]) -> Vec<Vec<u8>> {
    let mut bodies = vec![Vec::new(); ranks.size()];
    for (tile, owner) in traced.tiles.iter().zip(owners) {
        bodies[*owner as usize].extend_from_slice(tile);
    }
    let others = bodies.iter().enumerate().filter(|(rank, _)| *rank != ranks.rank());
    let mut counts = traced.counts;
    counts.fragment_bytes = others.map(|(_, bytes)| bytes.len() as u64).sum();
    let seconds: Vec<f32> = mine.iter().map(|tile| traced.seconds[*tile as usize]).collect();
    let head = |rank: usize| {
        let seconds = if part.mates().contains(&rank) { &seconds[..] } else { &[] };
        let counts = if rank == 0 { counts } else { Counts::default() };
        encode(&(seconds, counts.numbers()))
    };
    bodies.into_iter().enumerate().map(|(rank, body)| [head(rank), body].concat()).collect()
}

/// The seconds of the tiles of a part, each of whose ranks traced some of `tiles`.
fn costs(raster: Raster, part: &Part, tiles: &[Vec<u32>], received: &[Vec<u8>]) -> Result<TileCosts> {
    let mut costs = TileCosts::new(raster);
    for (mate, tiles) in part.mates().iter().zip(tiles) {
        let (seconds, _) = decode_next::<Head>(&mut &received[*mate][..])?;
        tiles.iter().zip(seconds).for_each(|(tile, seconds)| costs.set(*tile, seconds.into()));
    }
    Ok(costs)
}
