//! Empty-space skipping: the values of a transfer function that are clear.
//!
//! A value along a ray is a convex mean of values at vertices. If all of these lie in one clear part of the transfer
//! function, by more than rounding, a frustum adds no light, moves no cut and is near no step: rays skip it without
//! reading, and the picture is equal to the bit. The same holds for a frustum of one value that is clear although it
//! lies on a knot, such as the zeros of cloud water.

use super::transfer::Spans;
use icoray_grid::array::MapInline;
use icoray_grid::real::Real;

/// The widest ranges of normalised values in which a transfer function is clear, at most `most`, among those that
/// overlap the field's range `within`. Each is narrowed by more than the rounding of means of the field's values.
#[inline]
pub fn clear_ranges<T: Real>(spans: &Spans<T>, within: [f64; 2], most: usize) -> Vec<[f64; 2]> {
    let largest = within[0].abs().max(within[1].abs()).min(T::LARGEST);
    let margin = 64.0 * T::ROUNDING * (1.0 + largest);
    let mut ranges: Vec<[f64; 2]> = Vec::new();
    for span in spans.all().iter().filter(|span| span.is_clear) {
        let (low, high) = (span.low.wide(), span.high.wide());
        match ranges.last_mut() {
            Some(last) if last[1] == low => last[1] = high,
            _ => ranges.push([low, high]),
        }
    }
    let narrow = |[low, high]: [f64; 2]| [low + margin, high - margin];
    let held = |[low, high]: &[f64; 2]| low.max(within[0]) < high.min(within[1]);
    let mut ranges: Vec<_> = ranges.into_iter().map(narrow).filter(held).collect();
    let width = |[low, high]: &[f64; 2]| high.min(within[1]) - low.max(within[0]);
    ranges.sort_by(|a, b| width(b).total_cmp(&width(a)));
    ranges.truncate(most);
    ranges
}

/// Normalised values that are clear although values beside them are not: knots without extinction inside the field's
/// range `within`, at most `most`. Two knots of one value make a step; a constant on it counts as above.
#[inline]
pub fn clear_knots<T: Real>(spans: &Spans<T>, within: [f64; 2], most: usize) -> Vec<T> {
    let (all, [low, high]) = (spans.all(), within.map_inline(T::of));
    let mut knots: Vec<T> = Vec::new();
    for pair in all.windows(2) {
        let value = pair[1].low;
        let is_inside = value >= low && value <= high;
        let is_amid = pair[0].is_clear && pair[1].is_clear;
        let is_clear = spans.span(spans.find(value)).extinction(value) == T::zero();
        if is_inside && !is_amid && is_clear && knots.last() != Some(&value) {
            knots.push(value);
        }
    }
    knots.truncate(most);
    knots
}
