//! The transfer function in vectors: the span that contains each lane's values.

use super::part::{Part, all};
use crate::transfer::Spans;
use fearless_simd::prelude::*;
use icoray_simd::{Floats, Machine, Mask, Numbers, Rows, Table};

/// The spans of a transfer function as tables.
#[derive(Clone, Copy)]
pub(super) struct SpanTables<'t> {
    /// The lower and the upper ends of spans.
    ends: Rows<'t, 2>,
    numbers: Rows<'t, NUMBERS>,
    /// The numbers of narrow spans below spans, and up to them.
    steps: Rows<'t, 2>,
    first: Table<'t, u32>,
    /// The first knot.
    pub origin: f32,
    /// The largest extinction.
    pub densest: f32,
    /// Whether there are steps or narrow spans, which only scalar code crosses.
    pub has_steps: bool,
}

/// The numbers of a span beside its ends.
const NUMBERS: usize = 11;

/// The span of each lane's value, and its ends.
#[derive(Clone, Copy)]
pub(super) struct Found<V: Machine> {
    pub span: Numbers<V>,
    pub low: Floats<V>,
    pub high: Floats<V>,
}

impl<'t> SpanTables<'t> {
    /// The tables of these spans.
    #[inline]
    pub fn new(spans: &'t Spans<f32>) -> Option<Self> {
        let rows = spans.rows();
        let ends = Rows::new([&rows.low, &rows.high])?;
        let numbers = Rows::new(std::array::from_fn(|k| rows.numbers[k].as_slice()))?;
        let steps = Rows::new([&rows.steps[0], &rows.steps[1]])?;
        let first = Table::new(&rows.first)?;
        let densest = spans.all().iter().fold(0.0f32, |most, span| most.max(span.extinction));
        let has_steps = spans.has_steps();
        Some(SpanTables { ends, numbers, steps, first, origin: rows.origin, densest, has_steps })
    }

    /// The span of the value of each lane of `lanes`, the upper one if it lies on a knot, searched from `near`.
    #[inline(always)]
    pub fn find<V: Machine>(&self, simd: V, value: Floats<V>, near: Numbers<V>, lanes: Mask<V>) -> Found<V> {
        let [low, high] = simd.look_up(&self.ends, near);
        let is_off = (high.simd_le(value) | value.simd_lt(low)) & lanes;
        if is_off.all_false() {
            return Found { span: near, low, high };
        }
        let buckets = self.first.last();
        let bucket = ((value - self.origin) * buckets as f32).max(all(simd, 0.0)).to_int::<Numbers<V>>();
        let mut span = is_off.select(simd.gather_u32(self.first, bucket), near);
        let (one, none) = (number(simd, 1), number(simd, 0));
        loop {
            let [low, high] = simd.look_up(&self.ends, span);
            let (is_above, is_below) = (high.simd_le(value) & lanes, value.simd_lt(low) & lanes);
            if (is_above | is_below).all_false() {
                return Found { span, low, high };
            }
            span = span + is_above.select(one, none) - is_below.select(one, none);
        }
    }

    /// Lanes of `lanes` with a step or a narrow span between two values, the lower of which is searched from `near`.
    #[inline(always)]
    pub fn have_steps<V: Machine>(
        &self,
        simd: V,
        [least, most]: [Floats<V>; 2],
        near: Numbers<V>,
        lanes: Mask<V>,
    ) -> Mask<V> {
        let least = self.find(simd, least, near, lanes).span;
        let [below, _] = simd.look_up(&self.steps, least);
        let [_, up_to] = simd.look_up(&self.steps, self.find(simd, most, least, lanes).span);
        below.simd_lt(up_to) & lanes
    }

    /// These spans with their ends.
    #[inline(always)]
    pub fn at<V: Machine>(&self, simd: V, span: Numbers<V>) -> Found<V> {
        let [low, high] = simd.look_up(&self.ends, span);
        Found { span, low, high }
    }

    /// The medium of spans.
    #[inline(always)]
    pub fn medium<V: Machine>(&self, simd: V, span: Numbers<V>) -> Medium<V> {
        let [anchor, extinction, slope, steepest, r, g, b, dr, dg, db, brightest] = simd.look_up(&self.numbers, span);
        Medium { anchor, extinction, slope, steepest, color: [r, g, b], color_slope: [dr, dg, db], brightest }
    }
}

/// The numbers of each lane's span, as in [`Span`](crate::transfer::Span).
pub(super) struct Medium<V: Machine> {
    pub anchor: Floats<V>,
    pub extinction: Floats<V>,
    pub slope: Floats<V>,
    pub steepest: Floats<V>,
    pub color: [Floats<V>; 3],
    pub color_slope: [Floats<V>; 3],
    pub brightest: Floats<V>,
}

impl<V: Machine> Medium<V> {
    /// Extinction at the values `f`.
    #[inline(always)]
    pub fn extinction(&self, simd: V, f: Floats<V>) -> Floats<V> {
        self.slope.mul_add(f - self.anchor, self.extinction).max(all(simd, 0.0))
    }

    /// Lanes whose part is constant and clear: on a knot without extinction, beside which values are not clear.
    #[inline(always)]
    pub fn is_clear(&self, simd: V, part: &Part<V>) -> Mask<V> {
        let zero = all(simd, 0.0);
        let is_constant = part.f0.simd_eq(part.f1) & part.kappa.simd_eq(zero);
        is_constant & self.extinction(simd, part.f0).simd_le(zero)
    }
}

/// The same number in all lanes.
#[inline(always)]
pub(super) fn number<V: Machine>(simd: V, value: u32) -> Numbers<V> {
    <Numbers<V> as SimdBase<V>>::splat(simd, value)
}
