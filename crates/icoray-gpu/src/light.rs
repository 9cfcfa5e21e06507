//! What lit scenes have beside the others: group 1 of the bindings of `shaders/picture.wgsl`.

use crate::gpu::Gpu;
use crate::gradient::Gradients;
use crate::layout::{Shading, halves3};
use icoray::Lights;
use icoray::device::{Job, Reason};
use wgpu::{BufferBindingType, BufferUsages};

/// How often a piece of a ray may be cut in two for its light's sake: `MOST_CUTS` of `shaders/kernel/lit.wgsl`.
const MOST_CUTS: u32 = 20;

/// The layout of group 1, and the group of scenes without light.
#[derive(Debug)]
pub(crate) struct Bindings {
    pub layout: wgpu::BindGroupLayout,
    none: wgpu::BindGroup,
}

impl Bindings {
    pub fn new(device: &wgpu::Device) -> Self {
        let kinds = [BufferBindingType::Uniform, BufferBindingType::Storage { read_only: true }];
        let layout = layout(device, "light", &kinds);
        let empty = |usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("no light"),
                size: size_of::<Shading>() as u64,
                usage,
                mapped_at_creation: false,
            })
        };
        let buffers = [&empty(BufferUsages::UNIFORM), &empty(BufferUsages::STORAGE)];
        let none = group(device, "no light", &layout, &buffers);
        Bindings { layout, none }
    }
}

/// The layout of a group of buffers of these kinds, numbered from 0.
pub(crate) fn layout(
    device: &wgpu::Device,
    label: &str,
    kinds: &[BufferBindingType],
) -> wgpu::BindGroupLayout {
    let entry = |(binding, ty): (u32, &BufferBindingType)| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer { ty: *ty, has_dynamic_offset: false, min_binding_size: None },
        count: None,
    };
    let entries: Vec<_> = (0..).zip(kinds).map(entry).collect();
    device
        .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries })
}

/// A group of `buffers`, numbered from 0.
pub(crate) fn group(
    device: &wgpu::Device,
    label: &str,
    layout: &wgpu::BindGroupLayout,
    buffers: &[&wgpu::Buffer],
) -> wgpu::BindGroup {
    let entries: Vec<_> = (0..)
        .zip(buffers)
        .map(|(binding, buffer)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() })
        .collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some(label), layout, entries: &entries })
}

/// The light of a job's rays, with the gradients of its picture.
pub(crate) fn bind(gpu: &Gpu, job: &Job, gradients: Option<&Gradients>) -> Result<wgpu::BindGroup, Reason> {
    let (Some(shading), Some(gradients)) = (shading(job), gradients) else {
        return Ok(gpu.light.none.clone());
    };
    let usage = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
    let uniform = gpu.buffer("the light", size_of_val(&shading), usage)?;
    gpu.queue.write_buffer(&uniform, 0, bytemuck::bytes_of(&shading));
    Ok(group(&gpu.device, "light", &gpu.light.layout, &[&uniform, &gradients.buffer]))
}

/// The light's numbers, where there is any.
fn shading(job: &Job) -> Option<Shading> {
    let shading = job.shading()?;
    let [light_hi, light_lo] = halves3(shading.towards_light.unwrap_or_default());
    Some(Shading {
        light_hi,
        ambient: shading.ambient,
        light_lo,
        diffuse: shading.diffuse,
        specular: shading.specular,
        shininess: shading.shininess,
        sharpness: shading.sharpness,
        blind: shading.blind,
        dull: shading.dull,
        is_headlight: u32::from(shading.towards_light.is_none()),
        most_cuts: if job.quality().lights == Lights::Coarse { 0 } else { MOST_CUTS },
        padding: 0,
    })
}
