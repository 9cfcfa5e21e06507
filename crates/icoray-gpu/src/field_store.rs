//! The fields on a device: allocation, upload and cache.

use crate::context::{Context, NON_PAGE_STORAGE_BUFFERS};
use crate::culling::CellSet;
use crate::device_field::{DeviceField, FieldLayout, GradientKey, VALUE_BYTES, visible_layers};
use crate::layout::Around;
use crate::picture::Picture;
use crate::pipelines::{bind_group, dispatch, page_group};
use crate::pool::PooledBuffer;
use crate::shader::Contents;
use crate::staging::StagingBuffers;
use icoray::device::{FallbackReason, Job};
use std::borrow::Cow;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use wgpu::BufferUsages;

/// Largest number of pages; each is a case in the shaders.
const MAX_PAGES: u32 = 32;

/// Bytes of a value's residual in f32, and of a gradient.
const REST_BYTES: usize = size_of::<i16>();
const GRADIENT_BYTES: usize = 3 * size_of::<f32>();

/// Bound of the components of gradients, as in `shaders/gradient.wgsl`.
const MAX_GRADIENT: f32 = 1e30;

/// Largest number of pages on a device, where each page of values is accompanied by a page of gradients.
fn max_pages(ctx: &Context) -> usize {
    let bindings = ctx.limits.max_storage_buffers_per_shader_stage - NON_PAGE_STORAGE_BUFFERS;
    (bindings / 2).min(MAX_PAGES) as usize
}

/// The fields that are in use or were used last.
#[derive(Debug)]
pub(crate) struct FieldStore {
    cached: Mutex<Vec<Arc<DeviceField>>>,
    staging: StagingBuffers,
    /// Largest size of a field in bytes, gradients included.
    max_bytes: u64,
}

impl FieldStore {
    pub fn new(max_bytes: u64) -> Self {
        FieldStore { cached: Mutex::default(), staging: StagingBuffers::default(), max_bytes }
    }

    fn cached(&self) -> MutexGuard<'_, Vec<Arc<DeviceField>>> {
        self.cached.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Columns of `layers` layers for which there is room in a page, and in all pages.
    fn capacity(&self, ctx: &Context, job: &Job, layers: usize) -> [u64; 2] {
        let (largest, all) = match job.shading() {
            Some(_) => (GRADIENT_BYTES, VALUE_BYTES + REST_BYTES + GRADIENT_BYTES),
            None => (VALUE_BYTES, VALUE_BYTES),
        };
        let page = ctx.max_buffer_size(BufferUsages::STORAGE) / (layers * largest) as u64;
        [page, (max_pages(ctx) as u64 * page).min(self.max_bytes / (layers * all) as u64)]
    }

    /// Whether the whole field of a job fits into one page.
    pub fn fits_a_page(&self, ctx: &Context, job: &Job) -> bool {
        let (columns, layers, _) = job.order();
        let [page, all] = self.capacity(ctx, job, layers);
        columns as u64 <= page.min(all)
    }

    /// The picture's field over `cells`, and the number of bytes uploaded: 0 if it was cached. The inner error is that
    /// there is no room for it.
    pub fn get(
        &self,
        picture: &Picture,
        cells: &Arc<CellSet>,
    ) -> Result<Result<(Arc<DeviceField>, u64), FallbackReason>, FallbackReason> {
        if let Some(field) = self.cached().iter().find(|field| field.matches(picture.job, cells)) {
            return Ok(Ok((Arc::clone(field), 0)));
        }
        // Frees the fields that no thread draws.
        self.cached().retain(|field| Arc::strong_count(field) > 1);
        let field = match self.allocate(picture, cells) {
            Ok(field) => field,
            Err(reason) => return picture.ctx.check().map(|()| Err(reason)),
        };
        let bytes = self.upload(picture, &field)?;
        let field = Arc::new(field);
        self.cached().push(Arc::clone(&field));
        Ok(Ok((field, bytes)))
    }

    fn allocate(&self, picture: &Picture, cells: &Arc<CellSet>) -> Result<DeviceField, FallbackReason> {
        let (ctx, job) = (picture.ctx, picture.job);
        let (_, _, is_level_fastest) = job.order();
        let layers = visible_layers(job, &cells.list);
        let has_all_layers = layers.len() == job.radius().len();
        let columns = cells.list.len().max(1);
        let [page, all] = self.capacity(ctx, job, layers.len());
        if columns as u64 > all {
            let bytes = columns * layers.len() * VALUE_BYTES;
            let (max, name) = (all * (layers.len() * VALUE_BYTES) as u64, ctx.name());
            let reason = format!("{bytes} bytes of the field, expected at most {max} on {name}");
            return Err(FallbackReason::new(reason));
        }
        // A power of two: each number of pages has a shader of its own, and it changes with the camera.
        let pages = columns.div_ceil(page as usize).next_power_of_two().min(max_pages(ctx));
        let page_columns = columns.div_ceil(pages);
        let pages = columns.div_ceil(page_columns);
        let layout = FieldLayout { layers, page_columns, pages, has_all_layers, is_level_fastest };
        let count = layout.page_columns * layout.layers.len();
        let gradient_key = GradientKey::new(job);
        let gradient_pages = if gradient_key.is_some() { pages } else { 0 };
        let buffers = |label: &str, count: usize, bytes: usize| {
            let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
            (0..count).map(|_| ctx.pooled(label, bytes, usage)).collect::<Result<Vec<_>, _>>()
        };
        Ok(DeviceField {
            content: job.content(),
            spans: job.spans(),
            cells: Arc::clone(cells),
            pages: buffers("page of the field", pages, count * VALUE_BYTES)?,
            gradients: buffers("page of gradients", gradient_pages, count * GRADIENT_BYTES)?,
            gradient_key,
            layout,
        })
    }

