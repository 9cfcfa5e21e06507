use super::*;
use crate::lit::{ADVANCE, HALVINGS_ALONG, HALVINGS_AT_START};
use crate::shade::{Shade, Shading};
use crate::transfer::KernelKnot;
use glam::DVec3;
use icoray_test_support::{Random, count};

fn knot(value: f64, color: [f64; 3], extinction: f64) -> KernelKnot {
    KernelKnot { value, color, extinction }
}

fn medium(source: usize, knots: &[KernelKnot]) -> Medium {
    Medium::new(TransferMap::new(source, knots.to_vec()), TransferMap::new(source, knots.to_vec()))
}

fn segment(f0: f64, f1: f64, kappa: f64, eps: f64, length: f64) -> Segment<f64> {
    Segment { f0, f1, kappa, eps, length }
}

/// The light of parts by midpoints, each as exact as its middle, and the absorbed part; `shade` is that of a part at a
/// place.
fn by_midpoints(
    parts: &[MediumPiece],
    shade: impl Fn(&MediumPiece, f64) -> Shade<f64>,
    length: f64,
    steps: usize,
) -> ([f64; 3], f64) {
    let (mut color, mut depth) = ([0.0; 3], 0.0f64);
    for i in 0..steps {
        let u = (i as f64 + 0.5) / steps as f64;
        let rate: f64 = parts.iter().map(|part| part.extinction(u)).sum();
        let step = rate * length / steps as f64;
        if rate == 0.0 {
            continue;
        }
        let absorbed = (-depth).exp() * -(-step).exp_m1();
        for part in parts {
            let (share, c, shade) = (part.extinction(u) / rate, part.at(u).color, shade(part, u));
            color = [0, 1, 2].map(|k| color[k] + absorbed * share * (c[k] * shade.body + shade.highlight));
        }
        depth += step;
    }
    (color, -(-depth).exp_m1())
}

/// The light of parts whose fields have these gradients.
fn lit(
    parts: &[MediumPiece],
    gradient: impl Fn(usize, f64) -> [f64; 3],
    shading: Option<&RayShading<f64>>,
    color_tolerance: f64,
) -> Radiance<f64> {
    let mut light = Radiance::none();
    let blend = Blend { parts, gradient, shading, color_tolerance, min_transmittance: 0.0 };
    blend.add(&mut light, 0.0, 1.0, &mut BlendBuffers::default());
    light
}

fn blended(parts: &[MediumPiece], color_tolerance: f64) -> Radiance<f64> {
    lit(parts, |_, _| [0.0; 3], None, color_tolerance)
}

/// The largest difference of a channel.
fn off(light: &Radiance<f64>, exact: &[f64; 3]) -> f64 {
    (0..3).map(|k| (light.color[k] - exact[k]).abs()).fold(0.0, f64::max)
}

fn shading(specular: f64, shininess: f64) -> Shading {
    Shading { ambient: 0.3, diffuse: 0.7, specular, shininess, towards_light: None, is_packed: false }
}

#[test]
fn mixed_media_are_those_of_a_million_steps() {
    let red = medium(0, &[knot(0.0, [1.0, 0.1, 0.0], 0.3), knot(1.0, [0.4, 0.0, 0.2], 3.0)]);
    let blue = medium(1, &[knot(10.0, [0.0, 0.2, 1.0], 5.0), knot(20.0, [0.0, 0.9, 0.3], 0.0)]);
    for length in [1e-3, 0.7, 30.0, 4e3] {
        for (kappa, eps) in [(0.0, 0.0), (0.25, 0.01), (-0.2, -0.4)] {
            let (f, g) = (segment(0.1, 0.9, kappa, eps, length), segment(19.0, 11.0, -3.0 * kappa, eps, length));
            let parts =
                [MediumPiece::new(&red, [f, f], 0.5, 0).unwrap(), MediumPiece::new(&blue, [g, g], 0.5, 1).unwrap()];
            let (color, absorbed) = by_midpoints(&parts, |_, _| Shade { body: 1.0, highlight: 0.0 }, length, 1_000_000);
            for share in [1e-2, 1e-4, 1e-7] {
                let light = blended(&parts, share);
                // A million steps are no better than that where light ends within few of them.
                let slack = 1e-9 + 2e-12 * length * length;
                assert!((light.alpha - absorbed).abs() < slack, "{length} {kappa}: {}", light.alpha);
                let (off, reported) = (off(&light, &color), light.total_error(false));
                assert!(off <= reported + slack, "{length} {kappa} {share}: {off} and {reported}");
                assert!(reported <= share * light.alpha * 1.0001, "{length}: {reported}");
            }
        }
    }
}

