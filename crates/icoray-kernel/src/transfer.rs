//! The transfer function in the kernel's form: linear spans between knots, in normalised values.

use super::segment::Segment;
use icoray_grid::array::{MapInline, partition_point};
use icoray_grid::real::Real;
use icoray_scene::TransferFunction;

/// A knot of the transfer function in the units of the kernel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KernelKnot {
    /// Field value, not normalised.
    pub value: f64,
    /// Linear RGB, not premultiplied.
    pub color: [f64; 3],
    /// Extinction per planet radius.
    pub extinction: f64,
}

impl KernelKnot {
    /// The knots of a transfer function in a shell of the given thickness, in planet radii, without those at which it
    /// does not bend.
    pub fn of(transfer: &TransferFunction, thickness: f64) -> Vec<Self> {
        let unit = transfer.unit_length.unwrap_or(thickness);
        let knots = transfer.knots.iter();
        let knots = knots.map(|k| KernelKnot { value: k.value, color: k.color, extinction: k.extinction / unit });
        without_straight(&knots.collect::<Vec<_>>())
    }

    pub(crate) fn channels(&self) -> [f64; 4] {
        let [r, g, b] = self.color;
        [r, g, b, self.extinction]
    }
}

/// The knots but for those that rounding alone distinguishes from points of the lines between the others.
fn without_straight(knots: &[KernelKnot]) -> Vec<KernelKnot> {
    /// Roundings of a knot's numbers.
    const ROUNDING: f64 = 8.0 * f64::EPSILON;
    const ANY: [[f64; 2]; 4] = [[f64::NEG_INFINITY, f64::INFINITY]; 4];
    let largest = |k: usize| knots.iter().fold(0.0, |most: f64, knot| most.max(knot.channels()[k].abs()));
    let largest = [0, 1, 2, 3].map_inline(largest);
    let mut kept: Vec<KernelKnot> = knots.iter().take(1).copied().collect();
    // The slopes of lines from the last kept knot that pass all knots since, the last of which is `passed`.
    let (mut slopes, mut passed) = (ANY, None);
    let mut i = 1;
    while let (Some(&knot), Some(&from)) = (knots.get(i), kept.last()) {
        let width = knot.value - from.value;
        let (start, end) = (from.channels(), knot.channels());
        let slope = [0, 1, 2, 3].map_inline(|k| (end[k] - start[k]) / width);
        let is_straight = width > 0.0 && (0..4).all(|k| slopes[k][0] <= slope[k] && slope[k] <= slopes[k][1]);
        match passed {
            Some(last) if !is_straight => {
                kept.push(last);
                (slopes, passed) = (ANY, None);
                // This knot is compared with the line that begins at the one before.
                continue;
            }
            _ if !is_straight => kept.push(knot),
            _ => {
                for k in 0..4 {
                    let off = ROUNDING * (largest[k] + slope[k].abs() * knot.value.abs()) / width;
                    slopes[k] = [slopes[k][0].max(slope[k] - off), slopes[k][1].min(slope[k] + off)];
                }
                passed = Some(knot);
            }
        }
        i += 1;
    }
    kept.extend(passed);
    kept
}

/// A span between two neighbouring knots, or outside all, in which extinction and colour are linear in the value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Span<T> {
    /// Values of the span, `low <= high`.
    pub low: T,
    /// The upper end.
    pub high: T,
    /// The value that slopes are measured from.
    pub anchor: T,
    /// Extinction at the anchor, per planet radius.
    pub extinction: T,
    /// Change of extinction per unit of value.
    pub extinction_slope: T,
    /// Colour at the anchor, linear RGB.
    pub color: [T; 3],
    /// Change of colour per unit of value.
    pub color_slope: [T; 3],
    /// Maximum of |dc/df| over the channels.
    pub steepest: T,
    /// Brightest channel within the span.
    pub brightest: T,
    /// Whether extinction is zero throughout.
    pub is_clear: bool,
}

