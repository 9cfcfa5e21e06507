//! The transfer function in vectors: the span that each lane's values lie in.

use super::part::{Part, all};
use crate::transfer::Spans;
use fearless_simd::prelude::*;
use icoray_simd::{Floats, Machine, Mask, Numbers, Table};

/// The spans of a transfer function as tables.
#[derive(Clone, Copy)]
pub(super) struct SpanTables<'t> {
    low: Table<'t, f32>,
    high: Table<'t, f32>,
    numbers: [Table<'t, f32>; NUMBERS],
    first: Table<'t, u32>,
    /// Whether there are steps or narrow spans, whose edges only scalar code crosses.
    pub has_steps: bool,
}

/// The numbers of a span beside its ends.
const NUMBERS: usize = 11;

impl<'t> SpanTables<'t> {
    /// The tables of these spans.
    #[inline]
    pub fn new(spans: &'t Spans<f32>) -> Option<Self> {
        let rows = spans.rows();
        let mut numbers = [Table::new(&rows.numbers[0])?; NUMBERS];
        for (table, row) in numbers.iter_mut().zip(&rows.numbers) {
            *table = Table::new(row)?;
        }
        let has_steps = spans.has_steps();
        let first = Table::new(&rows.first)?;
        Some(SpanTables { low: Table::new(&rows.low)?, high: Table::new(&rows.high)?, numbers, first, has_steps })
    }

    /// The upper ends of spans.
    #[inline(always)]
    pub fn high<V: Machine>(&self, simd: V, span: Numbers<V>) -> Floats<V> {
        simd.look_up(self.high, span)
    }

    /// The lower ends of spans.
    #[inline(always)]
    pub fn low<V: Machine>(&self, simd: V, span: Numbers<V>) -> Floats<V> {
        simd.look_up(self.low, span)
    }

    /// The span of each value: the upper one where it lies on a knot.
    #[inline(always)]
    pub fn find<V: Machine>(&self, simd: V, value: Floats<V>) -> Numbers<V> {
        let buckets = self.first.last();
        let bucket = (value * buckets as f32).max(all(simd, 0.0)).to_int::<Numbers<V>>();
        let mut span = simd.gather_u32(self.first, bucket);
        let (one, none) = (number(simd, 1), number(simd, 0));
        loop {
            let above = self.high(simd, span).simd_le(value);
            if above.all_false() {
                break;
            }
            span = span + above.select(one, none);
        }
        loop {
            let below = value.simd_lt(self.low(simd, span));
            if below.all_false() {
                break;
            }
            span = span - below.select(one, none);
        }
        span
    }

    /// The medium of spans.
    #[inline(always)]
    pub fn medium<V: Machine>(&self, simd: V, span: Numbers<V>) -> Medium<V> {
        let look = |k: usize| simd.look_up(self.numbers[k], span);
        Medium {
            anchor: look(0),
            extinction: look(1),
            slope: look(2),
            steepest: look(3),
            color: [look(4), look(5), look(6)],
            color_slope: [look(7), look(8), look(9)],
            brightest: look(10),
        }
    }
}

/// The numbers of each lane's span, as [`Span`](crate::transfer::Span) has them.
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

    /// Lanes whose part is constant and clear: on a knot without extinction, values beside which are not clear.
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