/// The light of parts by Gauss's rule on many intervals, with optical depths in closed form.
fn by_gauss(parts: &[MediumPiece], length: f64) -> [f64; 3] {
    const INTERVALS: usize = 300;
    let mut color = [0.0; 3];
    for i in 0..INTERVALS {
        for (place, weight) in [(-0.6f64.sqrt(), 5.0 / 18.0), (0.0, 8.0 / 18.0), (0.6f64.sqrt(), 5.0 / 18.0)] {
            let u = (i as f64 + 0.5 + 0.5 * place) / INTERVALS as f64;
            let depth: f64 = parts.iter().map(|part| part.depth(0.0, u)).sum();
            let step = weight * length / INTERVALS as f64 * (-depth).exp();
            for MediumNode { extinction, color: own, .. } in parts.iter().map(|part| part.at(u)) {
                color = [0, 1, 2].map(|k| color[k] + step * extinction * own[k]);
            }
        }
    }
    color
}

/// Transfer functions of random colours and extinctions from -10 to 10, some of which end in nothing.
fn random_medium(random: &mut Random, source: usize) -> Medium {
    let mut end = |value: f64| {
        let clear = random.below(3) == 0;
        let color = [(); 3].map(|()| random.unit());
        knot(value, color, if clear { 0.0 } else { 10f64.powf(3.0 * random.unit() - 2.0) })
    };
    let knots = [end(-10.0), knot(10.0, [0.2, 0.5, 0.9], 3.0)];
    medium(source, &knots)
}

/// Values within those of a random medium.
fn random_segment(random: &mut Random, eps: f64, length: f64) -> Segment<f64> {
    let swing = 10f64.powf(1.0 - 3.0 * random.unit());
    let base = (10.0 - 1.5 * swing.min(6.0)) * (2.0 * random.unit() - 1.0);
    let mut near = || base + 0.5 * swing.min(6.0) * (2.0 * random.unit() - 1.0);
    let (f0, f1) = (near(), near());
    segment(f0, f1, 2.0 * (near() - base), eps, length)
}

#[test]
fn one_panel_is_within_its_reported_error() {
    let mut random = Random::new(7);
    let mut ratios = Vec::new();
    for case in 0..count(500, 50_000) {
        let media: Vec<Medium> = (0..1 + case % 3).map(|source| random_medium(&mut random, source)).collect();
        let eps = [0.0, 0.02, -0.3, 0.5][case % 4];
        let length = 10f64.powf(3.0 * random.unit() - 3.0);
        let fields: Vec<_> = media.iter().map(|_| random_segment(&mut random, eps, length)).collect();
        let pieces = media.iter().zip(&fields).map(|(medium, field)| MediumPiece::new(medium, [*field; 2], 0.5, 0));
        let parts: Vec<MediumPiece> = pieces.flatten().collect();
        // One panel, for any error.
        let light = blended(&parts, 100.0);
        if light.alpha > 0.9999 {
            continue;
        }
        let exact = by_gauss(&parts, length);
        let (off, reported) = (off(&light, &exact), light.total_error(false));
        assert!(off <= reported + 1e-12, "case {case}: {off} off, {reported} reported");
        if off > 1e-11 {
            ratios.push(reported / off);
        }
    }
    ratios.sort_by(f64::total_cmp);
    let median = ratios[ratios.len() / 2];
    assert!(ratios.len() > 200 && median < 40.0, "{median} times the true error in the median of {}", ratios.len());
}

