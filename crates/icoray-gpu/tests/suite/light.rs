//! Functions of `kernel/shade.wgsl` and `kernel/lit.wgsl`, run on tables of inputs, against the same functions on the
//! CPU.

use glam::DVec3;
use icoray::Method;
use icoray::device::Span;
use icoray_kernel::lit::{FrustumInterpolant, LightSpread, Lit, mean_shade};
use icoray_kernel::piece::{ErrorBudget, Radiance};
use icoray_kernel::shade::{MeanShade, RayShading, Shade, Shading};
use icoray_kernel::turn::direction;
use itertools::iproduct;

use crate::dispatch::{Device, SEGMENT_AT, SPAN_AT, absorbing_spans, numbers_of, numbers_of_span, segment, span, ulps};

/// Number of members of the shader's `RayShading`, in its order.
const NUMBERS: usize = 11;
const SHADING_AT: &str = "
fn at3(at: u32) -> vec3f {
    return vec3f(inputs[at], inputs[at + 1u], inputs[at + 2u]);
}
fn shading_at(at: u32) -> RayShading {
    return RayShading(inputs[at], inputs[at + 1u], inputs[at + 2u], inputs[at + 3u], at3(at + 4u), at3(at + 7u),
        inputs[at + 10u]);
}
fn interpolant_at(at: u32) -> FrustumInterpolant {
    return FrustumInterpolant(at3(at), at3(at + 3u), at3(at + 6u), inputs[at + 9u], 0.0);
}";

fn numbers(s: &RayShading<f32>) -> [f32; NUMBERS] {
    let ([lx, ly, lz], [hx, hy, hz]) = (s.light, s.halfway);
    [s.ambient, s.diffuse, s.specular, s.shininess, lx, ly, lz, hx, hy, hz, s.sharpness]
}

const DIRECTION: [f64; 3] = [0.6, -0.48, 0.64];

/// Matt, glossy and mirror-like materials, each under a headlight and under suns from the side, from behind and from
/// the front.
fn shadings() -> Vec<([f64; 4], Option<[f64; 3]>)> {
    let models = [
        [0.35, 0.65, 0.2, 32.0],
        [0.0, 1.0, 0.0, 1.0],
        [0.1, 0.6, 0.9, 200.0],
        [0.2, 0.8, 1.0, 1000.0],
        [1.0, 0.0, 1e-9, 3.0],
    ];
    let back = DIRECTION.map(|x| -x);
    let unit = |direction: [f64; 3]| DVec3::from_array(direction).normalize().to_array();
    let suns = [None, Some(unit([0.3, 0.9, -0.2])), Some(back), Some(unit([0.6, -0.48, 0.6403]))];
    models.iter().flat_map(|model| suns.map(|sun| (*model, sun))).collect()
}

fn along([ambient, diffuse, specular, shininess]: [f64; 4], sun: Option<[f64; 3]>) -> RayShading<f32> {
    let towards_light = sun.map(DVec3::from_array);
    let shading = Shading { ambient, diffuse, specular, shininess, towards_light, is_packed: false };
    shading.along(DVec3::from_array(DIRECTION))
}

fn all_along() -> Vec<RayShading<f32>> {
    shadings().into_iter().map(|(model, sun)| along(model, sun)).collect()
}

/// Gradients of many lengths, across and along the ray, and zero.
fn gradients() -> Vec<[f32; 3]> {
    let directions = [
        [1.0f32, 0.0, 0.0],
        [0.6, -0.48, 0.64],
        [-0.6, 0.48, -0.640_1],
        [0.8, 0.36, -0.48],
        [0.1, 0.7, -0.7],
        [0.601, -0.482, 0.639],
        [1e-9, 1.0, -1e-4],
    ];
    let sizes = [1.0f32, 1e-30, 1e30, 3e4, -0.07];
    let all = directions.iter().flat_map(|d| sizes.map(|size| d.map(|x| x * size)));
    all.chain([[0.0; 3]]).collect()
}

