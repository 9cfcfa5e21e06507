//! What lit scenes have beside the others: group 1 of the shaders' bindings.

use crate::gpu::Gpu;
use crate::layout::{Shading, halves3};
use icoray::Lights;
use icoray::device::{Job, Reason};
use wgpu::BufferUsages;

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
        let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
            count: None,
        };
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("light"),
            entries: &[
                entry(0, wgpu::BufferBindingType::Uniform),
                entry(1, wgpu::BufferBindingType::Storage { read_only: true }),
            ],
        });
        let empty = |usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("no light"),
                size: size_of::<Shading>() as u64,
                usage,
                mapped_at_creation: false,
            })
        };
        let none = group(device, &layout, &empty(BufferUsages::UNIFORM), &empty(BufferUsages::STORAGE));
        Bindings { layout, none }
    }
}

fn group(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    shading: &wgpu::Buffer,
    gradients: &wgpu::Buffer,
) -> wgpu::BindGroup {
    let entries = [(0, shading), (1, gradients)]
        .map(|(binding, buffer)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() });
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some("light"), layout, entries: &entries })
}

/// Gradients on the device where `job` is lit, and how many bytes were uploaded.
pub(crate) fn gradients(gpu: &Gpu, job: &Job) -> Result<(Option<wgpu::Buffer>, u64), Reason> {
    let gradients = job.gradients();
    if gradients.is_empty() {
        return Ok((None, 0));
    }
    let buffer = gpu.upload("gradients", gradients)?;
    Ok((Some(buffer), size_of_val(gradients) as u64))
}

/// The light of a job's rays, with the gradients of its picture.
pub(crate) fn bind(
    gpu: &Gpu,
    job: &Job,
    gradients: Option<&wgpu::Buffer>,
) -> Result<wgpu::BindGroup, Reason> {
    let (Some(shading), Some(gradients)) = (shading(job), gradients) else {
        return Ok(gpu.light.none.clone());
    };
    let usage = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
    let uniform = gpu.buffer("the light", size_of_val(&shading), usage)?;
    gpu.queue.write_buffer(&uniform, 0, bytemuck::bytes_of(&shading));
    Ok(group(&gpu.device, &gpu.light.layout, &uniform, gradients))
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