    /// Uploads values and gradients, or the data from which these are computed. Returns the number of bytes.
    ///
    /// Values are normalised in f64 while they are copied from the model's array to a staging buffer: once per value
    /// instead of once per read, with the bits of the CPU's kernel, and without a second copy of the field on the host.
    fn upload(&self, picture: &Picture, field: &DeviceField) -> Result<u64, FallbackReason> {
        let (ctx, job) = (picture.ctx, picture.job);
        let FieldLayout { layers, page_columns, .. } = &field.layout;
        let count = page_columns * layers.len();
        let mut bytes = field.pages.len() * count * VALUE_BYTES;
        let mut rests = Vec::with_capacity(field.gradients.len());
        for (k, columns) in field.cells.list.chunks(*page_columns).enumerate() {
            // The last page is filled up, so that all pages have the same strides.
            let mut columns = Cow::Borrowed(columns);
            if columns.len() < *page_columns {
                let filler = columns[0];
                columns.to_mut().resize(*page_columns, filler);
            }
            self.staging.fill(ctx, &field.pages[k], count, |first, values| {
                job.values(&columns, layers.clone(), first, values);
            })?;
            if job.has_gradients() && field.gradient_key.is_some() {
                self.upload_gradients(picture, field, &columns, &field.gradients[k])?;
                bytes += count * GRADIENT_BYTES;
            } else if field.gradient_key.is_some() {
                let (words, usage) = (count.div_ceil(2), BufferUsages::STORAGE | BufferUsages::COPY_DST);
                let page = ctx.pooled("page of last digits", words * 2 * REST_BYTES, usage)?;
                self.staging.fill(ctx, &page, words, |first, words| {
                    let digits: &mut [i16] = bytemuck::cast_slice_mut(words);
                    let end = digits.len().min(count - 2 * first);
                    job.residuals(&columns, layers.clone(), 2 * first, &mut digits[..end]);
                })?;
                bytes += words * 2 * REST_BYTES;
                rests.push(page);
            }
        }
        let of_gradients = if rests.is_empty() { 0 } else { compute_gradients(picture, field, &rests)? };
        Ok(bytes as u64 + of_gradients)
    }

    /// Uploads a page of the gradients that the job gives.
    fn upload_gradients(
        &self,
        picture: &Picture,
        field: &DeviceField,
        columns: &[u32],
        page: &wgpu::Buffer,
    ) -> Result<(), FallbackReason> {
        let (layers, all) = (&field.layout.layers, picture.job.gradients());
        let [column_stride, layer_stride] = field.layout.strides();
        let layers_of_column = picture.job.radius().len();
        let component = |at: usize| {
            let (column, row) = match field.layout.is_level_fastest {
                true => (at / 3 / column_stride, at / 3 % column_stride),
                false => (at / 3 % layer_stride, at / 3 / layer_stride),
            };
            let vertex = columns[column] as usize * layers_of_column + layers.start + row;
            // Without any, nothing of the field is lit.
            let gradient = all.get(vertex).map_or(0.0, |gradient| gradient[at % 3]);
            if gradient.is_nan() { 0.0 } else { gradient.clamp(-MAX_GRADIENT, MAX_GRADIENT) }
        };
        let count = 3 * columns.len() * layers.len();
        self.staging.fill(picture.ctx, page, count, |first, components| {
            (first..).zip(components).for_each(|(at, gradient)| *gradient = component(at));
        })
    }
}

/// Invocations in a workgroup of `shaders/gradient.wgsl`.
const WORKGROUP: u32 = 64;

/// Submits the computation of the gradients at a field's vertices on the device, and returns the number of bytes
/// uploaded. `rests` has a page of the values' residuals in f32 for each page of values: 2 bytes per value instead of
/// the 12 of a gradient.
fn compute_gradients(picture: &Picture, field: &DeviceField, rests: &[PooledBuffer]) -> Result<u64, FallbackReason> {
    let (ctx, pipelines, cells) = (picture.ctx, picture.pipelines, &field.cells);
    let (triangles, bytes) = picture.mesh.cell_triangles(ctx, picture.job.grid())?;
    let shader = ("gradient", Contents::default(), &pipelines.gradient);
    let pipeline = pipelines.get(ctx, shader, field.layout.pages, field.constants())?;
    let params = ctx.pooled_data("params", &[field.params(picture)], BufferUsages::UNIFORM)?;
    // The shader reads neither pieces nor pixels.
    let pieces = ctx.pooled("no pieces", 0, BufferUsages::STORAGE)?;
    let pixels = ctx.pooled("no pixels", 0, BufferUsages::STORAGE)?;
    let tables = picture.group(cells, [&params, &pieces, &pixels])?;
    let cells_of_columns = match cells.places {
        Some(_) => ctx.pooled_data("cells of columns", &cells.list, BufferUsages::STORAGE)?,
        None => ctx.pooled("no cells", 0, BufferUsages::STORAGE)?,
    };
    let values = page_group(ctx, &field.pages)?;
    let rests = page_group(ctx, rests)?;
    let (columns, layers) = (field.layout.page_columns, field.layout.layers.len());
    for (page, gradients) in field.gradients.iter().enumerate() {
        let first = page * columns;
        let columns = columns.min(cells.list.len() - first);
        let around = Around { first: first as u32, columns: columns as u32, row: triangles.row };
        let around = ctx.pooled_data("around cells", &[around], BufferUsages::UNIFORM)?;
        let buffers = [&*around, &triangles.buffer, &cells_of_columns, gradients];
        let own = bind_group(ctx, &pipelines.gradient, buffers)?;
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
