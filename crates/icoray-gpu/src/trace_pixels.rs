//! Pixels of a whole grid: each band is traced while the results of the one before are read back.

use crate::bands::{Bands, Tile};
use crate::bindings;
use crate::device_field::DeviceField;
use crate::layout::Pixel;
use crate::picture::Picture;
use crate::pool::PooledBuffer;
use crate::readback::Readback;
use icoray::device::{Band, FallbackReason, Traced};
use std::ops::Range;
use std::time::Instant;

/// Tiles of a picture, ready to be traced.
pub(crate) struct PixelTrace<'t> {
    bands: Bands<'t>,
    /// Group 2.
    scene: wgpu::BindGroup,
    /// Bound in `scene`.
    _buffers: Vec<PooledBuffer>,
}

impl<'t> PixelTrace<'t> {
    /// Prepares tiles of a picture of `field`.
    pub fn new(picture: &Picture<'t>, field: &DeviceField, tiles: &'t [Tile]) -> Result<Self, FallbackReason> {
        let bands = Bands::new(picture, field, tiles, false)?;
        let buffers = picture.scene_buffers()?;
        let scene = bindings::group(picture.ctx, bands.scene_layout, buffers.iter().map(|buffer| &**buffer))?;
        Ok(PixelTrace { bands, scene, _buffers: buffers })
    }

    /// Bytes that were uploaded.
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
