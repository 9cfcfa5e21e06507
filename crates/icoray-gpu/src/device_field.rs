//! A field on the device: columns of values and gradients in pages, in the order of the model's array.

use crate::bindings;
use crate::context::Context;
use crate::culling::CellSet;
use crate::layout::Params;
use crate::picture::Picture;
use crate::pipelines::Constants;
use crate::pool::PooledBuffer;
use crate::visible_layers::needs_all_layers;
use icoray::device::{Content, FallbackReason, Job, Span};
use std::ops::Range;
use std::sync::Arc;

/// Bytes of a value.
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

/// The values of a field over some cells.
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

    /// Bytes of the values.
    pub fn bytes(&self) -> u64 {
        (self.cells.list.len() * self.layout.layers.len() * VALUE_BYTES) as u64
    }
}

/// Binds the pages of a field.
pub(crate) fn page_group(ctx: &Context, pages: &[PooledBuffer]) -> Result<wgpu::BindGroup, FallbackReason> {
    let layout = bindings::page_layout(ctx, pages.len());
    bindings::group(ctx, &layout, pages.iter().map(|page| &**page))
}
