//! Pieces against a reference of its own, from clear to stiff.

use super::super::transfer::{KernelKnot, Spans};
use super::*;

fn spans<T: Real>(extinction: [f64; 2]) -> Spans<T> {
    let knot = |k: usize, color| KernelKnot { value: k as f64, color, extinction: extinction[k] };
    Spans::new(&[knot(0, [0.9, 0.1, 0.3]), knot(1, [0.2, 0.8, 0.3])])
}

/// The integral of `f` from `a` to `b` by Gauss's 4-point rule.
fn gauss4(a: f64, b: f64, f: impl Fn(f64) -> f64) -> f64 {
    let nodes =
        [(0.861_136_311_594_052_6, 0.347_854_845_137_453_9), (0.339_981_043_584_856_3, 0.652_145_154_862_546_1)];
    let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
    nodes.iter().map(|(x, w)| half * w * (f(middle - half * x) + f(middle + half * x))).sum()
}

/// The integral to about 1e-13, in steps that grow from the front, so that a dense front is resolved.
fn reference(piece: &Segment<f64>, span: &Span<f64>) -> Radiance<f64> {
    let sigma = |u: f64| piece.length * span.extinction(piece.value(u));
    let mut light = Radiance::none();
    let mut u = 0.0f64;
    while u < 1.0 && light.alpha < 1.0 - 1e-15 {
        let mut step = (1.0 - u).min(0.01);
        while gauss4(u, u + step, sigma) > 0.1 {
            step *= 0.5;
        }
        let depth = |to: f64| gauss4(u, to, sigma);
        let absorbed = depth(u + step).absorbed_by();
        let color =
            [0, 1, 2].map(|k| gauss4(u, u + step, |v| span.color(piece.value(v))[k] * sigma(v) * (-depth(v)).exp()));
        light.over(&Radiance { color, alpha: absorbed, ..Radiance::none() });
        u += step;
    }
    light
}

fn cases() -> Vec<([f64; 2], Segment<f64>)> {
    let shapes = [
        (0.1, 0.9, 0.0, 0.0),
        (0.9, 0.1, 0.5, -0.3),
        (0.0, 1.0, 0.8, 0.02),
        (0.4, 0.4, 0.0, 0.1),
        (0.5, 0.5, 1.2, 0.01),
        (0.8, 0.3, -0.4, -0.9),
        (0.2, 0.21, 0.004, 1.5),
    ];
    let mut cases = Vec::new();
    for extinction in [[0.0, 1.0], [1.0, 0.0], [0.3, 0.7], [1.0, 1.0], [1e-9, 1e-3]] {
        for length in [1e-9, 1e-3, 0.1, 1.0, 10.0, 1e3, 1e6, 1e12] {
            for (f0, f1, kappa, eps) in shapes {
                cases.push((extinction, Segment { f0, f1, kappa, eps, length }));
            }
        }
    }
    cases
}

fn allowance<T: Real>(share: f64) -> ErrorBudget<T> {
    ErrorBudget {
        color_tolerance: T::of(share),
        min_transmittance: T::of(share),
        transmittance: T::one(),
        reach: T::of(2.0 * T::ROUNDING),
    }
}

fn narrow(piece: &Segment<f64>) -> Segment<f32> {
    let Segment { f0, f1, kappa, eps, length } = *piece;
    Segment { f0: f0 as f32, f1: f1 as f32, kappa: kappa as f32, eps: eps as f32, length: length as f32 }
}

/// The error of `light` against `expected`: the largest difference of a channel.
fn distance(light: &Radiance<f64>, expected: &Radiance<f64>) -> f64 {
    (0..3).fold(0.0, |most: f64, k| most.max((light.color[k] - expected.color[k]).abs()))
}

#[test]
fn the_bound_holds_from_clear_to_stiff_and_is_within_the_allowance() {
    let mut ratios = Vec::new();
    for (extinction, piece) in cases() {
        let double = spans::<f64>(extinction);
        let expected = reference(&piece, double.span(1));
        for exponent in 1..=10 {
            let share = 0.1f64.powi(exponent);
            let light = integrate(Method::Exact, &piece, double.span(1), &allowance(share));
            let off = distance(&light, &expected);
            let what = format!("{extinction:?} {piece:?} to {share:e}: {light:?} against {expected:?}");
            // What the back of a stiff piece is left out of is the caller's to count.
            let rest = if light.alpha < expected.alpha - 1e-12 { share } else { 0.0 };
            assert!(off <= light.error + rest + 2e-13, "{what}");
            assert!(light.error <= 1.01 * share * light.alpha + 1e-300, "{what}");
            assert!((light.alpha - expected.alpha).abs() <= rest + 1e-12, "{what}");
            if off > 1e-12 && rest == 0.0 {
                ratios.push(light.error / off);
            }
        }
    }
    ratios.sort_by(f64::total_cmp);
    let median = ratios[ratios.len() / 2];
    println!("{} pieces, bound over error: median {median:.1}", ratios.len());
    assert!(ratios.len() > 300 && median < 20.0, "{median}");
}

