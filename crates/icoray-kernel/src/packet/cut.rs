//! Cuts parts of frusta into pieces that each stay in one span of a transfer function.

use super::mask;
use super::medium::{Found, SpanTables, number};
use super::part::{Part, all};
use fearless_simd::prelude::*;
use icoray_simd::{Floats, Machine, Mask, Numbers};

/// The pieces of this turn: each lane's part of its frustum inside one span of the transfer function.
pub(super) struct Pieces<V: Machine> {
    pub part: Part<V>,
    pub span: Numbers<V>,
    /// End of each piece in its part.
    pub upto: Floats<V>,
    /// Lanes whose frusta continue behind their pieces, and the remaining parts.
    pub more: u32,
    pub rest: Part<V>,
    /// Lanes in which the remaining part is monotone.
    pub is_monotone: Mask<V>,
}

impl<V: Machine> Pieces<V> {
    /// Takes only a `fraction` of the pieces of the lanes `cut`; the flag that their parts are monotone then applies to
    /// the remaining parts.
    #[inline(always)]
    pub fn shorten(&mut self, simd: V, part: &Part<V>, fraction: Floats<V>, (cut, is_monotone): (u32, Mask<V>)) {
        let is_cut = mask::<V>(simd, cut);
        let piece = self.part;
        let f = piece.value(simd, fraction);
        let front = piece.between((all(simd, 0.0), piece.f0), (fraction, f));
        let upto = self.upto * fraction;
        let rest = part.between((upto, f), (all(simd, 1.0), part.f1));
        self.part = front.over(is_cut, piece);
        self.rest = rest.over(is_cut, self.rest);
        self.upto = is_cut.select(upto, self.upto);
        self.is_monotone = is_cut.select(is_monotone, self.is_monotone);
        self.more |= cut;
    }
}

impl<V: Machine> Pieces<V> {
    /// Ends the pieces of these lanes at `upto` of their parts, for any previous end.
    #[inline(always)]
    pub fn end_at(&mut self, simd: V, part: &Part<V>, upto: Floats<V>, (lanes, is_monotone): (Mask<V>, Mask<V>)) {
        let place = (upto, part.value(simd, upto));
        let front = part.between((all(simd, 0.0), part.f0), place);
        let rest = part.between(place, (all(simd, 1.0), part.f1));
        self.part = front.over(lanes, self.part);
        self.rest = rest.over(lanes, self.rest);
        self.upto = lanes.select(upto, self.upto);
        self.is_monotone = lanes.select(is_monotone, self.is_monotone);
    }
}

/// Cuts parts of frusta at the knots of a transfer function.
pub(super) struct Cutter<'c, 't, V: Machine> {
    pub simd: V,
    pub spans: &'c SpanTables<'t>,
    /// Lanes with monotone parts.
    pub is_monotone: Mask<V>,
    /// The largest magnitude of values at the vertices of their frusta.
    pub size: Floats<V>,
}

impl<V: Machine> Cutter<'_, '_, V> {
    /// The piece of each `active` lane's part: the whole part if its values stay in one span, else up to the extremum
    /// or the next knot. Adds lanes of frusta that only scalar code can cut, at steps, to `scalar`; these are `new`, as
    /// the pieces of a frustum that is cut here may come near no step. Spans are searched from `near`.
    #[inline(always)]
    pub fn pieces(&self, part: Part<V>, near: Numbers<V>, [active, new]: [u32; 2], scalar: &mut u32) -> Pieces<V> {
        let Cutter { simd, spans, .. } = *self;
        let [mut least, mut most] = part.within();
        let Found { span, low, high } = spans.find(simd, least, near, mask::<V>(simd, active));
        if spans.has_steps {
            let margin = mask::<V>(simd, new).select(part.reach(self.size) * 8.0, all(simd, 0.0));
            (least, most) = (least - margin, most + margin);
        }
        let is_whole = low.simd_le(least) & most.simd_le(high);
        let mut cut = (!is_whole).to_bitmask() as u32 & active & !*scalar;
        if spans.has_steps && cut & new != 0 {
            let steps = spans.have_steps(simd, [least, most], span, mask::<V>(simd, cut & new));
            *scalar |= steps.to_bitmask() as u32;
            cut &= !*scalar;
        }
        if cut == 0 { self.whole(part, span) } else { self.cut(part, span, cut) }
    }

    /// Parts that stay in their spans.
    #[inline(always)]
    pub fn whole(&self, part: Part<V>, span: Numbers<V>) -> Pieces<V> {
        Pieces { part, span, upto: all(self.simd, 1.0), more: 0, rest: part, is_monotone: self.is_monotone }
    }