/// Each medium absorbs light that fades in all of them.
#[test]
fn the_distribution_of_light_is_within_its_error() {
    let mut random = Random::new(11);
    let mut offs = Vec::new();
    for case in 0..count(500, 50_000) {
        let media = [0, 1].map(|source| random_medium(&mut random, source));
        let (eps, length) = ([0.0, 0.02, -0.3, 0.5][case % 4], 10f64.powf(2.5 * random.unit() - 3.0));
        let pieces = media.each_ref().map(|medium| {
            let field = random_segment(&mut random, eps, length);
            MediumPiece::new(medium, [field; 2], 0.5, 0)
        });
        let parts: Vec<MediumPiece> = pieces.into_iter().flatten().collect();
        let gradient = |_: usize, _: f64| [0.0; 3];
        let blend = Blend { parts: &parts, gradient, shading: None, color_tolerance: 1.0, min_transmittance: 0.0 };
        let nodes = [0.0, 0.5, 1.0].map(|u| blend.node(0.0, u, &mut Vec::new()));
        let (panel, absorbed) = (blend.panel(&nodes), -(-nodes[2].depth).exp_m1());
        let (Some(part), true) = (parts.first(), nodes[2].depth < THIN) else { continue };
        let seen = panel.length * panel.faded(&panel.rate).mean();
        let own = [0.0, 0.5, 1.0].map(|u| part.at(u)).map(|own| [own.extinction, own.thickening]);
        let spread = panel.faded(&over(1.0, own)).spread(panel.growth(), (seen / absorbed - 1.0).abs());
        let mut sums = [0.0; 3];
        const STEPS: usize = 2000;
        for u in (0..STEPS).map(|i| (i as f64 + 0.5) / STEPS as f64) {
            let depth: f64 = parts.iter().map(|part| part.depth(0.0, u)).sum();
            let light = part.extinction(u) * (-depth).exp();
            sums = [sums[0] + light, sums[1] + light * (u - 0.5), sums[2] + light * (u - 0.5).powi(2)];
        }
        if sums[0] > 0.0 {
            let off = (spread.centre - sums[1] / sums[0]).abs().max((spread.second - sums[2] / sums[0]).abs());
            assert!(off <= spread.error_bound + 1e-6, "case {case}: {off} off, {spread:?}");
            offs.push(off);
        }
    }
    offs.sort_by(f64::total_cmp);
    let median = offs[offs.len() / 2];
    assert!(offs.len() > 150 && median < 1e-5, "{median} off in the median of {}", offs.len());
}

/// A field that rises above a value without extinction and falls back, beside another: nothing absorbs at either end.
#[test]
fn absorption_between_two_clear_ends_is_integrated() {
    let hill = medium(0, &[knot(1.0, [1.0, 0.0, 0.0], 0.0), knot(2.0, [0.0, 1.0, 0.2], 400.0)]);
    let other = medium(0, &[knot(1.0, [0.0, 0.3, 1.0], 0.0), knot(2.0, [0.9, 0.6, 0.0], 150.0)]);
    for (length, eps) in [(0.01, 0.0), (0.1, 0.05), (1.0, -0.2)] {
        let f = segment(1.0, 1.0, 2.0, eps, length);
        let parts = [&hill, &other].map(|medium| MediumPiece::new(medium, [f, f], 0.5, 0).unwrap());
        let exact = by_gauss(&parts, length);
        for share in [1e-3, 1e-5, 1e-7] {
            let light = blended(&parts, share);
            let (off, reported) = (off(&light, &exact), light.total_error(false));
            assert!(off <= reported + 1e-12, "{length} {share}: {off} and {reported}");
            assert!(reported <= share * light.alpha * 1.0001, "{length} {share}: {reported}");
        }
    }
}

/// The error of 100 thin panels is ten times that of one.
#[test]
fn estimates_of_panels_are_independent() {
    let hill = medium(0, &[knot(1.0, [1.0, 0.0, 0.0], 0.0), knot(2.0, [0.0, 1.0, 0.2], 400.0)]);
    let f = segment(1.0, 1.9, 0.3, 0.05, 1e-6);
    let one = blended(&[MediumPiece::new(&hill, [f, f], 0.5, 0).unwrap()], 100.0);
    let mut light = Radiance::none();
    (0..100).for_each(|_| light.over(&one));
    let ratio = light.total_error(false) / one.total_error(false);
    assert!(one.total_error(false) > 0.0 && (9.0..11.0).contains(&ratio), "{ratio} times {one:?}");
}

