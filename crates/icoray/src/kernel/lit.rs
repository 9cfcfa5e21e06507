//! Pieces under light: the shade is taken at a piece's ends and middle, and where these do not tell it near enough the
//! piece is cut in two.

use super::column::Values;
use super::piece::{Allowance, Light, Method, integrate};
use super::real::{Real, lerp};
use super::segment::Segment;
use super::shade::{RayShading, Shade};
use super::transfer::Span;
use crate::array::MapInline;

/// Value and gradient along a whole frustum: each component runs as a [`Segment`]'s value does.
pub(crate) struct Course<T, const N: usize> {
    pub from: Values<T, N>,
    pub to: Values<T, N>,
    pub kappa: Values<T, N>,
    pub eps: T,
}

impl<T: Real, const N: usize> Course<T, N> {
    /// The gradient at `u`.
    #[inline(always)]
    pub fn gradient(&self, u: T) -> [T; 3] {
        let bent = u * (T::one() - u) / (T::one() + self.eps * u);
        let at = |k: usize| lerp(self.from[k % N], self.to[k % N], u) + bent * self.kappa[k % N];
        [at(1), at(2), at(3)]
    }
}

/// Where in a piece its light comes from.
pub(crate) struct Spread<T> {
    /// The light's centre, from the piece's middle in parts of the piece.
    pub centre: T,
    /// How far it may be from there.
    pub doubt: T,
}

impl<T: Real> Spread<T> {
    /// Thin and without a bend the light is spread as extinction is, whose centre lies by a sixth of its relative change
    /// from the middle; to first order in the optical depth x it is drawn forward by x/12.
    #[inline(always)]
    pub fn of(piece: &Segment<T>, span: &Span<T>) -> Self {
        let (from, to) = (span.extinction(piece.f0), span.extinction(piece.f1));
        let sum = from + to + T::min_positive_value();
        let depth = piece.length * from.max(to);
        let (sixth, half) = (T::of(1.0 / 6.0), T::of(0.5));
        let centre = sixth * ((to - from) / sum - half * depth.min(T::one()));
        let bent = (span.extinction_slope() * piece.kappa).abs() / sum;
        let plain =
            span.steepest() * (piece.f1 - piece.f0).abs() / (span.brightest() + T::min_positive_value());
        Spread { centre, doubt: (T::of(0.2) * (depth * depth + bent + half * plain)).min(half) }
    }
}

/// Shades at a piece's start, middle and end.
pub(crate) type Shades<'s, T> = [&'s Shade<T>; 3];

/// How far a channel may be off that `shading` gives a piece under the mean of `shades`, per absorbed light.
#[inline(always)]
pub(crate) fn off<T: Real>(
    shading: &RayShading<T>,
    [start, middle, end]: Shades<'_, T>,
    span: &Span<T>,
    spread: &Spread<T>,
) -> T {
    let doubt = shading.doubt(start, middle, end, spread.doubt);
    let (body, highlight) = doubt.unwrap_or(shading.range());
    span.brightest() * body + highlight
}

/// A piece under light.
pub(crate) struct Lit<'l, T, const N: usize> {
    pub method: Method,
    pub allowance: &'l Allowance<T>,
    pub shading: &'l RayShading<T>,
    pub span: &'l Span<T>,
    pub course: &'l Course<T, N>,
}

impl<T: Real, const N: usize> Lit<'_, T, N> {
    /// How often a piece is cut in two for its light's sake, one cut inside the other.
    pub const MOST_CUTS: u32 = 20;

    /// The light of `piece`, `range` of the course, cut as often as its share asks for but `cuts` times at most, one cut
    /// inside the other.
    #[inline]
    pub fn light(&self, piece: &Segment<T>, range: [T; 2], cuts: u32) -> Light<T> {
        let ends = range.map_inline(|u| self.shade(u));
        self.part(piece, range, [&ends[0], &ends[1]], cuts, None)
    }

    #[inline]
    fn shade(&self, u: T) -> Shade<T> {
        self.shading.shade(self.course.gradient(u))
    }

    /// The light of a part with the shades `ends`: under the mean of three shades where these tell that it is near enough,
    /// or where all that light could change is no more than `enough`, a small part of the whole piece's share; else of its
    /// two halves.
    #[inline]
    fn part(
        &self,
        piece: &Segment<T>,
        range: [T; 2],
        ends: [&Shade<T>; 2],
        cuts: u32,
        enough: Option<T>,
    ) -> Light<T> {
        let half = T::of(0.5);
        let middle = half * (range[0] + range[1]);
        let shade = self.shade(middle);
        let spread = Spread::of(piece, self.span);
        let off = off(self.shading, [ends[0], &shade, ends[1]], self.span, &spread);
        let depth = piece.length * self.span.extinction(piece.f0).max(self.span.extinction(piece.f1));
        let is_near = off <= self.allowance.share || enough.is_some_and(|enough| off * depth <= enough);
        if is_near || cuts == 0 {
            let light = integrate(self.method, piece, self.span, self.allowance);
            let mean = RayShading::mean(ends[0], &shade, ends[1], spread.centre);
            return self.shading.apply(light, mean, off);
        }
        let enough =
            enough.unwrap_or_else(|| T::of(0.03) * self.allowance.share * (half * depth).absorbed_by());
        let cut = (half, piece.value(half));
        let parts = [piece.part((T::zero(), piece.f0), cut), piece.part(cut, (T::one(), piece.f1))];
        let mut light = self.part(&parts[0], [range[0], middle], [ends[0], &shade], cuts - 1, Some(enough));
        if (T::one() - light.absorbed) * self.allowance.through > self.allowance.rest {
            let behind = self.part(&parts[1], [middle, range[1]], [&shade, ends[1]], cuts - 1, Some(enough));
            light.over(&behind);
        }
        light
    }
}
