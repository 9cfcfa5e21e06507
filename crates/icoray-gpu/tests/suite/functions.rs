//! Functions of the shaders, run on tables of inputs, against the same functions on the CPU.

use icoray::Method;
use icoray::device::{ENDLESS, Span};
use icoray_gpu::layout::{self, Params};
use icoray_grid::real::Real;
use icoray_kernel::piece::{self, ErrorBudget, bend_factor};
use itertools::iproduct;

use crate::dispatch::{Device, SEGMENT_AT, SPAN_AT, absorbing_spans, numbers_of, numbers_of_span, segment, ulps};

/// Segments: f0, f1, kappa, eps, length.
fn segments() -> impl Iterator<Item = [f32; 5]> + Clone {
    iproduct!(
        [0.0, 0.1, -3.0, 0.3],
        [0.0, 0.3, 1.0, -2.0, 0.100_000_01],
        [0.0, 1e-12, 0.2, 3.0, -3.0, -0.4, 1e-7],
        [0.0, 1e-3, -0.3, 0.8, -0.9, 1e-9, -1.6e-5],
        [1e-6, 0.01, 1.0]
    )
    .map(<[f32; 5]>::from)
}

#[test]
fn absorption_and_bend_factor() {
    let Some(device) = Device::open() else { return };
    let depths: Vec<f32> = (-300..60).map(|i| 1.2f32.powi(i)).chain([0.0, 0.5, 0.500_000_06, 100.0, 1e12]).collect();
    let body = "let all = array<f32, 1>(absorbed_by(inputs[i]));";
    for (x, [got]) in device.run("#import kernel/real", body, depths, |x| vec![*x]) {
        let expected = x.absorbed_by();
        assert!(ulps(got, expected, 0.0) <= 4.0, "{x:e}: {got:e}, expected {expected:e}");
    }
    let eps: Vec<f32> = (-999..5000)
        .map(|i| i as f32 / 1000.0)
        .chain((-60..0).flat_map(|i| [1.3f32.powi(i), -1.3f32.powi(i)]))
        .chain([20.0, 1e3, -0.02, 0.02, -0.75, 3.0, -0.999_999, -(1.0 - 0.5 * f32::EPSILON)])
        .filter(|e| *e > -1.0)
        .collect();
    let body = "let all = array<f32, 1>(bend_factor(inputs[i]));";
    for (e, [got]) in device.run("#import kernel/piece", body, eps, |e| vec![*e]) {
        let expected = bend_factor(e);
        // Below -0.75 and above 3 the closed form suffers cancellation.
        let max = if !(-0.75..=3.0).contains(&e) { 64.0 } else { 6.0 };
        assert!(ulps(got, expected, 0.0) <= max, "{e:e}: {got:e}, expected {expected:e}");
    }
}

#[test]
fn segments_value_part_extremum_and_solve() {
    let Some(device) = Device::open() else { return };
    let cases: Vec<([f32; 5], f32)> = iproduct!(segments(), [0.0, 1e-6, 0.3, 0.75, 1.0]).collect();
    let text = format!("#import kernel/segment\n{SEGMENT_AT}");
    let body = "let s = segment_at(6u * i);
        let u = inputs[6u * i + 5u];
        let turn = segment_extremum(s);
        let v = lerp(s.f0, s.f1, u);
        let to = vec2f(1.0, s.f1);
        let part = segment_part(s, vec2f(u, segment_value(s, u)), to);
        let all = array<f32, 9>(segment_value(s, u), f32(turn.is_there), turn.u, turn.f, segment_solve(s, v),
            part.kappa, part.eps, part.length, segment_reach(s));";
    let results = device.run::<_, 9>(&text, body, cases, |(s, u)| [&s[..], &[*u]].concat());
    let mut worst = [0.0f64; 4];
    for ((s, u), got) in results {
        let [f0, f1, kappa, eps, _] = s;
        let what = format!("{s:?} at {u}: {got:?}");
        let s = segment(s);
        let size = f0.abs() + f1.abs() + kappa.abs();
        let value = s.value(u);
        worst[0] = worst[0].max(ulps(got[0], value, size / (1.0 + eps)));
        let turn = s.extremum();
        if turn.is_some() == (got[1] == 1.0) {
            let (at, f) = turn.unwrap_or((got[2], got[3]));
            worst[1] = worst[1].max(ulps(got[2], at, 0.0)).max(ulps(got[3], f, size));
        } else {
            // They disagree only within rounding of the test, with an extremum at an end.
            let (d, at) = (f1 - f0, turn.map_or(got[2], |(at, _)| at));
            let least = (d + kappa).abs().min(((1.0 + eps) * d - kappa).abs());
            assert!(least <= 4.0 * f32::EPSILON * size && !(1e-3..=0.999).contains(&at), "{what}");
        }
        let v = f0 + u * (f1 - f0);
        let solved = s.solve(v);
        // Where f is flat, roots differ much: compare the values there, on monotone segments.
        if turn.is_none() && f0 != f1 {
            let [ours, theirs] = [got[4], solved].map(|u| s.value(u));
            worst[2] = worst[2].max(ulps(ours, theirs, size / (1.0 + eps)));
        }
        let part = s.part((u, value), (1.0, f1));
        for (got, expected) in got[5..8].iter().zip([part.kappa, part.eps, part.length]) {
            worst[3] = worst[3].max(ulps(*got, expected, 0.0));
        }
        assert!(ulps(got[8], s.reach(1.0), 0.0) <= 2.0, "{what}");
    }
    println!("value, extremum, solve, part: {worst:?} ulp");
    let max = [4.0, 16.0, 16.0, 12.0];
    assert!(worst.iter().zip(max).all(|(w, max)| *w <= max), "{worst:?}, expected at most {max:?}");
}

