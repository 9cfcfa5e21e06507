//! The integral of one monotone piece between two knots (§3.4 of the paper): extinction and colour are linear in f here.
//!
//! With T(u) the optical depth from the piece's start, emission c κ e^-T integrates by parts to
//!
//! `C = c0·wa + c1·wb`, `wa = ∫ (f'/d) (1 - e^-T) du`, `wb = (1 - e^-T(1)) - wa`
//!
//! one scalar for all channels, with `0 <= wa <= 1 - e^-T(1)`.
//! - [`Method::Paper`] takes f as linear and the colour as the mean of the ends: second order.
//! - [`Method::Exact`] keeps the bend of f: the optical depth is exact to rounding (a series; the closed log1p form
//!   cancels), wa is Gauss 2-point with the known quartic term, fourth order, on as many panels as its error bound asks for.
//!   See Novins and Arvo, "Controlled Precision Volume Integration" (1992), for the first bounded integration.

use super::real::Real;
use super::segment::Segment;
use super::transfer::Span;

/// How a monotone piece is integrated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// f linear over the piece, colour the mean of its ends (the paper's piecewise linear approximation).
    Paper,
    /// The bend of f kept: exact optical depth, colour of fourth order.
    #[default]
    Exact,
}

/// What a piece does to the light that passes it: premultiplied colour and the part that is absorbed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Light<T> {
    pub color: [T; 3],
    pub absorbed: T,
}

impl<T: Real> Light<T> {
    /// No light, nothing absorbed.
    pub fn none() -> Self {
        Light { color: [T::zero(); 3], absorbed: T::zero() }
    }

    /// Puts `behind` behind `self` (premultiplied `over`, front to back).
    #[inline]
    pub fn over(&mut self, behind: &Light<T>) {
        let through = T::one() - self.absorbed;
        for k in 0..3 {
            self.color[k] = self.color[k] + through * behind.color[k];
        }
        self.absorbed = self.absorbed + through * behind.absorbed;
    }
}

/// Integrates `piece`, on which f is monotone and stays in `span`.
#[inline]
pub(crate) fn integrate<T: Real>(method: Method, piece: &Segment<T>, span: &Span<T>) -> Light<T> {
    match method {
        Method::Paper => linear(piece, span),
        Method::Exact => exact(piece, span),
    }
}

#[inline]
fn blend<T: Real>(c0: &[T; 3], c1: &[T; 3], w0: T, w1: T) -> [T; 3] {
    [c0[0] * w0 + c1[0] * w1, c0[1] * w0 + c1[1] * w1, c0[2] * w0 + c1[2] * w1]
}

#[inline]
fn linear<T: Real>(piece: &Segment<T>, span: &Span<T>) -> Light<T> {
    let half = T::of(0.5);
    let depth = piece.length * half * (span.extinction(piece.f0) + span.extinction(piece.f1));
    let absorbed = depth.absorbed_by();
    let (c0, c1) = (span.color(piece.f0), span.color(piece.f1));
    Light { color: blend(&c0, &c1, half * absorbed, half * absorbed), absorbed }
}

/// What one piece may add to the error of a pixel, per unit of colour difference over it.
const TOLERANCE: f64 = 1e-6;
/// The most relative change of height over one panel: a panel takes κ/(1 + εu) as constant, which errs by
/// `|κ/d| ε (a² + L|σ1 - σ0|)/120`. Only layers thicker than 3% of the radius come near it.
const LARGEST_EPS: f64 = 0.03;
/// A piece that wants more panels of equal length than this is halved instead.
const MOST_PANELS: usize = 32;

#[inline]
fn exact<T: Real>(piece: &Segment<T>, span: &Span<T>) -> Light<T> {
    if span.is_plain {
        let absorbed = optical_depth(piece, span).absorbed_by();
        let color = span.color(piece.f0);
        return Light { color: blend(&color, &color, absorbed, T::zero()), absorbed };
    }
    let excess = excess(piece, span);
    let heights = piece.eps.abs() * T::of(1.0 / LARGEST_EPS);
    if excess <= T::one() && heights <= T::one() {
        return panel(piece, span);
    }
    let wanted = excess.sqrt().sqrt().max(heights);
    if wanted <= T::of(MOST_PANELS as f64) { panels(piece, span, wanted) } else { halves(piece, span) }
}

