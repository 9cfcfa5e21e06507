use super::*;
use crate::budget::Budget;
use crate::shade::Shading;
use crate::transfer::{KernelKnot, Spans};
use glam::DVec3;
use icoray_test_support::Random;

/// Error of a sum of 4,000 steps per absorbed light, at kinks and narrow highlights.
const STEP_ERROR: f64 = 3e-6;

/// A piece that is a whole frustum, in a medium under light.
struct Case {
    piece: Segment<f64>,
    knots: [KernelKnot; 2],
    spans: Spans<f64>,
    interpolant: FrustumInterpolant<f64, 4>,
    shading: RayShading<f64>,
}

impl Case {
    fn lit(&self, color_tolerance: f64, cuts: u32) -> Radiance<f64> {
        let allowance = ErrorBudget { color_tolerance, min_transmittance: 0.0, transmittance: 1.0, reach: 0.0 };
        let lit = Lit {
            method: Method::Exact,
            allowance: &allowance,
            shading: &self.shading,
            span: self.spans.span(1),
            interpolant: &self.interpolant,
            gradient_size: 0.0,
        };
        lit.light(&self.piece, [0.0, 1.0], cuts, &Radiance::none())
    }

    /// The error of `light`, and its bound.
    fn error(&self, light: &Radiance<f64>) -> (f64, f64) {
        let (exact, absorbed) = self.by_sum(4_000);
        let (off, reported) =
            (largest_difference(&light.color, &exact), light.total_error(true) + STEP_ERROR * absorbed);
        if off <= reported {
            return (off, reported);
        }
        // A normal that swings round within few steps needs more.
        (largest_difference(&light.color, &self.by_sum(400_000).0), reported)
    }

    /// Its light by this number of midpoints, and the absorbed part.
    fn by_sum(&self, steps: usize) -> ([f64; 3], f64) {
        let span = self.spans.span(1);
        let (mut color, mut depth) = ([0.0; 3], 0.0f64);
        for i in 0..steps {
            let u = (i as f64 + 0.5) / steps as f64;
            let f = self.piece.value(u);
            let step = span.extinction(f) * self.piece.length / steps as f64;
            let absorbed = (-depth).exp() * -(-step).exp_m1();
            depth += step;
            let shade = self.shading.shade(self.interpolant.gradient(u));
            let own = span.color(f);
            for k in 0..3 {
                color[k] += absorbed * (own[k] * shade.body + shade.highlight);
            }
        }
        (color, -(-depth).exp_m1())
    }
}

fn vector(random: &mut Random) -> DVec3 {
    DVec3::from_array(random.direction())
}

/// Ten to a random power.
fn power(random: &mut Random, low: f64, high: f64) -> f64 {
    10f64.powf(low + (high - low) * random.unit())
}

/// Gradients at start and end that differ by about `turn`, and their bend.
fn gradients(random: &mut Random, turn: f64) -> [DVec3; 3] {
    let base = vector(random);
    let [mut from, to] = [(); 2].map(|()| base + turn * vector(random));
    let bend = turn * power(random, -3.0, 0.0) * vector(random);
    match random.unit() {
        x if x < 0.02 => from = DVec3::ZERO,
        x if x < 0.04 => return [from, -from + 0.05 * vector(random), bend],
        x if x < 0.05 => return [base, base, DVec3::ZERO],
        x if x < 0.06 => return [DVec3::ZERO, DVec3::ZERO, if x < 0.055 { DVec3::ZERO } else { bend }],
        // The gradient nearly vanishes at one end, and keeps its bend.
        x if x < 0.15 => from *= power(random, -3.0, 0.0),
        _ => {}
    }
    [from, to, bend]
}

