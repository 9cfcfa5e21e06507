//! Functions of `kernel/shade.wgsl` and `kernel/lit.wgsl`, run on tables of inputs, against the same functions on the
//! CPU.

use icoray::Method;
use icoray::device::Span;
use icoray::device::mirror::light::{AlongRay, Shade, gradient, mean, spread};

use crate::dispatch::{Device, SEGMENT_AT, absorbing_spans, span, ulps};

/// Number of members of the shader's `RayShading`, in its order.
const NUMBERS: usize = 13;
const SHADING_AT: &str = "
fn at3(at: u32) -> vec3f {
    return vec3f(inputs[at], inputs[at + 1u], inputs[at + 2u]);
}
fn shading_at(at: u32) -> RayShading {
    return RayShading(inputs[at], inputs[at + 1u], inputs[at + 2u], inputs[at + 3u], at3(at + 4u), at3(at + 7u),
        inputs[at + 10u], inputs[at + 11u], inputs[at + 12u]);
}
fn shade_at(at: u32) -> Shade {
    return Shade(inputs[at], inputs[at + 1u], at3(at + 2u));
}
fn interpolant_at(at: u32) -> FrustumInterpolant {
    return FrustumInterpolant(at3(at), at3(at + 3u), at3(at + 6u), inputs[at + 9u]);
}";

fn numbers(s: &AlongRay) -> [f32; NUMBERS] {
    let ([lx, ly, lz], [hx, hy, hz]) = (s.light, s.halfway);
    [s.ambient, s.diffuse, s.specular, s.shininess, lx, ly, lz, hx, hy, hz, s.sharpness, s.blind, s.dull]
}

fn unit([x, y, z]: [f64; 3]) -> [f64; 3] {
    let long = (x * x + y * y + z * z).sqrt();
    [x / long, y / long, z / long]
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
    let suns = [None, Some(unit([0.3, 0.9, -0.2])), Some(back), Some(unit([0.6, -0.48, 0.6403]))];
    models.iter().flat_map(|model| suns.map(|sun| (*model, sun))).collect()
}

fn all_along(share: f64) -> Vec<AlongRay> {
    shadings().into_iter().map(|(model, sun)| AlongRay::new(model, sun, DIRECTION, share)).collect()
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
    let halves3 = icoray_gpu::layout::halves3;
    let (mut inputs, mut expected) = (Vec::new(), Vec::new());
    for (model, sun) in shadings() {
        for share in [5e-4, 1e-7] {
            let theirs = AlongRay::new(model, sun, DIRECTION, share);
            let [dir_hi, dir_lo] = halves3(DIRECTION);
            let [light_hi, light_lo] = halves3(sun.unwrap_or_default());
            inputs.extend([light_hi, light_lo, dir_hi, dir_lo].as_flattened());
            inputs.push(if sun.is_none() { 1.0 } else { 0.0 });
            inputs.extend([theirs.ambient, theirs.diffuse, theirs.specular, theirs.shininess]);
            inputs.extend([theirs.sharpness, theirs.blind, theirs.dull]);
            expected.push(theirs);
        }
    }
    let text = format!("#import kernel/lit\n{SHADING_AT}");
    let body = "let at = 20u * i;
        let s = Shading(at3(at), inputs[at + 13u], at3(at + 3u), inputs[at + 14u], inputs[at + 15u], inputs[at + 16u],
            inputs[at + 17u], inputs[at + 18u], inputs[at + 19u], u32(inputs[at + 12u]), 20u);
        let r = shading_along(s, Wide3(at3(at + 6u), at3(at + 9u)));
        let all = array<f32, 13>(r.ambient, r.diffuse, r.specular, r.shininess, r.light.x, r.light.y, r.light.z,
            r.halfway.x, r.halfway.y, r.halfway.z, r.sharpness, r.blind, r.dull);";
    let got = device.run(&text, body, &inputs, 20, NUMBERS);
    for (expected, got) in expected.iter().zip(got.chunks_exact(NUMBERS)) {
        for (theirs, ours) in numbers(expected).iter().zip(got) {
            assert!(ulps(*ours, *theirs, 0.1) <= 2.0, "{got:?}, expected {expected:?}");
        }
    }
}

