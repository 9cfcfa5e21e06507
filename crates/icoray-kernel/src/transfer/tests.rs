//! Spans and steps of transfer functions, and knots that are left out.

use super::*;
use icoray_test_support::Random;

fn knot(value: f64, gray: f64, extinction: f64) -> KernelKnot {
    KernelKnot { value, color: [gray; 3], extinction }
}

#[test]
fn spans_are_linear_between_knots_and_flat_outside() {
    let spans = Spans::<f64>::new(&[knot(10.0, 0.0, 0.0), knot(20.0, 1.0, 4.0), knot(50.0, 0.5, 0.0)]);
    let look = |v: f64| {
        let f = (v - 10.0) / 40.0;
        let s = spans.span(spans.find(f));
        (s.extinction(f), s.color(f)[0])
    };
    for (v, extinction, gray) in
        [(0.0, 0.0, 0.0), (10.0, 0.0, 0.0), (15.0, 2.0, 0.5), (35.0, 2.0, 0.75), (99.0, 0.0, 0.5)]
    {
        let (e, g) = look(v);
        assert!((e - extinction).abs() < 1e-12 && (g - gray).abs() < 1e-12, "{v}: {e} {g}");
    }
    assert!(spans.span(0).is_clear && spans.span(3).is_clear && !spans.span(1).is_clear);
}

#[test]
fn knots_on_straight_lines_are_left_out_and_no_others() {
    let mut random = Random::new(11);
    for round in 0..300 {
        let within = |random: &mut Random, low: f64, high: f64| low + (high - low) * random.unit();
        let mut at = within(&mut random, -500.0, 500.0);
        let corners: Vec<KernelKnot> = (0..2 + random.below(6))
            .map(|k| {
                // A step now and then.
                at += if k > 0 && random.below(5) == 0 { 0.0 } else { within(&mut random, 0.1, 30.0) };
                knot(at, within(&mut random, 0.0, 1.0), within(&mut random, 0.0, 1e4))
            })
            .collect();
        let mut dense = vec![corners[0]];
        for pair in corners.windows(2) {
            let points = if pair[0].value < pair[1].value { random.below(200) } else { 0 };
            for point in 1..=points {
                let part = point as f64 / (points + 1) as f64;
                let between = |a: f64, b: f64| a + part * (b - a);
                let [a, b] = [pair[0], pair[1]];
                let gray = between(a.color[0], b.color[0]);
                dense.push(knot(between(a.value, b.value), gray, between(a.extinction, b.extinction)));
            }
            dense.push(pair[1]);
        }
        assert_eq!(without_straight(&dense), corners, "round {round}");
        // A bend that single precision would not show is kept.
        let mut bent = corners.clone();
        let (first, last) = (corners[0], corners[corners.len() - 1]);
        bent.push(knot(last.value + 1.0, last.color[0], last.extinction));
        bent.push(knot(last.value + 2.0, last.color[0] + 1e-9, last.extinction));
        bent.insert(0, knot(first.value - 1.0, first.color[0] - 1e-9, first.extinction));
        assert_eq!(without_straight(&bent).len(), bent.len(), "round {round}");
    }
}

#[test]
fn a_step_has_two_sides_and_a_value_on_it_counts_as_above() {
    let spans =
        Spans::<f32>::new(&[knot(0.0, 0.0, 1.0), knot(0.5, 0.0, 1.0), knot(0.5, 1.0, 9.0), knot(1.0, 1.0, 9.0)]);
    assert_eq!(spans.range(), [0.5, 1.5], "values are counted from the step");
    assert_eq!(spans.span(spans.find(0.0)).extinction(0.0), 9.0);
    assert_eq!(spans.span(spans.find(-0.001)).extinction(-0.001), 1.0);
    // Coming from below and stopping on the step stays below; going on goes above.
    let below = spans.find(-0.2);
    assert_eq!(spans.follow(below, 0.0), below);
    assert_eq!(spans.span(spans.follow(below, 0.1)).extinction(0.1), 9.0);
}

#[test]
fn knots_near_zero_keep_their_digits_on_a_scale_of_both_signs() {
    let knots = [-1.0, -1e-4, -1e-8, 0.0, 1e-8, 1e-4, 1.0].map(|value| knot(value, 0.0, 1.0));
    let spans = Spans::<f32>::new(&knots);
    assert_eq!((spans.range(), spans.has_steps()), ([0.0, 2.0], true));
    let lows: Vec<f32> = spans.all()[1..].iter().map(|span| span.low).collect();
    assert_eq!(lows, [-0.5, -5e-5, -5e-9, 0.0, 5e-9, 5e-5, 0.5]);
}

#[test]
fn knots_that_all_but_coincide_are_a_step() {
    let spans = Spans::<f32>::new(&[knot(0.0, 0.0, 1.0), knot(1e-40, 1.0, 9.0), knot(1.0, 0.5, 3.0)]);
    for f in [-1.0, 0.0, 1e-30, 0.5, 1.0, 2.0] {
        let span = spans.span(spans.find(f));
        assert!(span.extinction(f).is_finite() && span.color(f).iter().all(|c| c.is_finite()), "{f}");
    }
    assert_eq!((spans.steps().len(), spans.steps()[0].extinction), (1, 9.0));
}
