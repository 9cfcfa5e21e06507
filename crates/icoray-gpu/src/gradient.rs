//! Gradients at the vertices, computed on the device from a field's pages and the residuals of its values in f32. This
//! uploads 2 bytes per value instead of 12.

use crate::bindings;
use crate::device_field::{DeviceField, page_group};
use crate::layout::Around;
use crate::picture::Picture;
use crate::pipelines::dispatch;
use crate::pool::PooledBuffer;
use crate::shader::Contents;
use icoray::device::FallbackReason;
use wgpu::BufferUsages;

/// Invocations in a workgroup of `shaders/gradient.wgsl`.
const WORKGROUP: u32 = 64;

/// Submits the computation of a field's gradients and returns the number of bytes uploaded. `rests` has a page of
/// residuals for each page of values.
pub(crate) fn submit(picture: &Picture, field: &DeviceField, rests: &[PooledBuffer]) -> Result<u64, FallbackReason> {
    let (ctx, pipelines, cells) = (picture.ctx, picture.pipelines, &field.cells);
    let (triangles, bytes) = picture.mesh.cell_triangles(ctx, picture.job.grid())?;
    let shader = ("gradient", Contents::default(), &pipelines.gradient);
    let pipeline = pipelines.get(ctx, shader, field.layout.pages, field.constants())?;
    let params = ctx.pooled_uniform("params", &field.params(picture))?;
    // The shader reads neither pieces nor pixels.
    let pieces = ctx.pooled("no pieces", 0, BufferUsages::STORAGE)?;
    let pixels = ctx.pooled("no pixels", 0, BufferUsages::STORAGE)?;
    let tables = picture.group(cells, [&params, &pieces, &pixels])?;
    let cells_of_columns = match cells.places {
        Some(_) => ctx.pooled_storage("cells of columns", &cells.list)?,
        None => ctx.pooled("no cells", 0, BufferUsages::STORAGE)?,
    };
    let values = page_group(ctx, &field.pages)?;
    let rests = page_group(ctx, rests)?;
    let (columns, layers) = (field.layout.page_columns, field.layout.layers.len());
    for (page, gradients) in field.gradients.iter().enumerate() {
        let first = page * columns;
        let columns = columns.min(cells.list.len() - first);
        let around = Around { first: first as u32, columns: columns as u32, row: triangles.row };
        let around = ctx.pooled_uniform("around cells", &around)?;
        let buffers = [&*around, &triangles.buffer, &cells_of_columns, gradients];
        let own = bindings::group(ctx, &pipelines.gradient, buffers)?;
        let workgroups = ((columns * layers) as u32).div_ceil(WORKGROUP);
        let across = workgroups.min(ctx.limits.max_compute_workgroups_per_dimension);
        let size = [across, workgroups.div_ceil(across.max(1))];
        ctx.scoped(|| {
            let mut commands = ctx.device.create_command_encoder(&Default::default());
            let groups = [&tables, &values, &own, &rests];
            dispatch(&mut commands, &Default::default(), &pipeline, groups, size);
            ctx.queue.submit([commands.finish()]);
        })?;
    }
    Ok(bytes)
}
