//! A field on the device: its columns in pages, in the order that the model's array has.

use crate::gpu::{Gpu, STORAGES, because};
use crate::layout::Params;
use crate::scene::{self, Picture, Places};
use crate::select::{Cells, seen_layers};
use crate::store::Lent;
use icoray::device::{Content, Job, Reason, Span};
use std::borrow::Cow;
use std::ops::Range;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use wgpu::BufferUsages;

/// Pages are cases of a shader, of which there should not be hundreds.
const MOST_PAGES: u32 = 32;

/// Bytes of a value, of what f32 leaves of it, and of a gradient.
const VALUE: usize = size_of::<f32>();
const REST: usize = size_of::<i16>();
const GRADIENT: usize = 3 * size_of::<f32>();

/// The longest gradient that a shader reads.
const STEEPEST: f32 = 1e30;

/// Where values lie.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Layout {
    pub layers: Range<usize>,
    /// Columns of a page, the last one of which may have fewer.
    pub page_columns: usize,
    pub pages: usize,
    has_all_layers: bool,
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
    /// The transfer function by which layers are left out.
    spans: Vec<Span>,
    pub cells: Arc<Cells>,
    pub layout: Layout,
    pub pages: Vec<Lent>,
    /// Of the same columns; none where the picture is not lit.
    pub gradients: Vec<Lent>,
    /// What these depend on beside the field.
    lit: Option<Lit>,
}

/// What gradients depend on beside the field.
#[derive(Debug, Clone, PartialEq)]
struct Lit {
    /// Of the layers.
    radius: Vec<f64>,
    /// The picture that gives them, where they are not computed here: those of a halo depend on other ranks' fields.
    given_by: Option<u64>,
}

impl Held {
    /// Groups 1 and 3. What is not lit reads no gradients, and may have anything in their place.
    pub fn groups(&self, gpu: &Gpu) -> Result<[wgpu::BindGroup; 2], Reason> {
        let gradients = if self.lit.is_some() { &self.gradients } else { &self.pages };
        Ok([self.group(gpu, &self.pages)?, self.group(gpu, gradients)?])
    }

    /// A group of pages.
    pub fn group(&self, gpu: &Gpu, pages: &[Lent]) -> Result<wgpu::BindGroup, Reason> {
        gpu.group(&gpu.page_layout(pages.len()), pages.iter().map(|page| &**page))
    }

    /// How it lies.
    pub fn places(&self) -> Places {
        let Layout { pages, has_all_layers, .. } = self.layout;
        Places { pages, has_places: self.cells.places.is_some(), has_all_layers }
    }