#[test]
fn shades_of_gradients_and_of_the_core() {
    let Some(device) = Device::open() else { return };
    let (mut inputs, mut cases) = (Vec::new(), Vec::new());
    for shading in all_along(1e-6) {
        for gradient in gradients() {
            inputs.extend(numbers(&shading));
            inputs.extend(gradient);
            cases.push((shading, gradient));
        }
    }
    let text = format!("#import kernel/lit\n{SHADING_AT}");
    let body = "let s = ray_shading_shade(shading_at(16u * i), at3(16u * i + 13u));
        let all = array<f32, 6>(s.body, s.highlight, s.normal.x, s.normal.y, s.normal.z,
            ray_shading_solid(shading_at(16u * i), at3(16u * i + 13u)));";
    let got = device.run(&text, body, &inputs, 16, 6);
    let mut worst = [0.0f64; 4];
    let mut gleaming = 0;
    for ((shading, gradient), got) in cases.iter().zip(got.chunks_exact(6)) {
        let [body, highlight, normal @ ..] = shading.shade(*gradient);
        let what = format!("{gradient:?} {shading:?}: {got:?}, expected {body} {highlight} {normal:?}");
        worst[0] = worst[0].max(ulps(got[0], body, 0.0));
        // The error of a highlight grows with its exponent; weak highlights are cut off.
        let sharp = 1.0 + f64::from(shading.shininess);
        let is_at_end = got[1].min(highlight) == 0.0 && got[1].max(highlight) <= 1.01 * shading.blind;
        assert!(got[1].min(highlight) > 0.0 || got[1] == highlight || is_at_end, "{what}");
        if got[1].min(highlight) > 0.0 {
            worst[1] = worst[1].max(ulps(got[1], highlight, 0.0) / sharp);
            gleaming += 1;
        }
        for k in 0..3 {
            worst[2] = worst[2].max(ulps(got[2 + k], normal[k], 0.5));
        }
        let unlike = gradient.iter().any(|g| g.abs() > 1e6);
        if !unlike {
            let solid = shading.solid(gradient.map(f64::from));
            let size = gradient.iter().fold(0.0f32, |max, g| max.max(g.abs()));
            worst[3] = worst[3].max(ulps(got[5], solid, size));
        }
    }
    println!("body, highlight per exponent, normal, core: {worst:?} ulp; {gleaming} of {}", cases.len());
    assert!(gleaming > cases.len() / 8);
    assert!(worst.iter().all(|w| *w <= 4.0), "{worst:?}");
}

