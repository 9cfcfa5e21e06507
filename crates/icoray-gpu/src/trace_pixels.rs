//! Pixels of a whole grid, traced in one pass over the field, or in several if the device has no room for all columns
//! that rays read. Each band of tiles is traced while the results of the one before are read back.

use crate::bands::{Bands, Tile};
use crate::device_field::DeviceField;
use crate::field_store::FieldStore;
use crate::layout::Pixel;
use crate::picture::Picture;
use crate::pipelines::bind_group;
use crate::pool::PooledBuffer;
use crate::readback::Readback;
use icoray::device::{Band, DeviceCost, FallbackReason, Traced};
use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

/// Tiles of a picture, ready to be traced.
struct PixelTrace<'t> {
    bands: Bands<'t>,
    /// Group 2.
    scene: wgpu::BindGroup,
    /// Bound in `scene`.
    _buffers: Vec<PooledBuffer>,
}

impl<'t> PixelTrace<'t> {
    pub fn new(picture: &Picture<'t>, field: &DeviceField, tiles: &'t [Tile]) -> Result<Self, FallbackReason> {
        let bands = Bands::new(picture, field, tiles, false)?;
        let buffers = picture.scene_buffers()?;
        let scene = bind_group(picture.ctx, bands.scene_layout, buffers.iter().map(|buffer| &**buffer))?;
        Ok(PixelTrace { bands, scene, _buffers: buffers })
    }

    pub fn bytes(&self) -> u64 {
        self.bands.bytes
    }

    /// Traces the tiles and passes those without lost rays to `sink`. Returns the number of the other tiles, and the
    /// seconds in rays by the device's clock.
    pub fn run(self, sink: &(dyn Fn(Band) + Sync)) -> Result<(usize, Option<f64>), FallbackReason> {
        let Bands { ctx, tiles, list, .. } = &self.bands;
        let (mut lost, mut last, mut previous) = (0, Instant::now(), None);
        let mut finish = |(band, readback): (Range<usize>, Readback)| {
            let tiles = &tiles[band];
            lost += readback.wait(ctx, |bytes| {
                let seconds = std::mem::replace(&mut last, Instant::now()).elapsed().as_secs_f64();
                send_runs(tiles, bytemuck::cast_slice(bytes), seconds, sink)
            })?;
            Ok(())
        };
        for band in list {
            let readback = self.bands.submit(band, &self.scene, |_| ())?;
            previous.replace((band.tiles.clone(), readback)).map_or(Ok(()), &mut finish)?;
        }
        previous.map_or(Ok(()), &mut finish)?;
        Ok((lost, self.bands.seconds()?))
    }
}

/// Passes runs of tiles with consecutive indices to `sink`, without the tiles that have lost rays, and returns the
/// number of these. The seconds are shared equally among the tiles.
fn send_runs(tiles: &[Tile], rays: &[Traced], seconds: f64, sink: &(dyn Fn(Band) + Sync)) -> usize {
    let seconds = seconds / tiles.len() as f64;
    let send = |run: &[Tile], rays: &[Traced]| {
        if let Some((first, _)) = run.first() {
            sink(Band { first: *first, rays, seconds: seconds * run.len() as f64 });
        }
    };
    let (mut lost, mut run, mut start, mut end) = (0, 0..0, 0, 0);
    for (i, (index, tile)) in tiles.iter().enumerate() {
        let next = end + tile.pixels();
        let is_lost = rays[end..next].iter().any(|ray| ray.error == Pixel::LOST);
        let follows = i > run.start && tiles[i - 1].0 + 1 == *index;
        if is_lost || !follows {
            send(&tiles[run.clone()], &rays[start..end]);
            (run.start, start) = if is_lost { (i + 1, next) } else { (i, end) };
        }
        run.end = i + 1;
        lost += usize::from(is_lost);
        end = next;
    }
    send(&tiles[run], &rays[start..end]);
    lost
}

/// A picture that is being traced.
pub(crate) struct Passes<'p> {
    pub fields: &'p FieldStore,
    pub picture: Picture<'p>,
    pub sink: &'p (dyn Fn(Band) + Sync),
    /// When the preparation of the next rays began.
    pub since: Instant,
    pub spent: DeviceCost,
    pub lost: usize,
}

impl Passes<'_> {
    /// Traces tiles with a field that is on the device after an upload of this number of bytes.
    pub fn trace(&mut self, (field, bytes): (Arc<DeviceField>, u64), tiles: &[Tile]) -> Result<(), FallbackReason> {
        let trace = PixelTrace::new(&self.picture, &field, tiles)?;
        self.spent.bytes_uploaded += bytes + trace.bytes();
        self.spent.unread_bytes = self.spent.field_bytes.saturating_sub(field.bytes());
        self.spent.passes += 1;
        self.spent.upload_s += self.since.elapsed().as_secs_f64();
        let (lost, device_s) = trace.run(self.sink)?;
        self.lost += lost;
        self.spent += DeviceCost { device_s, ..DeviceCost::default() };
        self.since = Instant::now();
        Ok(())
    }

    /// Bisects the tiles until there is room for the columns that their rays read. Each ray has all columns that it
    /// reads, so that the picture is the same. Tiles are sorted in Morton order: neighbours read much the same columns.
    pub fn trace_bisected(&mut self, mut tiles: Vec<Tile>) -> Result<(), FallbackReason> {
        tiles.sort_by_key(|(_, tile)| morton(tile.left, tile.top));
        let mut stack = vec![&tiles[..]];
        while let Some(tiles) = stack.pop().filter(|tiles| !tiles.is_empty()) {
            let Picture { ctx, job, mesh, .. } = &self.picture;
            let cells = Arc::new(mesh.culling.of_tiles(ctx, job, tiles)?);
            match self.fields.get(&self.picture, &cells)? {
                Ok((field, bytes)) => self.trace((field, bytes + cells.bytes()), tiles)?,
                Err(reason) if tiles.len() == 1 => return Err(reason),
                Err(_) => {
                    let (one, other) = tiles.split_at(tiles.len() / 2);
                    stack.extend([other, one]);
                }
            }
        }
        Ok(())
    }
}

/// The Morton code of two numbers: their bits interleaved.
fn morton(x: u32, y: u32) -> u64 {
    let spread = |n: u32| (0..32).fold(0, |bits, i| bits | u64::from(n >> i & 1) << (2 * i));
    spread(x) | spread(y) << 1
}