    /// The numbers that all rays share, but for the pieces of a dispatch.
    pub fn params(&self, picture: &Picture) -> Params {
        let Layout { layers, page_columns, .. } = &self.layout;
        let [column_stride, layer_stride] = self.layout.strides().map(|stride| stride as u32);
        Params {
            column_stride,
            layer_stride,
            page_columns: *page_columns as u32,
            first_layer: layers.start as u32,
            last_layer: layers.end as u32 - 1,
            ..scene::params(picture.job, &picture.mesh)
        }
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
    /// How many columns of `layers` layers a page has room for, and all pages.
    fn room(&self, job: &Job, layers: usize) -> [u64; 2] {
        let (largest, all) =
            if lit(job).is_some() { (GRADIENT, VALUE + REST + GRADIENT) } else { (VALUE, VALUE) };
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
        picture: &Picture,
        cells: &Arc<Cells>,
    ) -> Result<Result<(Arc<Held>, u64), Reason>, Reason> {
        let job = picture.job;
        let lit = lit(job);
        let spans = job.spans();
        let is_it = |held: &&Arc<Held>| {
            held.content == job.content()
                && held.cells.number == cells.number
                && (held.layout.has_all_layers || held.spans == spans)
                && (lit.is_none() || held.lit == lit)
        };
        if let Some(held) = self.fields.held().iter().find(is_it) {
            return Ok(Ok((Arc::clone(held), 0)));
        }
        self.fields.sweep();
        let held = match self.reserve(job, cells) {
            Ok(held) => held,
            Err(reason) => return self.untroubled().map(|()| Err(reason)),
        };
        let bytes = self.fill_pages(picture, &held)?;
        let held = Arc::new(held);
        self.fields.held().push(Arc::clone(&held));
        Ok(Ok((held, bytes)))
    }

    fn reserve(&self, job: &Job, cells: &Arc<Cells>) -> Result<Held, Reason> {
        let (_, _, is_level_fastest) = job.order();
        let layers = seen_layers(job, &cells.list);
        let has_all_layers = layers.len() == job.radius().len();
        let columns = cells.list.len().max(1);
        let [page, all] = self.room(job, layers.len());
        if columns as u64 > all {
            let of_field = columns * layers.len() * VALUE;
            let (most, name) = (all * (layers.len() * VALUE) as u64, self.described());
            return because(format!("{of_field} bytes of the field, expected at most {most} on {name}"));
        }
        let pages = columns.div_ceil(page as usize);
        let layout =
            Layout { layers, page_columns: columns.div_ceil(pages), pages, has_all_layers, is_level_fastest };
        let count = layout.page_columns * layout.layers.len();
        let of_gradients = if lit(job).is_some() { pages } else { 0 };
        let lend = |what: &str, count: usize, bytes: usize| {
            let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
            (0..count).map(|_| self.lend(what, bytes, usage)).collect::<Result<Vec<_>, _>>()
        };
        Ok(Held {
            content: job.content(),
            spans: job.spans(),
            cells: Arc::clone(cells),
            pages: lend("page of the field", pages, count * VALUE)?,
            gradients: lend("page of gradients", of_gradients, count * GRADIENT)?,
            lit: lit(job),
            layout,
        })
    }

    /// Uploads all values, normalised on the way: each is read from the model's array and written where the device takes it
    /// from, so that the host never has a second field.
    ///
    /// Normalised here, in f64, and not in the shader: it is done once per value instead of once per read, and gives the bits
    /// that the CPU's kernel has.
    fn fill_pages(&self, picture: &Picture, held: &Held) -> Result<u64, Reason> {
        let job = picture.job;
        let Layout { layers, page_columns, .. } = &held.layout;
        let count = page_columns * layers.len();
        let mut bytes = held.pages.len() * count * VALUE;
        let mut rests = Vec::with_capacity(held.gradients.len());
        for (k, columns) in held.cells.list.chunks(*page_columns).enumerate() {
            // The last page has as many as the others, so that strides are the same.
            let mut columns = Cow::Borrowed(columns);
            if columns.len() < *page_columns {
                let filler = columns[0];
                columns.to_mut().resize(*page_columns, filler);
            }
            self.fill(&held.pages[k], count, |first, values| {
                job.values(&columns, layers.clone(), first, values);
            })?;
            if job.is_part() && held.lit.is_some() {
                self.fill_gradients(job, held, &columns, &held.gradients[k])?;
                bytes += count * GRADIENT;
            } else if held.lit.is_some() {
                let (words, usage) = (count.div_ceil(2), BufferUsages::STORAGE | BufferUsages::COPY_DST);
                let page = self.lend("page of last digits", words * 2 * REST, usage)?;
                self.fill(&page, words, |first, words: &mut [[i16; 2]]| {
                    let digits: &mut [i16] = bytemuck::cast_slice_mut(words);
                    let there = digits.len().min(count - 2 * first);
                    job.rests(&columns, layers.clone(), 2 * first, &mut digits[..there]);
                })?;
                bytes += words * 2 * REST;
                rests.push(page);
            }
        }
        let of_gradients = if rests.is_empty() { 0 } else { self.compute_gradients(picture, held, &rests)? };
        Ok(bytes as u64 + of_gradients)
    }

    /// Uploads the gradients of a page as they are given.
    fn fill_gradients(
        &self,
        job: &Job,
        held: &Held,
        columns: &[u32],
        page: &wgpu::Buffer,
    ) -> Result<(), Reason> {
        let (layers, all) = (&held.layout.layers, job.gradients());
        let [column_stride, layer_stride] = held.layout.strides();
        let of_column = job.radius().len();
        let number = |at: usize| {
            let (column, row) = match held.layout.is_level_fastest {
                true => (at / 3 / column_stride, at / 3 % column_stride),
                false => (at / 3 % layer_stride, at / 3 / layer_stride),
            };
            let there = columns[column] as usize * of_column + layers.start + row;
            // As far as they may go in the shader that computes them.
            let gradient = all[there][at % 3];
            if gradient.is_nan() { 0.0 } else { gradient.clamp(-STEEPEST, STEEPEST) }
        };
        self.fill(page, 3 * columns.len() * layers.len(), |first, numbers: &mut [f32]| {
            (first..).zip(numbers).for_each(|(at, gradient)| *gradient = number(at));
        })
    }
}

fn lit(job: &Job) -> Option<Lit> {
    let given_by = job.is_part().then(|| job.number());
    job.shading().map(|_| Lit { radius: job.radius().to_vec(), given_by })
}