#[test]
fn integrals_of_pieces() {
    let Some(device) = Device::open() else { return };
    let text = format!("#import kernel/piece\n{SEGMENT_AT}\n{SPAN_AT}");
    let body = "let at = 9u * i;
        let light = integrate(segment_at(at), span_at(at + 5u), ErrorBudget(inputs[at + 8u], 1e-5, 1.0, 1e-7));
        let c = light.color;
        let all = array<f32, 7>(c.x, c.y, c.z, light.alpha, light.error, light.variance, light.shade_variance);";
    let cases: Vec<([f32; 5], Span, f32)> = iproduct!(segments(), absorbing_spans(), [5e-3, 5e-4, 1e-6]).collect();
    let numbers =
        |(piece, span, share): &([f32; 5], Span, f32)| [&piece[..], &numbers_of_span(span), &[*share]].concat();
    for (method, name) in [(Method::Exact, "exact"), (Method::Paper, "paper")] {
        let constant = [("IS_EXACT", f64::from(u8::from(method == Method::Exact)))];
        let results = device.run_beside::<_, 7>(&text, body, cases.clone(), numbers, &constant, Default::default());
        let (mut worst, mut others) = (0.0f64, 0);
        for ((piece, span, share), got) in results {
            let (color_tolerance, min_transmittance) = (share, 1e-5);
            let allowance = ErrorBudget { color_tolerance, min_transmittance, transmittance: 1.0, reach: 1e-7 };
            let expected = numbers_of(piece::integrate(method, &segment(piece), &span, &allowance));
            let what = format!("{name} {piece:?} {span:?} {share:e}: {got:?}, expected {expected:?}");
            assert!(ulps(got[3], expected[3], 0.0) <= 64.0, "{what}");
            // At the limit of a rule's error bound, one of the two may choose the next rule.
            let is_same_rule = (got[4] - expected[4]).abs() <= 1e-3 * expected[4] + 1e-9;
            for k in 0..3 {
                let off = (got[k] - expected[k]).abs();
                if is_same_rule {
                    worst = worst.max(ulps(got[k], expected[k], expected[3] * (1.0 + span.steepest * 4.0)));
                } else {
                    others += 1;
                    assert!(off <= got[4] + expected[4] + 1e-6 * expected[3], "{what}");
                }
            }
            assert!(got[5] <= 1.01 * expected[5] + 1e-20 && got[5] >= 0.99 * expected[5] - 1e-20, "{what}");
        }
        println!("{name}: {worst} ulp, {} of {} by another rule", others / 3, cases.len());
        assert!(worst <= 64.0, "{name}: {worst} ulp");
        assert!(others / 3 <= cases.len() / 50, "{name}: {others}");
    }
}

/// Numbers with digits in both halves, near powers of two, close to each other, and of both signs.
fn wide_numbers() -> Vec<f64> {
    let mut all = vec![1.0, -1.0, 3.0, 0.1, -0.7, 1.0 / 3.0, 1e-5, -1e-9, 1e-15, 1e9, 0.999_999_940_395_355_2];
    for k in [1, 12, 23, 24, 25, 30, 40, 46] {
        all.extend([1.0 + 0.5f64.powi(k), -(1.0 - 0.5f64.powi(k)), 0.1 * (1.0 + 3.0 * 0.5f64.powi(k))]);
    }
    all
}

