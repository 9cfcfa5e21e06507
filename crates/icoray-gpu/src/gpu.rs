//! The device: which one, and what goes wrong on it.

use crate::light;
use crate::mesh::Meshes;
use crate::scene::{Picture, Variant};
use crate::starts::Starts;
use icoray::device::Reason;
use std::collections::HashMap;
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

/// Shorthand of this crate's.
pub(crate) fn because<T>(reason: impl Into<String>) -> Result<T, Reason> {
    Err(Reason::new(reason))
}

/// What a device has complained of and nobody has looked at, first come.
#[derive(Debug, Clone, Default)]
struct Trouble(Arc<Mutex<Option<String>>>);

impl Trouble {
    fn put(&self, message: String) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(message);
    }

    fn take(&self) -> Option<String> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

/// A device, ready to draw.
#[derive(Debug)]
pub struct Gpu {
    info: wgpu::AdapterInfo,
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    pub(crate) limits: wgpu::Limits,
    pub(crate) bindings: wgpu::BindGroupLayout,
    pub(crate) light: light::Bindings,
    pub(crate) pipelines: Mutex<HashMap<Variant, wgpu::ComputePipeline>>,
    pub(crate) meshes: Meshes,
    /// The last one.
    pub(crate) picture: Mutex<Option<Arc<Picture>>>,
    pub(crate) starts: Mutex<Arc<Starts>>,
    trouble: Trouble,
}

/// Bindings of `shaders/`, in order: their kinds.
const BINDINGS: [wgpu::BufferBindingType; 14] = {
    let mut kinds = [wgpu::BufferBindingType::Storage { read_only: true }; 14];
    kinds[0] = wgpu::BufferBindingType::Uniform;
    kinds[13] = wgpu::BufferBindingType::Storage { read_only: false };
    kinds
};

impl Gpu {
    /// Opens a device.
    pub(crate) fn open(adapter: &wgpu::Adapter) -> Result<Self, Reason> {
        let (info, limits) = (adapter.get_info(), adapter.limits());
        // The gradients are one more.
        let needed = BINDINGS.len() as u32;
        if limits.max_storage_buffers_per_shader_stage < needed {
            let has = limits.max_storage_buffers_per_shader_stage;
            return because(format!(
                "{} has {has} storage buffers for a shader, expected {needed}",
                info.name
            ));
        }
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("icoray"),
            // Clocks are for reports, and not missed where they are missing.
            required_features: adapter.features() & wgpu::Features::TIMESTAMP_QUERY,
            required_limits: limits.clone(),
            memory_hints: wgpu::MemoryHints::MemoryUsage,
            ..wgpu::DeviceDescriptor::default()
        };
        let opened = pollster::block_on(adapter.request_device(&descriptor));
        let (device, queue) = opened.map_err(|e| Reason::new(format!("{}: {e}", info.name)))?;
        let trouble = Trouble::default();
        let (error, loss) = (trouble.clone(), trouble.clone());
        device.on_uncaptured_error(Arc::new(move |e: wgpu::Error| error.put(e.to_string())));
        device.set_device_lost_callback(move |reason, message| {
            // A device that is dropped is lost to nobody.
            if reason != wgpu::DeviceLostReason::Destroyed {
                loss.put(format!("the device is lost: {message}"));
            }
        });
        let entries: Vec<_> = (0u32..)
            .zip(BINDINGS)
            .map(|(binding, ty)| wgpu::BindGroupLayoutEntry {
                binding,
                visibility: wgpu::ShaderStages::COMPUTE,
                ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
                count: None,
            })
            .collect();
        let layout = wgpu::BindGroupLayoutDescriptor { label: Some("icoray"), entries: &entries };
        let bindings = device.create_bind_group_layout(&layout);
        let light = light::Bindings::new(&device);
        let gpu = Gpu {
            info,
            device,
            queue,
            limits,
            bindings,
            light,
            pipelines: Mutex::default(),
            meshes: Meshes::default(),
            picture: Mutex::default(),
            starts: Mutex::default(),
            trouble,
        };
        gpu.untroubled()?;
        Ok(gpu)
    }

    /// The device's name and driver.
    pub(crate) fn described(&self) -> String {
        let wgpu::AdapterInfo { name, driver, driver_info, .. } = &self.info;
        format!("{name} ({driver} {driver_info})")
    }

    /// Whether the device is a processor that acts as a GPU, which is no faster than the CPU renderer.
    pub fn is_processor(&self) -> bool {
        self.info.device_type == wgpu::DeviceType::Cpu
    }

    /// What the device has complained of since it was last asked.
    pub(crate) fn untroubled(&self) -> Result<(), Reason> {
        self.trouble.take().map_or(Ok(()), |message| because(format!("{}: {message}", self.info.name)))
    }

    /// Room for `bytes` in a buffer that shaders read.
    pub(crate) fn buffer(
        &self,
        what: &str,
        bytes: usize,
        usage: wgpu::BufferUsages,
    ) -> Result<wgpu::Buffer, Reason> {
        let binding = if usage.contains(wgpu::BufferUsages::STORAGE) {
            self.limits.max_storage_buffer_binding_size
        } else {
            u64::MAX
        };
        let most = self.limits.max_buffer_size.min(binding);
        // A binding has at least one element, the largest of which are 64 bytes.
        let size = (bytes as u64).max(64).next_multiple_of(4);
        if size > most {
            return because(format!(
                "{what}: {bytes} bytes, expected at most the {most} of {}",
                self.info.name
            ));
        }
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(what),
            size,
            usage,
            mapped_at_creation: false,
        });
        self.untroubled()?;
        Ok(buffer)
    }

    /// A buffer that holds `elements`.
    pub(crate) fn upload<T: bytemuck::NoUninit>(
        &self,
        what: &str,
        elements: &[T],
    ) -> Result<wgpu::Buffer, Reason> {
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
        let buffer = self.buffer(what, size_of_val(elements), usage)?;
        self.queue.write_buffer(&buffer, 0, bytemuck::cast_slice(elements));
        self.untroubled()?;
        Ok(buffer)
    }

    /// Waits for the device and takes what it wrote to a buffer.
    pub(crate) fn read<R>(&self, buffer: &wgpu::Buffer, take: impl FnOnce(&[u8]) -> R) -> Result<R, Reason> {
        let failed = |e: &dyn fmt::Display| Reason::new(format!("reading from {}: {e}", self.info.name));
        let (told, hear) = std::sync::mpsc::channel();
        buffer.map_async(wgpu::MapMode::Read, .., move |is| drop(told.send(is)));
        let waited = self.device.poll(wgpu::PollType::wait_indefinitely());
        self.untroubled()?;
        waited.map_err(|e| failed(&e))?;
        hear.recv().map_err(|e| failed(&e))?.map_err(|e| failed(&e))?;
        let view = buffer.get_mapped_range(..).map_err(|e| failed(&e))?;
        let taken = take(&view);
        drop(view);
        buffer.unmap();
        Ok(taken)
    }
}
