//! An open device with its queue, limits and buffer pool.

use crate::adapters::Kind;
use crate::pool::{BufferPool, PooledBuffer};
use icoray::device::FallbackReason;
use std::ops::Deref;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use wgpu::BufferUsages;

/// Largest number of storage buffers of a shader besides its pages, which come in pairs.
pub(crate) const NON_PAGE_STORAGE_BUFFERS: u32 = 13;

/// Open devices that nobody uses. GPUs are closed only if they are lost: with NVIDIA's driver the process waits for
/// ever if one thread closes a device while another compiles a shader (seen with 580.159). Processors are closed, and
/// with them their threads end.
static IDLE: Mutex<Vec<OpenDevice>> = Mutex::new(Vec::new());

#[derive(Debug, Clone)]
pub(crate) struct OpenDevice {
    info: wgpu::AdapterInfo,
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    pub limits: wgpu::Limits,
    /// Why the device is unusable: that it was lost, or an error outside all error scopes.
    failure: Arc<OnceLock<String>>,
}

/// An open device and what belongs to its user, who has it alone.
#[derive(Debug)]
pub(crate) struct Context {
    open: OpenDevice,
    pub pool: Arc<BufferPool>,
    buffers_created: AtomicU64,
}

impl Deref for Context {
    type Target = OpenDevice;

    fn deref(&self) -> &OpenDevice {
        &self.open
    }
}

impl Drop for Context {
    fn drop(&mut self) {
        self.pool.clear();
        // Frees the memory of what was dropped.
        drop(self.device.poll(wgpu::PollType::Poll));
        if self.check().is_ok() && Kind::from(self.info.device_type) != Kind::Processor {
            IDLE.lock().unwrap_or_else(PoisonError::into_inner).push(self.open.clone());
        }
    }
}

impl OpenDevice {
    /// Opens `adapter`, with storage bindings of at most `max_binding` bytes, or takes a device that is open so.
    fn new(adapter: &wgpu::Adapter, max_binding: Option<u64>) -> Result<Self, FallbackReason> {
        let (info, mut limits) = (adapter.get_info(), adapter.limits());
        let binding = &mut limits.max_storage_buffer_binding_size;
        *binding = max_binding.map_or(*binding, |max| max.min(*binding));
        let fits = |idle: &OpenDevice| (&idle.info, &idle.limits) == (&info, &limits) && idle.failure.get().is_none();
        let mut idle = IDLE.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(at) = idle.iter().position(fits) {
            return Ok(idle.swap_remove(at));
        }
        drop(idle);
        let (has, needed) = (limits.max_storage_buffers_per_shader_stage, NON_PAGE_STORAGE_BUFFERS + 2);
        if has < needed {
            let name = &info.name;
            let reason = format!("{name} has {has} storage buffers for a shader, expected {needed}");
            return Err(FallbackReason::new(reason));
        }
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("icoray"),
            // Optional: timestamps appear in reports only.
            required_features: adapter.features() & wgpu::Features::TIMESTAMP_QUERY,
            required_limits: limits.clone(),
            memory_hints: wgpu::MemoryHints::MemoryUsage,
            ..wgpu::DeviceDescriptor::default()
        };
        let opened = pollster::block_on(adapter.request_device(&descriptor));
        let (device, queue) = opened.map_err(|e| FallbackReason::new(format!("{}: {e}", info.name)))?;
        let failure = Arc::new(OnceLock::new());
        let (error, lost) = (Arc::clone(&failure), Arc::clone(&failure));
        // All calls that may fail run in error scopes, so an error outside them is unexpected and disables the device.
        device.on_uncaptured_error(Arc::new(move |e: wgpu::Error| drop(error.set(e.to_string()))));
        device.set_device_lost_callback(move |reason, message| {
            // Dropping the device reports `Destroyed`.
            if reason != wgpu::DeviceLostReason::Destroyed {
                drop(lost.set(format!("the device is lost: {message}")));
            }
        });
        Ok(OpenDevice { info, device, queue, limits, failure })
    }
}

impl Context {
    /// Opens `adapter`, with storage bindings of at most `max_binding` bytes.
    pub fn open(adapter: &wgpu::Adapter, max_binding: Option<u64>) -> Result<Self, FallbackReason> {
        let open = OpenDevice::new(adapter, max_binding)?;
        let context = Context { open, pool: Arc::default(), buffers_created: AtomicU64::default() };
        context.check()?;
        Ok(context)
    }

    /// Name and driver of the device.
    pub fn name(&self) -> String {
        let wgpu::AdapterInfo { name, driver, driver_info, .. } = &self.info;
        format!("{name} ({driver} {driver_info})")
    }

    pub fn buffers_created(&self) -> u64 {
        self.buffers_created.load(Ordering::Relaxed)
    }

    /// Fails if the device was lost.
    pub fn check(&self) -> Result<(), FallbackReason> {
        let error = |message| Err(FallbackReason::new(format!("{}: {message}", self.info.name)));
        self.failure.get().map_or(Ok(()), error)
    }

