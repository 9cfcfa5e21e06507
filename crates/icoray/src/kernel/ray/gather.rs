//! Frusta of one ray are gathered and integrated together; what can only be done one after the other is done in the ray's order.

use super::{Course, Flow, Ray};
use crate::kernel::piece::SMALL_EPS;
use crate::kernel::piece::lanes::ROOM;
use crate::kernel::real::Real;
use crate::kernel::sample::Sample;
use crate::kernel::segment::Segment;

/// How many frusta are waited for where it is not known how dense they are.
pub(super) const FIRST: usize = 16;

impl<T: Real, S: Sample, const N: usize> Ray<'_, '_, T, S, N> {
    /// Keeps a frustum for later.
    #[inline(always)]
    pub(super) fn gather(&mut self, segment: &Segment<T>) -> Flow {
        if let Some(k) = self.span {
            let span = self.caster.spans.span(k);
            if span.holds(segment) & (segment.eps.abs() < T::of(SMALL_EPS)) & !segment.is_constant() {
                self.batch.push(segment, span, k, true);
                return if self.batch.count() < self.room { Flow::On } else { self.settle() };
            }
        }
        self.gather_elsewhere(segment)
    }

    /// The same of one that begins or ends in another span than where the ray was.
    #[inline(never)]
    fn gather_elsewhere(&mut self, segment: &Segment<T>) -> Flow {
        let spans = self.caster.spans;
        let Some(k) = self.enter(segment) else {
            // Counted in its turn.
            self.counts.void_frusta -= 1;
            self.batch.push(segment, spans.span(0), 0, false);
            return if self.batch.count() < self.room { Flow::On } else { self.settle() };
        };
        let (span, is_small) = (spans.span(k), segment.eps.abs() < T::of(SMALL_EPS));
        let is_whole = span.holds(segment) & is_small & !span.is_clear_in(segment);
        self.batch.push(segment, spans.span(k), k, is_whole);
        self.span = Some(if is_whole { k } else { spans.follow(k, segment.f1) });
        if self.batch.count() < self.room { Flow::On } else { self.settle() }
    }

    /// Adds the light of all frusta that wait.
    #[inline(never)]
    pub(super) fn settle(&mut self) -> Flow {
        let (Some(level), count) = (self.caster.level, self.batch.count()) else { return Flow::On };
        if count == 0 {
            return Flow::On;
        }
        let span = self.span;
        self.batch.integrate(level, self.share);
        let before = T::one() - self.light.absorbed;
        let mut flow = Flow::On;
        for i in 0..count {
            let (segment, k) = self.batch.piece(i);
            flow = match self.batch.light(i) {
                Some(light) => {
                    self.add(&light);
                    self.passed(&segment)
                }
                None => self.odd(&segment, k),
            };
            if flow == Flow::Stop {
                self.counts.frusta -= (count - i - 1) as u64;
                break;
            }
        }
        self.batch.clear();
        self.span = span;
        self.room = self.next_room(before);
        flow
    }

    /// A frustum that is not done by [`super::super::piece::lanes`].
    #[inline(never)]
    fn odd(&mut self, segment: &Segment<T>, k: usize) -> Flow {
        if segment.is_void() {
            self.counts.void_frusta += 1;
            return Flow::On;
        }
        let all = |value: T| [value; N];
        let course = Course {
            from: all(segment.f0),
            to: all(segment.f1),
            kappa: all(segment.kappa),
            eps: segment.eps,
        };
        self.whole(segment, k, &course)
    }

    /// How many frusta to wait for behind those that have brought transmittance down from `before`: fewer where
    /// the ray soon ends.
    fn next_room(&self, before: T) -> usize {
        let through = T::one() - self.light.absorbed;
        if through * through < self.rest * before { FIRST / 2 } else { ROOM }
    }
}
