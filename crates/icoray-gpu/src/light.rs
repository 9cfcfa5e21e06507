//! What lit scenes have beside the others and their gradients: group 2 of the shaders' bindings.

use crate::gpu::Gpu;
use crate::layout::{Shading, halves3};
use icoray::Lights;
use icoray::device::{Job, Reason};
use wgpu::BufferUsages;

/// How often a piece of a ray may be cut in two for its light's sake: `MOST_CUTS` of `shaders/kernel/lit.wgsl`.
const MOST_CUTS: u32 = 20;

/// The layout of group 2, and the group of scenes without light.
#[derive(Debug)]
pub(crate) struct Bindings {
    pub layout: wgpu::BindGroupLayout,
    none: wgpu::BindGroup,
}

impl Bindings {
    pub fn new(device: &wgpu::Device) -> Self {
        let ty = wgpu::BufferBindingType::Uniform;
        let entry = wgpu::BindGroupLayoutEntry {
            binding: 0,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
            count: None,
        };
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("light"),
            entries: &[entry],
        });
        let none = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("no light"),
            size: size_of::<Shading>() as u64,
            usage: BufferUsages::UNIFORM,
            mapped_at_creation: false,
        });
        let none = group(device, &layout, &none);
        Bindings { layout, none }
    }
}

fn group(device: &wgpu::Device, layout: &wgpu::BindGroupLayout, shading: &wgpu::Buffer) -> wgpu::BindGroup {
    let entries = &[wgpu::BindGroupEntry { binding: 0, resource: shading.as_entire_binding() }];
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some("light"), layout, entries })
}

/// The light of a job's rays.
pub(crate) fn bind(gpu: &Gpu, job: &Job) -> Result<wgpu::BindGroup, Reason> {
    let Some(shading) = shading(job) else { return Ok(gpu.light.none.clone()) };
    let usage = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
    let uniform = gpu.lend("the light", size_of_val(&shading), usage)?;
    gpu.watched(|| {
        gpu.queue.write_buffer(&uniform, 0, bytemuck::bytes_of(&shading));
        group(&gpu.device, &gpu.light.layout, &uniform)
    })
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