/// Values that differ in their last digits, between knots that do so too, with gradients that are those of rounding.
#[test]
fn the_panels_of_a_piece_are_bounded() {
    let unit = f64::EPSILON;
    let noise =
        medium(0, &[knot(1.0 - 3.0 * unit, [1.0, 0.1, 0.0], 0.0), knot(1.0 + 3.0 * unit, [0.1, 0.9, 0.4], 9.0)]);
    let shading = shading(0.3, 30.0).along::<f64>(DVec3::NEG_X);
    let mut random = Random::new(3);
    for _ in 0..count(50, 2000) {
        let mut ulps = || (random.below(7) as f64 - 3.0) * unit;
        let f = segment(1.0 + ulps(), 1.0 + ulps(), ulps(), 0.01, 0.3);
        let Some(part) = MediumPiece::new(&noise, [f, f], 0.5, 0) else { continue };
        let turning = random_gradient(&mut random, 0.01);
        let places = std::cell::Cell::new(0);
        let gradient = |_: usize, u: f64| {
            places.set(places.get() + 1);
            turning.map(|axis| axis.value(u))
        };
        let light = lit(&[part], gradient, Some(&shading), 1e-9);
        let most = 2 * (HALVINGS_AT_START + HALVINGS_ALONG) as usize + 3;
        assert!(places.get() <= most, "{} places", places.get());
        assert!(light.alpha.is_finite() && light.total_error(true).is_finite(), "{light:?}");
    }
}

#[test]
fn an_endless_depth_shows_the_colour_at_its_front() {
    let red = medium(0, &[knot(0.0, [1.0, 0.0, 0.0], 1.0), knot(1.0, [0.0, 0.0, 1.0], 1.0)]);
    for length in [1e6, 1e9, 1e15] {
        let f = segment(0.25, 1.0, 0.0, 0.0, length);
        let parts = [MediumPiece::new(&red, [f, f], 0.5, 0).unwrap()];
        let light = blended(&parts, 1e-4);
        assert!((light.color[0] - 0.75).abs() < 1e-4 && (light.alpha - 1.0).abs() < 1e-12, "{light:?}");
    }
}

#[test]
fn one_colour_is_itself_to_the_digit_however_dense() {
    let grey = medium(0, &[knot(0.0, [0.3; 3], 0.0), knot(1.0, [0.3; 3], 7.0)]);
    for length in [1e-6, 1.0, 1e4] {
        let f = segment(0.2, 0.8, 0.1, 0.0, length);
        let light = blended(&[MediumPiece::new(&grey, [f, f], 0.5, 0).unwrap()], 1e-6);
        assert!((light.color[0] - 0.3 * light.alpha).abs() <= 1e-15, "{light:?}");
    }
}

#[test]
fn light_follows_the_gradient_of_the_absorbing_medium() {
    let white = medium(0, &[knot(0.0, [1.0; 3], 2.0), knot(1.0, [1.0; 3], 2.0)]);
    let f = segment(0.0, 1.0, 0.0, 0.0, 0.1);
    let shading = shading(0.0, 8.0).along::<f64>(DVec3::NEG_X);
    let parts = [MediumPiece::new(&white, [f, f], 0.5, 3).unwrap()];
    let body = |gradient: [f64; 3]| {
        let at = |slot: usize, _: f64| {
            assert_eq!(slot, 3);
            gradient
        };
        let light = lit(&parts, at, Some(&shading), 1e-6);
        light.color[0] / light.alpha
    };
    assert!((body([1.0, 0.0, 0.0]) - 1.0).abs() < 1e-12);
    assert!((body([0.0, 1.0, 0.0]) - 0.3).abs() < 1e-12);
    assert!((body([1.0, 1.0, 0.0]) - (0.3 + 0.7 * 0.5f64.sqrt())).abs() < 1e-12);
}

/// A random gradient as along a frustum: it turns a little, or round and round.
fn random_gradient(random: &mut Random, eps: f64) -> [Segment<f64>; 3] {
    let turn = 10f64.powf(-2.5 + 3.5 * random.unit());
    [(); 3].map(|()| {
        let base = 2.0 * random.unit() - 1.0;
        let mut swing = || turn * (2.0 * random.unit() - 1.0);
        segment(base + swing(), base + swing(), swing(), eps, 1.0)
    })
}

