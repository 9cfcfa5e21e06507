//! Pixels of a whole grid, traced in one pass over the field, or in several if the device has no room for all columns
//! that rays read. Each band of tiles is traced while the results of the one before are read back.

use crate::bands::{Bands, Tile};
use crate::culling::Culling;
use crate::device_field::DeviceField;
use crate::field_store::FieldStore;
use crate::layout::picture::LOST;
use crate::picture::Picture;
use crate::pipelines::bind_group;
use crate::readback::Readback;
use icoray::device::{Band, DeviceCost, FallbackReason, Traced};
use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

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
        let is_lost = rays[end..next].iter().any(|ray| ray.error == LOST);
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
    /// Traces tiles with a field that is on the device after an upload of this number of bytes, and passes those
    /// without lost rays to the sink.
    pub fn trace(&mut self, (field, bytes): (Arc<DeviceField>, u64), tiles: &[Tile]) -> Result<(), FallbackReason> {
        let bands = Bands::new(&self.picture, &field, tiles, false)?;
        let (ctx, sink, lost) = (self.picture.ctx, self.sink, &mut self.lost);
        let buffers = self.picture.scene_buffers()?;
        let scene = bind_group(ctx, bands.scene_layout, buffers.iter().map(|buffer| &**buffer))?;
        self.spent.bytes_uploaded += bytes + bands.bytes;
        self.spent.unread_bytes = self.spent.field_bytes.saturating_sub(field.bytes());
        self.spent.passes += 1;
        self.spent.upload_s += self.since.elapsed().as_secs_f64();
        let (mut last, mut previous) = (Instant::now(), None);
        let mut finish = |(band, readback): (Range<usize>, Readback)| {
            let tiles = &tiles[band];
            *lost += readback.wait(ctx, |bytes| {
                let seconds = std::mem::replace(&mut last, Instant::now()).elapsed().as_secs_f64();
                send_runs(tiles, bytemuck::cast_slice(bytes), seconds, sink)
            })?;
            Ok(())
        };
        for band in &bands.list {
            let readback = bands.submit(band, &scene, |_| ())?;
            previous.replace((band.tiles.clone(), readback)).map_or(Ok(()), &mut finish)?;
        }
        previous.map_or(Ok(()), &mut finish)?;
        self.spent += DeviceCost { device_s: bands.seconds()?, ..DeviceCost::default() };
        self.since = Instant::now();
        Ok(())
    }

    /// Bisects the tiles until there is room for the columns that their rays read. Each ray has all columns that it
    /// reads, so that the picture is the same. Tiles are sorted in Morton order: neighbours read much the same columns.
    pub fn trace_bisected(&mut self, mut tiles: Vec<Tile>) -> Result<(), FallbackReason> {
        tiles.sort_by_key(|(_, tile)| morton(tile.left, tile.top));
        let mut stack = vec![&tiles[..]];
        while let Some(tiles) = stack.pop().filter(|tiles| !tiles.is_empty()) {
            let cells = Arc::new(Culling::of_tiles(self.picture.ctx, self.picture.job, tiles)?);
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
