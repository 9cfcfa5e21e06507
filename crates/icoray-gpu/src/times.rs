//! Seconds on the device by its own clock: timestamps before and behind each compute pass, summed.

use crate::gpu::Gpu;
use crate::store::Lent;
use icoray::device::Reason;
use std::cell::Cell;
use wgpu::{BufferUsages, QUERY_RESOLVE_BUFFER_ALIGNMENT, QUERY_SET_MAX_QUERIES};

/// From one pair of timestamps to the next: each pass resolves its own, at a place as it has to be aligned.
const APART: usize = QUERY_RESOLVE_BUFFER_ALIGNMENT as usize;

/// Timestamps of passes; none where the device has none, or where there are more passes than it counts.
pub(crate) struct Times {
    kept: Option<(wgpu::QuerySet, Lent)>,
    passes: Cell<u32>,
}

impl Times {
    /// Room for the timestamps of `most` passes.
    pub fn new(gpu: &Gpu, most: usize) -> Result<Self, Reason> {
        let has_clock = gpu.device.features().contains(wgpu::Features::TIMESTAMP_QUERY);
        if !has_clock || !(1..=QUERY_SET_MAX_QUERIES as usize / 2).contains(&most) {
            return Ok(Times { kept: None, passes: Cell::new(0) });
        }
        let descriptor = wgpu::QuerySetDescriptor {
            label: Some("times"),
            ty: wgpu::QueryType::Timestamp,
            count: 2 * most as u32,
        };
        let queries = gpu.watched(|| gpu.device.create_query_set(&descriptor))?;
        let usage = BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC;
        let resolved = gpu.lend("times", most * APART, usage)?;
        Ok(Times { kept: Some((queries, resolved)), passes: Cell::new(0) })
    }

    /// The next pass, as it is to be begun.
    pub fn pass(&self) -> wgpu::ComputePassDescriptor<'_> {
        let first = 2 * self.passes.get();
        let timestamp_writes = self.kept.as_ref().map(|(queries, _)| wgpu::ComputePassTimestampWrites {
            query_set: queries,
            beginning_of_pass_write_index: Some(first),
            end_of_pass_write_index: Some(first + 1),
        });
        wgpu::ComputePassDescriptor { label: None, timestamp_writes }
    }

    /// Behind the pass, in the same encoder.
    pub fn resolve(&self, commands: &mut wgpu::CommandEncoder) {
        let pass = self.passes.get();
        if let Some((queries, resolved)) = &self.kept {
            let there = u64::from(pass) * QUERY_RESOLVE_BUFFER_ALIGNMENT;
            commands.resolve_query_set(queries, 2 * pass..2 * pass + 2, resolved, there);
        }
        self.passes.set(pass + 1);
    }

    /// Waits for the passes, and gives the seconds that they took together.
    pub fn seconds(&self, gpu: &Gpu) -> Result<Option<f64>, Reason> {
        let Some((_, resolved)) = self.kept.as_ref().filter(|_| self.passes.get() > 0) else {
            return Ok(None);
        };
        let commands = gpu.device.create_command_encoder(&Default::default());
        let flight = gpu.submit(commands, resolved, self.passes.get() as usize * APART)?;
        let ticks: u64 = gpu.land(flight, |bytes| {
            let pair = |bytes: &[u8]| bytemuck::pod_read_unaligned::<[u64; 2]>(&bytes[..16]);
            bytes.chunks_exact(APART).map(pair).map(|[start, end]| end.saturating_sub(start)).sum()
        })?;
        Ok(Some(ticks as f64 * f64::from(gpu.queue.get_timestamp_period()) * 1e-9))
    }
}
