//! Bind groups of buffers, numbered from 0, and their layouts.

use crate::context::Context;
use icoray::device::FallbackReason;
use wgpu::BufferBindingType::{self, Storage};

/// A storage buffer that shaders read.
pub(crate) const READ: BufferBindingType = Storage { read_only: true };
/// A storage buffer that shaders write.
pub(crate) const READ_WRITE: BufferBindingType = Storage { read_only: false };

/// The layout of a group of buffers of these kinds.
pub(crate) fn layout(ctx: &Context, kinds: &[BufferBindingType]) -> wgpu::BindGroupLayout {
    let entry = |(binding, ty): (u32, &BufferBindingType)| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer { ty: *ty, has_dynamic_offset: false, min_binding_size: None },
        count: None,
    };
    let entries: Vec<_> = (0..).zip(kinds).map(entry).collect();
    let descriptor = wgpu::BindGroupLayoutDescriptor { label: None, entries: &entries };
    ctx.device.create_bind_group_layout(&descriptor)
}

/// The layout of a group of `pages` pages of a field or of its gradients.
pub(crate) fn page_layout(ctx: &Context, pages: usize) -> wgpu::BindGroupLayout {
    layout(ctx, &vec![READ; pages])
}

/// Binds whole buffers.
pub(crate) fn group<'b>(
    ctx: &Context,
    layout: &wgpu::BindGroupLayout,
    buffers: impl IntoIterator<Item = &'b wgpu::Buffer>,
) -> Result<wgpu::BindGroup, FallbackReason> {
    let entry = |(binding, buffer): (u32, &'b wgpu::Buffer)| wgpu::BindGroupEntry {
        binding,
        resource: buffer.as_entire_binding(),
    };
    let entries: Vec<_> = (0..).zip(buffers).map(entry).collect();
    let descriptor = wgpu::BindGroupDescriptor { label: None, layout, entries: &entries };
    ctx.scoped(|| ctx.device.create_bind_group(&descriptor))
}
