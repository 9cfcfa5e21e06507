//! The frusta of a packet, a piece of each in a turn.

use super::gap::Crossing;
use super::integral::{Integral, LARGEST_EPS, Light, Outcome};
use super::lanes::{Lanes, lanes_of};
use super::part::{Part, all};
use super::read::{LARGEST, Vertices, Way};
use super::{Packet, mask};
use crate::column::{Chord, Flow};
use crate::lit::FrustumInterpolant;
use crate::single_volume::SingleVolumeTracer;
use fearless_simd::prelude::*;
use icoray_simd::{Floats, Machine, Mask, Numbers};

/// The pieces of this turn: each lane's part of its frustum inside one span of the transfer function.
struct Pieces<V: Machine> {
    part: Part<V>,
    span: Numbers<V>,
    /// Lanes whose frusta go on behind their pieces.
    more: u32,
}

impl<V: Machine, const N: usize> Packet<'_, '_, V, N> {
    /// Integrates a piece of the frusta of the lanes `inside`, and sets [`Packet::mid`] to those of which more is left.
    #[inline(always)]
    pub(super) fn frusta(&mut self, crossing: &Crossing<V>, inside: u32) {
        let simd = self.simd;
        let new = inside & !self.mid;
        self.counts.frusta += u64::from(new.count_ones());
        let mut part = self.lanes.rest;
        let mut scalar = 0;
        let mut active = inside;
        if new != 0 {
            let way = self.lanes.way(crossing);
            let vertices = self.tables.source.read(simd, &self.lanes, new);
            let [f0, f1, kappa] = self.tables.source.normalised(simd, &vertices, &way);
            let read = Part { f0, f1, kappa, eps: way.eps, length: crossing.length };
            let is_new = mask::<V>(simd, new);
            part = read.over(is_new, part);
            self.lanes.is_monotone = self.lanes.is_monotone & !is_new;
            let (void, beyond) = self.unusual(&vertices, &part, new);
            self.counts.void_frusta += u64::from(void.count_ones());
            active &= !void;
            scalar = beyond;
        }
        self.mid = 0;
        if !self.tracer.integrates {
            return;
        }
        let pieces = self.pieces(part, active, &mut scalar);
        let part = pieces.part;
        let medium = self.tables.spans.medium(simd, pieces.span);
        let integral = Integral::new(simd, &part, &medium);
        let mut outcome = integral.thin(self.color_tolerance);
        let mut far = (!outcome.is_near).to_bitmask() as u32 & active & !scalar;
        if far != 0 {
            outcome = Outcome::over(outcome, mask::<V>(simd, !far), integral.gauss(self.color_tolerance));
            far = (!outcome.is_near).to_bitmask() as u32 & active & !scalar;
        }
        let mut light = integral.light(&outcome, part.reach());
        light.variance = medium.is_clear(simd, &part).select(all(simd, 0.0), light.variance);
        self.lanes.add(simd, mask::<V>(simd, active & !scalar & !far), &light);
        self.mid = pieces.more & active & !scalar;
        if far != 0 {
            self.scalar_pieces(far, &part, pieces.span);
        }
        if scalar != 0 {
            self.scalar_frusta(scalar, crossing);
        }
        self.end(active);
    }

    /// Ends the rays of `active` lanes through which no more light comes than may be left out.
    #[inline(always)]
    fn end(&mut self, active: u32) {
        // The transmittance of a piece that ended early is known to the last digit only.
        let rest = self.min_transmittance * 1.001 + f32::EPSILON;
        let through = all(self.simd, 1.0) - self.lanes.alpha;
        let ends = through.simd_le(rest).to_bitmask() as u32 & active & !self.ended;
        if ends != 0 {
            let left_out = through * self.tracer.budget.brightest as f32;
            self.lanes.error = mask::<V>(self.simd, ends).select(self.lanes.error + left_out, self.lanes.error);
            self.ended |= ends;
        }
    }

    /// Lanes of `new` frusta in which a value is missing, and those that scalar code must integrate.
    #[inline(always)]
    fn unusual(&self, vertices: &Vertices<V>, part: &Part<V>, new: u32) -> (u32, u32) {
        let source = &self.tables.source;
        let size = part.f0.abs() + part.f1.abs() + part.kappa.abs();
        let is_usual = size.simd_le(LARGEST) & part.eps.abs().simd_lt(LARGEST_EPS);
        let unusual = (!is_usual).to_bitmask() as u32 & new;
        let mut void = source.missing(self.simd, vertices).map_or(0, |missing| missing.to_bitmask() as u32 & new);
        if unusual != 0 {
            void |= source.not_finite(self.simd, vertices).to_bitmask() as u32 & unusual;
        }
        (void, unusual & !void)
    }

    /// The piece of each `active` lane's part: all of it where its values stay in one span, else up to where they turn
    /// or meet the next knot. Lanes of frusta that only scalar code can cut are added to `scalar`.
    #[inline(always)]
    fn pieces(&mut self, part: Part<V>, active: u32, scalar: &mut u32) -> Pieces<V> {
        let simd = self.simd;
        let spans = &self.tables.spans;
        let [least, most] = part.within();
        let span = spans.find(simd, least);
        let is_whole = if spans.has_steps {
            let margin = part.reach() * 8.0;
            let is_above = spans.low(simd, span).simd_le(least - margin);
            is_above & (most + margin).simd_le(spans.high(simd, span))
        } else {
            most.simd_le(spans.high(simd, span))
        };
        let cut = (!is_whole).to_bitmask() as u32 & active & !*scalar;
        if cut == 0 {
            return Pieces { part, span, more: 0 };
        }
        if spans.has_steps {
            *scalar |= cut;
            return Pieces { part, span, more: 0 };
        }
        self.cut(part, span, cut)
    }

