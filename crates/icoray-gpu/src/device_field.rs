//! A field on the device: columns of values and gradients in pages, in the order of the model's array.

use crate::context::Context;
use crate::culling::CellSet;
use crate::layout::Params;
use crate::picture::Picture;
use crate::pipelines::{Constants, page_group};
use crate::pool::PooledBuffer;
use icoray::device::{
    ColorByField, Content, FallbackReason, Isosurface, IsosurfacePaint, Job, Scenery, Span, SurfaceLayer, SurfacePlace,
};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

pub(crate) const VALUE_BYTES: usize = size_of::<f32>();

/// The layout of values in pages.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct FieldLayout {
    pub layers: Range<usize>,
    /// Columns per page. The last page may use fewer.
    pub page_columns: usize,
    pub pages: usize,
    pub has_all_layers: bool,
    pub is_level_fastest: bool,
}

impl FieldLayout {
    /// Elements from column to column and from layer to layer.
    pub fn strides(&self) -> [usize; 2] {
        if self.is_level_fastest { [self.layers.len(), 1] } else { [1, self.page_columns] }
    }
}

#[derive(Debug)]
pub(crate) struct DeviceField {
    pub content: Content,
    /// The transfer function that decided which layers are left out.
    pub spans: Vec<Span>,
    pub cells: Arc<CellSet>,
    pub layout: FieldLayout,
    pub pages: Vec<PooledBuffer>,
    /// One page per page of values; none if the picture is unlit.
    pub gradients: Vec<PooledBuffer>,
    pub gradient_key: Option<GradientKey>,
}

/// The inputs of gradients besides the field.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct GradientKey {
    /// Radii of the layers.
    radius: Vec<f64>,
    /// The job that gives the gradients, if the device does not compute them: those of a part's halo cells depend on other
    /// ranks' fields.
    given_by: Option<u64>,
}

impl GradientKey {
    /// The key of a job; `None` if it is unlit.
    pub fn new(job: &Job) -> Option<Self> {
        let given_by = job.has_gradients().then(|| job.number());
        job.shading().map(|_| GradientKey { radius: job.radius().to_vec(), given_by })
    }
}

impl DeviceField {
    /// Whether these are the values and gradients that a job reads over `cells`.
    pub fn matches(&self, job: &Job, cells: &CellSet) -> bool {
        let key = GradientKey::new(job);
        self.content == job.content()
            && self.cells.id == cells.id
            && (self.layout.has_all_layers || (self.spans == job.spans() && !needs_all_layers(job)))
            && (key.is_none() || self.gradient_key == key)
    }

    /// Binds groups 1 and 3. Shaders of unlit scenes do not read gradients, so that any pages can be bound there.
    pub fn groups(&self, ctx: &Context) -> Result<[wgpu::BindGroup; 2], FallbackReason> {
        let gradients = if self.gradient_key.is_some() { &self.gradients } else { &self.pages };
        Ok([page_group(ctx, &self.pages)?, page_group(ctx, gradients)?])
    }

    /// The override constants of shaders that read this field.
    pub fn constants(&self) -> Constants {
        vec![("PAGES", self.layout.pages as u32), ("HAS_PLACES", u32::from(self.cells.places.is_some()))]
    }

    /// The parameters of all rays of a picture of this field, without those of a dispatch.
    pub fn params(&self, picture: &Picture) -> Params {
        let FieldLayout { layers, page_columns, .. } = &self.layout;
        let [column_stride, layer_stride] = self.layout.strides().map(|stride| stride as u32);
        Params {
            column_stride,
            layer_stride,
            page_columns: *page_columns as u32,
            first_layer: layers.start as u32,
            last_layer: layers.end as u32 - 1,
            ..picture.params()
        }
    }

    pub fn bytes(&self) -> u64 {
        (self.cells.list.len() * self.layout.layers.len() * VALUE_BYTES) as u64
    }
}

/// Number of columns that are read at a time.
const CHUNK: usize = 1024;

/// The layers without the lowest and the highest ones that lie, together with their neighbour, within one clear span of
/// the transfer function over all of `columns`. Values that shaders read instead of the missing ones lie in the same
/// span, so that the picture is the same.
pub(crate) fn visible_layers(job: &Job, columns: &[u32]) -> Range<usize> {
    let layers = job.radius().len();
    if needs_all_layers(job) {
        return 0..layers;
    }
    let below = clear_layers(job, columns, |k| k);
    if below == layers {
        // All are clear, and a field has at least one layer.
        return 0..1;
    }
    let above = clear_layers(job, columns, |k| layers - 1 - k);
    // Gradients read one layer more.
    let kept = if job.shading().is_some() { 2 } else { 1 };
    below.max(kept) - kept..layers - above.max(kept) + kept
}

/// Whether values that the transfer function shows as clear are needed: for an isosurface, or for the colour of a volume
/// with the opacity of another field.
fn needs_all_layers(job: &Job) -> bool {
    let is_of_own = |surface: &Isosurface| {
        let is_painted = matches!(&surface.paint, IsosurfacePaint::Field(ColorByField { field: None, .. }));
        surface.field.is_none() || is_painted
    };
    let is_between = |surface: &SurfaceLayer| matches!(surface.place, SurfacePlace::Radius(_));
    let needs = |scenery: &Scenery| {
        !scenery.volumes.is_empty()
            || scenery.isosurfaces.iter().any(is_of_own)
            || scenery.surface_layers.iter().any(is_between)
    };
    job.scenery().is_some_and(needs)
}

/// Counts the layers, in the order of `layer`, whose values all lie in the clear span of the first value.
fn clear_layers(job: &Job, columns: &[u32], layer: impl Fn(usize) -> usize + Sync) -> usize {
    let value = |column: u32, k: usize| {
        let mut value = [0.0];
        job.values(&[column], layer(k)..layer(k) + 1, 0, &mut value);
        value[0]
    };
    let Some(first) = columns.first().map(|column| value(*column, 0)) else { return 0 };
    let spans = job.spans();
    let Some(span) = spans.iter().find(|span| span.is_clear && is_inside(span, first)) else { return 0 };
    let clear = AtomicUsize::new(job.radius().len());
    let check = |columns: &[u32]| {
        let mut values = [0.0; CHUNK];
        let values = &mut values[..columns.len()];
        for k in 0..clear.load(Ordering::Relaxed) {
            job.values(columns, layer(k)..layer(k) + 1, 0, values);
            if !values.iter().all(|value| is_inside(span, *value)) {
                clear.fetch_min(k, Ordering::Relaxed);
            }
            if clear.load(Ordering::Relaxed) <= k {
                break;
            }
        }
    };
    // A sample of the whole globe first: it shows quickly that most fields have no clear layer.
    let sample: Vec<u32> = columns.iter().step_by((columns.len() / CHUNK).max(1)).copied().take(CHUNK).collect();
    check(&sample);
    columns.par_chunks(CHUNK).for_each(check);
    clear.into_inner()
}

/// Whether a value lies inside a span by more than the rounding error of any mean of such values.
fn is_inside(span: &Span, value: f32) -> bool {
    const FARTHEST: f32 = 100.0;
    const MARGIN: f32 = 1e-3;
    value.abs() <= FARTHEST && value - MARGIN >= span.low && value + MARGIN <= span.high
}
