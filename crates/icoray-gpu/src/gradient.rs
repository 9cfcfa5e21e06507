//! Gradients at the vertices, computed on the device from the field that is there and from what f32 leaves of its values: 2
//! bytes to upload per value instead of 12, and little work for the host.

use crate::gpu::{Gpu, because};
use crate::layout::{Around, Params};
use crate::light::{group, layout};
use crate::mesh::Mesh;
use crate::shader;
use icoray::Grid;
use icoray::device::{Job, Reason};
use rayon::prelude::*;
use std::sync::{Mutex, OnceLock, PoisonError};
use wgpu::{BufferBindingType, BufferUsages};

/// In place of a triangle behind a cell's last one: `NONE` of `shaders/gradient.wgsl`.
const NONE: u32 = u32::MAX;

/// Values whose last digits are taken at a time, an even number.
const PIECE: usize = 1 << 18;

/// Invocations in a workgroup of `shaders/gradient.wgsl`.
const GROUP: u32 = 64;

/// The triangles with data around each cell, on the device.
#[derive(Debug)]
pub(crate) struct Corners {
    around: Around,
    buffer: wgpu::Buffer,
}

impl Corners {
    fn upload(gpu: &Gpu, grid: &Grid) -> Result<Self, Reason> {
        let triangles = |cell: u32| grid.corners_of(cell).filter(|&corner| grid.is_triangle(corner));
        let cells = grid.cells() as u32;
        let row = (0..cells).into_par_iter().map(|cell| triangles(cell).count()).max().unwrap_or(0).max(1);
        let mut rows = vec![NONE; grid.cells() * row];
        rows.par_chunks_exact_mut(row).zip(0..cells).for_each(|(places, cell)| {
            places.iter_mut().zip(triangles(cell)).for_each(|(place, triangle)| *place = triangle);
        });
        let buffer = gpu.upload("triangles around cells", &rows)?;
        Ok(Corners { around: Around { cells, row: row as u32 }, buffer })
    }
}

/// Gradients of a picture's field.
#[derive(Debug)]
pub(crate) struct Gradients {
    pub buffer: wgpu::Buffer,
    /// What f32 leaves of the field's values, until the device has been told to compute.
    rests: Mutex<Option<wgpu::Buffer>>,
}

impl Gradients {
    /// Room for those of `job`, where it is lit, and how many bytes were uploaded for them.
    pub fn new(gpu: &Gpu, job: &Job, mesh: &Mesh) -> Result<(Option<Self>, u64), Reason> {
        if job.shading().is_none() {
            return Ok((None, 0));
        }
        let (mut bytes, grid) = (0, job.grid());
        if mesh.corners.get().is_none() {
            let corners = Corners::upload(gpu, grid)?;
            bytes = corners.buffer.size();
            // Another picture's thread may have been faster.
            drop(mesh.corners.set(corners));
        }
        let count = 3 * grid.cells() * job.radius().len();
        if u32::try_from(count).is_err() {
            return because(format!("gradients: {count} numbers, expected fewer than 2^32"));
        }
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
        let buffer = gpu.buffer("gradients", count * size_of::<f32>(), usage)?;
        let rests = rests(gpu, job)?;
        bytes += rests.size();
        Ok((Some(Gradients { buffer, rests: Mutex::new(Some(rests)) }), bytes))
    }

    /// Has the device compute them, once, before what is submitted later. `tables` is group 0 of all shaders, `uniform` its
    /// first buffer.
    pub fn begin(
        &self,
        gpu: &Gpu,
        mesh: &Mesh,
        tables: &wgpu::BindGroup,
        uniform: &wgpu::Buffer,
        params: &Params,
    ) -> Result<(), Reason> {
        let mut waiting = self.rests.lock().unwrap_or_else(PoisonError::into_inner);
        let (Some(rests), Some(Corners { around, buffer })) = (&*waiting, mesh.corners.get()) else {
            return Ok(());
        };
        let pass = gpu.gradient_pass.pipeline(gpu)?;
        let usage = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
        let numbers = gpu.buffer("around cells", size_of_val(around), usage)?;
        gpu.queue.write_buffer(&numbers, 0, bytemuck::bytes_of(around));
        gpu.queue.write_buffer(uniform, 0, bytemuck::bytes_of(params));
        let own = group(
            &gpu.device,
            "gradients",
            &gpu.gradient_pass.layout,
            &[&numbers, buffer, &self.buffer, rests],
        );
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let mut pass_of = encoder.begin_compute_pass(&Default::default());
        pass_of.set_pipeline(pass);
        pass_of.set_bind_group(0, tables, &[]);
        pass_of.set_bind_group(1, &own, &[]);
        let groups = (around.cells * params.layers).div_ceil(GROUP);
        let across = groups.min(gpu.limits.max_compute_workgroups_per_dimension);
        pass_of.dispatch_workgroups(across, groups.div_ceil(across.max(1)), 1);
        drop(pass_of);
        gpu.queue.submit([encoder.finish()]);
        gpu.untroubled()?;
        *waiting = None;
        Ok(())
    }
}

/// What f32 leaves of the field's values, in the field's order.
fn rests(gpu: &Gpu, job: &Job) -> Result<wgpu::Buffer, Reason> {
    let (columns, layers, _) = job.order();
    let count = columns * layers;
    let bytes = (count * size_of::<i16>()).next_multiple_of(4);
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
    let buffer = gpu.buffer("last digits of the field", bytes, usage)?;
    let size = wgpu::BufferSize::new(bytes as u64);
    let Some(mut staged) = size.and_then(|size| gpu.queue.write_buffer_with(&buffer, 0, size)) else {
        gpu.untroubled()?;
        return because("the device has no room to take the field's last digits in");
    };
    let mut piece = vec![0i16; PIECE.min(count.next_multiple_of(2))];
    for first in (0..count).step_by(PIECE) {
        let values = PIECE.min(count - first);
        job.rests(first, &mut piece[..values]);
        let start = first * size_of::<i16>();
        let whole = &piece[..values.next_multiple_of(2)];
        staged.slice(start..start + size_of_val(whole)).copy_from_slice(bytemuck::cast_slice(whole));
    }
    drop(staged);
    gpu.untroubled()?;
    Ok(buffer)
}

/// The shader that computes them, made when it is first needed.
#[derive(Debug)]
pub(crate) struct Pass {
    layout: wgpu::BindGroupLayout,
    made: OnceLock<wgpu::ComputePipeline>,
}

impl Pass {
    pub fn new(device: &wgpu::Device) -> Self {
        let kinds = [
            BufferBindingType::Uniform,
            BufferBindingType::Storage { read_only: true },
            BufferBindingType::Storage { read_only: false },
            BufferBindingType::Storage { read_only: true },
        ];
        Pass { layout: layout(device, "gradients", &kinds), made: OnceLock::new() }
    }

    fn pipeline(&self, gpu: &Gpu) -> Result<&wgpu::ComputePipeline, Reason> {
        let make = || {
            let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some("gradient"),
                source: wgpu::ShaderSource::Wgsl(shader::compose("gradient").into()),
            });
            let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("gradient"),
                bind_group_layouts: &[Some(&gpu.bindings), Some(&self.layout)],
                immediate_size: 0,
            });
            gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some("gradient"),
                layout: Some(&layout),
                module: &module,
                entry_point: Some("gradient"),
                compilation_options: Default::default(),
                cache: None,
            })
        };
        let pipeline = self.made.get_or_init(make);
        gpu.untroubled()?;
        Ok(pipeline)
    }
}
