//! Gradients at the vertices, computed on the device from the field that is there and from what f32 leaves of its values: 2
//! bytes to upload per value instead of 12, and little work for the host.

use crate::gpu::Gpu;
use crate::groups::{READ, layout};
use crate::held::Held;
use crate::layout::Around;
use crate::mesh::Mesh;
use crate::scene::{Picture, Places};
use crate::shader;
use crate::store::Lent;
use icoray::Grid;
use icoray::device::Reason;
use rayon::prelude::*;
use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};
use wgpu::BufferBindingType::{Storage, Uniform};
use wgpu::BufferUsages;

/// In place of a triangle behind a cell's last one: `NONE` of `shaders/gradient.wgsl`.
const NONE: u32 = u32::MAX;

/// Invocations in a workgroup of `shaders/gradient.wgsl`.
const GROUP: u32 = 64;

/// The triangles with data around each cell, on the device.
#[derive(Debug)]
pub(crate) struct Corners {
    row: u32,
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
        Ok(Corners { row: row as u32, buffer: gpu.upload("triangles around cells", &rows)? })
    }

    /// Those of a grid, and how many bytes were uploaded: none where they are there.
    fn of<'m>(gpu: &Gpu, grid: &Grid, mesh: &'m Mesh) -> Result<(&'m Self, u64), Reason> {
        if let Some(corners) = mesh.corners.get() {
            return Ok((corners, 0));
        }
        let corners = Corners::upload(gpu, grid)?;
        let bytes = corners.buffer.size();
        // Another picture's thread may have been faster.
        Ok((mesh.corners.get_or_init(|| corners), bytes))
    }
}

impl Gpu {
    /// Has the device compute the gradients of a field that is there, of which `rests` is what f32 leaves, before what is
    /// submitted later. How many bytes were uploaded.
    pub(crate) fn compute_gradients(
        &self,
        picture: &Picture,
        held: &Held,
        rests: &[Lent],
    ) -> Result<u64, Reason> {
        let (job, mesh) = (picture.job, &picture.mesh);
        let (corners, bytes) = Corners::of(self, job.grid(), mesh)?;
        let pipeline = self.gradient_pass.pipeline(self, held.places())?;
        let uniform = self.lend_uniform("params", &held.params(picture))?;
        // What only rays have: anything will do.
        let none = self.lend("no pieces", 0, BufferUsages::STORAGE)?;
        let nothing = self.lend("no pixels", 0, BufferUsages::STORAGE)?;
        let tables = picture.group(self, held, &uniform, &none, &nothing)?;
        let cells = match held.cells.places {
            Some(_) => self.lend_with("cells of columns", &held.cells.list)?,
            None => self.lend("no cells", 0, BufferUsages::STORAGE)?,
        };
        let values = held.group(self, &held.pages)?;
        let rests = held.group(self, rests)?;
        let (columns, layers) = (held.layout.page_columns, held.layout.layers.len());
        for (page, gradients) in held.gradients.iter().enumerate() {
            let first = page * columns;
            let columns = columns.min(held.cells.list.len() - first);
            let around = Around { first: first as u32, columns: columns as u32, row: corners.row };
            let around = self.lend_uniform("around cells", &around)?;
            let own =
                self.group(&self.gradient_pass.layout, [&*around, &corners.buffer, &cells, gradients])?;
            let groups = ((columns * layers) as u32).div_ceil(GROUP);
            let across = groups.min(self.limits.max_compute_workgroups_per_dimension);
            self.watched(|| {
                let mut encoder = self.device.create_command_encoder(&Default::default());
                let mut pass = encoder.begin_compute_pass(&Default::default());
                pass.set_pipeline(&pipeline);
                (0..)
                    .zip([&tables, &values, &own, &rests])
                    .for_each(|(i, of)| pass.set_bind_group(i, of, &[]));
                pass.dispatch_workgroups(across, groups.div_ceil(across.max(1)), 1);
                drop(pass);
                self.queue.submit([encoder.finish()]);
            })?;
        }
        Ok(bytes)
    }
}

/// The shader that computes them, in variants that are made when they are first needed.
#[derive(Debug)]
pub(crate) struct Pass {
    /// Of group 2.
    layout: wgpu::BindGroupLayout,
    made: Mutex<HashMap<Places, wgpu::ComputePipeline>>,
}

impl Pass {
    pub fn new(device: &wgpu::Device) -> Self {
        let kinds = [Uniform, READ, READ, Storage { read_only: false }];
        Pass { layout: layout(device, &kinds), made: Mutex::default() }
    }

    fn pipeline(&self, gpu: &Gpu, places: Places) -> Result<wgpu::ComputePipeline, Reason> {
        let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(pipeline) = made.get(&places) {
            return Ok(pipeline.clone());
        }
        let pages = gpu.page_layout(places.pages);
        let layouts = [&gpu.bindings, &pages, &self.layout, &pages];
        let text = shader::compose_for("gradient", places.pages);
        let pipeline = gpu.pipeline("gradient", text, layouts, &places.constants())?;
        made.insert(places, pipeline.clone());
        Ok(pipeline)
    }
}
