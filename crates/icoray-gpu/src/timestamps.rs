//! Time that compute passes take by the device's clock: timestamps at the beginning and the end of each pass, summed.

use crate::context::Context;
use crate::pool::PooledBuffer;
use crate::readback::Readback;
use icoray::device::FallbackReason;
use std::cell::Cell;
use wgpu::{BufferUsages, QUERY_RESOLVE_BUFFER_ALIGNMENT, QUERY_SET_MAX_QUERIES};

/// Bytes from one resolved pair of timestamps to the next. Each pass resolves its own pair, at an aligned offset.
const STRIDE: usize = QUERY_RESOLVE_BUFFER_ALIGNMENT as usize;

/// Timestamps of passes; none if the device has no clock or there are more passes than a query set can hold.
pub(crate) struct Timestamps {
    /// The query set, and the buffer of its resolved timestamps.
    queries: Option<(wgpu::QuerySet, PooledBuffer)>,
    passes: Cell<u32>,
}

impl Timestamps {
    /// Allocates the timestamps of at most `max_passes` passes.
    pub fn new(ctx: &Context, max_passes: usize) -> Result<Self, FallbackReason> {
        let has_clock = ctx.device.features().contains(wgpu::Features::TIMESTAMP_QUERY);
        if !has_clock || !(1..=QUERY_SET_MAX_QUERIES as usize / 2).contains(&max_passes) {
            return Ok(Timestamps { queries: None, passes: Cell::new(0) });
        }
        let descriptor = wgpu::QuerySetDescriptor {
            label: Some("times"),
            ty: wgpu::QueryType::Timestamp,
            count: 2 * max_passes as u32,
        };
        let queries = ctx.scoped(|| ctx.device.create_query_set(&descriptor))?;
        let usage = BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC;
        let resolved = ctx.pooled("times", max_passes * STRIDE, usage)?;
        Ok(Timestamps { queries: Some((queries, resolved)), passes: Cell::new(0) })
    }

    /// Describes the next pass. Call [`Self::resolve`] after it.
    pub fn pass(&self) -> wgpu::ComputePassDescriptor<'_> {
        let first = 2 * self.passes.get();
        let timestamp_writes = self.queries.as_ref().map(|(queries, _)| wgpu::ComputePassTimestampWrites {
            query_set: queries,
            beginning_of_pass_write_index: Some(first),
            end_of_pass_write_index: Some(first + 1),
        });
        wgpu::ComputePassDescriptor { label: None, timestamp_writes }
    }

    /// Resolves the timestamps of the pass that was encoded last in `commands`.
    pub fn resolve(&self, commands: &mut wgpu::CommandEncoder) {
        let pass = self.passes.get();
        if let Some((queries, resolved)) = &self.queries {
            let offset = u64::from(pass) * QUERY_RESOLVE_BUFFER_ALIGNMENT;
            commands.resolve_query_set(queries, 2 * pass..2 * pass + 2, resolved, offset);
        }
        self.passes.set(pass + 1);
    }

    /// Waits for the passes and returns the sum of their times in seconds.
    pub fn seconds(&self, ctx: &Context) -> Result<Option<f64>, FallbackReason> {
        let Some((_, resolved)) = self.queries.as_ref().filter(|_| self.passes.get() > 0) else {
            return Ok(None);
        };
        let commands = ctx.device.create_command_encoder(&Default::default());
        let readback = Readback::submit(ctx, commands, resolved, self.passes.get() as usize * STRIDE)?;
        let ticks: u64 = readback.wait(ctx, |bytes| {
            let pair = |bytes: &[u8]| bytemuck::pod_read_unaligned::<[u64; 2]>(&bytes[..16]);
            bytes.chunks_exact(STRIDE).map(pair).map(|[start, end]| end.saturating_sub(start)).sum()
        })?;
        Ok(Some(ticks as f64 * f64::from(ctx.queue.get_timestamp_period()) * 1e-9))
    }
}