    /// The pieces of the lanes of `cut` up to where their parts turn or meet the next knot.
    #[inline(always)]
    fn cut(&mut self, part: Part<V>, span: Numbers<V>, cut: u32) -> Pieces<V> {
        let simd = self.simd;
        let spans = &self.tables.spans;
        let (one, is_cut) = (all(simd, 1.0), mask::<V>(simd, cut));
        let extremum = part.extremum(simd);
        let turns = extremum.exists & !self.lanes.is_monotone;
        let (u, f) = (turns.select(extremum.place.0, one), turns.select(extremum.place.1, part.f1));
        let front = part.between((all(simd, 0.0), part.f0), (u, f));
        let is_rising = part.f0.simd_le(f);
        let start = spans.find(simd, part.f0);
        // A falling part that begins on a knot lies below it.
        let is_below = !is_rising & part.f0.simd_eq(spans.low(simd, start));
        let start = start - is_below.select(super::medium::number(simd, 1), super::medium::number(simd, 0));
        let knot = is_rising.select(spans.high(simd, start), spans.low(simd, start));
        let crosses = is_rising.select(knot.simd_lt(f), f.simd_lt(knot));
        let place = (crosses.select(u * front.solve(simd, knot), u), crosses.select(knot, f));
        let piece = part.between((all(simd, 0.0), part.f0), place);
        let rest = part.between(place, (one, part.f1));
        let goes_on = is_cut & (crosses | turns);
        self.lanes.rest = rest.over(goes_on, self.lanes.rest);
        // What follows a part that does not turn, or is cut where it turns, is monotone.
        self.lanes.is_monotone = self.lanes.is_monotone | (is_cut & (!turns | !crosses));
        Pieces {
            part: piece.over(is_cut, part),
            span: is_cut.select(start, span),
            more: goes_on.to_bitmask() as u32,
        }
    }

    /// Integrates the pieces of lanes in scalar code.
    #[inline(never)]
    fn scalar_pieces(&mut self, lanes: u32, part: &Part<V>, span: Numbers<V>) {
        for lane in lanes_of(lanes) {
            let Some(mut ray) = self.ray(lane) else { continue };
            let (segment, span) = (part.segment(lane), span[lane] as usize);
            self.counts.scalar_pieces += 1;
            ray.unlit_piece(&segment, span);
            self.lanes.put_light(lane, &ray.light);
        }
    }

    /// Integrates whole frusta of lanes in scalar code.
    #[inline(never)]
    fn scalar_frusta(&mut self, lanes: u32, crossing: &Crossing<V>) {
        for lane in lanes_of(lanes) {
            let Some(mut ray) = self.ray(lane) else { continue };
            let interpolant = self.lanes.interpolant(lane, self.tracer, crossing);
            self.counts.scalar_pieces += 1;
            if ray.frustum(&interpolant, crossing.length[lane]) == Flow::Stop {
                self.ended |= 1 << lane;
            }
            self.counts.void_frusta += ray.counts.void_frusta;
            self.lanes.put_light(lane, &ray.light);
        }
    }
}

impl<V: Machine> Lanes<V> {
    /// The ways of the lanes through their gaps.
    #[inline(always)]
    fn way(&self, crossing: &Crossing<V>) -> Way<V> {
        Way {
            weights: self.weights,
            place: [self.place, crossing.place],
            tau: [self.tau, crossing.tau],
            eps: crossing.eps,
        }
    }

    /// Value, and gradient where `N` is 4, along the frustum of a lane, in scalar code.
    fn interpolant<const N: usize>(
        &self,
        lane: usize,
        tracer: &SingleVolumeTracer<'_, f32>,
        crossing: &Crossing<V>,
    ) -> FrustumInterpolant<f32, N> {
        let weights = self.weights.map(|end| end.map(|row| row[lane]));
        let upper = self.gap[lane] as usize;
        let chord = |layer: usize| {
            let vertex = |k: usize| {
                let cell = self.cells[k][lane];
                tracer.vertex::<N>(cell, tracer.samples.get(tracer.samples.base(cell), layer), layer)
            };
            Chord::over([vertex(0), vertex(1), vertex(2)], &weights)
        };
        let (low, high) = (chord(upper - 1), chord(upper));
        let [from, to] = [self.place[lane], crossing.place[lane]].map(|place| low.mix(high, place));
        from.interpolant(&to, [self.tau[lane], crossing.tau[lane]], crossing.eps[lane])
    }

    /// Puts light behind that of the lanes of `mask`.
    #[inline(always)]
    fn add(&mut self, simd: V, mask: Mask<V>, light: &Light<V>) {
        let through = all(simd, 1.0) - self.alpha;
        let behind = |own: Floats<V>, new: Floats<V>| mask.select(through.mul_add(new, own), own);
        for k in 0..3 {
            self.color[k] = behind(self.color[k], light.color[k]);
        }
        self.alpha = behind(self.alpha, light.alpha);
        self.error = behind(self.error, light.error);
        // The sum is rounded to its own last digit.
        let off = self.alpha * (0.25 * f32::EPSILON);
        let variance = through * through * light.variance + off * off;
        self.variance = mask.select(self.variance + variance, self.variance);
    }
}