#[test]
fn rounding_in_single_precision_is_counted() {
    for (extinction, piece) in cases() {
        let expected = reference(&piece, spans::<f64>(extinction).span(1));
        let single = integrate(Method::Exact, &narrow(&piece), spans::<f32>(extinction).span(1), &allowance(1e-6));
        let off = single.color.iter().zip(expected.color).map(|(a, b)| (f64::from(*a) - b).abs());
        let off = off.fold(0.0, f64::max);
        let counted = f64::from(single.error) + 6.0 * f64::from(single.variance).sqrt() + 1e-6;
        assert!(off <= counted, "{extinction:?} {piece:?}: {single:?} against {expected:?}");
        assert!(off < 2e-6, "{extinction:?} {piece:?}: {single:?} against {expected:?}");
    }
}

/// Errors of `rule` on 1, 2, 4, ... equal parts of a piece: how often halving the parts halves the error.
fn orders(rule: impl Fn(&Segment<f64>, &Span<f64>) -> Radiance<f64>) -> Vec<f64> {
    let piece = Segment { f0: 0.2, f1: 0.7, kappa: 0.3, eps: 0.0, length: 0.8 };
    let spans = spans::<f64>([0.4, 1.0]);
    let span = spans.span(1);
    let expected = reference(&piece, span);
    let error = |parts: i32| {
        let mut light = Radiance::none();
        for i in 0..parts {
            let [a, b] = [i, i + 1].map(|i| f64::from(i) / f64::from(parts));
            light.over(&rule(&piece.part((a, piece.value(a)), (b, piece.value(b))), span));
        }
        distance(&light, &expected)
    };
    let errors = [1, 2, 4, 8].map(error);
    println!("{errors:?}");
    errors.windows(2).map(|e| (e[0] / e[1]).log2()).collect()
}

#[test]
fn each_rule_has_its_order() {
    let paper = orders(|piece, span| linear(&Terms::new(piece, span)));
    let by = |rule: fn(&Terms<'_, f64>) -> f64| {
        orders(move |piece, span| {
            let terms = Terms::new(piece, span);
            terms.light(terms.depth.absorbed_by(), rule(&terms), 0.0)
        })
    };
    let (thin, gauss) = (by(thin), by(gauss));
    println!("paper {paper:.2?}, thin {thin:.2?}, gauss {gauss:.2?}");
    for (orders, order) in [(&paper, 2.0), (&thin, 3.0), (&gauss, 4.0)] {
        assert!(orders.iter().skip(1).all(|o| *o > order - 0.2), "{orders:?}, expected {order}");
    }
}

#[test]
fn the_bend_is_the_same_on_both_sides_of_the_switch() {
    for eps in [0.019_999_999f64, 0.02, -0.019_999_999, -0.02] {
        let series = (0..20).map(|k| 6.0 * (-eps).powi(k) / f64::from((k + 2) * (k + 3))).sum::<f64>();
        assert!((bend_factor(eps) - series).abs() < 6e-11, "{eps}: {} {series}", bend_factor(eps));
    }
    assert!((bend_factor(0.0f64) - 1.0).abs() < 1e-16);
}

/// Beyond all numbers of f32 a piece is a surface of the colour at its start, and no NaN comes of it.
#[test]
fn pieces_of_any_depth_are_finite() {
    fn check<T: Real>(piece: &Segment<T>) {
        let spans = spans::<T>([0.0, 1.0]);
        let light = integrate(Method::Exact, piece, spans.span(1), &allowance(1e-6));
        let start = spans.span(1).color(piece.f0);
        assert!(light.error.is_finite() && light.variance.is_finite(), "{}", light.error.wide());
        for (channel, color) in light.color.iter().zip(start) {
            assert!((channel.wide() - color.wide()).abs() < 1e-4, "{}", channel.wide());
        }
    }
    for length in [1e13, 1e16, 1e24, 1e36] {
        for kappa in [0.0, 0.2] {
            let piece = Segment { f0: 0.1, f1: 0.9, kappa, eps: 0.0, length };
            check(&piece);
            check(&narrow(&piece));
        }
    }
}
