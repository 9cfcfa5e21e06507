//! Buffers that outlive their frame: the next one takes them, so that only the first frames ask the device for memory.

use crate::gpu::Gpu;
use icoray::device::Reason;
use std::ops::Deref;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use wgpu::BufferUsages;

/// Frames after which a buffer that none of them has taken goes back to the device.
const KEPT: u64 = 16;

/// Buffers that are not lent.
#[derive(Debug, Default)]
pub(crate) struct Store {
    free: Mutex<Vec<Free>>,
    frames: AtomicU64,
}

#[derive(Debug)]
struct Free {
    buffer: wgpu::Buffer,
    since: u64,
}

/// A buffer that is given back when this is dropped, which must come after the last commands with it are submitted. The device
/// may still be at work on these: it does what it is told in order.
/// One that the host reads is given back by [`Self::unmap`] only, so that nobody gets a mapped one.
#[derive(Debug)]
pub(crate) struct Lent {
    buffer: wgpu::Buffer,
    store: Arc<Store>,
}

impl Deref for Lent {
    type Target = wgpu::Buffer;

    fn deref(&self) -> &wgpu::Buffer {
        &self.buffer
    }
}

impl Lent {
    /// Gives a mapped buffer back.
    pub fn unmap(self) {
        self.buffer.unmap();
        self.store.put(self.buffer.clone());
    }
}

impl Drop for Lent {
    fn drop(&mut self) {
        if !self.buffer.usage().contains(BufferUsages::MAP_READ) {
            self.store.put(self.buffer.clone());
        }
    }
}

impl Store {
    fn free(&self) -> MutexGuard<'_, Vec<Free>> {
        self.free.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn put(&self, buffer: wgpu::Buffer) {
        let since = self.frames.load(Ordering::Relaxed);
        self.free().push(Free { buffer, since });
    }

    /// The smallest one that holds `size` bytes and is not far too large.
    fn take(&self, size: u64, usage: BufferUsages) -> Option<wgpu::Buffer> {
        let mut free = self.free();
        let fits = |b: &wgpu::Buffer| b.usage() == usage && (size..=2 * size).contains(&b.size());
        let fitting = (0..free.len()).filter(|&i| fits(&free[i].buffer));
        let best = fitting.min_by_key(|&i| free[i].buffer.size())?;
        Some(free.swap_remove(best).buffer)
    }

    /// Gives buffers that are no longer taken back to the device; told once per frame.
    pub fn sweep(&self) {
        let now = self.frames.fetch_add(1, Ordering::Relaxed);
        self.free().retain(|free| free.since + KEPT >= now);
    }

    /// Gives all of them back.
    pub fn clear(&self) {
        self.free().clear();
    }
}

impl Gpu {
    /// Room for `bytes` in a buffer of the store, or in a new one.
    pub(crate) fn lend(&self, what: &str, bytes: usize, usage: BufferUsages) -> Result<Lent, Reason> {
        // In steps of an eighth, so that frames which need a little more now and then need no other buffer.
        let size = (bytes as u64).max(1 << 12);
        let size =
            size.next_multiple_of(size.next_power_of_two() / 8).min(self.most(usage)).max(bytes as u64);
        let new = || self.buffer(what, size as usize, usage);
        let buffer = self.store.take(size, usage).map_or_else(new, Ok);
        // Where there is no room, what others have left goes.
        let buffer = buffer.or_else(|_| {
            self.store.clear();
            self.buffer(what, bytes, usage)
        })?;
        Ok(Lent { buffer, store: Arc::clone(&self.store) })
    }

    /// A buffer of the store that holds a shader's numbers.
    pub(crate) fn lend_uniform<T: bytemuck::NoUninit>(
        &self,
        what: &str,
        numbers: &T,
    ) -> Result<Lent, Reason> {
        let usage = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
        let buffer = self.lend(what, size_of::<T>(), usage)?;
        self.watched(|| self.queue.write_buffer(&buffer, 0, bytemuck::bytes_of(numbers)))?;
        Ok(buffer)
    }

    /// A buffer of the store that holds `elements`.
    pub(crate) fn lend_with<T: bytemuck::NoUninit>(
        &self,
        what: &str,
        elements: &[T],
    ) -> Result<Lent, Reason> {
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        let buffer = self.lend(what, size_of_val(elements), usage)?;
        self.watched(|| self.queue.write_buffer(&buffer, 0, bytemuck::cast_slice(elements)))?;
        Ok(buffer)
    }
}