/// Three shades along a piece: close together, turning, reversing, zero.
fn triples(shading: &AlongRay) -> Vec<[Shade; 3]> {
    let of = |gradients: [[f32; 3]; 3]| gradients.map(|gradient| shading.shade(gradient));
    vec![
        of([[1.0, 0.2, 0.3], [1.0, 0.21, 0.3], [1.0, 0.22, 0.31]]),
        of([[1.0, 0.0, 0.0], [1.0, 0.01, 0.0], [1.0, 0.0, 0.0]]),
        of([[0.6, -0.48, 0.64], [0.6, -0.48, 0.641], [0.6, -0.481, 0.644]]),
        of([[1.0, 0.0, 0.0], [0.7, 0.7, 0.0], [0.0, 1.0, 0.0]]),
        of([[1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]),
        of([[0.0, 0.0, 0.0]; 3]),
        of([[1e-5, 2e-5, 3e-5], [1.5, 3.0, 4.5], [2e9, 4e9, 6e9]]),
    ]
}

#[test]
fn mean_error_bound_and_apply() {
    let Some(device) = Device::open() else { return };
    let lights = [[0.1f32, 0.4, 0.0, 0.5, 1e-5, 1e-14], [0.0; 6], [2.0, 1.0, 0.5, 1.0, 0.3, 1e-8]];
    let (mut inputs, mut cases) = (Vec::new(), Vec::new());
    for shading in all_along(1e-4) {
        for shades in triples(&shading) {
            for (light, by) in lights.iter().zip([0.1f32, 0.0, -0.16]) {
                inputs.extend(numbers(&shading));
                inputs.extend(shades.as_flattened());
                inputs.extend(light);
                inputs.push(by);
                cases.push((shading, shades, *light, by));
            }
        }
    }
    let text = format!("#import kernel/lit\n{SHADING_AT}");
    let body = "let at = 35u * i;
        let s = shading_at(at);
        let a = shade_at(at + 13u);
        let m = shade_at(at + 18u);
        let b = shade_at(at + 23u);
        let light = Radiance(at3(at + 28u), inputs[at + 31u], inputs[at + 32u], inputs[at + 33u]);
        let by = inputs[at + 34u];
        let mean = ray_shading_mean(a, m, b, by);
        let error_bound = ray_shading_error_bound(s, a, m, b, abs(by));
        let lit = ray_shading_apply(s, light, mean, 0.25 * abs(by));
        let all = array<f32, 11>(mean.x, mean.y, f32(error_bound.is_there), error_bound.off.x, error_bound.off.y,
            lit.color.x, lit.color.y, lit.color.z, lit.alpha, lit.error, lit.variance);";
    let got = device.run(&text, body, &inputs, 35, 11);
    let mut bounded = 0;
    for ((shading, shades, light, by), got) in cases.iter().zip(got.chunks_exact(11)) {
        let what = format!("{shading:?} {shades:?} {light:?} {by}: {got:?}");
        let mean = mean(*shades, *by);
        assert!(ulps(got[0], mean.0, 1.0) <= 4.0 && ulps(got[1], mean.1, 1.0) <= 4.0, "{what} {mean:?}");
        let error_bound = shading.error_bound(*shades, by.abs());
        assert_eq!(got[2] == 1.0, error_bound.is_some(), "{what}");
        if let Some((body, highlight)) = error_bound {
            let off = [ulps(got[3], body, 1.0), ulps(got[4], highlight, 1.0)];
            assert!(off.iter().all(|off| *off <= 4.0), "{what} {error_bound:?}");
            bounded += 1;
        }
        let lit = shading.apply(*light, mean, 0.25 * by.abs());
        for k in 0..6 {
            assert!(ulps(got[5 + k], lit[k], if k < 3 { 1.0 } else { 0.0 }) <= 8.0, "{what} {lit:?}");
        }
    }
    assert!(bounded > cases.len() / 3 && bounded < cases.len(), "{bounded} of {}", cases.len());
}

/// Courses: gradients at both ends, their bends, ε.
fn interpolants() -> Vec<[f32; 10]> {
    vec![
        [1.0, 0.2, 0.3, 1.0, 0.21, 0.31, 0.0, 0.0, 0.0, 0.0],
        [1.0, 0.2, 0.3, 0.2, 0.9, -0.3, 0.1, -0.2, 0.05, 1e-3],
        [3e4, -2e3, 10.0, -1e4, 2e4, 5.0, 4e3, 1e2, -3e3, -0.3],
        [1.0, 0.0, 0.0, -1.0, 1e-3, 0.0, 0.0, 0.0, 0.0, 0.8],
        [0.0; 10],
    ]
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

const SPAN_AT: &str = "
fn span_at(at: u32) -> Span {
    let slope = inputs[at + 2u];
    return Span(-3e38, 3e38, -8.0, inputs[at], vec3f(0.1, 0.5, 0.9), inputs[at + 1u],
        vec3f(slope, -0.2 * slope, 0.0), abs(slope), 0u, 0.9);
}";

#[test]
fn gradients_along_interpolants_and_the_centre_of_light() {
    let Some(device) = Device::open() else { return };
    let (mut inputs, mut cases) = (Vec::new(), Vec::new());
    for interpolant in interpolants() {
        for u in [0.0f32, 1e-6, 0.3, 0.5, 1.0] {
            for piece in PIECES {
                for span in spans() {
                    inputs.extend(interpolant);
                    inputs.push(u);
                    inputs.extend(piece);
                    inputs.extend([span.extinction, span.extinction_slope, span.color_slope[0]]);
                    cases.push((interpolant, u, piece, span));
                }
            }
        }
    }
    let text = format!("#import kernel/lit\n{SHADING_AT}\n{SEGMENT_AT}\n{SPAN_AT}");
    let body = "let at = 19u * i;
        let g = frustum_interpolant_gradient(interpolant_at(at), inputs[at + 10u]);
        let s = light_spread_of(segment_at(at + 11u), span_at(at + 16u));
        let all = array<f32, 5>(g.x, g.y, g.z, s.centre, s.error_bound);";
    let got = device.run(&text, body, &inputs, 19, 5);
    for ((interpolant, u, piece, span), got) in cases.iter().zip(got.chunks_exact(5)) {
        let expected = gradient(*interpolant, *u);
        let size = interpolant[..9].iter().fold(0.0f32, |max, x| max.max(x.abs()));
        for k in 0..3 {
            assert!(ulps(got[k], expected[k], size) <= 4.0, "{interpolant:?} {u}: {got:?}, expected {expected:?}");
        }
        let (centre, error_bound) = spread(*piece, span);
        let what = format!("{piece:?} {span:?}: {got:?}, expected {centre} {error_bound}");
        assert!(ulps(got[3], centre, 0.1) <= 4.0 && ulps(got[4], error_bound, 0.0) <= 8.0, "{what}");
    }
}

/// Lit pieces, which are bisected as on the CPU.
#[test]
fn pieces_under_light() {
    let Some(device) = Device::open() else { return };
    let text = format!("#import kernel/lit\n{SHADING_AT}\n{SEGMENT_AT}\n{SPAN_AT}");
    let body = "let at = 38u * i;
        let budget = ErrorBudget(inputs[at + 31u], inputs[at + 32u], inputs[at + 33u], 1e-7);
        let lit = Lit(budget, shading_at(at), span_at(at + 18u), interpolant_at(at + 21u));
        let range = vec2f(inputs[at + 34u], inputs[at + 35u]);
        let light = lit_light(lit, segment_at(at + 13u), range, u32(inputs[at + 36u]));
        let c = light.color;
        let all = array<f32, 6>(c.x, c.y, c.z, light.alpha, light.error, light.variance);";
    let ranges = [([0.0, 1.0], false), ([0.2, 0.21], false), ([0.0, 1.0], true)];
    for (method, name) in [(Method::Exact, "exact"), (Method::Paper, "paper")] {
        let (mut inputs, mut cases) = (Vec::new(), Vec::new());
        for share in [5e-3f32, 5e-4, 1e-6] {
            for shading in all_along(share.into()) {
                for piece in PIECES {
                    for span in spans() {
                        for interpolant in interpolants() {
                            for (range, is_coarse) in ranges {
                                let allowance = [share, share, 0.7, 1e-7];
                                inputs.extend(numbers(&shading));
                                inputs.extend(piece);
                                inputs.extend([span.extinction, span.extinction_slope, span.color_slope[0]]);
                                inputs.extend(interpolant);
                                inputs.extend(&allowance[..3]);
                                inputs.extend(range);
                                inputs.extend([if is_coarse { 0.0 } else { 20.0 }, 0.0]);
                                cases.push((shading, piece, span, interpolant, allowance, range, is_coarse));
                            }
                        }
                    }
                }
            }
        }
        let constant = [("IS_EXACT", f64::from(u8::from(method == Method::Exact)))];
        let got = device.run_with(&text, body, &inputs, 38, 6, &constant);
        let (mut worst, mut others) = (0.0f64, 0);
        for (case, got) in cases.iter().zip(got.chunks_exact(6)) {
            let (shading, piece, span, interpolant, allowance, range, is_coarse) = case;
            let expected = shading.lit(method, *piece, span, *allowance, *interpolant, *range, *is_coarse);
            let what = format!("{name} {case:?}: {got:?}, expected {expected:?}");
            let is_same = (got[4] - expected[4]).abs() <= 1e-3 * expected[4] + 1e-8;
            for k in 0..4 {
                let off = (got[k] - expected[k]).abs();
                if is_same {
                    worst = worst.max(f64::from(off));
                } else {
                    assert!(off <= got[4] + expected[4] + 1e-6 * expected[3], "{what}");
                }
            }
            others += usize::from(!is_same);
        }
        println!("{name}: {worst:e}, {others} of {} cut elsewhere", cases.len());
        assert!(worst <= 1e-6, "{name}: {worst:e}");
        assert!(others <= cases.len() / 50, "{name}: {others}");
    }
}
