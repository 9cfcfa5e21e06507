//! Traverses the layers inside one column: Algorithm 2's top and bottom faces.
//!
//! A ray crosses each facet of a column once at most, and the facets do not cross each other inside it. So the next one
//! on its way is the layer above or the layer below, whichever is met first.

use super::Levels;
use super::wedge::{Facet, FacetSide, Wedge};
use crate::column::Flow;

/// The visitor of [`cross`].
pub(crate) trait ColumnVisitor {
    /// Passes the gap between two layers from place to place of the column.
    fn gap(&mut self, wedge: &Wedge, facets: [&Facet; 2], ends: [(f64, FacetSide); 2]) -> Flow;

    /// Passes a layer at the fraction `u` of the column, upwards or downwards.
    fn layer(&mut self, _wedge: &Wedge, _facet: &Facet, _u: f64, _rises: bool) -> Flow {
        Flow::On
    }

    /// Is below the innermost layer from `u` on.
    fn core(&mut self, wedge: &Wedge, lowest: &Facet, u: f64) -> Flow;
}

/// Visits the gaps and layers that the ray passes in a column, in order. The gap that contains its entry (k lies between
/// the layers k - 1 and k) is searched from `hint` on. Returns the gap at the ray's end in the column.
#[inline(always)]
pub(crate) fn cross(wedge: &Wedge, levels: &Levels, hint: usize, visitor: &mut impl ColumnVisitor) -> (usize, Flow) {
    let facet = |layer: usize| Facet::new(wedge, levels, layer);
    let top = levels.count();
    let mut gap = gap_at(hint, top, |layer| facet(layer).is_below_entry());
    let mut lower = gap.checked_sub(1).map(facet);
    let mut upper = (gap < top).then(|| facet(gap));
    let (mut a, mut from) = (0.0, FacetSide::Between);
    loop {
        let up = upper.and_then(|facet| facet.up());
        let down = lower.and_then(|facet| facet.down());
        let rises = up.is_some_and(|up| down.is_none_or(|down| up <= down));
        let crossing = if rises { up } else { down };
        let b = crossing.map_or(1.0, |u| u.max(a));
        let to = match crossing {
            Some(_) if rises => FacetSide::Upper,
            Some(_) => FacetSide::Lower,
            None => FacetSide::Between,
        };
        let flow = match (&lower, &upper) {
            (Some(lower), Some(upper)) => visitor.gap(wedge, [lower, upper], [(a, from), (b, to)]),
            (None, Some(lowest)) => visitor.core(wedge, lowest, a),
            (_, None) => Flow::On,
        };
        if flow == Flow::Stop || crossing.is_none() {
            return (gap, flow);
        }
        let met = if rises { upper } else { lower };
        if met.is_some_and(|met| visitor.layer(wedge, &met, b, rises) == Flow::Stop) {
            return (gap, Flow::Stop);
        }
        if rises {
            gap += 1;
            (lower, upper) = (upper, (gap < top).then(|| facet(gap)));
        } else {
            gap -= 1;
            (upper, lower) = (lower, gap.checked_sub(1).map(facet));
        }
        (a, from) = (b, if rises { FacetSide::Lower } else { FacetSide::Upper });
    }
}

/// The number of layers below the point at which the ray enters a column, searched from `hint` on.
#[inline]
fn gap_at(hint: usize, layers: usize, is_below: impl Fn(usize) -> bool) -> usize {
    let hint = hint.min(layers);
    if (hint == 0 || is_below(hint - 1)) && (hint == layers || !is_below(hint)) {
        return hint;
    }
    let (mut low, mut high) = (0, layers);
    while low < high {
        let middle = (low + high) / 2;
        if is_below(middle) { low = middle + 1 } else { high = middle }
    }
    low
}
