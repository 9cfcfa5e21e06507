//! The effect of rounding on the places at which a segment is cut at knots.
//!
//! Rounding of a segment's ends shifts all cuts equally; rounding of a cut and of its knot shifts only that cut. Both
//! move a little of the segment from one side of a knot to the other. The effect is added to the light's variance.

use super::piece::Radiance;
use super::segment::Segment;
use super::transfer::Span;
use icoray_grid::array::MapInline;
use icoray_grid::real::Real;

/// Extinction and colour at a value.
#[derive(Debug, Clone, Copy)]
pub struct MediumSample<T> {
    extinction: T,
    color: [T; 3],
}

impl<T: Real> MediumSample<T> {
    /// The sample of `span` at value `f`.
    #[inline]
    pub fn at(span: &Span<T>, f: T) -> Self {
        MediumSample { extinction: span.extinction(f), color: span.color(f) }
    }

    /// The largest difference of a channel between the light of both.
    #[inline]
    fn color_difference(&self, other: &Self) -> T {
        let [r, g, b] = [0, 1, 2].map_inline(|k| (self.color[k] - other.color[k]).abs());
        self.extinction.min(other.extinction) * r.max(g).max(b)
    }
}

/// A piece behind a cut.
#[derive(Debug, Clone, Copy)]
pub(super) struct KnotCrossing<T> {
    /// Values at its start, which is the cut, and at its end.
    pub values: [T; 2],
    /// Slope of the segment at the cut.
    pub slope: T,
    /// Its length, planet radii.
    pub length: T,
    /// Its medium at its middle.
    pub mean: MediumSample<T>,
    /// Change of colour over it.
    pub change: T,
    /// Whether its span is narrow.
    pub is_narrow: bool,
}

/// The cuts of one segment.
#[derive(Debug)]
pub(super) struct Roundoff<T> {
    length: T,
    /// Values at the ends, and their rounding error.
    ends: [T; 2],
    reach: T,
    /// Maximum of the slope, and the least at a cut.
    steepest: T,
    flattest: T,
    start: MediumSample<T>,
    /// What the ray has absorbed before the first cut.
    pub absorbed_before: Option<T>,
    /// The piece before the cut: its medium and length.
    last: Option<(MediumSample<T>, T)>,
}

impl<T: Real> Roundoff<T> {
    /// For a segment that starts in `start`, whose ends have the rounding error `reach`.
    #[inline]
    pub fn new(segment: &Segment<T>, reach: T, start: MediumSample<T>) -> Self {
        let ends = [segment.f0, segment.f1];
        let flattest = (segment.f1 - segment.f0).abs();
        let steepest = flattest + segment.kappa.abs();
        Roundoff { length: segment.length, ends, reach, steepest, flattest, start, absorbed_before: None, last: None }
    }

    #[inline]
    fn rise(&self) -> T {
        (self.ends[1] - self.ends[0]).abs()
    }

    /// Adds a cut, after the piece behind it was added to `light`, which had absorbed `absorbed` before.
    #[inline]
    pub fn cut(&mut self, light: &mut Radiance<T>, absorbed: T, piece: KnotCrossing<T>) {
        let unit = T::of(2.0 * T::ROUNDING);
        let last_digit = unit * piece.values[0].abs();
        let knot = self.length * last_digit / (last_digit + self.rise());
        let off = unit * piece.length + knot;
        if let Some((last, length)) = self.last {
            self.flattest = self.flattest.min(piece.slope.abs());
            // A cut is found from the previous cut: the shorter adjacent piece bounds its error.
            let off = unit * length.min(piece.length) + knot;
            self.add_displacement(light, absorbed, off, [&last, &piece.mean]);
        }
        // A piece of the wrong length has its colours elsewhere; in a narrow span it is too long or too short by as
        // much as the segment is too flat or too steep there.
        let stretch = if piece.is_narrow { self.stretch(piece.values) } else { T::zero() };
        let part = (stretch + off / piece.length).min(T::one());
        let colors = (light.alpha - absorbed) * piece.change * part;
        let depth = ((T::one() - light.alpha) * piece.mean.extinction * piece.length * stretch).min(T::one());
        light.variance = light.variance + colors * colors + depth * depth;
        self.last = Some((piece.mean, piece.length));
    }

    /// The relative error of the length of a narrow piece between these values: largest if it ends at a knot near an
    /// end of the segment, at which f turns and is flat.
    #[inline]
    fn stretch(&self, values: [T; 2]) -> T {
        let apart = |value: T| (value - self.ends[0]).abs().min((value - self.ends[1]).abs());
        let knots = values.into_iter().filter(|value| !self.ends.contains(value));
        let near = knots.map(apart).fold(T::infinity(), T::min);
        T::of(2.0) * self.reach / (self.reach + near)
    }

    /// Adds the effect of a shift of all cuts, at the segment's end, in the medium `end`. The displaced light is seen
    /// through what lies before the first cut.
    #[inline]
    pub fn shift(&self, light: &mut Radiance<T>, end: &MediumSample<T>) {
        // At an extremum the place of a cut is the root of the reach of rounding.
        let root = (self.reach / (self.reach + self.steepest)).sqrt();
        let shift = self.length * root.min(self.reach / (self.reach + self.flattest));
        let absorbed = self.absorbed_before.unwrap_or(light.alpha);
        self.add_displacement(light, absorbed, shift, [&self.start, end]);
    }

    /// Adds the effect of `length` of the segment being in one medium instead of the other. If extinction rises, the
    /// denser piece behind hides the displaced light.
    #[inline]
    fn add_displacement(
        &self,
        light: &mut Radiance<T>,
        absorbed: T,
        length: T,
        [before, behind]: [&MediumSample<T>; 2],
    ) {
        let rises = behind.extinction > before.extinction;
        let through = T::one() - if rises { light.alpha } else { absorbed };
        let thicker = (length * (behind.extinction - before.extinction).abs()).min(T::one());
        let painted = (length * before.color_difference(behind)).min(T::one());
        let off = through * thicker + (T::one() - absorbed) * painted;
        light.variance = light.variance + off * off;
    }
}