/// The error bound of one panel over [`TOLERANCE`]; it falls with the fourth power of the number of panels.
///
/// With `a = L σmax`, `k = |κ/d| <= 1`, `b = L |σ1 - σ0| (1 + k)`, `j = 2 L |σ1 - σ0| k` the fourth derivative of the integrand
/// of wa is at most `(1 + k)(a⁴ + 6a²b + 3b² + 4aj) + 8k(a³ + 3ab)`, and the 2-point rule's error that over 4320.
#[inline]
fn excess<T: Real>(piece: &Segment<T>, span: &Span<T>) -> T {
    let one = T::one();
    let (s0, s1) = (span.extinction(piece.f0), span.extinction(piece.f1));
    let a = piece.length * s0.max(s1);
    let change = piece.length * (s1 - s0).abs();
    // Thin pieces, nearly all, are settled by the bound for k = 1 without the division.
    if a * (a * a + T::of(8.0) * change) + T::of(3.0) * change * change < T::of(4320.0 * TOLERANCE / 16.0) {
        return one;
    }
    let d = (piece.f1 - piece.f0).abs();
    let bend = piece.kappa.abs();
    let k = if bend < d { bend / d } else { one };
    let (b, j) = (change * (one + k), T::of(2.0) * change * k);
    let (a2, three) = (a * a, T::of(3.0));
    let even = a2 * a2 + T::of(6.0) * a2 * b + three * b * b + T::of(4.0) * a * j;
    let odd = T::of(8.0) * k * a * (a2 + three * b);
    ((one + k) * even + odd) * T::of(1.0 / (4320.0 * TOLERANCE))
}

/// Optical depth of the piece: `L[(σ0 + σ1)/2 + m κ J(ε)]` with `J = ∫ x(1-x)/(1+εx) dx`.
#[inline]
fn optical_depth<T: Real>(piece: &Segment<T>, span: &Span<T>) -> T {
    let mean = T::of(0.5) * (span.extinction(piece.f0) + span.extinction(piece.f1));
    (piece.length * (mean + span.extinction_slope() * piece.kappa * bend_integral(piece.eps))).max(T::zero())
}

/// J(ε): Σ (-ε)^k / ((k+2)(k+3)) for small ε, the closed form where it no longer cancels.
#[inline]
fn bend_integral<T: Real>(eps: T) -> T {
    if eps.abs() < T::of(0.02) {
        // The first term left out is ε⁶/72 < 1e-12.
        const C: [f64; 6] = [1.0 / 6.0, -1.0 / 12.0, 1.0 / 20.0, -1.0 / 30.0, 1.0 / 42.0, -1.0 / 56.0];
        let e2 = eps * eps;
        let pair = |k: usize| T::of(C[k]) + eps * T::of(C[k + 1]);
        return pair(0) + e2 * (pair(2) + e2 * pair(4));
    }
    let e = eps.wide();
    T::of((e + 0.5 * e * e - (1.0 + e) * e.ln_1p()) / (e * e * e))
}

/// One panel: wa by Gauss 2-point, plus the error term that is known in closed form.
#[inline]
fn panel<T: Real>(piece: &Segment<T>, span: &Span<T>) -> Light<T> {
    let (one, half) = (T::one(), T::of(0.5));
    let d = piece.f1 - piece.f0;
    let slope = span.extinction_slope();
    let start = span.extinction(piece.f0);
    let bend = piece.kappa / (one + half * piece.eps);
    let relative = if d == T::zero() { T::zero() } else { (bend / d).max(-one).min(one) };
    let weighted = |u: T| {
        let risen = u * u * (half * d + bend * (half - u * T::of(1.0 / 3.0)));
        let depth = piece.length * (start * u + slope * risen);
        (one + relative * (one - u - u)) * depth.absorbed_by()
    };
    let offset = T::of(0.288_675_134_594_812_9);
    let gauss = half * (weighted(half - offset) + weighted(half + offset));
    // What the 2-point rule misses of u⁴, the product of the two bends: (2/3)/180 of its coefficient.
    let quartic = relative * piece.length * slope * bend * T::of(1.0 / 270.0);
    let absorbed = optical_depth(piece, span).absorbed_by();
    let wa = (gauss + quartic).max(T::zero()).min(absorbed);
    let wb = absorbed - wa;
    let (c0, c1) = (span.color(piece.f0), span.color(piece.f1));
    Light { color: blend(&c0, &c1, wa, wb), absorbed }
}

/// A piece in `wanted` panels of equal length, rounded up, front to back.
fn panels<T: Real>(piece: &Segment<T>, span: &Span<T>, wanted: T) -> Light<T> {
    let count = wanted.ceil().wide() as usize;
    let mut light = Light::none();
    let mut from = (T::zero(), piece.f0);
    for i in 1..=count {
        let u = T::of(i as f64 / count as f64);
        let to = (u, if i == count { piece.f1 } else { piece.value(u) });
        light.over(&panel(&piece.part(from, to), span));
        from = to;
    }
    light
}