/// Light towards anywhere, often across the normal or near the middle of the highlight.
fn directions(random: &mut Random, normal: DVec3, turn: f64, shininess: f64) -> [DVec3; 2] {
    let mut light = vector(random);
    if random.unit() < 0.3 {
        let across = (light - light.dot(normal) * normal).normalize_or(light);
        light = (across + turn.min(1.0) * (2.0 * random.unit() - 1.0) * normal).normalize();
    }
    let width = (turn + 1.0 / shininess.sqrt()).min(2.0);
    let near = (normal + power(random, -3.0, 0.0) * width * vector(random)).normalize_or(normal);
    [light, if random.unit() < 0.7 { near } else { vector(random) }]
}

fn case(random: &mut Random, number: usize) -> Case {
    let turn = power(random, -2.5, 0.5);
    let eps = [0.0, 0.01, -0.3, 0.8][number % 4];
    let [from, to, kappa] = gradients(random, turn);
    let with = |value: f64, gradient: DVec3| [value, gradient.x, gradient.y, gradient.z];
    let interpolant = FrustumInterpolant { from: with(0.0, from), to: with(0.0, to), kappa: with(0.0, kappa), eps };
    let f0: f64 = 0.1 + 0.8 * random.unit();
    let change = if random.unit() < 0.5 { 1.0 } else { 0.1 };
    let f1 = f0 + change * (0.1 + 0.8 * random.unit() - f0);
    // Small enough for the value to stay in its span.
    let kappa = (random.unit() - 0.5) * power(random, -2.0, 0.0) * 0.3 * (f1 - f0).abs();
    let piece = Segment { f0, f1, kappa, eps, length: power(random, -3.0, 1.0) };
    let extinctions = [[1.0, 1.0], [0.0, 1.0], [1.0, 0.0], [random.unit(), random.unit()]][number / 4 % 4];
    let color = [(); 2].map(|()| [random.unit(), random.unit(), random.unit()]);
    let colors = [color[0], color[usize::from(random.unit() < 0.7)]];
    let knot = |k: usize| KernelKnot { value: k as f64, color: colors[k], extinction: extinctions[k] };
    let shininess = [1.0, 1.5, 2.0, 3.0, 8.0, 32.0, 100.0, 1000.0, 5000.0][number / 16 % 9];
    let normal = DVec3::from_array(interpolant.gradient(0.5)).normalize_or_zero();
    let [light, halfway] = directions(random, normal, turn, shininess);
    let specular = [0.0, 0.2, 1.0][number / 144 % 3];
    let shading =
        Shading { ambient: 0.3, diffuse: 0.7, specular, shininess, towards_light: Some(light), is_packed: false };
    let shading = RayShading { halfway: halfway.to_array(), ..shading.along(-halfway) };
    let knots = [knot(0), knot(1)];
    Case { piece, knots, spans: Spans::new(&knots), interpolant, shading }
}

fn largest_difference(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).abs()).fold(0.0, f64::max)
}

#[test]
fn one_shade_is_within_its_reported_error() {
    let mut random = Random::new(7);
    let cases = icoray_test_support::count(3_000, 200_000);
    let mut small = 0;
    for number in 0..cases {
        let case = case(&mut random, number);
        let light = case.lit(1e-6, 0);
        let (off, reported) = case.error(&light);
        let case = (case.piece, case.interpolant, case.shading);
        assert!(off <= reported, "{number}: {off} off, {reported} reported, {light:?}\n{case:?}");
        small += usize::from(reported < 1e-2 * light.alpha);
    }
    // Errors of one are easily right.
    assert!(small > cases / 3, "{small} of {cases}");
}

#[test]
fn pieces_are_cut_until_they_can_be_afforded() {
    let mut random = Random::new(11);
    for number in 0..icoray_test_support::count(10_000, 50_000) {
        let mut case = case(&mut random, number);
        // The rounding of gradients is not reduced by cuts.
        case.shading.deviations = [0.0; 2];
        for color_tolerance in [5e-3, 5e-4, 5e-5] {
            let light = case.lit(color_tolerance, Lit::<f64, 4>::MAX_CUTS);
            let (off, reported) = case.error(&light);
            let all = (case.piece, case.interpolant, case.shading);
            assert!(off <= reported, "{number}, {color_tolerance}: {off} off, {reported} reported, {light:?}\n{all:?}");
            // Colours have the tolerance once more.
            let allowed = color_tolerance * (2.0 * light.alpha + ADVANCE);
            assert!(light.total_error(true) <= allowed, "{number}, {color_tolerance}: {light:?}");
        }
    }
}