    /// Runs `act` and returns the first error that the device reports meanwhile on this thread.
    pub fn scoped<R>(&self, act: impl FnOnce() -> R) -> Result<R, FallbackReason> {
        use wgpu::ErrorFilter::{Internal, OutOfMemory, Validation};
        let mut scopes = [Internal, OutOfMemory, Validation].map(|kind| Some(self.device.push_error_scope(kind)));
        let result = act();
        let errors = scopes.iter_mut().rev().filter_map(Option::take);
        let errors: Vec<_> = errors.filter_map(|scope| pollster::block_on(scope.pop())).collect();
        self.check()?;
        match errors.first() {
            Some(error) => Err(FallbackReason::new(format!("{}: {error}", self.info.name))),
            None => Ok(result),
        }
    }

    /// Largest size in bytes of a buffer of `usage`.
    pub fn max_buffer_size(&self, usage: BufferUsages) -> u64 {
        let binding = match usage.contains(BufferUsages::STORAGE) {
            true => self.limits.max_storage_buffer_binding_size,
            false => u64::MAX,
        };
        self.limits.max_buffer_size.min(binding) / 4 * 4
    }

    /// Creates a buffer of at least `bytes` bytes; with [`BufferUsages::MAP_WRITE`] it is mapped.
    pub fn buffer(&self, label: &str, bytes: usize, usage: BufferUsages) -> Result<wgpu::Buffer, FallbackReason> {
        let (max, name) = (self.max_buffer_size(usage), &self.info.name);
        // A binding has at least one element, the largest of which are 64 bytes.
        let size = (bytes as u64).max(64).next_multiple_of(4);
        if size > max {
            let reason = format!("{label}: {bytes} bytes, expected at most the {max} of {name}");
            return Err(FallbackReason::new(reason));
        }
        let mapped_at_creation = usage.contains(BufferUsages::MAP_WRITE);
        let descriptor = wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation };
        self.buffers_created.fetch_add(1, Ordering::Relaxed);
        self.scoped(|| self.device.create_buffer(&descriptor))
    }

    /// Creates a storage buffer that holds `elements`.
    pub fn storage<T: bytemuck::NoUninit>(&self, label: &str, elements: &[T]) -> Result<wgpu::Buffer, FallbackReason> {
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        let buffer = self.buffer(label, size_of_val(elements), usage)?;
        self.write(&buffer, elements)?;
        Ok(buffer)
    }

    /// Takes a buffer of at least `bytes` bytes from the pool, or creates one.
    pub fn pooled(&self, label: &str, bytes: usize, usage: BufferUsages) -> Result<PooledBuffer, FallbackReason> {
        // Rounded up to an eighth of a power of two, so that a slightly larger frame reuses the same buffers.
        let size = (bytes as u64).max(1 << 12);
        let size = size.next_multiple_of(size.next_power_of_two() / 8);
        let size = size.min(self.max_buffer_size(usage)).max(bytes as u64);
        let create = || self.buffer(label, size as usize, usage);
        let buffer = self.pool.take(size, usage).map_or_else(create, Ok);
        // If memory is exhausted, retry without the free buffers and without rounding.
        let buffer = buffer.or_else(|_| {
            self.pool.clear();
            self.buffer(label, bytes, usage)
        })?;
        Ok(PooledBuffer::new(buffer, &self.pool))
    }

    /// A pooled buffer of `usage`, storage or uniform, that holds `elements`.
    pub fn pooled_data<T: bytemuck::NoUninit>(
        &self,
        label: &str,
        elements: &[T],
        usage: BufferUsages,
    ) -> Result<PooledBuffer, FallbackReason> {
        let buffer = self.pooled(label, size_of_val(elements), usage | BufferUsages::COPY_DST)?;
        self.write(&buffer, elements)?;
        Ok(buffer)
    }

    fn write<T: bytemuck::NoUninit>(&self, buffer: &wgpu::Buffer, elements: &[T]) -> Result<(), FallbackReason> {
        self.scoped(|| self.queue.write_buffer(buffer, 0, bytemuck::cast_slice(elements)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::adapters::find;
    use icoray::device::DeviceRequest;
    use icoray_test_support::{Need, skip_because};
    use std::path::Path;

    /// A GPU that is no longer used is taken again, one in use or a lost one is not.
    #[test]
    fn devices_stay_open() {
        let wanted = DeviceRequest { adapter: None, or_processor: true, node_rank: 0 };
        // Limits of this test alone.
        let open = || find(&wanted, Path::new("/dev")).and_then(|adapter| Context::open(&adapter, Some(77 << 20)));
        let first = match open() {
            Ok(ctx) => ctx,
            Err(reason) => return skip_because(Need::Gpu, reason),
        };
        // Devices of two instances can compare as equal.
        let device = Arc::clone(&first.failure);
        let is_same = |other: &Context| Arc::ptr_eq(&device, &other.failure);
        let second = open().unwrap();
        assert!(!is_same(&second));
        if Kind::from(first.info.device_type) == Kind::Processor {
            IDLE.lock().unwrap().push(first.open.clone());
        }
        drop(first);
        let again = open().unwrap();
        assert!(is_same(&again));
        again.failure.set("lost".into()).unwrap();
        drop(again);
        assert!(!is_same(&open().unwrap()));
    }
}
