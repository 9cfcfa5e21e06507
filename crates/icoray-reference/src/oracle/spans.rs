//! The transfer function as spans between knots, in f64 and the field's own units.

use glam::DVec3;
use icoray::TransferFunction;

/// Between two neighbouring knots, or outside all: extinction and colour are linear in the value.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Span {
    /// Values of the span, `low <= high`; infinite outside all knots.
    pub low: f64,
    pub high: f64,
    pub anchor: f64,
    pub extinction: f64,
    pub color: DVec3,
    /// Extinction per planet radius, per unit of the value.
    pub extinction_slope: f64,
    /// Linear RGB per unit of the value.
    pub color_slope: DVec3,
    /// There is no extinction in it.
    pub is_clear: bool,
}

impl Span {
    /// Extinction per planet radius at the value `base + f`.
    #[inline]
    pub fn extinction(&self, base: f64, f: f64) -> f64 {
        (self.extinction + self.extinction_slope * (f - (self.anchor - base))).max(0.0)
    }

    /// Linear RGB at the value `base + f`.
    #[inline]
    pub fn color(&self, base: f64, f: f64) -> DVec3 {
        self.color + self.color_slope * (f - (self.anchor - base))
    }
}

/// `knots + 1` spans; span k lies above knot k - 1.
#[derive(Debug, Clone)]
pub(crate) struct Spans {
    pub spans: Vec<Span>,
    knots: Vec<f64>,
}

impl Spans {
    /// For a shell of the given thickness in planet radii.
    pub fn new(transfer: &TransferFunction, thickness: f64) -> Self {
        let knots = &transfer.knots;
        let unit = transfer.unit_length.unwrap_or(thickness);
        let last = knots.len() - 1;
        let span = |k: usize| {
            let (a, b) = (&knots[k.saturating_sub(1)], &knots[k.min(last)]);
            let width = b.value - a.value;
            let per = if width > 0.0 { 1.0 / width } else { 0.0 };
            let color = DVec3::from_array(a.color);
            Span {
                low: if k == 0 { f64::NEG_INFINITY } else { a.value },
                high: if k > last { f64::INFINITY } else { b.value },
                anchor: a.value,
                extinction: a.extinction / unit,
                color,
                extinction_slope: (b.extinction - a.extinction) / unit * per,
                color_slope: (DVec3::from_array(b.color) - color) * per,
                is_clear: a.extinction == 0.0 && b.extinction == 0.0,
            }
        };
        Spans { spans: (0..=knots.len()).map(span).collect(), knots: knots.iter().map(|k| k.value).collect() }
    }

    /// The span of a value; one exactly on a knot belongs to the span above.
    pub fn at(&self, value: f64) -> &Span {
        &self.spans[self.knots.partition_point(|k| *k <= value)]
    }

    /// The knots from `low` to `high`.
    pub fn knots_between(&self, low: f64, high: f64) -> &[f64] {
        let first = self.knots.partition_point(|k| *k < low);
        &self.knots[first..first.max(self.knots.partition_point(|k| *k <= high))]
    }
}
