//! The device: which one, and what goes wrong on it.

use crate::gradient;
use crate::groups::{READ, layout};
use crate::held::Fields;
use crate::mesh::Meshes;
use crate::part;
use crate::scene::Variant;
use crate::staging::Staging;
use crate::starts::Starts;
use crate::store::Store;
use icoray::device::Reason;
use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock};
use wgpu::BufferUsages;

/// Shorthand of this crate's.
pub(crate) fn because<T>(reason: impl Into<String>) -> Result<T, Reason> {
    Err(Reason::new(reason))
}

/// A device, ready to draw.
#[derive(Debug)]
pub struct Gpu {
    info: wgpu::AdapterInfo,
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    pub(crate) limits: wgpu::Limits,
    pub(crate) bindings: wgpu::BindGroupLayout,
    /// Group 2 of pictures: the light.
    pub(crate) of_light: wgpu::BindGroupLayout,
    /// Group 2 of rays through parts.
    pub(crate) of_parts: wgpu::BindGroupLayout,
    pub(crate) gradient_pass: gradient::Pass,
    pub(crate) pipelines: Mutex<HashMap<Variant, wgpu::ComputePipeline>>,
    pub(crate) meshes: Meshes,
    pub(crate) starts: Mutex<Arc<Starts>>,
    pub(crate) store: Arc<Store>,
    pub(crate) staging: Staging,
    pub(crate) fields: Fields,
    /// Bytes that fields may take.
    pub(crate) most_of_fields: u64,
    buffers_made: AtomicU64,
    /// How the device was lost, if it was.
    loss: Arc<OnceLock<String>>,
}

/// How much of a device is used, where that is less than it has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Most {
    /// Bytes of a buffer that a shader reads.
    pub binding: Option<u64>,
    /// Bytes of a field, gradients included. A picture of a larger one is drawn in passes, each with what its rays meet.
    pub field: Option<u64>,
}

/// Bindings of `shaders/` in group 0, in order: their kinds. Groups 1 and 3 have the pages of the field and of its gradients,
/// group 2 has the light.
const BINDINGS: [wgpu::BufferBindingType; 14] = {
    let mut kinds = [READ; 14];
    kinds[0] = wgpu::BufferBindingType::Uniform;
    kinds[13] = wgpu::BufferBindingType::Storage { read_only: false };
    kinds
};

/// Storage buffers that a shader has at most beside pages, which come in pairs.
pub(crate) const STORAGES: u32 = 16;

