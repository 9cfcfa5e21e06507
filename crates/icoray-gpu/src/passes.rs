//! Pictures traced in one pass over the field, or in several if the device has no room for all columns that rays read.

use crate::bands::Tile;
use crate::device_field::DeviceField;
use crate::field_store::FieldStore;
use crate::picture::Picture;
use crate::trace_pixels::PixelTrace;
use icoray::device::{Band, DeviceCost, FallbackReason};
use std::sync::Arc;
use std::time::Instant;

/// A picture that is being traced.
pub(crate) struct Passes<'p> {
    pub fields: &'p FieldStore,
    pub picture: Picture<'p>,
    pub sink: &'p (dyn Fn(Band) + Sync),
    /// When the preparation of the next rays began.
    pub since: Instant,
    pub spent: DeviceCost,
    /// Number of tiles with lost rays.
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
