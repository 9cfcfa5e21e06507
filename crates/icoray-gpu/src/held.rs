//! A field on the device: its columns in pages, in the order that the model's array has.

use crate::gpu::{Gpu, because};
use crate::select::{Cells, seen_layers};
use crate::store::Lent;
use icoray::device::{Content, Job, Reason};
use std::borrow::Cow;
use std::ops::Range;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use wgpu::BufferUsages;

/// Storage buffers of a shader beside the pages.
const STORAGES: u32 = 13;
/// Pages are cases of a shader, of which there should not be hundreds.
const MOST_PAGES: u32 = 32;

/// Bytes of a value, and of a gradient.
const VALUE: usize = size_of::<f32>();
const GRADIENT: usize = 3 * size_of::<f32>();

/// Where values lie.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Layout {
    pub layers: Range<usize>,
    /// Columns of a page, the last one of which may have fewer.
    pub page_columns: usize,
    pub pages: usize,
    is_level_fastest: bool,
}

impl Layout {
    /// Elements from column to column and from layer to layer.
    pub fn strides(&self) -> [usize; 2] {
        if self.is_level_fastest { [self.layers.len(), 1] } else { [1, self.page_columns] }
    }
}

/// The values over some cells.
#[derive(Debug)]
pub(crate) struct Held {
    content: Content,
    pub cells: Arc<Cells>,
    pub layout: Layout,
    pages: Vec<Lent>,
    /// Of the same columns; none where the picture is not lit.
    gradients: Vec<Lent>,
    /// The picture that these are of.
    lit_by: Option<u64>,
}

impl Held {
    /// Groups 1 and 3. What is not lit reads no gradients, and may have anything in their place.
    pub fn groups(&self, gpu: &Gpu) -> Result<[wgpu::BindGroup; 2], Reason> {
        let gradients = if self.lit_by.is_some() { &self.gradients } else { &self.pages };
        Ok([self.group(gpu, &self.pages)?, self.group(gpu, gradients)?])
    }

    fn group(&self, gpu: &Gpu, pages: &[Lent]) -> Result<wgpu::BindGroup, Reason> {
        let pages = (0u32..).zip(pages);
        let entries: Vec<_> = pages
            .map(|(binding, page)| wgpu::BindGroupEntry { binding, resource: page.as_entire_binding() })
            .collect();
        gpu.watched(|| {
            gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("pages"),
                layout: &gpu.page_bindings(self.pages.len()),
                entries: &entries,
            })
        })
    }

    /// Bytes of the values.
    pub fn bytes(&self) -> u64 {
        (self.cells.list.len() * self.layout.layers.len() * VALUE) as u64
    }
}

/// The fields that were drawn last: one, or as many as threads draw at once.
#[derive(Debug, Default)]
pub(crate) struct Fields(Mutex<Vec<Arc<Held>>>);

impl Fields {
    fn held(&self) -> MutexGuard<'_, Vec<Arc<Held>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Gives back the memory of those that nobody draws.
    fn sweep(&self) {
        self.held().retain(|held| Arc::strong_count(held) > 1);
    }
}