#[test]
fn a_missing_normal_has_ambient_light() {
    let mut random = Random::new(3);
    let mut case = case(&mut random, 0);
    (case.interpolant.from, case.interpolant.to, case.interpolant.kappa) = ([0.0; 4], [0.0; 4], [0.0; 4]);
    case.shading.ambient = 0.0;
    let light = case.lit(1e-3, 0);
    assert_eq!((light.color, light.total_error(true) < 1e-3 * light.alpha), ([0.0; 3], true));
}

/// In f32, with gradients of any size.
#[test]
fn sizes_of_gradients_do_not_matter() {
    let shading =
        Shading { ambient: 0.2, diffuse: 0.7, specular: 0.5, shininess: 32.0, towards_light: None, is_packed: false };
    let shading = shading.along::<f32>(DVec3::new(-0.6, -0.8, 0.0));
    let knot = |value: f64, gray: f64| KernelKnot { value, color: [gray; 3], extinction: 2.0 };
    let spans = Spans::<f32>::new(&[knot(0.0, 0.1), knot(1.0, 0.9)]);
    let piece = Segment { f0: 0.2, f1: 0.7, kappa: 0.1, eps: 0.1, length: 0.3 };
    let of = |size: f32| {
        let gradients = [[0.9, 0.4, 0.1], [0.8, 0.5, 0.12], [0.7, 0.62, 0.13]].map(|g| g.map(|x: f32| x * size));
        mean_shade(&shading, &piece, spans.span(1), &gradients)
    };
    let plain = of(1.0);
    assert!(plain.off > 0.0 && plain.off < 5e-2 && plain.shade.highlight > 0.01, "{plain:?}");
    for size in [1e-38, 1e-30, 1e-10, 1e10, 1e30, 1e38] {
        let other = of(size);
        assert!((other.shade.body - plain.shade.body).abs() < 1e-6, "{size}: {other:?}");
        assert!((other.shade.highlight - plain.shade.highlight).abs() < 1e-5, "{size}: {other:?}");
        assert!((other.off - plain.off).abs() < 1e-5, "{size}: {other:?}");
    }
    for broken in [0.0, f32::INFINITY, f32::NAN] {
        let other = of(broken);
        let is_dark = other.shade.body == shading.ambient && other.shade.highlight < 1e-30 && other.tilt == 0.0;
        assert!(is_dark && other.off <= 0.9 * 0.7 + 0.5 + 1e-6, "{broken}: {other:?}");
    }
}

/// Otherwise pieces would be cut without end.
#[test]
fn the_rounding_of_a_shade_can_be_afforded() {
    let knot = |value: f64| KernelKnot { value, color: [0.9; 3], extinction: 2.0 };
    let spans = Spans::<f32>::new(&[knot(0.0), knot(1.0)]);
    let piece = Segment { f0: 0.2, f1: 0.7, kappa: 0.0, eps: 0.1, length: 0.3 };
    for shininess in [1.0, 8.0, 100.0, 5000.0] {
        for specular in [0.0, 0.2, 1.0] {
            let shading =
                Shading { ambient: 0.2, diffuse: 0.7, specular, shininess, towards_light: None, is_packed: false };
            let mean = mean_shade(&shading.along(DVec3::NEG_X), &piece, spans.span(1), &[[1.0, 0.0, 0.0]; 3]);
            let budget = Budget::new(1e-9, 0.9 * 0.9 + specular, Some(0.9));
            let allowed = budget.color_tolerance_in::<f32>(Some(&shading)) as f32;
            assert!(
                mean.rounding > 1e-7 && mean.off + mean.rounding < 0.6 * allowed,
                "{shininess}, {specular}: {mean:?}, {allowed}"
            );
        }
    }
}