/// Fails on drivers that simplify `(a + b) - a`, or contract to fused operations where these are not allowed.
#[test]
fn double_float_arithmetic() {
    let Some(device) = Device::open() else { return };
    let cases: Vec<_> =
        iproduct!(wide_numbers(), wide_numbers()).map(|(a, b)| (layout::halves(a), layout::halves(b))).collect();
    let body = "let a = Wide(inputs[4u * i], inputs[4u * i + 1u]);
        let b = Wide(inputs[4u * i + 2u], inputs[4u * i + 3u]);
        let a3 = Wide3(vec3f(a.hi, b.hi, 1.0), vec3f(a.lo, b.lo, 0.0));
        let b3 = Wide3(vec3f(b.hi, b.hi, a.hi), vec3f(b.lo, b.lo, a.lo));
        let sum = wide_add(a, b);
        let less = wide_sub(a, b);
        let product = wide_mul(a, b);
        let ratio = wide_div(a, b);
        let root = wide_sqrt(Wide(abs(a.hi), select(-a.lo, a.lo, a.hi > 0.0)));
        let dot = wide3_dot(a3, b3);
        let times = wide_times(a, b.hi);
        let all = array<f32, 15>(sum.hi, sum.lo, less.hi, less.lo, product.hi, product.lo, ratio.hi, ratio.lo,
            root.hi, root.lo, dot.hi, dot.lo, times.hi, times.lo, wide_apart(a, b));";
    let mut worst = [0.0f64; 7];
    for ((a, b), got) in device.run::<_, 15>("#import kernel/wide", body, cases, |(a, b)| [*a, *b].concat()) {
        let [a, b] = [a, b].map(|[hi, lo]| f64::from(hi) + f64::from(lo));
        let b_hi = f64::from(b as f32);
        let dot = a * b + b * b + a;
        let expected = [a + b, a - b, a * b, a / b, a.abs().sqrt(), dot, a * b_hi];
        for k in 0..7 {
            let value = f64::from(got[2 * k]) + f64::from(got[2 * k + 1]);
            // The error of a dot product is relative to its largest term. Low halves below f32's smallest number are
            // lost.
            let size = if k == 5 { (a * b).abs().max(b * b).max(a.abs()) } else { expected[k].abs() };
            let off = ((value - expected[k]).abs() - 1e-37).max(0.0);
            worst[k] = worst[k].max(if off == 0.0 { 0.0 } else { off / size });
        }
        let apart = f64::from(got[14]);
        let off = (apart - (a - b)).abs();
        assert!(off <= 2e-7 * (a - b).abs() + 1e-14 * a.abs().max(b.abs()), "{a} - {b}: {apart}");
        assert_eq!(apart > 0.0, a > b, "{a} - {b}: {apart}");
    }
    println!("add, sub, mul, div, sqrt, dot, times: {:?} bits", worst.map(|w| -w.log2()));
    assert!(worst.iter().all(|w| *w <= 0.5f64.powi(44)), "{worst:?}");
}

/// The variant for few knots finds the same spans as the binary search.
#[test]
fn spans_of_few_knots() {
    let Some(device) = Device::open() else { return };
    for knots in [&[][..], &[0.25], &[0.25, 0.25], &[-1.0, 0.0, 0.5], &[0.0, 0.3, 0.3, 1.0], &[0.5; 4]] {
        let edges: Vec<f32> = [&[-ENDLESS][..], knots, &[ENDLESS]].concat();
        let spans: Vec<layout::Span> =
            edges.windows(2).map(|e| layout::Span { low: e[0], high: e[1], ..Default::default() }).collect();
        let mut params = Params { spans: spans.len() as u32, knots: [ENDLESS; 4], ..Default::default() };
        params.knots[..knots.len()].copy_from_slice(knots);
        let values = knots.iter().copied().chain([-1e15, -2.0, -0.0, 0.1, 0.7, 1e15]);
        let values = values.flat_map(|value| [value.next_down(), value, value.next_up()]);
        let inputs: Vec<[f32; 2]> =
            iproduct!(values, 0..spans.len()).map(|(value, from)| [value, from as f32]).collect();
        let body = "let f = inputs[2u * i];
            let k = u32(inputs[2u * i + 1u]);
            let all = array<f32, 4>(f32(spans_find(f)), f32(spans_search(f)), f32(spans_follow(k, f)),
                f32(spans_walk(k, f)));";
        let beside = (params, &[(4, bytemuck::cast_slice(&spans))][..]);
        let constants = [("FEW_KNOTS", 1.0)];
        let results = device.run_beside::<_, 4>(
            "#import kernel/transfer",
            body,
            inputs,
            |input| input.to_vec(),
            &constants,
            beside,
        );
        for (input, row) in results {
            assert!(row[0] == row[1] && row[2] == row[3], "{knots:?}, value and span {input:?}: {row:?}");
        }
    }
}
