//! The fields of the kernel's scene. Single rays read raw values in double precision, from any storage of the model.

use super::wedge::{Facet, Wedge};
use crate::transfer::{KernelKnot, Span, Spans};
use icoray_grid::Field;
use icoray_grid::array::{MapInline, partition_point};
use icoray_grid::gradient::PartialGradients;

/// A field with the data that rays need of it.
#[derive(Debug)]
pub struct FieldSource<'f> {
    /// The field; its first layer is the innermost.
    pub field: Field<'f>,
    /// Gradients at the vertices, level-fastest; empty if nothing of the field is lit.
    pub gradients: PartialGradients<'f>,
    /// The values, rising, at which a transfer function or an isosurface of the field has a knot.
    pub cuts: Vec<f64>,
    /// The least and the greatest value of the field, if it has any.
    pub value_range: Option<[f64; 2]>,
    /// The largest magnitude; larger values count as this one.
    pub largest: f64,
}

impl FieldSource<'_> {
    /// The values at `layer` over three cells; NaN for a missing one.
    #[inline]
    pub fn at(&self, cells: [u32; 3], layer: usize) -> [f64; 3] {
        let values = self.field.values(cells.map_inline(|cell| cell as usize), layer);
        values.map_inline(|value| value.clamp(-self.largest, self.largest))
    }

    /// The value on the facet of a layer at `u`.
    #[inline]
    pub(super) fn on_layer(&self, wedge: &Wedge, facet: &Facet, u: f64) -> f64 {
        let g = self.at(wedge.cells, facet.layer);
        let [b, c] = facet.weights(wedge, u);
        g[0] + (b * (g[1] - g[0]) + c * (g[2] - g[0]))
    }

    /// The gradients at `layer`, a row for each axis.
    #[inline]
    pub fn gradients_at(&self, cells: [u32; 3], layer: usize) -> [[f64; 3]; 3] {
        let (gradients, layers) = (self.gradients.values(), self.field.shape().layers);
        let [a, b, c] = cells.map_inline(|cell| gradients.at(cell as usize * layers + layer));
        [0, 1, 2].map_inline(|axis| [a, b, c].map_inline(|gradient| f64::from(gradient[axis])))
    }

    /// The cuts strictly between two values.
    #[inline]
    pub fn cuts_between(&self, low: f64, high: f64) -> &[f64] {
        let from = partition_point(&self.cuts, |cut| *cut <= low);
        let to = partition_point(&self.cuts, |cut| *cut < high);
        &self.cuts[from..to.max(from)]
    }
}

/// A transfer function of a source's values.
#[derive(Debug)]
pub struct TransferMap {
    /// The number of the source.
    pub source: usize,
    spans: Spans<f64>,
    knots: Vec<KernelKnot>,
    shift: f64,
    scale: f64,
}

impl TransferMap {
    /// The transfer function of these knots, for the values of a source.
    #[inline]
    pub fn new(source: usize, knots: Vec<KernelKnot>) -> Self {
        let spans = Spans::new(&knots);
        let [low, high] = spans.range();
        TransferMap { source, spans, knots, shift: low, scale: 1.0 / (high - low) }
    }

    /// The knots of the transfer function.
    #[inline]
    pub fn knots(&self) -> &[KernelKnot] {
        &self.knots
    }

    /// The factor from differences of field values to differences of normalised values.
    #[inline]
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// The value in the units of the spans.
    #[inline]
    pub fn normal(&self, value: f64) -> f64 {
        (value - self.shift) * self.scale
    }

    /// The transfer function, in its own units.
    #[inline]
    pub(crate) fn spans(&self) -> &Spans<f64> {
        &self.spans
    }

    /// The span of a value.
    #[inline]
    pub fn span(&self, value: f64) -> &Span<f64> {
        self.spans.span(self.spans.find(self.normal(value)))
    }

    /// Whether all values from `low` to `high` have no extinction.
    #[inline]
    pub fn is_clear_between(&self, low: f64, high: f64) -> bool {
        let (low, high) = (self.normal(low), self.normal(high));
        if low == high {
            let span = self.spans.span(self.spans.find(low));
            return span.is_clear || span.extinction(low) == 0.0;
        }
        let all = self.spans.all();
        let first = partition_point(all, |span| span.high < low);
        all[first..].iter().take_while(|span| span.low <= high).all(|span| {
            // The outer two spans extend to infinity.
            span.is_clear || span.high <= low || span.low >= high
        })
    }
}
