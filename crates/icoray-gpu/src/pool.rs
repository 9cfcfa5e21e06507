//! Buffers that are reused from frame to frame, so that only the first frames allocate device memory.

use std::ops::Deref;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use wgpu::BufferUsages;

/// Number of frames after which an unused buffer is released.
const MAX_IDLE_FRAMES: u64 = 16;

/// Buffers that are free for reuse.
#[derive(Debug, Default)]
pub(crate) struct BufferPool {
    free: Mutex<Vec<FreeBuffer>>,
    frames: AtomicU64,
}

#[derive(Debug)]
struct FreeBuffer {
    buffer: wgpu::Buffer,
    /// Number of the frame that freed it.
    since: u64,
}

/// A buffer that returns to its pool when dropped. Drop it after the last commands that use it are submitted; they may
/// still be executing, because the device executes submissions in order.
///
/// A buffer with [`BufferUsages::MAP_READ`] returns to the pool by [`Self::unmap`] only: the pool must not hold a
/// mapped one.
#[derive(Debug)]
pub(crate) struct PooledBuffer {
    buffer: wgpu::Buffer,
    pool: Arc<BufferPool>,
}

impl Deref for PooledBuffer {
    type Target = wgpu::Buffer;

    fn deref(&self) -> &wgpu::Buffer {
        &self.buffer
    }
}

impl PooledBuffer {
    pub fn new(buffer: wgpu::Buffer, pool: &Arc<BufferPool>) -> Self {
        PooledBuffer { buffer, pool: Arc::clone(pool) }
    }

    pub fn unmap(self) {
        self.buffer.unmap();
        self.pool.put(self.buffer.clone());
    }
}

impl Drop for PooledBuffer {
    fn drop(&mut self) {
        if !self.buffer.usage().contains(BufferUsages::MAP_READ) {
            self.pool.put(self.buffer.clone());
        }
    }
}

impl BufferPool {
    fn free(&self) -> MutexGuard<'_, Vec<FreeBuffer>> {
        self.free.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn put(&self, buffer: wgpu::Buffer) {
        let since = self.frames.load(Ordering::Relaxed);
        self.free().push(FreeBuffer { buffer, since });
    }

    /// Removes and returns the smallest buffer of `usage` that has between `size` and `2 * size` bytes.
    pub fn take(&self, size: u64, usage: BufferUsages) -> Option<wgpu::Buffer> {
        let mut free = self.free();
        let fits = |b: &wgpu::Buffer| b.usage() == usage && (size..=2 * size).contains(&b.size());
        let fitting = (0..free.len()).filter(|&i| fits(&free[i].buffer));
        let best = fitting.min_by_key(|&i| free[i].buffer.size())?;
        Some(free.swap_remove(best).buffer)
    }

    /// Counts a frame and releases the buffers that were unused for more than [`MAX_IDLE_FRAMES`].
    pub fn end_frame(&self) {
        let now = self.frames.fetch_add(1, Ordering::Relaxed);
        self.free().retain(|free| free.since + MAX_IDLE_FRAMES >= now);
    }

    pub fn clear(&self) {
        self.free().clear();
    }
}