impl Gpu {
    /// Opens a device.
    pub(crate) fn open(adapter: &wgpu::Adapter, most: Most) -> Result<Self, Reason> {
        let (info, mut limits) = (adapter.get_info(), adapter.limits());
        let binding = &mut limits.max_storage_buffer_binding_size;
        *binding = most.binding.map_or(*binding, |most| most.min(*binding));
        let needed = STORAGES + 2;
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
        let loss = Arc::new(OnceLock::new());
        let (error, lost) = (Arc::clone(&loss), Arc::clone(&loss));
        // Whatever may fail is watched; what is not is as good as a loss.
        device.on_uncaptured_error(Arc::new(move |e: wgpu::Error| drop(error.set(e.to_string()))));
        device.set_device_lost_callback(move |reason, message| {
            // A device that is dropped is lost to nobody.
            if reason != wgpu::DeviceLostReason::Destroyed {
                drop(lost.set(format!("the device is lost: {message}")));
            }
        });
        let bindings = layout(&device, &BINDINGS);
        let of_light = layout(&device, &[wgpu::BufferBindingType::Uniform]);
        let of_parts = layout(&device, &part::BINDINGS);
        let gradient_pass = gradient::Pass::new(&device);
        let gpu = Gpu {
            info,
            device,
            queue,
            limits,
            bindings,
            of_light,
            of_parts,
            gradient_pass,
            pipelines: Mutex::default(),
            meshes: Meshes::default(),
            starts: Mutex::default(),
            store: Arc::default(),
            staging: Staging::default(),
            fields: Fields::default(),
            most_of_fields: most.field.unwrap_or(u64::MAX),
            buffers_made: AtomicU64::default(),
            loss,
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

    /// How many buffers the device was asked for so far.
    pub fn buffers_made(&self) -> u64 {
        self.buffers_made.load(Ordering::Relaxed)
    }

    /// Whether the device is still there.
    pub(crate) fn untroubled(&self) -> Result<(), Reason> {
        self.loss.get().map_or(Ok(()), |message| because(format!("{}: {message}", self.info.name)))
    }

    /// Does something on the device; what it complains of meanwhile, on this thread, is why it is not done.
    pub(crate) fn watched<R>(&self, act: impl FnOnce() -> R) -> Result<R, Reason> {
        use wgpu::ErrorFilter::{Internal, OutOfMemory, Validation};
        let mut scopes =
            [Internal, OutOfMemory, Validation].map(|kind| Some(self.device.push_error_scope(kind)));
        let done = act();
        let errors = scopes.iter_mut().rev().filter_map(Option::take);
        let errors: Vec<_> = errors.filter_map(|scope| pollster::block_on(scope.pop())).collect();
        self.untroubled()?;
        match errors.first() {
            Some(error) => because(format!("{}: {error}", self.info.name)),
            None => Ok(done),
        }
    }

    /// The most bytes that a buffer may have.
    pub(crate) fn most(&self, usage: BufferUsages) -> u64 {
        let binding = match usage.contains(BufferUsages::STORAGE) {
            true => self.limits.max_storage_buffer_binding_size,
            false => u64::MAX,
        };
        self.limits.max_buffer_size.min(binding) / 4 * 4
    }

    /// Room for `bytes` in a buffer.
    pub(crate) fn buffer(
        &self,
        what: &str,
        bytes: usize,
        usage: BufferUsages,
    ) -> Result<wgpu::Buffer, Reason> {
        let (most, name) = (self.most(usage), &self.info.name);
        // A binding has at least one element, the largest of which are 64 bytes.
        let size = (bytes as u64).max(64).next_multiple_of(4);
        if size > most {
            return because(format!("{what}: {bytes} bytes, expected at most the {most} of {name}"));
        }
        // What the host writes it does so at once.
        let mapped_at_creation = usage.contains(BufferUsages::MAP_WRITE);
        let descriptor = wgpu::BufferDescriptor { label: Some(what), size, usage, mapped_at_creation };
        self.buffers_made.fetch_add(1, Ordering::Relaxed);
        self.watched(|| self.device.create_buffer(&descriptor))
    }

    /// A buffer that holds `elements`.
    pub(crate) fn upload<T: bytemuck::NoUninit>(
        &self,
        what: &str,
        elements: &[T],
    ) -> Result<wgpu::Buffer, Reason> {
        let buffer =
            self.buffer(what, size_of_val(elements), BufferUsages::STORAGE | BufferUsages::COPY_DST)?;
        self.watched(|| self.queue.write_buffer(&buffer, 0, bytemuck::cast_slice(elements)))?;
        Ok(buffer)
    }
}

#[cfg(test)]
mod tests {
    use crate::Gpu;
    use icoray::{Field, Grid, IcosahedralMesh, Layers, Location, Renderer, Scene, Shape};
    use icoray_test_support::{Need, skip_because};
    use std::sync::Arc;

    /// The picture of a device that is lost comes from the CPU, now and later.
    #[test]
    fn a_lost_device_is_a_reason() {
        let gpu = match Gpu::new(None) {
            Ok(gpu) => Arc::new(gpu),
            Err(reason) => return skip_because(Need::Gpu, reason),
        };
        let tables = IcosahedralMesh::new(2).unwrap();
        let grid = Grid::new(tables.tables()).unwrap();
        let layers = Layers::new(vec![1.0, 1.1, 1.2], 1.0).unwrap();
        let values: Vec<f32> = (0..3 * grid.cells()).map(|i| (i % 7) as f32 / 7.0).collect();
        let shape = Shape::level_fastest(grid.cells(), 3);
        let field = Field::new(values.as_slice().into(), shape, Location::Center, None).unwrap();
        let scene = Scene::parse(
            "field = \"f\"\n[image]\nwidth = 24\nheight = 24\n[camera]\nlon = 30\nlat = 25\ndistance = 3\nfov = 50\n\
             [transfer]\nmap = \"viridis\"\nrange = [0, 1]\nopacity = [[0, 0.2], [1, 0.8]]\n",
        )
        .unwrap();
        let alone = Renderer::new(1).unwrap().render(&scene, &grid, &layers, &field).unwrap();
        let renderer = Renderer::new(1).unwrap().with_device(Arc::clone(&gpu) as _);
        let draw = || renderer.render(&scene, &grid, &layers, &field).unwrap();
        assert!(draw().report.device.is_some());
        gpu.device.destroy();
        for _ in 0..2 {
            let frame = draw();
            assert!(
                frame.report.device.is_none() && frame.report.left_to_cpu.is_some(),
                "{:?}",
                frame.report
            );
            assert!(frame.pixels == alone.pixels && frame.error == alone.error);
        }
    }
}
