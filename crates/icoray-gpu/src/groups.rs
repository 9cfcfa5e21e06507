//! Groups of buffers that shaders read and write.

use crate::gpu::Gpu;
use icoray::device::Reason;
use wgpu::BufferBindingType::{self, Storage};

/// Of a buffer that is read only.
pub(crate) const READ: BufferBindingType = Storage { read_only: true };

/// The layout of a group of buffers of these kinds, numbered from 0.
pub(crate) fn layout(device: &wgpu::Device, kinds: &[BufferBindingType]) -> wgpu::BindGroupLayout {
    let entry = |(binding, ty): (u32, &BufferBindingType)| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer { ty: *ty, has_dynamic_offset: false, min_binding_size: None },
        count: None,
    };
    let entries: Vec<_> = (0..).zip(kinds).map(entry).collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: None, entries: &entries })
}

/// A group of buffers, numbered from 0.
pub(crate) fn group<'b>(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    buffers: impl IntoIterator<Item = &'b wgpu::Buffer>,
) -> wgpu::BindGroup {
    let entry = |(binding, buffer): (u32, &'b wgpu::Buffer)| wgpu::BindGroupEntry {
        binding,
        resource: buffer.as_entire_binding(),
    };
    let entries: Vec<_> = (0..).zip(buffers).map(entry).collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
}

impl Gpu {
    /// A group of buffers, numbered from 0.
    pub(crate) fn group<'b>(
        &self,
        layout: &wgpu::BindGroupLayout,
        buffers: impl IntoIterator<Item = &'b wgpu::Buffer>,
    ) -> Result<wgpu::BindGroup, Reason> {
        self.watched(|| group(&self.device, layout, buffers))
    }

    /// The layout of groups of pages.
    pub(crate) fn page_layout(&self, pages: usize) -> wgpu::BindGroupLayout {
        layout(&self.device, &vec![READ; pages])
    }
}
