//! Seconds on the device by its own clock: timestamps before and behind each compute pass, summed.

use crate::gpu::Gpu;
use icoray::device::Reason;
use std::cell::Cell;
use wgpu::{BufferUsages, QUERY_RESOLVE_BUFFER_ALIGNMENT, QUERY_SET_MAX_QUERIES};

/// A pair of timestamps.
const PAIR: u64 = 2 * wgpu::QUERY_SIZE as u64;

/// Timestamps of passes; none where the device has none, or where there are more passes than it counts.
#[derive(Debug)]
pub(crate) struct Times {
    kept: Option<Kept>,
    passes: Cell<u32>,
}

#[derive(Debug)]
struct Kept {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    read: wgpu::Buffer,
}

impl Times {
    /// Room for the timestamps of `most` passes.
    pub fn new(gpu: &Gpu, most: usize) -> Result<Self, Reason> {
        let is_kept = gpu.device.features().contains(wgpu::Features::TIMESTAMP_QUERY)
            && (1..=QUERY_SET_MAX_QUERIES as usize / 2).contains(&most);
        if !is_kept {
            return Ok(Times { kept: None, passes: Cell::new(0) });
        }
        let queries = gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("times"),
            ty: wgpu::QueryType::Timestamp,
            count: 2 * most as u32,
        });
        // Each pass resolves its own pair, at a place as it has to be aligned.
        let apart = most * QUERY_RESOLVE_BUFFER_ALIGNMENT as usize;
        let resolved = gpu.buffer("times", apart, BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC)?;
        let usage = BufferUsages::MAP_READ | BufferUsages::COPY_DST;
        let read = gpu.buffer("times read", most * PAIR as usize, usage)?;
        Ok(Times { kept: Some(Kept { queries, resolved, read }), passes: Cell::new(0) })
    }

    /// The next pass, as it is to be begun.
    pub fn pass(&self) -> wgpu::ComputePassDescriptor<'_> {
        let first = 2 * self.passes.get();
        let timestamp_writes = self.kept.as_ref().map(|kept| wgpu::ComputePassTimestampWrites {
            query_set: &kept.queries,
            beginning_of_pass_write_index: Some(first),
            end_of_pass_write_index: Some(first + 1),
        });
        wgpu::ComputePassDescriptor { label: None, timestamp_writes }
    }

    /// Behind the pass, in the same encoder.
    pub fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        if let Some(Kept { queries, resolved, read }) = &self.kept {
            let (i, first) = (u64::from(self.passes.get()), 2 * self.passes.get());
            let from = i * QUERY_RESOLVE_BUFFER_ALIGNMENT;
            encoder.resolve_query_set(queries, first..first + 2, resolved, from);
            encoder.copy_buffer_to_buffer(resolved, from, read, i * PAIR, PAIR);
        }
        self.passes.set(self.passes.get() + 1);
    }

    /// Waits for the passes, and gives the seconds that they took together.
    pub fn seconds(self, gpu: &Gpu) -> Result<Option<f64>, Reason> {
        let Some(kept) = self.kept else { return Ok(None) };
        let bytes = self.passes.get() as usize * PAIR as usize;
        let ticks = gpu.read(&kept.read, |read| {
            let pairs: &[[u64; 2]] = bytemuck::cast_slice(&read[..bytes]);
            pairs.iter().map(|[start, end]| end.saturating_sub(*start)).sum::<u64>()
        })?;
        Ok(Some(ticks as f64 * f64::from(gpu.queue.get_timestamp_period()) * 1e-9))
    }
}