#[test]
fn light_on_normals_that_turn_is_that_of_fine_steps() {
    let red = medium(0, &[knot(0.0, [1.0, 0.1, 0.0], 0.3), knot(1.0, [0.4, 0.0, 0.2], 3.0)]);
    let blue = medium(1, &[knot(10.0, [0.0, 0.2, 1.0], 5.0), knot(20.0, [0.0, 0.9, 0.3], 1.0)]);
    let mut random = Random::new(1);
    let mut beyond = Vec::new();
    let cases = count(600, 20_000);
    for case in 0..cases {
        let eps = [0.0, 0.01, -0.3, 0.8][case % 4];
        let length = [0.05, 0.5, 3.0][case / 4 % 3];
        let interpolants = [random_gradient(&mut random, eps), random_gradient(&mut random, eps)];
        let towards_light = (case / 144 % 3 > 0).then(|| DVec3::from_array(random.direction()));
        let shading = shading([0.0, 0.3, 1.0][case / 12 % 3], [1.0, 8.0, 32.0, 100.0][case / 36 % 4]);
        let shading = Shading { towards_light, ..shading }.along::<f64>(DVec3::from_array(random.direction()));
        let gradient = |slot: usize, u: f64| interpolants[slot].map(|axis| axis.value(u));
        let (f, g) = (segment(0.1, 0.9, 0.2, eps, length), segment(19.0, 11.0, -0.5, eps, length));
        let both = [MediumPiece::new(&red, [f, f], 0.5, 0).unwrap(), MediumPiece::new(&blue, [g, g], 0.5, 1).unwrap()];
        let parts = &both[..1 + case % 2];
        let shade = |part: &MediumPiece, u: f64| shading.shade(gradient(part.slot, u));
        let (exact, _) = by_midpoints(parts, shade, length, 4000);
        for share in [5e-3, 5e-4, 5e-5] {
            let light = lit(parts, gradient, Some(&shading), share);
            let off = off(&light, &exact);
            let reported = light.total_error(true);
            // The steps' own error.
            if off > reported + 3e-6 {
                beyond.push(format!("{case}, {share}: {off} off, {reported} reported"));
                assert!(off <= 3.0 * reported + 3e-6, "{case}, {share}: {off} off, {reported} reported");
            }
            let allowed = 1.0001 * share * (light.alpha + ADVANCE);
            assert!(reported <= allowed, "{case}, {share}: {reported} reported");
        }
    }
    // The rule is an estimate: gradients at random are harder than those of a field.
    assert!(beyond.len() * 10_000 <= 3 * cases, "{}:\n{}", beyond.len(), beyond.join("\n"));
}

/// In a dense panel that begins clear, the middle and the end contribute nothing.
#[test]
fn dense_media_that_begin_clear_show_the_shade_of_their_front() {
    let clear = medium(0, &[knot(0.0, [0.9, 0.2, 0.1], 0.0), knot(1.0, [0.1, 0.1, 0.9], 1.0)]);
    let shading = shading(0.5, 40.0).along::<f64>(DVec3::NEG_X);
    let gradient = |_: usize, u: f64| [1.0 - 1.5 * u, 0.1 + u, 0.0];
    for length in [1e2, 1e4, 1e7, 1e12] {
        let f = segment(0.0, 1.0, 0.0, 0.0, length);
        let parts = [MediumPiece::new(&clear, [f, f], 0.5, 0).unwrap()];
        // All light comes from in front of an optical depth of 72.
        let to = (12.0 / length.sqrt()).min(1.0);
        let front = segment(0.0, to, 0.0, 0.0, to * length);
        let front = [MediumPiece::new(&clear, [front, front], 0.5, 0).unwrap()];
        let shade = |part: &MediumPiece, u: f64| shading.shade(gradient(part.slot, to * u));
        let (exact, _) = by_midpoints(&front, shade, to * length, 4000);
        for share in [1e3, 5e-3] {
            let light = lit(&parts, gradient, Some(&shading), share);
            let off = off(&light, &exact);
            assert!(off <= light.total_error(true) + 1e-5, "{length}, {share}: {off} off, {light:?}, {exact:?}");
        }
    }
}