impl Gpu {
    /// The layout of group 1.
    pub(crate) fn page_bindings(&self, pages: usize) -> wgpu::BindGroupLayout {
        let ty = wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only: true },
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let entry = |binding| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty,
            count: None,
        };
        let entries: Vec<_> = (0..pages as u32).map(entry).collect();
        self.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("pages"),
            entries: &entries,
        })
    }

    /// How many columns of `layers` layers a page has room for, and all pages.
    fn room(&self, job: &Job, layers: usize) -> [u64; 2] {
        let (largest, all) = if is_lit(job) { (GRADIENT, VALUE + GRADIENT) } else { (VALUE, VALUE) };
        let page = self.most(BufferUsages::STORAGE) / (layers * largest) as u64;
        // Each page of values has one of gradients beside it.
        let pages = ((self.limits.max_storage_buffers_per_shader_stage - STORAGES) / 2).min(MOST_PAGES);
        [page, (u64::from(pages) * page).min(self.most_of_fields / (layers * all) as u64)]
    }

    /// Whether there is room for the field of `job` in one page.
    pub(crate) fn fits_a_page(&self, job: &Job) -> bool {
        let (columns, layers, _) = job.order();
        let [page, all] = self.room(job, layers);
        columns as u64 <= page.min(all)
    }

    /// The field of `job` over `cells`, and how many bytes were uploaded for it: none where it is there. Or why there is no
    /// room for it.
    ///
    /// # Errors
    /// A [`Reason`] where something is broken.
    pub(crate) fn hold(
        &self,
        job: &Job,
        cells: &Arc<Cells>,
    ) -> Result<Result<(Arc<Held>, u64), Reason>, Reason> {
        let lit_by = is_lit(job).then(|| job.number());
        let is_it = |held: &&Arc<Held>| {
            held.content == job.content()
                && held.cells.number == cells.number
                && (lit_by.is_none() || held.lit_by == lit_by)
        };
        if let Some(held) = self.fields.held().iter().find(is_it) {
            return Ok(Ok((Arc::clone(held), 0)));
        }
        self.fields.sweep();
        let held = match self.reserve(job, cells) {
            Ok(held) => held,
            Err(reason) => return self.untroubled().map(|()| Err(reason)),
        };
        let bytes = self.fill_pages(job, &held)?;
        let held = Arc::new(held);
        self.fields.held().push(Arc::clone(&held));
        Ok(Ok((held, bytes)))
    }

    fn reserve(&self, job: &Job, cells: &Arc<Cells>) -> Result<Held, Reason> {
        let (_, _, is_level_fastest) = job.order();
        let layers = seen_layers(job, &cells.list);
        let columns = cells.list.len().max(1);
        let [page, all] = self.room(job, layers.len());
        if columns as u64 > all {
            let of_field = columns * layers.len() * VALUE;
            let (most, name) = (all * (layers.len() * VALUE) as u64, self.described());
            return because(format!("{of_field} bytes of the field, expected at most {most} on {name}"));
        }
        let pages = columns.div_ceil(page as usize);
        let layout = Layout { layers, page_columns: columns.div_ceil(pages), pages, is_level_fastest };
        let count = layout.page_columns * layout.layers.len();
        let lend = |what: &str, count: usize, bytes: usize| {
            let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
            (0..count).map(|_| self.lend(what, bytes, usage)).collect::<Result<Vec<_>, _>>()
        };
        Ok(Held {
            content: job.content(),
            cells: Arc::clone(cells),
            pages: lend("page of the field", pages, count * VALUE)?,
            gradients: lend("page of gradients", if is_lit(job) { pages } else { 0 }, count * GRADIENT)?,
            lit_by: is_lit(job).then(|| job.number()),
            layout,
        })
    }

    /// Uploads all values, normalised on the way: each is read from the model's array and written where the device takes it
    /// from, so that the host never has a second field.
    ///
    /// Normalised here, in f64, and not in the shader: it is done once per value instead of once per read, and gives the bits
    /// that the CPU's kernel has.
    fn fill_pages(&self, job: &Job, held: &Held) -> Result<u64, Reason> {
        let Layout { layers, page_columns, is_level_fastest, .. } = &held.layout;
        let count = page_columns * layers.len();
        for (k, columns) in held.cells.list.chunks(*page_columns).enumerate() {
            // The last page has as many as the others, so that strides are the same.
            let mut columns = Cow::Borrowed(columns);
            if columns.len() < *page_columns {
                let filler = columns[0];
                columns.to_mut().resize(*page_columns, filler);
            }
            self.fill(&held.pages[k], count, |first, values| {
                job.values(&columns, layers.clone(), first, values)
            })?;
            let (gradients, all) = (job.gradients(), job.radius().len());
            let gradient = |at: usize| {
                let (column, layer) = match is_level_fastest {
                    true => (columns[at / layers.len()], at % layers.len()),
                    false => (columns[at % page_columns], at / page_columns),
                };
                gradients[column as usize * all + layers.start + layer]
            };
            if let Some(page) = held.gradients.get(k) {
                self.fill(page, 3 * count, |first, numbers| {
                    (first..).zip(numbers).for_each(|(at, number)| *number = gradient(at / 3)[at % 3]);
                })?;
            }
        }
        Ok((count * (held.pages.len() * VALUE + held.gradients.len() * GRADIENT)) as u64)
    }
}

fn is_lit(job: &Job) -> bool {
    !job.gradients().is_empty()
}
