//! Copies of device buffers to the host, which overlap with the execution of later commands.

use crate::context::Context;
use crate::pool::PooledBuffer;
use icoray::device::FallbackReason;
use std::fmt::Display;
use std::sync::mpsc::{Receiver, channel};
use wgpu::BufferUsages;

pub(crate) struct Readback {
    buffer: PooledBuffer,
    bytes: usize,
    submission: wgpu::SubmissionIndex,
    mapped: Receiver<Result<(), wgpu::BufferAsyncError>>,
}

impl Readback {
    /// Submits `commands`, followed by a copy of the first `bytes` bytes of `source` to the host.
    pub fn submit(
        ctx: &Context,
        mut commands: wgpu::CommandEncoder,
        source: &wgpu::Buffer,
        bytes: usize,
    ) -> Result<Self, FallbackReason> {
        let buffer = ctx.pooled("back", bytes, BufferUsages::MAP_READ | BufferUsages::COPY_DST)?;
        let (sender, mapped) = channel();
        let submission = ctx.scoped(|| {
            commands.copy_buffer_to_buffer(source, 0, &buffer, 0, bytes as u64);
            let submission = ctx.queue.submit([commands.finish()]);
            buffer.map_async(wgpu::MapMode::Read, .., move |result| drop(sender.send(result)));
            submission
        })?;
        Ok(Readback { buffer, bytes, submission, mapped })
    }

    /// Waits for the copy and passes its bytes to `read`.
    pub fn wait<R>(self, ctx: &Context, read: impl FnOnce(&[u8]) -> R) -> Result<R, FallbackReason> {
        let Readback { buffer, bytes, submission, mapped } = self;
        let failed = |e: &dyn Display| FallbackReason::new(format!("reading from {}: {e}", ctx.name()));
        let wait = wgpu::PollType::Wait { submission_index: Some(submission), timeout: None };
        let waited = ctx.device.poll(wait);
        ctx.check()?;
        waited.map_err(|e| failed(&e))?;
        mapped.recv().map_err(|e| failed(&e))?.map_err(|e| failed(&e))?;
        let view = buffer.get_mapped_range(..bytes as u64).map_err(|e| failed(&e))?;
        let result = read(&view);
        drop(view);
        buffer.unmap();
        Ok(result)
    }
}
