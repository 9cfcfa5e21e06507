//! The integral of one piece of a ray between two knots (§3.4 of the paper), and its error bound.
//!
//! Extinction and colour are linear in f here. With T(u) the optical depth from the piece's start and s = dc/df, the
//! emission c κ e^-T integrates by parts to
//!
//! `C = c1·A - s·W`, `A = 1 - e^-T(1)`, `W = ∫ f' (1 - e^-T) du`
//!
//! one scalar for all channels; f need not be monotone.
//! - [`Method::Paper`] takes f as linear and the colour as the mean of the ends: second order.
//! - [`Method::Exact`] keeps the bend of f: A is exact to 1e-11 and better (a series; the closed log1p form cancels),
//!   and W is taken by the cheapest rule whose bound, known before, is within the piece's share of the tolerance:
//!   `thin`, which needs no exponential; `gauss`, 2-point with the known quartic term, fourth order; and that on
//!   several panels.
//!
//! The share of a piece is the tolerance times the light that it absorbs: over a ray these add up to no more than the
//! tolerance. See Novins and Arvo, "Controlled Precision Volume Integration" (1992), for the first bounded integration.

use super::segment::Segment;
use super::transfer::Span;
pub use crate::light::Radiance;
use icoray_grid::array::MapInline;
use icoray_grid::real::Real;
use icoray_scene::Method;

/// Error and transmittance allowed for a piece.
#[derive(Debug, Clone, Copy)]
pub struct ErrorBudget<T> {
    /// Allowed error of the colour per absorbed light.
    pub color_tolerance: T,
    /// Transmittance at which the ray may end.
    pub min_transmittance: T,
    /// Transmittance at the piece's start.
    pub transmittance: T,
    /// Error of the values at the piece's ends due to rounding.
    pub reach: T,
}

/// Integrates `piece`, on which f stays in `span`.
#[inline]
pub fn integrate<T: Real>(
    method: Method,
    piece: &Segment<T>,
    span: &Span<T>,
    allowance: &ErrorBudget<T>,
) -> Radiance<T> {
    let terms = Terms::new(piece, span);
    let mut light = match method {
        Method::Paper => linear(&terms),
        Method::Exact => exact(&terms, allowance),
    };
    light.variance = light.variance + terms.variance(light.alpha, allowance.reach);
    light
}

/// Terms of a piece that all rules of integration share.
struct Terms<'p, T> {
    piece: &'p Segment<T>,
    span: &'p Span<T>,
    /// Extinction at the ends, and its slope in f.
    ends: [T; 2],
    slope: T,
    /// f1 - f0.
    rise: T,
    /// The bend, taken as constant: the value that gives the piece its mean.
    bend: T,
    /// Maximum of |f'|.
    steep: T,
    /// Optical depth.
    depth: T,
}

impl<'p, T: Real> Terms<'p, T> {
    #[inline(always)]
    fn new(piece: &'p Segment<T>, span: &'p Span<T>) -> Self {
        let half = T::of(0.5);
        let ends = [span.extinction(piece.f0), span.extinction(piece.f1)];
        let slope = span.extinction_slope;
        let rise = piece.f1 - piece.f0;
        let bend = piece.kappa * bend_factor(piece.eps);
        let depth = piece.length * (half * (ends[0] + ends[1]) + slope * bend * T::of(1.0 / 6.0));
        let depth = depth.max(T::zero());
        Terms { piece, span, ends, slope, rise, bend, steep: rise.abs() + bend.abs(), depth }
    }

    /// Maximum of |T''|.
    #[inline(always)]
    fn bend_of_depth(&self) -> T {
        self.piece.length * self.slope.abs() * self.steep
    }

    /// The light of colour `c1·A - s·W`.
    #[inline(always)]
    fn light(&self, absorbed: T, weight: T, error: T) -> Radiance<T> {
        let (c1, s) = (self.span.color(self.piece.f1), self.span.color_slope);
        let color = [0, 1, 2].map_inline(|k| c1[k] * absorbed - s[k] * weight);
        Radiance { color, alpha: absorbed, error, ..Radiance::none() }
    }

    /// Error of W from taking the bend as constant: that of f is at most `0.05 |κε|/(1 + ε)`, that of T at most `L |m
    /// κε|/60` (times the same factor).
    #[inline(always)]
    fn skew(&self, absorbed: T) -> T {
        let (one, eps) = (T::one(), self.piece.eps);
        let wide = if eps < T::of(-0.04) { one / (one + eps) } else { one };
        wide * self.bend.abs() * eps.abs() * (T::of(0.05) * absorbed + T::of(1.0 / 60.0) * self.bend_of_depth())
    }

    /// Variance due to rounding: the effect of values that are off by `reach`, and the last digits of lengths and sums.
    #[inline(always)]
    fn variance(&self, absorbed: T, reach: T) -> T {
        let change = self.piece.length * self.slope.abs() * (T::one() - absorbed) + self.span.steepest * absorbed;
        let off = (reach * change + T::of(T::ROUNDING) * absorbed).min(T::one());
        off * off
    }
}

