//! What comes back from the device, while it is at work on what follows.

use crate::gpu::Gpu;
use crate::store::Lent;
use icoray::device::Reason;
use std::sync::mpsc::{Receiver, channel};
use wgpu::BufferUsages;

/// Bytes on their way.
pub(crate) struct Flight {
    back: Lent,
    bytes: usize,
    submission: wgpu::SubmissionIndex,
    mapped: Receiver<Result<(), wgpu::BufferAsyncError>>,
}

impl Gpu {
    /// Submits commands, and behind them a copy of the first `bytes` of `buffer` to the host.
    pub(crate) fn submit(
        &self,
        mut commands: wgpu::CommandEncoder,
        buffer: &wgpu::Buffer,
        bytes: usize,
    ) -> Result<Flight, Reason> {
        let back = self.lend("back", bytes, BufferUsages::MAP_READ | BufferUsages::COPY_DST)?;
        let (told, mapped) = channel();
        let submission = self.watched(|| {
            commands.copy_buffer_to_buffer(buffer, 0, &back, 0, bytes as u64);
            let submission = self.queue.submit([commands.finish()]);
            back.map_async(wgpu::MapMode::Read, .., move |is| drop(told.send(is)));
            submission
        })?;
        Ok(Flight { back, bytes, submission, mapped })
    }

    /// Waits for bytes and gives them to `read`.
    pub(crate) fn land<R>(&self, flight: Flight, read: impl FnOnce(&[u8]) -> R) -> Result<R, Reason> {
        let Flight { back, bytes, submission, mapped } = flight;
        let broken =
            |e: &dyn std::fmt::Display| Reason::new(format!("reading from {}: {e}", self.described()));
        let wait = wgpu::PollType::Wait { submission_index: Some(submission), timeout: None };
        let waited = self.device.poll(wait);
        self.untroubled()?;
        waited.map_err(|e| broken(&e))?;
        mapped.recv().map_err(|e| broken(&e))?.map_err(|e| broken(&e))?;
        let view = back.get_mapped_range(..bytes as u64).map_err(|e| broken(&e))?;
        let read = read(&view);
        drop(view);
        back.unmap();
        Ok(read)
    }
}
