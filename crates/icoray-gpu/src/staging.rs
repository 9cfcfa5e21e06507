//! The way of large arrays onto the device: written piece by piece into memory that the device copies from, on all threads of
//! the pool, while it copies the pieces before.

use crate::gpu::Gpu;
use icoray::device::Reason;
use rayon::prelude::*;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use wgpu::BufferUsages;

/// Bytes of a stage.
const STAGE: usize = 8 << 20;
/// Stages that there are at most, of all threads.
const MOST: usize = 8;
/// Bytes of an element.
const SIZE: usize = 4;
/// Elements that a thread writes in one go, which its nearest cache holds.
const PIECE: usize = 4096;

/// What is uploaded.
pub(crate) trait Element: bytemuck::Pod + Send {}

impl Element for f32 {}
/// Two in a word.
impl Element for [i16; 2] {}

/// Stages, which are made when they are first needed.
#[derive(Debug, Default)]
pub(crate) struct Staging(Arc<Mutex<Stages>>);

#[derive(Debug, Default)]
struct Stages {
    /// Those that can be written.
    ready: Vec<wgpu::Buffer>,
    made: usize,
}

impl Staging {
    fn stages(&self) -> MutexGuard<'_, Stages> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Has a stage come back once the device has read it.
    fn come_back(&self, stage: wgpu::Buffer) {
        let (stages, mapped) = (Arc::clone(&self.0), stage.clone());
        stage.map_async(wgpu::MapMode::Write, .., move |is_mapped| {
            let mut stages = stages.lock().unwrap_or_else(PoisonError::into_inner);
            match is_mapped {
                Ok(()) => stages.ready.push(mapped),
                Err(_) => stages.made -= 1,
            }
        });
    }
}

impl Gpu {
    /// Fills `buffer` with `count` elements of 4 bytes; `values` gives those from a number on, for all threads.
    pub(crate) fn fill<T: Element>(
        &self,
        buffer: &wgpu::Buffer,
        count: usize,
        values: impl Fn(usize, &mut [T]) + Sync,
    ) -> Result<(), Reason> {
        let mut submitted = VecDeque::new();
        for first in (0..count).step_by(STAGE / SIZE) {
            let rest = (count - first) * SIZE;
            let bytes = rest.min(STAGE) as u64;
            let stage = self.stage(&mut submitted)?;
            let view = stage.get_mapped_range_mut(..bytes);
            let mut view = view.map_err(|e| Reason::new(format!("writing for {}: {e}", self.described())))?;
            write(view.slice(..), |at, piece| values(first + at, piece));
            drop(view);
            stage.unmap();
            submitted.push_back(self.watched(|| {
                let mut encoder = self.device.create_command_encoder(&Default::default());
                encoder.copy_buffer_to_buffer(&stage, 0, buffer, (first * SIZE) as u64, bytes);
                self.queue.submit([encoder.finish()])
            })?);
            self.staging.come_back(stage);
        }
        Ok(())
    }

    /// A stage that can be written: waits for the first of `submitted` where there is none.
    fn stage(&self, submitted: &mut VecDeque<wgpu::SubmissionIndex>) -> Result<wgpu::Buffer, Reason> {
        loop {
            let mut stages = self.staging.stages();
            if let Some(stage) = stages.ready.pop() {
                return Ok(stage);
            }
            if stages.made < MOST {
                stages.made += 1;
                drop(stages);
                let made = self.buffer("stage", STAGE, BufferUsages::MAP_WRITE | BufferUsages::COPY_SRC);
                return made.inspect_err(|_| self.staging.stages().made -= 1);
            }
            drop(stages);
            // Others may hold all stages: then nothing of this thread's is there to wait for. Of a loss the device tells.
            let submission_index = submitted.front().cloned();
            let timeout = Some(Duration::from_millis(1));
            if self.device.poll(wgpu::PollType::Wait { submission_index, timeout }).is_ok() {
                submitted.pop_front();
            }
            self.untroubled()?;
        }
    }
}

/// Writes all of a stage in pieces.
fn write<T: Element>(stage: wgpu::WriteOnly<'_, [u8]>, values: impl Fn(usize, &mut [T]) + Sync) {
    let (pieces, mut rest) = stage.into_chunks::<{ PIECE * SIZE }>();
    let pieces: Vec<_> = pieces.into_iter().collect();
    let whole = pieces.len() * PIECE;
    pieces.into_par_iter().enumerate().for_each(|(i, piece)| {
        let mut numbers = [T::zeroed(); PIECE];
        values(i * PIECE, &mut numbers);
        wgpu::WriteOnly::<[u8]>::from(piece).copy_from_slice(bytemuck::cast_slice(&numbers));
    });
    let mut numbers = vec![T::zeroed(); rest.len() / SIZE];
    values(whole, &mut numbers);
    rest.copy_from_slice(bytemuck::cast_slice(&numbers));
}