/// The paper's scheme. Its error is an estimate: the omitted bend, and the colour's skew over the piece.
#[inline]
fn linear<T: Real>(terms: &Terms<'_, T>) -> Radiance<T> {
    let half = T::of(0.5);
    let depth = terms.piece.length * half * (terms.ends[0] + terms.ends[1]);
    let absorbed = depth.absorbed_by();
    let left_out = terms.piece.length * (terms.slope * terms.bend).abs() * T::of(1.0 / 6.0);
    let skew = terms.rise.abs() * (terms.bend_of_depth() + depth * absorbed) * T::of(1.0 / 12.0);
    let error = left_out + terms.span.steepest * (skew + terms.bend.abs() * absorbed * T::of(1.0 / 6.0));
    terms.light(absorbed, half * terms.rise * absorbed, error.min(T::one()))
}

/// A piece that needs more panels of equal length than this is halved instead.
pub const MAX_PANELS: usize = 32;
/// Optical depth above which a piece is not integrated as a thin one.
pub const THIN: f64 = 0.5;

#[inline]
fn exact<T: Real>(terms: &Terms<'_, T>, allowance: &ErrorBudget<T>) -> Radiance<T> {
    let absorbed = terms.depth.absorbed_by();
    let steepest = terms.span.steepest;
    if steepest * terms.steep == T::zero() {
        return Radiance::plain(terms.span.color(terms.piece.f0), absorbed);
    }
    if terms.depth < T::of(THIN) {
        let error = steepest * (thin_error(terms) + terms.skew(absorbed));
        if error <= allowance.color_tolerance * absorbed {
            return terms.light(absorbed, thin(terms), error);
        }
    }
    dense(terms, absorbed, allowance)
}

/// Integrates a piece for which [`thin`] is not sufficient.
#[inline]
fn dense<T: Real>(terms: &Terms<'_, T>, absorbed: T, allowance: &ErrorBudget<T>) -> Radiance<T> {
    let (half, two, steepest) = (T::of(0.5), T::of(2.0), terms.span.steepest);
    // A surface of the colour at its start: even where T rises as u³ all light stays in the first 4e-5 of the piece.
    if terms.depth > T::of(T::SURFACE) || terms.depth.is_nan() {
        let error = T::of(4e-5) * steepest * terms.steep;
        return Radiance { error, ..Radiance::plain(terms.span.color(terms.piece.f0), T::one()) };
    }
    let allowed = allowance.color_tolerance * absorbed;
    let (bound, skew) = (steepest * gauss_error(terms), steepest * terms.skew(absorbed));
    if bound + skew <= allowed {
        return terms.light(absorbed, gauss(terms), bound + skew);
    }
    // The colours of the piece differ by no more than its change, for any weights.
    let change = steepest * terms.steep;
    if half * change <= allowance.color_tolerance {
        return terms.light(absorbed, half * terms.rise * absorbed, half * change * absorbed);
    }
    let wanted = (two * bound / allowed).sqrt().sqrt().max((two * skew / allowed).sqrt());
    if wanted <= T::of(MAX_PANELS as f64) {
        panels(terms, wanted.ceil().max(two).wide() as usize, allowance)
    } else {
        halves(terms, allowance)
    }
}

/// 6 ∫ x(1-x)/(1+εx) dx: Σ 6 (-ε)^k / ((k+2)(k+3)) for small ε, the closed form where it no longer cancels.
#[inline]
pub fn bend_factor<T: Real>(eps: T) -> T {
    /// Bound of |ε| below which the series is exact to 1e-11; the first term left out is ε⁶/12.
    const SMALL_EPS: f64 = 0.02;
    const C: [f64; 6] = [1.0, -1.0 / 2.0, 3.0 / 10.0, -1.0 / 5.0, 1.0 / 7.0, -3.0 / 28.0];
    if eps.abs() < T::of(SMALL_EPS) {
        let e2 = eps * eps;
        let pair = |k: usize| T::of(C[k]) + eps * T::of(C[k + 1]);
        return pair(0) + e2 * (pair(2) + e2 * pair(4));
    }
    let e = eps.wide();
    T::of(6.0 * (e + 0.5 * e * e - (1.0 + e) * e.ln_1p()) / (e * e * e))
}

/// W of a thin piece, to the third order in its optical depth x without an exponential: `∫ f' T`, a polynomial, and
/// `∫ f' T²/2`, which is `x/3` of that where T is linear, less `bend·x²/36`.
#[inline(always)]
fn thin<T: Real>(terms: &Terms<'_, T>) -> T {
    let Terms { bend, slope, depth, .. } = *terms;
    let third = T::of(1.0 / 3.0);
    let p = terms.rise + bend;
    let level = terms.ends[0] * (T::of(0.5) * p - T::of(2.0 / 3.0) * bend);
    let ramp = slope * (p * (T::of(1.0 / 6.0) * p - third * bend) + T::of(2.0 / 15.0) * bend * bend);
    terms.piece.length * (level + ramp) * (T::one() - third * depth) + bend * depth * depth * T::of(1.0 / 36.0)
}

