//! Pieces with lighting: a piece has one shade, at its mean normal, and is cut in two if the error of the shade exceeds
//! the ray's remaining budget.

use super::column::Values;
use super::light::{INDEPENDENT, LIT_DEVIATIONS};
use super::number::Number;
use super::piece::{ErrorBudget, Radiance, integrate};
use super::segment::Segment;
use super::shade::{ColorChange, MeanShade, RayShading};
use super::transfer::Span;
use super::turn::NormalTurn;
use icoray_grid::array::MapInline;
use icoray_grid::real::{Real, lerp};
use icoray_scene::Method;

/// Value and gradient along a whole frustum: each component varies like a [`Segment`]'s value.
#[derive(Debug, Clone, Copy)]
pub struct FrustumInterpolant<T, const N: usize> {
    /// Value and gradient at the frustum's entry.
    pub from: Values<T, N>,
    /// Value and gradient at its exit.
    pub to: Values<T, N>,
    /// Coefficient of u(1 - u) of each component, as in [`Segment`].
    pub kappa: Values<T, N>,
    /// Relative change of height along the frustum.
    pub eps: T,
}

impl<T: Real, const N: usize> FrustumInterpolant<T, N> {
    /// The value along the frustum, which is `length` long.
    #[inline(always)]
    pub fn segment(&self, length: T) -> Segment<T> {
        let FrustumInterpolant { from, to, kappa, eps } = *self;
        Segment { f0: from[0], f1: to[0], kappa: kappa[0], eps, length }
    }

    /// The gradient at `u`.
    #[inline(always)]
    pub fn gradient(&self, u: T) -> [T; 3] {
        let bent = u * (T::one() - u) / (T::one() + self.eps * u);
        let at = |k: usize| lerp(self.from[k % N], self.to[k % N], u) + bent * self.kappa[k % N];
        [at(1), at(2), at(3)]
    }
}

/// The distribution of the light of a piece, independent of its colour.
#[derive(Debug, Clone, Copy)]
pub struct LightSpread<T> {
    /// The light's centre, from the piece's middle as a fraction of the piece.
    pub centre: T,
    /// Mean square of the distance from the middle.
    pub second: T,
    /// Error of both.
    pub error_bound: T,
    /// Fraction of the piece, from its start, in which most of the light is.
    pub extent: T,
}

impl<T: Number> LightSpread<T> {
    /// The light of a piece of this length with this extinction at its ends, in whose extinction u(1 - u) has the
    /// coefficient `bend`.
    ///
    /// The light of a thin piece without bend is distributed like extinction, whose centre lies at a sixth of its
    /// relative change ρ from the middle. Light behind is weakened: to first order in the optical depth x this moves
    /// the centre forward by `x (5 - ρ²)/60`.
    #[inline(always)]
    pub fn of([from, to]: [T; 2], length: T, bend: T) -> Self {
        let number = |value: f64| length.like(value);
        let sum = from + to + length.least();
        let inverse = number(1.0) / sum;
        let depth = length * sum * number(0.5);
        let rise = (to - from) * inverse;
        let forward = depth.min(number(3.0)) * (rise * rise).mul_add(number(-1.0 / 60.0), number(5.0 / 60.0));
        let bent = bend.abs() * inverse;
        let error_bound = (depth * depth * number(0.02) + bent * number(0.2)).min(number(0.5));
        let extent = number(1.0) / depth.max(number(1.0));
        LightSpread { centre: rise * number(1.0 / 6.0) - forward, second: number(1.0 / 12.0), error_bound, extent }
    }
}

impl<T: Real> ColorChange<T> {
    /// The spread of a piece that stays in `span`.
    #[inline(always)]
    pub fn of(piece: &Segment<T>, span: &Span<T>) -> Self {
        let bend = span.steepest * piece.kappa.abs();
        let change = span.steepest * (piece.f1 - piece.f0).abs() + bend;
        ColorChange { brightest: span.brightest, change, bend, eps: piece.eps }
    }
}

/// The shade of a piece with these gradients at its start, middle and end.
#[inline(always)]
pub fn mean_shade<T: Real>(
    shading: &RayShading<T>,
    piece: &Segment<T>,
    span: &Span<T>,
    gradients: &[[T; 3]; 3],
) -> MeanShade<T> {
    let ends = [span.extinction(piece.f0), span.extinction(piece.f1)];
    let spread = LightSpread::of(ends, piece.length, span.extinction_slope * piece.kappa);
    let turn = NormalTurn::of(gradients, piece.eps, spread);
    shading.mean(&turn, &ColorChange::of(piece, span))
}

/// Whether a piece that absorbs at most `absorbed` of the light that reaches it need not be cut. `off` are its errors
/// per absorbed light: those that add up along a ray, and those that are independent. Either they are within
/// `color_tolerance`, or the errors of the ray, which has the light `before` it, stay with them within that tolerance of
/// the light with the piece and the [advance](ADVANCE), for any order of its hard pieces.
#[inline(always)]
pub fn is_affordable<T: Real>(before: &Radiance<T>, absorbed: T, off: [T; 2], color_tolerance: T) -> bool {
    let share = absorbed * before.transmittance();
    let [shared, own] = off;
    let allowed = color_tolerance * (before.alpha + share + T::of(ADVANCE)) - before.error - share * shared;
    let own = own * T::of(LIT_DEVIATIONS * INDEPENDENT);
    let own_share = share * own;
    let spread = T::of(LIT_DEVIATIONS * LIT_DEVIATIONS) * before.shade_variance + own_share * own_share;
    shared + own <= color_tolerance || (allowed >= T::zero() && spread <= allowed * allowed)
}