#[test]
fn shading_along_a_ray() {
    let Some(device) = Device::open() else { return };
    let text = format!("#import kernel/lit\n{SHADING_AT}");
    let body = "let at = 18u * i;
        let s = Shading(at3(at), inputs[at + 13u], at3(at + 3u), inputs[at + 14u], inputs[at + 15u], inputs[at + 16u],
            inputs[at + 17u], u32(inputs[at + 12u]), 20u);
        let r = shading_along(s, Wide3(at3(at + 6u), at3(at + 9u)));
        let all = array<f32, 11>(r.ambient, r.diffuse, r.specular, r.shininess, r.light.x, r.light.y, r.light.z,
            r.halfway.x, r.halfway.y, r.halfway.z, r.sharpness);";
    let numbers_of = |(model, sun): &([f64; 4], Option<[f64; 3]>)| {
        let theirs = along(*model, *sun);
        let is_headlight = if sun.is_none() { 1.0 } else { 0.0 };
        let material = [theirs.ambient, theirs.diffuse, theirs.specular, theirs.shininess, theirs.sharpness];
        let [light, dir] = [sun.unwrap_or_default(), DIRECTION].map(icoray_gpu::layout::halves3);
        [light.as_flattened(), dir.as_flattened(), &[is_headlight], &material].concat()
    };
    for ((model, sun), got) in device.run::<_, NUMBERS>(&text, body, shadings(), numbers_of) {
        let expected = along(model, sun);
        for (theirs, ours) in numbers(&expected).iter().zip(got) {
            assert!(ulps(ours, *theirs, 0.1) <= 2.0, "{got:?}, expected {expected:?}");
        }
    }
}

#[test]
fn shades_of_gradients_and_of_the_core() {
    let Some(device) = Device::open() else { return };
    let cases: Vec<_> = iproduct!(all_along(), gradients()).collect();
    let count = cases.len();
    let text = format!("#import kernel/lit\n{SHADING_AT}");
    let body = "let s = ray_shading_shade(shading_at(14u * i), at3(14u * i + 11u));
        let n = direction_of(at3(14u * i + 11u));
        let all = array<f32, 6>(s.body, s.highlight, n.x, n.y, n.z,
            ray_shading_solid(shading_at(14u * i), at3(14u * i + 11u)));";
    let of_case = |(shading, gradient): &(_, [f32; 3])| [&numbers(shading)[..], gradient].concat();
    let mut worst = [0.0f64; 4];
    let mut gleaming = 0;
    for ((shading, gradient), got) in device.run::<_, 6>(&text, body, cases, of_case) {
        let Shade { body, highlight } = shading.shade(gradient);
        let normal = direction(&gradient);
        // Drivers may fuse the products of a cosine with its sum, which then need not cancel.
        worst[0] = worst[0].max(ulps(got[0], body, shading.diffuse));
        // The error of a highlight grows with its exponent; weak highlights have none of their own.
        let sharp = 1.0 + f64::from(shading.shininess);
        worst[1] = worst[1].max(ulps(got[1], highlight, 1e-6) / sharp);
        gleaming += usize::from(highlight > 1e-6);
        for k in 0..3 {
            worst[2] = worst[2].max(ulps(got[2 + k], normal[k], 0.5));
        }
        let unlike = gradient.iter().any(|g| g.abs() > 1e6);
        if !unlike {
            let solid = shading.solid(DVec3::from_array(gradient.map(f64::from)));
            let size = gradient.iter().fold(0.0f32, |max, g| max.max(g.abs()));
            worst[3] = worst[3].max(ulps(got[5], solid, size));
        }
    }
    println!("body, highlight per exponent, normal, core: {worst:?} ulp; {gleaming} of {count}");
    assert!(gleaming > count / 8);
    assert!(worst.iter().all(|w| *w <= 4.0), "{worst:?}");
}

