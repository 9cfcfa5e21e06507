//! What rounding does to the places where a segment is cut at knots.
//!
//! A segment's ends are off by rounding, which shifts all cuts alike; each cut is off by a last digit of its own and of
//! its knot beside. Both move a little of the segment from one side of a knot to the other. It is added to the light's variance.

use super::piece::Light;
use super::real::Real;
use super::segment::Segment;
use super::transfer::Span;
use crate::array::MapInline;

/// Extinction and colour at a value.
#[derive(Debug, Clone, Copy)]
pub(super) struct Medium<T> {
    extinction: T,
    color: [T; 3],
}

impl<T: Real> Medium<T> {
    /// Of `span` at value `f`.
    #[inline]
    pub fn at(span: &Span<T>, f: T) -> Self {
        Medium { extinction: span.extinction(f), color: span.color(f) }
    }

    /// The largest difference of a channel between light that both emit.
    #[inline]
    fn paints_apart(&self, other: &Self) -> T {
        let [r, g, b] = [0, 1, 2].map_inline(|k| (self.color[k] - other.color[k]).abs());
        self.extinction.min(other.extinction) * r.max(g).max(b)
    }
}

/// A piece behind a cut.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cut<T> {
    /// Value at the cut.
    pub value: T,
    /// Its length, planet radii.
    pub length: T,
    /// Its medium at its middle.
    pub mean: Medium<T>,
    /// Change of colour over it.
    pub change: T,
    /// Whether its span is narrow.
    pub is_narrow: bool,
}

/// The cuts of one segment.
#[derive(Debug)]
pub(super) struct Doubt<T> {
    length: T,
    /// Values at the ends, and how far rounding may have put them.
    ends: [T; 2],
    reach: T,
    start: Medium<T>,
    /// The piece before the cut: its medium and length.
    last: Option<(Medium<T>, T)>,
}

impl<T: Real> Doubt<T> {
    /// For a segment that starts in `start`.
    #[inline]
    pub fn new(segment: &Segment<T>, start: Medium<T>) -> Self {
        let ends = [segment.f0, segment.f1];
        Doubt { length: segment.length, ends, reach: segment.reach(), start, last: None }
    }

    #[inline]
    fn rise(&self) -> T {
        (self.ends[1] - self.ends[0]).abs()
    }

    /// A cut, told after the piece behind it was added to `light`, of which `absorbed` had been absorbed before.
    #[inline]
    pub fn cut(&mut self, light: &mut Light<T>, absorbed: T, piece: Cut<T>) {
        let unit = T::of(2.0 * T::ROUNDING);
        let knot = unit * self.length * piece.value.abs() / (unit + self.rise());
        let off = unit * piece.length + knot;
        if let Some((last, length)) = self.last {
            // A cut is found from the cut before: the shorter piece beside it says how far it may be off.
            let off = unit * length.min(piece.length) + knot;
            self.moved(light, absorbed, off, [&last, &piece.mean]);
        }
        // A piece that is longer or shorter than it should be has its colours elsewhere; one in a narrow span is so by
        // as much as the segment is too steep or too flat there.
        let stretch = if piece.is_narrow { self.stretch(piece.value) } else { T::zero() };
        let part = (stretch + off / piece.length).min(T::one());
        let colors = (light.absorbed - absorbed) * piece.change * part;
        let depth =
            ((T::one() - light.absorbed) * piece.mean.extinction * piece.length * stretch).min(T::one());
        light.variance = light.variance + colors * colors + depth * depth;
        self.last = Some((piece.mean, piece.length));
    }

    /// By which part a narrow piece at `value` may be longer or shorter: most near an end at which f turns, where it
    /// runs flat.
    #[inline]
    fn stretch(&self, value: T) -> T {
        let near = (value - self.ends[0]).abs().min((value - self.ends[1]).abs());
        T::of(2.0) * self.reach / (self.reach + near)
    }

    /// The segment's end, in the medium `end`.
    #[inline]
    pub fn shift(&self, light: &mut Light<T>, end: &Medium<T>) {
        let shift = self.length * self.reach / (self.reach + self.rise());
        self.moved(light, light.absorbed, shift, [&self.start, end]);
    }

    /// `length` of the segment lies in the one medium rather than in the other. Where extinction rises, what is moved is
    /// hidden by the denser piece behind.
    #[inline]
    fn moved(&self, light: &mut Light<T>, absorbed: T, length: T, [before, behind]: [&Medium<T>; 2]) {
        let rises = behind.extinction > before.extinction;
        let through = T::one() - if rises { light.absorbed } else { absorbed };
        let thicker = (length * (behind.extinction - before.extinction).abs()).min(T::one());
        let painted = (length * before.paints_apart(behind)).min(T::one());
        let off = through * thicker + (T::one() - absorbed) * painted;
        light.variance = light.variance + off * off;
    }
}