impl<T: Real> Span<T> {
    /// Whether `segment` surely stays in the span.
    #[inline(always)]
    pub fn holds(&self, segment: &Segment<T>) -> bool {
        let [low, high] = segment.within();
        (low >= self.low) & (high <= self.high) & (segment.eps > T::of(-0.75))
    }

    /// Whether `segment`, which stays in the span, has no extinction. A constant on a knot is clear if the knot has no
    /// extinction, although values beside it are not clear.
    #[inline(always)]
    pub fn is_clear_in(&self, segment: &Segment<T>) -> bool {
        self.is_clear || (segment.is_constant() && self.extinction(segment.f0) == T::zero())
    }

    /// Extinction per planet radius at value `f`.
    #[inline(always)]
    pub fn extinction(&self, f: T) -> T {
        // A value that rounding puts beyond a knot must not make extinction negative.
        (self.extinction + self.extinction_slope * (f - self.anchor)).max(T::zero())
    }

    /// Whether it is a spike or a step instead of a part of a ramp.
    #[inline]
    pub fn is_narrow(&self) -> bool {
        self.high - self.low < T::of(NARROW)
    }

    /// Linear RGB at value `f`.
    #[inline(always)]
    pub fn color(&self, f: T) -> [T; 3] {
        let x = f - self.anchor;
        let (c, s) = (&self.color, &self.color_slope);
        [c[0] + s[0] * x, c[1] + s[1] * x, c[2] + s[2] * x]
    }
}

/// A value at which the transfer function jumps, or changes within the reach of rounding.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step<T> {
    /// The value, normalised.
    pub value: T,
    /// The larger extinction of its two sides.
    pub extinction: T,
    /// Slope of the extinction in the narrow span beside it, if it is the end of one.
    pub slope: T,
}

impl<T: Real> Step<T> {
    /// The largest extinction by which the two sides differ within `reach` of the value.
    #[inline]
    pub fn extinction_within(&self, reach: T) -> T {
        self.extinction + self.slope * reach
    }
}

/// The transfer function: `knots + 1` spans, the outer two reaching to infinity with the end knots' values.
#[derive(Debug, Clone)]
pub struct Spans<T> {
    spans: Vec<Span<T>>,
    rows: Box<SpanRows<T>>,
    steps: Vec<Step<T>>,
    has_steps: bool,
    range: [f64; 2],
}

impl<T: Real> Spans<T> {
    /// `knots` rise; two may share a value, which makes a step there (a value exactly on it counts as above).
    #[inline]
    pub fn new(knots: &[KernelKnot]) -> Self {
        let (first, last) = (knots[0], knots[knots.len() - 1]);
        // If all knots have one value there is no range for normalisation; the value's own size replaces it.
        let width = last.value - first.value;
        let width = if width > 0.0 { width } else { first.value.abs().max(1.0) };
        let origin = origin(knots, width);
        let range = [origin, origin + width];
        let normalise = |v: f64| T::of((v - origin) / width);
        let flat = |knot: &KernelKnot, low: T, high: T| span(low, high, normalise(knot.value), knot, knot, T::one());
        let mut values = vec![normalise(first.value)];
        for knot in &knots[1..] {
            let (before, value) = (values[values.len() - 1], normalise(knot.value));
            // Slopes between closer knots would not be finite: a step.
            values.push(if value - before < T::of(T::ROUNDING * T::ROUNDING) { before } else { value });
        }
        let mut spans = vec![flat(&first, T::neg_infinity(), values[0])];
        for (pair, value) in knots.windows(2).zip(values.windows(2)) {
            let (low, high) = (value[0], value[1]);
            let width = if high > low { high - low } else { T::one() };
            spans.push(span(low, high, low, &pair[0], &pair[1], width));
        }
        spans.push(flat(&last, values[values.len() - 1], T::infinity()));
        let steps = steps(&spans[1..knots.len()]);
        let has_steps = spans.iter().any(Span::is_narrow);
        let rows = Box::new(SpanRows::new(&spans, &values));
        Spans { spans, rows, steps, has_steps, range }
    }