/// Gradients at the start, middle and end of a piece: close together, turning, reversing, zero, missing at one end or
/// in the middle.
const TRIPLES: [[[f32; 3]; 3]; 10] = [
    [[1.0, 0.2, 0.3], [1.0, 0.21, 0.3], [1.0, 0.22, 0.31]],
    [[1.0, 0.0, 0.0], [1.0, 0.01, 0.0], [1.0, 0.0, 0.0]],
    [[0.6, -0.48, 0.64], [0.6, -0.48, 0.641], [0.6, -0.481, 0.644]],
    [[0.64, 0.6, 0.1], [0.66, 0.47, 0.08], [0.67, 0.3, 0.06]],
    [[1.0, 0.0, 0.0], [0.7, 0.7, 0.0], [0.0, 1.0, 0.0]],
    [[1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [-1.0, 0.0, 0.0]],
    [[0.0, 0.0, 0.0]; 3],
    [[0.0, 0.0, 0.0], [0.3, 0.1, -0.3], [0.6, 0.25, -0.7]],
    [[0.6, 0.25, -0.7], [0.3, 0.1, -0.3], [0.0, 0.0, 0.0]],
    [[1e-5, 2e-5, 3e-5], [1.5, 3.0, 4.5], [2e9, 4e9, 6e9]],
];

#[test]
fn mean_shades_and_apply() {
    let Some(device) = Device::open() else { return };
    let lights = [[0.1f32, 0.4, 0.0, 0.5, 1e-5, 1e-14, 1e-10], [2.0, 1.0, 0.5, 1.0, 0.3, 1e-8, 1e-9]];
    let spans_and_lights = spans().into_iter().zip(lights.into_iter().cycle());
    let cases: Vec<_> = iproduct!(all_along(), TRIPLES, PIECES, spans_and_lights).collect();
    let count = cases.len();
    let text = format!("#import kernel/lit\n{SHADING_AT}\n{SEGMENT_AT}\n{SPAN_AT}");
    let body = "let at = 35u * i;
        let s = shading_at(at);
        let mean = mean_shade(s, segment_at(at + 20u), span_at(at + 25u), at3(at + 11u), at3(at + 14u), at3(at + 17u),
            0.0);
        let light = Radiance(at3(at + 28u), inputs[at + 31u], inputs[at + 32u], inputs[at + 33u], inputs[at + 34u]);
        let lit = ray_shading_apply(s, light, mean, vec3f(0.3, -0.1, 0.0));
        let all = array<f32, 12>(mean.shade.body, mean.shade.highlight, mean.tilt, mean.off, mean.rounding,
            lit.color.x, lit.color.y, lit.color.z, lit.alpha, lit.error, lit.variance, lit.shade_variance);";
    let of_case = |(shading, gradients, piece, (span, light)): &(_, [[f32; 3]; 3], [f32; 5], (_, [f32; 7]))| {
        [&numbers(shading)[..], gradients.as_flattened(), piece, &numbers_of_span(span), light].concat()
    };
    let mut near = 0;
    for ((shading, gradients, piece, (span, light)), got) in device.run::<_, 12>(&text, body, cases, of_case) {
        let MeanShade { shade, tilt, off, rounding, .. } = mean_shade(&shading, &segment(piece), &span, &gradients);
        let mean = [shade.body, shade.highlight, tilt, off, rounding];
        let what = format!("{shading:?} {gradients:?} {piece:?} {span:?} {light:?}: {got:?} {mean:?}");
        // Powers have the error of their exponent, and so have cosines that differ by a rounding.
        let sharp = 1.0 + shading.shininess;
        let allowed = 1e-6 * (1.0 + 0.5 * sharp * shading.specular);
        for k in 0..5 {
            assert!((got[k] - mean[k]).abs() <= allowed + 1e-5 * mean[3], "{what}");
        }
        near += usize::from(mean[3] < 1e-2);
        let [r, g, b, alpha, error, variance, shade_variance] = light;
        let light = Radiance { color: [r, g, b], alpha, error, variance, shade_variance };
        // Across gradients that do not cancel.
        let shade = Shade { body: got[0], highlight: got[1] };
        let mean = MeanShade { shade, tilt: got[2], off: got[3], rounding: got[4], size: 1.0 };
        let lit = numbers_of(shading.apply(light, &mean, [0.3, -0.1, 0.0], shading.deviation_of(0.0, 1.0)));
        for k in 0..7 {
            assert!(ulps(got[5 + k], lit[k], if k < 3 { 1.0 } else { 0.0 }) <= 8.0, "{what} {lit:?}");
        }
    }
    assert!(near > count / 10 && near < count, "{near} of {count}");
}

/// Gradients that cancel have normals that rounding turns.
#[test]
fn deviations_of_shades_across_small_gradients() {
    let Some(device) = Device::open() else { return };
    let sizes = [[0.0f32, 1.0], [1.0, 1.0], [1.0, 1e-3], [3e7, 2e-2], [1.0, 0.0], [1e-30, 1e-33]];
    let cases: Vec<_> = iproduct!(all_along(), sizes).collect();
    let body = "let at = 13u * i;
        let all = array<f32, 1>(ray_shading_deviation(shading_at(at), inputs[at + 11u], inputs[at + 12u]));";
    let text = format!("#import kernel/lit\n{SHADING_AT}");
    let of_case = |(shading, sizes): &(_, [f32; 2])| [&numbers(shading)[..], sizes].concat();
    for ((shading, [mixed_of, size]), [got]) in device.run(&text, body, cases, of_case) {
        let expected = shading.deviation_of(mixed_of, size);
        assert!(ulps(got, expected, 0.0) <= 8.0, "{shading:?} {mixed_of} {size}: {got}, expected {expected}");
    }
}

/// Interpolants: gradients at both ends, their bends, ε.
const INTERPOLANTS: [[f32; 10]; 5] = [
    [1.0, 0.2, 0.3, 1.0, 0.21, 0.31, 0.0, 0.0, 0.0, 0.0],
    [1.0, 0.2, 0.3, 0.2, 0.9, -0.3, 0.1, -0.2, 0.05, 1e-3],
    [3e4, -2e3, 10.0, -1e4, 2e4, 5.0, 4e3, 1e2, -3e3, -0.3],
    [1.0, 0.0, 0.0, -1.0, 1e-3, 0.0, 0.0, 0.0, 0.0, 0.8],
    [0.0; 10],
];

fn interpolant_of([ax, ay, az, bx, by, bz, kx, ky, kz, eps]: [f32; 10]) -> FrustumInterpolant<f32, 4> {
    FrustumInterpolant { from: [0.0, ax, ay, az], to: [0.0, bx, by, bz], kappa: [0.0, kx, ky, kz], eps }
}

/// Pieces: f0, f1, kappa, eps, length.
const PIECES: [[f32; 5]; 7] = [
    [0.1, 0.3, 0.0, 0.0, 0.01],
    [0.1, 0.3, 0.1, 1e-3, 1.0],
    [-3.0, 1.0, 3.0, -0.3, 0.2],
    [0.3, -2.0, -0.4, 0.8, 1.0],
    [0.3, 0.3, 0.0, 0.0, 0.05],
    [0.0, 1.0, 1e-7, 1e-9, 1e-6],
    [0.0, 0.0, 3.0, 1e-3, 1.0],
];

fn spans() -> Vec<Span> {
    absorbing_spans().into_iter().chain([span(0.0, 0.0, 0.0)]).collect()
}

#[test]
fn gradients_along_interpolants_and_the_centre_of_light() {
    let Some(device) = Device::open() else { return };
    let cases: Vec<_> = iproduct!(INTERPOLANTS, [0.0f32, 1e-6, 0.3, 0.5, 1.0], PIECES, spans()).collect();
    let text = format!("#import kernel/lit\n{SHADING_AT}\n{SEGMENT_AT}\n{SPAN_AT}");
    let body = "let at = 19u * i;
        let g = frustum_interpolant_gradient(interpolant_at(at), inputs[at + 10u]);
        let s = light_spread_of(segment_at(at + 11u), span_at(at + 16u));
        let all = array<f32, 5>(g.x, g.y, g.z, s.centre, s.error_bound);";
    let of_case = |(interpolant, u, piece, span): &([f32; 10], f32, [f32; 5], Span)| {
        [&interpolant[..], &[*u], piece, &numbers_of_span(span)].concat()
    };
    for ((interpolant, u, piece, span), got) in device.run::<_, 5>(&text, body, cases, of_case) {
        let expected = interpolant_of(interpolant).gradient(u);
        let size = interpolant[..9].iter().fold(0.0f32, |max, x| max.max(x.abs()));
        for k in 0..3 {
            assert!(ulps(got[k], expected[k], size) <= 4.0, "{interpolant:?} {u}: {got:?}, expected {expected:?}");
        }
        let part = segment(piece);
        let ends = [span.extinction(part.f0), span.extinction(part.f1)];
        let LightSpread { centre, error_bound, .. } =
            LightSpread::of(ends, part.length, span.extinction_slope * part.kappa);
        let what = format!("{piece:?} {span:?}: {got:?}, expected {centre} {error_bound}");
        assert!(ulps(got[3], centre, 0.1) <= 4.0 && ulps(got[4], error_bound, 0.0) <= 8.0, "{what}");
    }
}

/// A share of the colours, a shading, a piece, a span, an interpolant, and a part of it with its number of cuts.
type Lighted = (f32, RayShading<f32>, [f32; 5], Span, [f32; 10], ([f32; 2], u32));

/// Lit pieces, which are cut as on the CPU.
#[test]
fn pieces_under_light() {
    let Some(device) = Device::open() else { return };
    let text = format!("#import kernel/lit\n{SHADING_AT}\n{SEGMENT_AT}\n{SPAN_AT}");
    let body = "let at = 35u * i;
        let budget = ErrorBudget(inputs[at + 29u], inputs[at + 30u], inputs[at + 31u], 1e-7);
        let lit = Lit(budget, shading_at(at), span_at(at + 16u), interpolant_at(at + 19u));
        let range = vec2f(inputs[at + 32u], inputs[at + 33u]);
        let light = lit_light(lit, segment_at(at + 11u), range, u32(inputs[at + 34u]), radiance_none());
        let c = light.color;
        let all = array<f32, 7>(c.x, c.y, c.z, light.alpha, light.error, light.variance, light.shade_variance);";
    let cuts = Lit::<f32, 4>::MAX_CUTS;
    let ranges = [([0.0, 1.0], cuts), ([0.2, 0.21], cuts), ([0.0, 1.0], 0)];
    let shares = [5e-3f32, 5e-4, 1e-6];
    let cases: Vec<Lighted> = iproduct!(shares, all_along(), PIECES, spans(), INTERPOLANTS, ranges).collect();
    let of_case = |(share, shading, piece, span, interpolant, (range, cuts)): &Lighted| {
        let allowance = [*share, *share, 0.7];
        let span = numbers_of_span(span);
        [&numbers(shading)[..], piece, &span, interpolant, &allowance, range, &[*cuts as f32]].concat()
    };
    for (method, name) in [(Method::Exact, "exact"), (Method::Paper, "paper")] {
        let constant = [("IS_EXACT", f64::from(u8::from(method == Method::Exact)))];
        let results = device.run_beside::<_, 7>(&text, body, cases.clone(), of_case, &constant, Default::default());
        let mut others = 0;
        for (case, got) in results {
            let (share, ref shading, piece, ref span, interpolant, (range, cuts)) = case;
            let (color_tolerance, min_transmittance) = (share, share);
            let allowance = &ErrorBudget { color_tolerance, min_transmittance, transmittance: 0.7, reach: 1e-7 };
            let interpolant = &interpolant_of(interpolant);
            let lit = Lit { method, allowance, shading, span, interpolant, gradient_size: 0.0 };
            let expected = numbers_of(lit.light(&segment(piece), range, cuts, &Radiance::none()));
            let what = format!("{name} {case:?}: {got:?}, expected {expected:?}");
            let [of_got, of_expected] = [got, expected].map(|light| light[4] + 4.0 * (light[5] + light[6]).sqrt());
            let off = (0..4).map(|k| (got[k] - expected[k]).abs()).fold(0.0, f32::max);
            // Rounding decides about a few cuts, and on which side of a kink a shade is.
            let is_same = off <= 1e-6;
            assert!(is_same || off <= of_got + of_expected, "{what}");
            others += usize::from(!is_same);
        }
        println!("{name}: {others} of {} cut elsewhere", cases.len());
        assert!(others <= cases.len() / 200, "{name}: {others}");
    }
}
