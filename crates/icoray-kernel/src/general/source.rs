//! A field as single rays read it: raw values in double precision, from any storage of the model.

use super::wedge::{Facet, Wedge};
use crate::transfer::{KernelKnot, Span, Spans};
use icoray_grid::Field;
use icoray_grid::array::{MapInline, partition_point};
use icoray_grid::gradient::PartialGradients;
use icoray_grid::real::Real;
use icoray_grid::samples::AnySamples;

/// A field's values and, if the field is lit, its gradients.
#[derive(Debug)]
pub struct FieldSource<'f> {
    values: AnySamples<'f>,
    /// Gradients at the vertices, level-fastest; empty if nothing of the field is lit.
    gradients: PartialGradients,
    layers: usize,
    cuts: Vec<f64>,
    value_range: Option<[f64; 2]>,
    /// The largest magnitude; larger values count as this one.
    most: f64,
}

impl<'f> FieldSource<'f> {
    /// A source that reads `field`, whose first layer is the outermost if `falling` is set. `cuts` are the values,
    /// rising, at which a transfer function or an isosurface of the field has a knot; `value_range` is that of the
    /// field, if it has values.
    #[inline]
    pub fn new(
        field: &Field<'f>,
        falling: bool,
        gradients: PartialGradients,
        cuts: Vec<f64>,
        value_range: Option<[f64; 2]>,
    ) -> Self {
        const RAW: [f64; 2] = [0.0, 1.0];
        let values = AnySamples::new(field, falling, RAW);
        FieldSource { values, gradients, layers: field.shape().layers, cuts, value_range, most: f64::LARGEST }
    }

    /// The same field of a single volume without surfaces, whose values may be as large as any.
    #[inline]
    pub fn of_any_size(self) -> Self {
        FieldSource { most: f64::MAX, ..self }
    }

    /// The gradients of the field.
    #[inline]
    pub fn gradients(&self) -> &PartialGradients {
        &self.gradients
    }

    /// The gradients, to be modified.
    #[inline]
    pub fn gradients_mut(&mut self) -> &mut PartialGradients {
        &mut self.gradients
    }

    /// The gradients, to reuse them for the next frame.
    #[inline]
    pub fn into_gradients(self) -> PartialGradients {
        self.gradients
    }

    /// The least and the greatest value of the field, if it has any.
    #[inline]
    pub(crate) fn value_range(&self) -> Option<[f64; 2]> {
        self.value_range
    }

    /// The field's values, normalised to a range.
    #[inline]
    pub(crate) fn samples_in(&self, range: [f64; 2]) -> AnySamples<'f> {
        self.values.normalised_to(range)
    }

    /// The field's values without normalisation.
    #[inline]
    pub(crate) fn samples(&self) -> AnySamples<'f> {
        self.values
    }

    /// The values at `layer` over three cells; NaN for a missing one.
    #[inline]
    pub fn at(&self, cells: [u32; 3], layer: usize) -> [f64; 3] {
        self.values.bases(cells).map_inline(|base| self.values.value(base, layer).clamp(-self.most, self.most))
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
        let gradients = self.gradients.values();
        let [a, b, c] = cells.map_inline(|cell| gradients.at(cell as usize * self.layers + layer));
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