    /// The values that normalise to 0 and 1.
    #[inline]
    pub fn range(&self) -> [f64; 2] {
        self.range
    }

    /// The values at which it jumps, rising.
    #[inline]
    pub fn steps(&self) -> &[Step<T>] {
        &self.steps
    }

    /// All spans, rising.
    #[inline]
    pub fn all(&self) -> &[Span<T>] {
        &self.spans
    }

    /// Span number `k`.
    #[inline]
    pub fn span(&self, k: usize) -> &Span<T> {
        &self.spans[k]
    }

    /// The span of value `f`, searched from span `k`: `k` itself when f lies on one of its knots.
    #[inline]
    pub fn follow(&self, mut k: usize, f: T) -> usize {
        while f > self.spans[k].high {
            k += 1;
        }
        while f < self.spans[k].low {
            k -= 1;
        }
        k
    }

    /// For a segment that begins in span `k`: the adjacent span, if the segment begins on the knot between the two and
    /// stays there; else `k`.
    #[inline]
    pub fn holding(&self, k: usize, segment: &Segment<T>) -> usize {
        let (span, f) = (&self.spans[k], segment.f0);
        let beside = match () {
            () if f == span.high => k + 1,
            () if f == span.low => k.wrapping_sub(1),
            () => return k,
        };
        let holds = |k: usize| self.spans.get(k).is_some_and(|span| span.holds(segment));
        if !holds(k) && holds(beside) { beside } else { k }
    }

    /// The numbers of all spans, row by row.
    #[inline]
    pub(crate) fn rows(&self) -> &SpanRows<T> {
        &self.rows
    }

    /// Whether there are steps, or spans so narrow that rounding shifts their edges by much of their width.
    #[inline]
    pub fn has_steps(&self) -> bool {
        self.has_steps
    }

    /// Whether the effect of rounding on values depends on those at the vertices of frusta: if spans are narrow, or
    /// values of a field, which has this range, are far outside of that of the knots.
    #[inline]
    pub fn needs_sizes(&self, values: Option<[f64; 2]>) -> bool {
        let [low, high] = self.range;
        let is_far = |value: f64| ((value - low) / (high - low)).abs() > OUTSIDE;
        self.has_steps || values.is_some_and(|ends| ends.into_iter().any(is_far))
    }

    /// The span of value `f`: the upper one when f lies on a knot.
    #[inline]
    pub fn find(&self, f: T) -> usize {
        partition_point(&self.spans, |s| s.low <= f).max(1) - 1
    }
}

/// The numbers of all spans, a row for each number, for look-up in vectors. Rows of up to 32 spans are filled up to 32.
#[derive(Debug, Clone)]
pub(crate) struct SpanRows<T> {
    pub low: Vec<T>,
    pub high: Vec<T>,
    /// Anchor, extinction, its slope, steepest, colour, its slopes, brightest.
    pub numbers: [Vec<T>; 11],
    /// The first knot.
    pub origin: T,
    /// The numbers of steps and narrow spans below a span, and up to it.
    pub steps: [Vec<T>; 2],
    /// For buckets of equal width from the first to the last knot, and one behind them: the number of knots up to the
    /// start of each.
    pub first: Vec<u32>,
}

/// Spans in a table that fits into registers.
const MIN_IN_TABLE: usize = 32;
/// Buckets of values.
const BUCKETS: usize = 64;

