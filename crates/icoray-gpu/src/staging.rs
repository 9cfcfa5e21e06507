//! Uploads of large arrays in chunks: all threads of the pool write one staging buffer while the device copies from
//! those written before.

use crate::context::Context;
use icoray::device::FallbackReason;
use rayon::prelude::*;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use wgpu::BufferUsages;

const BUFFER_BYTES: usize = 8 << 20;
const MAX_BUFFERS: usize = 8;
const ELEMENT_BYTES: usize = size_of::<f32>();
/// Elements that a thread writes at a time; they fit into its L1 cache.
const BLOCK: usize = 4096;

/// Staging buffers, created on first use.
#[derive(Debug, Default)]
pub(crate) struct StagingBuffers(Arc<Mutex<State>>);

#[derive(Debug, Default)]
struct State {
    ready: Vec<wgpu::Buffer>,
    created: usize,
}

impl StagingBuffers {
    fn state(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Fills `buffer` with `count` elements of the size of a float. `values(first, elements)` computes those from
    /// number `first` on and is called on all threads.
    pub fn fill(
        &self,
        ctx: &Context,
        buffer: &wgpu::Buffer,
        count: usize,
        values: impl Fn(usize, &mut [f32]) + Sync,
    ) -> Result<(), FallbackReason> {
        let mut submitted = VecDeque::new();
        for first in (0..count).step_by(BUFFER_BYTES / ELEMENT_BYTES) {
            let bytes = ((count - first) * ELEMENT_BYTES).min(BUFFER_BYTES) as u64;
            let staging = self.take(ctx, &mut submitted)?;
            let view = staging.get_mapped_range_mut(..bytes);
            let mut view = view.map_err(|e| FallbackReason::new(format!("writing for {}: {e}", ctx.name())))?;
            write(view.slice(..), |offset, block| values(first + offset, block));
            drop(view);
            staging.unmap();
            submitted.push_back(ctx.scoped(|| {
                let mut encoder = ctx.device.create_command_encoder(&Default::default());
                encoder.copy_buffer_to_buffer(&staging, 0, buffer, (first * ELEMENT_BYTES) as u64, bytes);
                ctx.queue.submit([encoder.finish()])
            })?);
            self.recycle(staging);
        }
        Ok(())
    }

    /// Returns a mapped staging buffer. If there is none and no more may be created, waits for the first of
    /// `submitted`.
    fn take(
        &self,
        ctx: &Context,
        submitted: &mut VecDeque<wgpu::SubmissionIndex>,
    ) -> Result<wgpu::Buffer, FallbackReason> {
        loop {
            let mut state = self.state();
            if let Some(buffer) = state.ready.pop() {
                return Ok(buffer);
            }
            if state.created < MAX_BUFFERS {
                state.created += 1;
                drop(state);
                let usage = BufferUsages::MAP_WRITE | BufferUsages::COPY_SRC;
                let buffer = ctx.buffer("stage", BUFFER_BYTES, usage);
                return buffer.inspect_err(|_| self.state().created -= 1);
            }
            drop(state);
            // Other threads may own all buffers, and this one may have submitted nothing: hence the timeout.
            let submission_index = submitted.front().cloned();
            let timeout = Some(Duration::from_millis(1));
            if ctx.device.poll(wgpu::PollType::Wait { submission_index, timeout }).is_ok() {
                submitted.pop_front();
            }
            ctx.check()?;
        }
    }

    /// Maps a buffer again once the device has copied from it.
    fn recycle(&self, buffer: wgpu::Buffer) {
        let (state, mapped) = (Arc::clone(&self.0), buffer.clone());
        buffer.map_async(wgpu::MapMode::Write, .., move |result| {
            let mut state = state.lock().unwrap_or_else(PoisonError::into_inner);
            match result {
                Ok(()) => state.ready.push(mapped),
                Err(_) => state.created -= 1,
            }
        });
    }
}

/// Writes a mapped staging buffer block by block.
fn write(staging: wgpu::WriteOnly<'_, [u8]>, values: impl Fn(usize, &mut [f32]) + Sync) {
    let (blocks, mut tail) = staging.into_chunks::<{ BLOCK * ELEMENT_BYTES }>();
    let blocks: Vec<_> = blocks.into_iter().collect();
    let whole = blocks.len() * BLOCK;
    blocks.into_par_iter().enumerate().for_each(|(i, block)| {
        let mut elements = [0.0; BLOCK];
        values(i * BLOCK, &mut elements);
        wgpu::WriteOnly::<[u8]>::from(block).copy_from_slice(bytemuck::cast_slice(&elements));
    });
    let mut elements = vec![0.0; tail.len() / ELEMENT_BYTES];
    values(whole, &mut elements);
    tail.copy_from_slice(bytemuck::cast_slice(&elements));
}