/// Fraction of the tolerance of all colours that the first pieces of a ray may spend in advance.
pub const ADVANCE: f64 = 0.1;

/// Maximum number of halvings of a piece at its start; hard pieces there leave some for the rest.
pub const HALVINGS_AT_START: f64 = 500.0;
/// Number of further halvings by its end. The error includes what remains.
pub const HALVINGS_ALONG: f64 = 1500.0;

/// Whether a part that ends at `done` of its piece, 0 to 1, may be halved after this number of halvings.
#[inline(always)]
pub fn may_halve(halvings: u32, done: f64) -> bool {
    f64::from(halvings) < HALVINGS_AT_START + HALVINGS_ALONG * done
}

/// The budget for the remaining parts of a piece.
struct Rest<T> {
    /// The light of the ray before the next part.
    before: Radiance<T>,
    halvings: u32,
    /// The whole piece's range of the interpolant.
    range: [T; 2],
    /// The transmittance of the previous parts.
    through: T,
    /// The sum of the standard deviations of their shades by rounding of the gradients at the vertices, which turns the
    /// normals of all parts alike.
    deviation: T,
}

/// A piece under light.
pub struct Lit<'l, T, const N: usize> {
    /// The rule of integration.
    pub method: Method,
    /// The allowed error.
    pub allowance: &'l ErrorBudget<T>,
    /// Lighting of the ray.
    pub shading: &'l RayShading<T>,
    /// The span of the transfer function that contains its values.
    pub span: &'l Span<T>,
    /// Value and gradient of its frustum.
    pub interpolant: &'l FrustumInterpolant<T, N>,
    /// The largest component of the gradients at the frustum's vertices; 0 if unknown.
    pub gradient_size: T,
}

impl<T: Real, const N: usize> Lit<'_, T, N> {
    /// Maximum depth of nested cuts of a piece.
    pub const MAX_CUTS: u32 = 20;

    /// The light of `piece`, which is `range` of the interpolant, on a ray that has the light `before` it. The piece is
    /// cut until its error [is affordable](is_affordable), with at most `cuts` nested cuts and as many halvings as
    /// [`may_halve`] permits.
    #[inline]
    pub fn light(&self, piece: &Segment<T>, range: [T; 2], cuts: u32, before: &Radiance<T>) -> Radiance<T> {
        let mut rest = Rest { before: *before, halvings: 0, range, through: T::one(), deviation: T::zero() };
        let mut light = self.part(piece, range, cuts, &mut rest);
        light.variance = light.variance + rest.deviation * rest.deviation;
        light
    }

    /// The light of a part, front to back with the unspent error of the previous parts.
    #[inline]
    fn part(&self, piece: &Segment<T>, range: [T; 2], cuts: u32, rest: &mut Rest<T>) -> Radiance<T> {
        let half = T::of(0.5);
        let places = [range[0], half * (range[0] + range[1]), range[1]];
        let gradients = places.map_inline(|u| self.interpolant.gradient(u));
        let mean = mean_shade(self.shading, piece, self.span, &gradients);
        let color_tolerance = self.allowance.color_tolerance;
        // An upper bound of the light that the piece absorbs.
        let depth = piece.length * self.span.extinction(piece.f0).max(self.span.extinction(piece.f1));
        let off = [mean.rounding, mean.off];
        if cuts > 0 && !is_affordable(&rest.before, depth.min(T::one()), off, color_tolerance) {
            let [from, to] = rest.range;
            if may_halve(rest.halvings, ((range[1] - from) / (to - from)).wide()) {
                rest.halvings += 1;
                return self.halves(piece, places, cuts - 1, rest);
            }
        }
        let light = integrate(self.method, piece, self.span, self.allowance);
        let largest = |of: &[T]| of.iter().fold(T::zero(), |most, x| most.max(x.abs()));
        let FrustumInterpolant { from, to, .. } = self.interpolant;
        let mixed_of = self.gradient_size.max(largest(&from[1..])).max(largest(&to[1..]));
        let deviation = self.shading.deviation_of(mixed_of, mean.size);
        let [rounded, _] = self.shading.deviations;
        let change = self.span.color_slope.map_inline(|slope| slope * (piece.f1 - piece.f0));
        let light = self.shading.apply(light, &mean, change, rounded);
        let turned = (deviation - rounded).max(T::zero());
        rest.deviation = rest.deviation + rest.through * light.alpha * turned;
        rest.through = rest.through * light.transmittance();
        rest.before.over(&light);
        light
    }

    #[inline(never)]
    fn halves(&self, piece: &Segment<T>, [from, middle, to]: [T; 3], cuts: u32, rest: &mut Rest<T>) -> Radiance<T> {
        let half = T::of(0.5);
        let cut = (half, piece.value(half));
        let parts = [piece.part((T::zero(), piece.f0), cut), piece.part(cut, (T::one(), piece.f1))];
        let mut light = self.part(&parts[0], [from, middle], cuts, rest);
        if light.transmittance() * self.allowance.transmittance > self.allowance.min_transmittance {
            light.over(&self.part(&parts[1], [middle, to], cuts, rest));
        }
        light
    }
}

#[cfg(test)]
mod tests;
