//! Pieces with lighting: the shade is taken at a piece's ends and middle, and where the error of their mean is too
//! large the piece is cut in two.

use super::column::Values;
use super::piece::{ErrorBudget, Radiance, integrate};
use super::segment::Segment;
use super::shade::{RayShading, Shade};
use super::transfer::Span;
use icoray_grid::array::MapInline;
use icoray_grid::real::{Real, lerp};
use icoray_scene::Method;

/// Value and gradient along a whole frustum: each component runs as a [`Segment`]'s value does.
#[derive(Debug, Clone, Copy)]
pub struct FrustumInterpolant<T, const N: usize> {
    /// Value and gradient at the frustum's entry.
    pub from: Values<T, N>,
    /// Value and gradient at its exit.
    pub to: Values<T, N>,
    /// Coefficient of u(1 - u) of each component, as [`Segment`] has it.
    pub kappa: Values<T, N>,
    /// Relative change of height along the frustum.
    pub eps: T,
}

impl<T: Real, const N: usize> FrustumInterpolant<T, N> {
    /// The gradient at `u`.
    #[inline(always)]
    pub fn gradient(&self, u: T) -> [T; 3] {
        let bent = u * (T::one() - u) / (T::one() + self.eps * u);
        let at = |k: usize| lerp(self.from[k % N], self.to[k % N], u) + bent * self.kappa[k % N];
        [at(1), at(2), at(3)]
    }
}

/// Where in a piece its light comes from.
pub struct LightSpread<T> {
    /// The light's centre, from the piece's middle in parts of the piece.
    pub centre: T,
    /// Error of the centre.
    pub error_bound: T,
}

impl<T: Real> LightSpread<T> {
    /// Thin and without a bend the light is spread as extinction is, whose centre lies by a sixth of its relative
    /// change from the middle; to first order in the optical depth x it is drawn forward by x/12.
    #[inline(always)]
    pub fn of(piece: &Segment<T>, span: &Span<T>) -> Self {
        let (from, to) = (span.extinction(piece.f0), span.extinction(piece.f1));
        let sum = from + to + T::min_positive_value();
        let depth = piece.length * from.max(to);
        let (sixth, half) = (T::of(1.0 / 6.0), T::of(0.5));
        let centre = sixth * ((to - from) / sum - half * depth.min(T::one()));
        let bent = (span.extinction_slope() * piece.kappa).abs() / sum;
        let plain = span.steepest() * (piece.f1 - piece.f0).abs() / (span.brightest() + T::min_positive_value());
        LightSpread { centre, error_bound: (T::of(0.2) * (depth * depth + bent + half * plain)).min(half) }
    }
}

/// Shades at a piece's start, middle and end.
pub(crate) type Shades<'s, T> = [&'s Shade<T>; 3];

/// Error of a channel of a piece that is lit by the mean of `shades`, per absorbed light.
#[inline(always)]
pub(crate) fn error_bound<T: Real>(
    shading: &RayShading<T>,
    [start, middle, end]: Shades<'_, T>,
    span: &Span<T>,
    spread: &LightSpread<T>,
) -> T {
    let bound = shading.error_bound(start, middle, end, spread.error_bound);
    let (body, highlight) = bound.unwrap_or(shading.range());
    span.brightest() * body + highlight
}

/// A piece under light.
pub struct Lit<'l, T, const N: usize> {
    /// The rule of integration.
    pub method: Method,
    /// The error that is allowed.
    pub allowance: &'l ErrorBudget<T>,
    /// Lighting of the ray.
    pub shading: &'l RayShading<T>,
    /// The part of the transfer function in which its values lie.
    pub span: &'l Span<T>,
    /// Value and gradient of its frustum.
    pub interpolant: &'l FrustumInterpolant<T, N>,
}

impl<T: Real, const N: usize> Lit<'_, T, N> {
    /// Largest depth of nested cuts of a piece.
    pub const MAX_CUTS: u32 = 20;

    /// The light of `piece`, which is `range` of the interpolant. The piece is cut until its error is allowed, with at
    /// most `cuts` nested cuts.
    #[inline]
    pub fn light(&self, piece: &Segment<T>, range: [T; 2], cuts: u32) -> Radiance<T> {
        let ends = range.map_inline(|u| self.shade(u));
        self.part(piece, range, [&ends[0], &ends[1]], cuts, None)
    }

    #[inline]
    fn shade(&self, u: T) -> Shade<T> {
        self.shading.shade(self.interpolant.gradient(u))
    }

    /// The light of a part with the shades `ends`: under the mean of three shades where these tell that it is near
    /// enough, or where all that light could change is no more than `enough`, a small part of the whole piece's
    /// share; else of its two halves.
    #[inline]
    fn part(
        &self,
        piece: &Segment<T>,
        range: [T; 2],
        ends: [&Shade<T>; 2],
        cuts: u32,
        enough: Option<T>,
    ) -> Radiance<T> {
        let half = T::of(0.5);
        let middle = half * (range[0] + range[1]);
        let shade = self.shade(middle);
        let spread = LightSpread::of(piece, self.span);
        let off = error_bound(self.shading, [ends[0], &shade, ends[1]], self.span, &spread);
        let depth = piece.length * self.span.extinction(piece.f0).max(self.span.extinction(piece.f1));
        let is_near = off <= self.allowance.color_tolerance || enough.is_some_and(|enough| off * depth <= enough);
        if is_near || cuts == 0 {
            let light = integrate(self.method, piece, self.span, self.allowance);
            let mean = RayShading::mean(ends[0], &shade, ends[1], spread.centre);
            return self.shading.apply(light, mean, off);
        }
        let enough =
            enough.unwrap_or_else(|| T::of(0.03) * self.allowance.color_tolerance * (half * depth).absorbed_by());
        let cut = (half, piece.value(half));
        let parts = [piece.part((T::zero(), piece.f0), cut), piece.part(cut, (T::one(), piece.f1))];
        let mut light = self.part(&parts[0], [range[0], middle], [ends[0], &shade], cuts - 1, Some(enough));
        if light.transmittance() * self.allowance.transmittance > self.allowance.min_transmittance {
            let behind = self.part(&parts[1], [middle, range[1]], [&shade, ends[1]], cuts - 1, Some(enough));
            light.over(&behind);
        }
        light
    }
}
