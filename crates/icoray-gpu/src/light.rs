//! What lit scenes have beside the others and their gradients: group 2 of the shaders' bindings.

use crate::gpu::Gpu;
use crate::groups::{group, layout};
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
    nothing: wgpu::Buffer,
    none: wgpu::BindGroup,
}

impl Bindings {
    pub fn new(device: &wgpu::Device) -> Self {
        let layout = layout(device, &[wgpu::BufferBindingType::Uniform]);
        let nothing = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("no light"),
            size: size_of::<Shading>() as u64,
            usage: BufferUsages::UNIFORM,
            mapped_at_creation: false,
        });
        let none = group(device, &layout, [&nothing]);
        Bindings { layout, nothing, none }
    }
}

/// The light of a job's rays.
pub(crate) fn bind(gpu: &Gpu, job: &Job) -> Result<wgpu::BindGroup, Reason> {
    if job.shading().is_none() {
        return Ok(gpu.light.none.clone());
    }
    with_uniform(gpu, job, |uniform| gpu.group(&gpu.light.layout, [uniform]))
}

/// Has `bind` bind the light's numbers, or what stands for them where there is none.
pub(crate) fn with_uniform<R>(
    gpu: &Gpu,
    job: &Job,
    bind: impl FnOnce(&wgpu::Buffer) -> Result<R, Reason>,
) -> Result<R, Reason> {
    match shading(job) {
        Some(shading) => bind(&*gpu.lend_uniform("the light", &shading)?),
        None => bind(&gpu.light.nothing),
    }
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