/// Shorter pieces have the rounding of longer ones.
#[test]
fn rounding_uses_up_no_budget() {
    let (tolerance, off) = (1e-3, [0.0, 2e-3]);
    let before = Radiance { alpha: 0.5, ..Radiance::none() };
    assert!(is_affordable(&Radiance { variance: 1.0, ..before }, 0.1, off, tolerance));
    assert!(!is_affordable(&Radiance { shade_variance: 1.0, ..before }, 0.1, off, tolerance));
}

/// The gradients at the vertices are the same for all parts of a piece, and larger than those at its start.
#[test]
fn cuts_do_not_reduce_the_rounding_of_gradients() {
    let mut case = case(&mut Random::new(9), 1);
    (case.interpolant.from, case.interpolant.to) = ([0.0, 0.1, 0.0, 0.0], [0.0, 0.0, 0.9, 0.0]);
    case.piece.length = 1e-3;
    let both = |case: &Case| [0, Lit::<f64, 4>::MAX_CUTS].map(|cuts| case.lit(1e-6, cuts));
    let exact = both(&case);
    assert!(exact[1].total_error(true) < 0.01 * exact[0].total_error(true), "{exact:?}");
    case.shading.deviations = [0.0, 1e-3];
    let rounded = both(&case);
    let [of_whole, of_parts] =
        [0, 1].map(|cut| (rounded[cut].variance - exact[cut].variance).sqrt() / exact[cut].alpha);
    assert!(of_whole > 0.999e-3 && of_parts > 2.0 * of_whole, "{of_whole} {of_parts}");
}

/// The same piece in f32.
fn in_single(case: &Case) -> Radiance<f32> {
    let narrow = |values: [f64; 4]| values.map(|x| x as f32);
    let FrustumInterpolant { from, to, kappa, eps } = case.interpolant;
    let interpolant = FrustumInterpolant { from: narrow(from), to: narrow(to), kappa: narrow(kappa), eps: eps as f32 };
    let Segment { f0, f1, kappa, eps, length } = case.piece;
    let [f0, f1, kappa, eps, length] = [f0, f1, kappa, eps, length].map(|x| x as f32);
    let piece = Segment { f0, f1, kappa, eps, length };
    let RayShading { ambient, diffuse, specular, shininess, light, halfway, sharpness, .. } = case.shading;
    let deviations = [0.25 * f32::EPSILON * sharpness as f32, 0.0];
    let [ambient, diffuse, specular, shininess, sharpness] =
        [ambient, diffuse, specular, shininess, sharpness].map(|x| x as f32);
    let [light, halfway] = [light, halfway].map(|d| d.map(|x| x as f32));
    let shading = RayShading { ambient, diffuse, specular, shininess, light, halfway, sharpness, deviations };
    let allowance =
        ErrorBudget { color_tolerance: 1e-6, min_transmittance: 0.0, transmittance: 1.0, reach: piece.reach(1.0) };
    let spans = Spans::<f32>::new(&case.knots);
    let (span, method) = (spans.span(1), Method::Exact);
    let lit =
        Lit { method, allowance: &allowance, shading: &shading, span, interpolant: &interpolant, gradient_size: 0.0 };
    lit.light(&piece, [0.0, 1.0], 0, &Radiance::none())
}

#[test]
fn single_precision_adds_no_more_than_rounding() {
    let mut random = Random::new(5);
    for number in 0..icoray_test_support::count(10_000, 500_000) {
        let case = case(&mut random, number);
        let (wide, narrow) = (case.lit(1e-6, 0), in_single(&case).wide());
        // Where n may be across the light, one of the two may see it cross and the other not.
        if wide.total_error(true) < 1e-4 * wide.alpha {
            let off = largest_difference(&wide.color, &narrow.color);
            let deviation = (narrow.total_variance() - wide.total_variance()).abs().sqrt();
            let rounded = narrow.error - wide.error + LIT_DEVIATIONS * deviation;
            assert!(off <= rounded, "{number}: {off} of {wide:?} and {narrow:?}, {rounded} reported");
        }
    }
}