    /// The pieces of the lanes of `cut` up to the extremum of their parts or the next knot.
    #[inline(always)]
    fn cut(&self, part: Part<V>, span: Numbers<V>, cut: u32) -> Pieces<V> {
        let Cutter { simd, spans, is_monotone, .. } = *self;
        let (one, is_cut) = (all(simd, 1.0), mask::<V>(simd, cut));
        let extremum = part.extremum(simd);
        let turns = extremum.exists & !is_monotone;
        let (u, f) = (turns.select(extremum.place.0, one), turns.select(extremum.place.1, part.f1));
        let front = part.between((all(simd, 0.0), part.f0), (u, f));
        let is_rising = part.f0.simd_le(f);
        let start = spans.find(simd, part.f0, span, is_cut);
        // A falling part that begins on a knot lies below it.
        let is_below = is_cut & !is_rising & part.f0.simd_eq(start.low);
        let start = if is_below.any_true() {
            let span = start.span - is_below.select(number(simd, 1), number(simd, 0));
            spans.at(simd, span)
        } else {
            start
        };
        let knot = is_rising.select(start.high, start.low);
        let start = start.span;
        let crosses = is_rising.select(knot.simd_lt(f), f.simd_lt(knot));
        let place = (crosses.select(u * front.solve(simd, knot), u), crosses.select(knot, f));
        let piece = part.between((all(simd, 0.0), part.f0), place);
        let rest = part.between(place, (one, part.f1));
        let goes_on = is_cut & (crosses | turns);
        Pieces {
            part: piece.over(is_cut, part),
            span: is_cut.select(start, span),
            upto: goes_on.select(place.0, one),
            more: goes_on.to_bitmask() as u32,
            rest,
            // The remainder of a part without extremum, or cut at it, is monotone.
            is_monotone: is_monotone | !turns | !crosses,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transfer::{KernelKnot, Spans};
    use fearless_simd::Level;

    /// The transfer function has a step at 0 and bends at -0.8 and 0.2. Each part is in the first lane, of a frustum that
    /// is new or not: the lanes that only scalar code can cut, and those with a remaining part.
    fn cut<V: Machine>(simd: V) {
        let knot = |value: f64, extinction: f64| KernelKnot { value, color: [0.5; 3], extinction };
        let spans = Spans::new(&[knot(-0.8, 1.0), knot(0.0, 2.0), knot(0.0, 9.0), knot(0.2, 0.0)]);
        let spans = SpanTables::new(&spans).expect("a short table");
        let no = <Mask<V> as SimdMask<V>>::splat(simd, false);
        let cutter = Cutter { simd, spans: &spans, is_monotone: no, size: all(simd, 1.0) };
        let outcome = |[f0, f1, kappa]: [f32; 3], new: u32| {
            let [f0, f1, kappa, eps] = [f0, f1, kappa, -0.2].map(|x| all(simd, x));
            let part = Part { f0, f1, kappa, eps, length: all(simd, 1.0) };
            let mut scalar = 0;
            let pieces = cutter.pieces(part, number(simd, 1), [1, new], &mut scalar);
            (scalar, pieces.more)
        };
        assert_eq!(outcome([-0.2, 0.1, 0.0], 1), (1, 0), "across the step");
        assert_eq!(outcome([-0.9, -0.1, 0.0], 1), (0, 1), "across a bend below the step");
        assert_eq!(outcome([0.1, 0.3, 0.0], 1), (0, 1), "across a bend above the step");
        assert_eq!(outcome([-0.7, -0.1, 0.0], 1), (0, 0), "in one span");
        // In a span below the step, which its bounds do not show. The rest of a frustum has looser bounds than the
        // frustum: if scalar code took it, its first pieces would count twice.
        assert_eq!(outcome([-0.2, -0.3, 0.5], 1), (1, 0), "the bounds cross the step");
        assert_eq!(outcome([-0.2, -0.3, 0.5], 0).0, 0, "the bounds of a rest cross the step");
    }

    #[test]
    fn only_frusta_near_steps_are_left_to_scalar_code() {
        match Level::new() {
            #[cfg(target_arch = "x86_64")]
            Level::Avx512(simd) => cut(simd),
            #[cfg(target_arch = "x86_64")]
            Level::Avx2(simd) => cut(simd),
            #[cfg(target_arch = "aarch64")]
            Level::Neon(simd) => cut(simd),
            // There are no packets.
            _ => {}
        }
    }
}