/// A piece so dense that panels of equal length would be wasted behind its opaque front: the front half first, and
/// the back half only where light still comes through.
fn halves<T: Real>(piece: &Segment<T>, span: &Span<T>) -> Light<T> {
    let half = T::of(0.5);
    if optical_depth(piece, span) > T::of(1e12) {
        // Seen from the front it is a surface of the colour at its start.
        return Light { color: span.color(piece.f0), absorbed: T::one() };
    }
    let middle = (half, piece.value(half));
    let mut light = exact(&piece.part((T::zero(), piece.f0), middle), span);
    if T::one() - light.absorbed > T::of(T::OPAQUE) {
        light.over(&exact(&piece.part(middle, (T::one(), piece.f1)), span));
    }
    light
}

#[cfg(test)]
mod tests {
    use super::super::transfer::{KernelKnot, Spans};
    use super::*;

    fn spans<T: Real>(extinction: [f64; 2]) -> Spans<T> {
        let knot = |k: usize, color| KernelKnot { value: k as f64, color, extinction: extinction[k] };
        Spans::new(&[knot(0, [0.9, 0.1, 0.3]), knot(1, [0.2, 0.8, 0.3])])
    }

    /// The same integral in steps that grow from the front, so that a dense front is resolved.
    fn brute_force(piece: &Segment<f64>, span: &Span<f64>) -> Light<f64> {
        const STEPS: i32 = 200_000;
        let edge = |i: i32| {
            let w = f64::from(i) / f64::from(STEPS);
            // Half of the steps lie in the first thousandth of the piece and half of those in its thousandth.
            if i == 0 { 0.0 } else { 0.5 * w.powi(12) + 0.5 * w }.min(1.0) * w.powi(3)
        };
        let mut light = Light::none();
        for i in 0..STEPS {
            let (u0, u1) = (edge(i), edge(i + 1));
            let f = piece.value(0.5 * (u0 + u1));
            let absorbed = (span.extinction(f) * piece.length * (u1 - u0)).absorbed_by();
            light.over(&Light { color: span.color(f).map(|c| c * absorbed), absorbed });
        }
        light
    }

    #[test]
    fn exact_pieces_match_fine_steps_from_clear_to_stiff() {
        for extinction in [[0.0, 1.0], [1.0, 0.0], [0.3, 0.7], [1.0, 1.0], [1e-9, 1e-3]] {
            for length in [1e-6, 0.1, 1.0, 10.0, 1e3, 1e6] {
                for (f0, f1, kappa, eps) in
                    [(0.1, 0.9, 0.0, 0.0), (0.9, 0.1, 0.5, -0.3), (0.0, 1.0, 0.8, 0.02), (0.4, 0.4, 0.0, 0.1)]
                {
                    let piece = Segment { f0, f1, kappa, eps, length };
                    let double = spans::<f64>(extinction);
                    let expected = brute_force(&piece, double.span(1));
                    let exact = integrate(Method::Exact, &piece, double.span(1));
                    let narrow = |x: f64| x as f32;
                    let single = Segment {
                        f0: narrow(f0),
                        f1: narrow(f1),
                        kappa: narrow(kappa),
                        eps: narrow(eps),
                        length: narrow(length),
                    };
                    let single = integrate(Method::Exact, &single, spans::<f32>(extinction).span(1));
                    for k in 0..3 {
                        let what =
                            format!("{extinction:?} {piece:?}: {exact:?}, {single:?} against {expected:?}");
                        assert!((exact.color[k] - expected.color[k]).abs() < 3e-6, "{what}");
                        assert!((f64::from(single.color[k]) - expected.color[k]).abs() < 5e-6, "{what}");
                    }
                    assert!((exact.absorbed - expected.absorbed).abs() < 1e-6);
                }
            }
        }
    }

    #[test]
    fn the_bend_integral_is_the_same_on_both_sides_of_the_switch() {
        for eps in [0.019_999_999f64, 0.02, -0.019_999_999, -0.02] {
            let series = (0..20).map(|k| (-eps).powi(k) / f64::from((k + 2) * (k + 3))).sum::<f64>();
            assert!((bend_integral(eps) - series).abs() < 1e-11, "{eps}: {} {series}", bend_integral(eps));
        }
        assert!((bend_integral(0.0f64) - 1.0 / 6.0).abs() < 1e-16);
    }
}