impl<T: Real> SpanRows<T> {
    fn new(spans: &[Span<T>], knots: &[T]) -> Self {
        let row = |of: &dyn Fn(&Span<T>) -> T| {
            let mut row: Vec<T> = spans.iter().map(of).collect();
            row.resize(spans.len().max(MIN_IN_TABLE), T::zero());
            row
        };
        let origin = knots[0];
        let start = |bucket: usize| origin + T::of(bucket as f64 / BUCKETS as f64);
        let mut below = vec![T::zero()];
        for span in spans {
            below.push(below[below.len() - 1] + if span.is_narrow() { T::one() } else { T::zero() });
        }
        let steps = [&below[..spans.len()], &below[1..]].map_inline(|counts: &[T]| {
            let mut row = counts.to_vec();
            row.resize(spans.len().max(MIN_IN_TABLE), T::zero());
            row
        });
        SpanRows {
            origin,
            steps,
            low: row(&|s| s.low),
            high: row(&|s| s.high),
            numbers: [
                row(&|s| s.anchor),
                row(&|s| s.extinction),
                row(&|s| s.extinction_slope),
                row(&|s| s.steepest),
                row(&|s| s.color[0]),
                row(&|s| s.color[1]),
                row(&|s| s.color[2]),
                row(&|s| s.color_slope[0]),
                row(&|s| s.color_slope[1]),
                row(&|s| s.color_slope[2]),
                row(&|s| s.brightest),
            ],
            first: (0..=BUCKETS).map(|b| knots.partition_point(|knot| *knot <= start(b)) as u32).collect(),
        }
    }
}

/// The value that normalises to 0: values near it have the most digits. The first knot, or the one beside the narrowest
/// span if that is narrow.
fn origin(knots: &[KernelKnot], width: f64) -> f64 {
    let span_width = |pair: &[KernelKnot]| pair[1].value - pair[0].value;
    let narrowest = knots.windows(2).min_by(|a, b| span_width(a).total_cmp(&span_width(b)));
    match narrowest.filter(|pair| span_width(pair) < NARROW * width) {
        Some([a, b]) if b.value.abs() < a.value.abs() => b.value,
        Some([a, _]) => a.value,
        _ => knots[0].value,
    }
}

/// Fraction of the range of knots below which a span is a spike or a step instead of a part of a ramp.
const NARROW: f64 = 1e-3;
/// A normalised value that is far outside of those of the knots, which are at most 1 in size.
const OUTSIDE: f64 = 4.0;
/// Spans narrower than this many last digits are steps too.
const STEP: f64 = 2000.0;
/// The steps between `spans`: values at which extinction or colour changes within rounding's reach.
#[inline]
fn steps<T: Real>(spans: &[Span<T>]) -> Vec<Step<T>> {
    let mut steps = Vec::new();
    for (k, span) in spans.iter().enumerate() {
        if span.low == span.high {
            let below = spans[..k].last().map_or(span.extinction, |s| s.extinction(s.high));
            let above = spans.get(k + 1).map_or(span.extinction, |s| s.extinction(s.low));
            let extinction = below.max(above).max(span.extinction);
            steps.push(Step { value: span.low, extinction, slope: T::zero() });
        } else if span.high - span.low < T::of(STEP * T::ROUNDING) {
            let (extinction, slope) = (T::zero(), span.extinction_slope.abs());
            steps.extend([span.low, span.high].map_inline(|value| Step { value, extinction, slope }));
        }
    }
    steps
}

#[inline]
fn span<T: Real>(low: T, high: T, anchor: T, a: &KernelKnot, b: &KernelKnot, width: T) -> Span<T> {
    let slope = |a: f64, b: f64| T::of(b - a) / width;
    let color_slope = [0, 1, 2].map_inline(|k| slope(a.color[k], b.color[k]));
    Span {
        low,
        high,
        anchor,
        extinction: T::of(a.extinction),
        extinction_slope: slope(a.extinction, b.extinction),
        color: a.color.map_inline(T::of),
        color_slope,
        steepest: color_slope.iter().fold(T::zero(), |most, s| most.max(s.abs())),
        brightest: T::of(a.color.iter().chain(&b.color).fold(0.0, |most, c| most.max(*c))),
        is_clear: a.extinction == 0.0 && b.extinction == 0.0,
    }
}

#[cfg(test)]
mod tests;