/// The bound of [`thin`]. With `b >= |T''|` T differs from its chord `xu` by at most `b u(1-u)/2`, which moves
/// `∫ f' (T²/2 - xT/3)` by at most `F (0.02xb + b²/240)`; and `e^-T - 1 + T - T²/2` is at most `T³/6` with
/// `T <= (x + b/2)u`.
#[inline(always)]
fn thin_error<T: Real>(terms: &Terms<'_, T>) -> T {
    let (x, b) = (terms.depth, terms.bend_of_depth());
    let y = x + T::of(0.5) * b;
    terms.steep * (b * (T::of(0.02) * x + T::of(1.0 / 240.0) * b) + y * y * y * T::of(1.0 / 24.0))
}

/// W by Gauss's 2-point rule, plus its error in u⁴, the product of the two bends, in closed form.
#[inline(always)]
fn gauss<T: Real>(terms: &Terms<'_, T>) -> T {
    let (one, half) = (T::one(), T::of(0.5));
    let Terms { piece, bend, slope, rise, .. } = *terms;
    let weighted = |u: T| {
        let risen = u * u * (half * rise + bend * (half - u * T::of(1.0 / 3.0)));
        let depth = piece.length * (terms.ends[0] * u + slope * risen);
        (rise + bend * (one - u - u)) * depth.max(T::zero()).absorbed_by()
    };
    let offset = T::of(0.288_675_134_594_812_9);
    let quartic = piece.length * slope * bend * bend * T::of(1.0 / 270.0);
    half * (weighted(half - offset) + weighted(half + offset)) + quartic
}

/// The bound of [`gauss`]: a fourth derivative over 4320; it falls with the fourth power of the number of panels.
///
/// With `a >= |T'|`, `b >= |T''|`, `j = |T'''|`, `F >= |f'|` and `f'' = -2·bend` the fourth derivative of
/// `f'(1 - e^-T)` is at most `F (a⁴ + 6a²b + 3b² + 4aj) + 8|bend| (a³ + 3ab + j min(1, a))`, the last being the
/// remainder of the quartic term.
#[inline(always)]
fn gauss_error<T: Real>(terms: &Terms<'_, T>) -> T {
    let (bend, length) = (terms.bend.abs(), terms.piece.length);
    let swing = terms.slope.abs() * bend;
    let a = length * (terms.ends[0].max(terms.ends[1]) + T::of(0.25) * swing);
    let (b, j) = (terms.bend_of_depth(), T::of(2.0) * length * swing);
    let (a2, three) = (a * a, T::of(3.0));
    let even = a2 * (a2 + T::of(6.0) * b) + three * b * b + T::of(4.0) * a * j;
    let odd = T::of(8.0) * bend * (a * (a2 + three * b) + j * a.min(T::one()));
    (terms.steep * even + odd) * T::of(1.0 / 4320.0)
}

/// A piece in `count` panels of equal length, front to back, each by [`gauss`].
#[inline]
fn panels<T: Real>(terms: &Terms<'_, T>, count: usize, allowance: &ErrorBudget<T>) -> Radiance<T> {
    let (piece, steepest) = (terms.piece, terms.span.steepest);
    let mut light = Radiance::none();
    let mut from = (T::zero(), piece.f0);
    for i in 1..=count {
        let u = T::of(i as f64 / count as f64);
        let to = (u, if i == count { piece.f1 } else { piece.value(u) });
        let part = piece.part(from, to);
        let panel = Terms::new(&part, terms.span);
        let absorbed = panel.depth.absorbed_by();
        let error = steepest * (gauss_error(&panel) + panel.skew(absorbed));
        light.over(&panel.light(absorbed, gauss(&panel), error));
        if light.transmittance() * allowance.transmittance <= allowance.min_transmittance {
            break;
        }
        from = to;
    }
    light
}

/// A piece so dense that panels of equal length would be wasted behind its opaque front: integrates the front half
/// first, and the back half only if light still passes.
#[inline]
fn halves<T: Real>(terms: &Terms<'_, T>, allowance: &ErrorBudget<T>) -> Radiance<T> {
    let (piece, span, half) = (terms.piece, terms.span, T::of(0.5));
    let middle = (half, piece.value(half));
    let mut light = exact(&Terms::new(&piece.part((T::zero(), piece.f0), middle), span), allowance);
    let through = light.transmittance() * allowance.transmittance;
    if through > allowance.min_transmittance {
        let behind = ErrorBudget { transmittance: through, ..*allowance };
        light.over(&exact(&Terms::new(&piece.part(middle, (T::one(), piece.f1)), span), &behind));
    }
    light
}

#[cfg(test)]
mod tests;
