//! Distances of pixels from the exact integral, against their errors.
//!
//! The oracle integrates the same interpolant to ten digits by other means; every pixel of every picture is compared.

use glam::DVec3;
use icoray::{Certainty, Frame, Precision, Renderer, Scene};
use icoray_reference::comparison::{BoundCheck, Comparison};
use icoray_reference::oracle;
use icoray_reference::sphere::{Sphere, multi_scale};
use icoray_test_support::count;
use icoray_tests::scene;

const FAR: &str = "lon = 30\nlat = 25\ndistance = 3.2\nfov = 45";
const INSIDE: &str = "eye = [1.02, 0.3, 0.1]\ntarget = [0, 1.2, 0.3]\nfov = 90";
const SMOOTH: &str = "knots = [ { value = -0.8, color = \"blue\", extinction = 4 }, { value = -0.2, color = \"white\", extinction = 0 }, \
     { value = 0.3, color = \"yellow\", extinction = 1 }, { value = 0.8, color = \"red\", extinction = 9 } ]";
const STEPS: &str = "knots = [ { value = -0.9, color = \"red\", extinction = 1e6 }, { value = -0.5, color = \"orange\", extinction = 1e6 }, \
     { value = -0.5, color = \"blue\", extinction = 0 }, { value = 0.9, color = \"white\", extinction = 5 } ]";
const SPIKE: &str = "knots = [ { value = 0.1, color = \"red\", extinction = 0 }, { value = 0.1000005, color = \"green\", extinction = 1e5 }, \
     { value = 0.100001, color = \"blue\", extinction = 0 }, { value = 0.9, color = \"white\", extinction = 5 } ]";
/// As a logarithmic scale has them.
const DECADES: &str = "knots = [ { value = 0, color = \"black\", extinction = 0 }, { value = 1e-6, color = \"blue\", extinction = 1 }, \
     { value = 1e-5, color = \"red\", extinction = 2 }, { value = 1e-4, color = \"orange\", extinction = 3 }, \
     { value = 1e-3, color = \"green\", extinction = 4 }, { value = 1e-2, color = \"yellow\", extinction = 5 }, \
     { value = 1, color = \"white\", extinction = 7 } ]";
const LIGHT: &str = "[light]\nkind = \"headlight\"";

/// A scene over a sphere, and its exact picture.
struct Look<'s> {
    name: String,
    sphere: &'s Sphere,
    scene: Scene,
    truth: Vec<[f64; 4]>,
    /// Largest ratio of the median reported error and the median error; errors under light are estimates.
    max_ratio: f64,
}

impl<'s> Look<'s> {
    fn new(name: &str, sphere: &'s Sphere, scene: Scene) -> Self {
        let truth = sphere.with_job(&scene, |job| oracle::picture(job, &Renderer::new(0)?)).unwrap();
        let max_ratio = if scene.lighting.is_some() { 60.0 } else { 20.0 };
        Look { name: name.into(), sphere, scene, truth, max_ratio }
    }

    fn render(&self, tolerance: f64, precision: Precision) -> Frame {
        let scene = Scene { tolerance, precision, ..self.scene.clone() };
        self.sphere.with_job(&scene, |job| job.render(&Renderer::new(0)?)).unwrap()
    }

    /// Renders, and checks every pixel against its own error; returns the largest error, and the reported ones.
    fn check(&self, tolerance: f64, precision: Precision) -> (f64, BoundCheck) {
        let frame = self.render(tolerance, precision);
        let Comparison { max, pixel_errors, .. } = Comparison::new(&frame.pixels, &self.truth);
        let reported = BoundCheck::new(&frame.error, &pixel_errors);
        let what = format!("{} {precision:?} {tolerance:.0e}: error {max:e}, {reported:?}", self.name);
        println!("{what}, {}", frame.report.error);
        let beyond = pixel_errors.iter().zip(&frame.error).position(|(error, bound)| *error > f64::from(*bound));
        assert!(max.is_finite() && frame.error.iter().all(|bound| bound.is_finite()), "{what}");
        assert_eq!((reported.violations, frame.report.error.max), (0, reported.max), "{what}: pixel {beyond:?}");
        let seen = self.truth.iter().filter(|pixel| pixel[3] > 0.0).count();
        assert!(seen > 1000, "{} sees nothing", self.name);
        (max, reported)
    }
}

fn looks<'s>(fine: &'s Sphere, thick: &'s Sphere) -> Vec<Look<'s>> {
    let hollow = "core = \"transparent\"";
    let lit = format!("{SMOOTH}\n{LIGHT}\nshininess = 40");
    vec![
        Look::new("smooth", fine, scene(128, FAR, SMOOTH, "")),
        Look::new("smooth, thick", thick, scene(64, FAR, SMOOTH, hollow)),
        Look::new("smooth, inside", fine, scene(64, INSIDE, SMOOTH, "background = \"#204060\"")),
        Look::new("steps", fine, scene(128, FAR, STEPS, "")),
        Look::new("steps, thick", thick, scene(64, FAR, STEPS, hollow)),
        Look::new("spike", fine, scene(128, FAR, SPIKE, "")),
        Look::new("spike, thick", thick, scene(64, FAR, SPIKE, hollow)),
        // Knots that are close to each other at one end of the range make no error.
        Look::new("decades", fine, scene(128, FAR, DECADES, "")),
        Look::new("lit", fine, scene(96, FAR, &lit, "")),
        Look::new("lit, thick", thick, scene(48, FAR, &lit, hollow)),
    ]
}

/// No error of a pixel is larger than the reported one or than the tolerance, and reported errors are of use: at the
/// median at most 20 times the error.
#[test]
fn no_error_of_a_pixel_is_larger_than_the_reported_one() {
    let fine = Sphere::new(4, 20, [1.0, 1.15], multi_scale).unwrap();
    let thick = Sphere::new(2, 6, [0.9, 1.5], multi_scale).unwrap();
    for look in looks(&fine, &thick) {
        for &tolerance in count(&[1e-2, 1e-4][..], &[1e-2, 1e-3, 1e-4, 1e-5, 1e-6]) {
            let (max, reported) = look.check(tolerance, Precision::F64);
            // Errors below half a last digit of the picture's own f32 are not seen.
            let limit = look.max_ratio * reported.median_error.max(3e-8);
            assert!(reported.median < limit && max <= tolerance + 6e-8, "{}: {max:e}, {reported:?}", look.name);
            let is_reported = reported.max <= tolerance + 6e-8;
            assert!(is_reported || look.scene.lighting.is_some(), "{}: {reported:?}", look.name);
        }
        for &tolerance in count(&[1e-3][..], &[1e-2, 1e-3, 1e-4, 1e-5]) {
            let (max, reported) = look.check(tolerance, Precision::F32);
            // Nor do errors in f32 that are smaller than a last digit or two count; the reported part of rounding is an
            // upper limit.
            let limit = 1.5 * look.max_ratio * reported.median_error.max(1e-7);
            assert!(reported.median < limit, "{}: {reported:?}", look.name);
            // The digits of f32 are not enough for all pixels of the spikes, which report so.
            assert!(max <= tolerance + 3e-5, "{}: {max:e}", look.name);
        }
    }
}

/// Values over decades keep their digits in f32, also about 0, and reported errors follow these.
#[test]
fn reported_errors_of_fields_over_decades_follow_their_rounding_in_f32() {
    let positive = |p: DVec3| 10f64.powf(3.0 * multi_scale(p).clamp(-1.0, 1.0) - 3.0);
    let both = |p: DVec3| if p.y > 0.0 { positive(p) } else { -positive(p) };
    let below =
        "{ value = -1, color = \"navy\", extinction = 7 }, { value = -1e-3, color = \"cyan\", extinction = 4 }, ";
    let mirrored = DECADES.replace("[ {", &format!("[ {below}{{"));
    for (name, knots, sphere) in [
        ("log", DECADES, Sphere::new(4, 20, [1.0, 1.15], positive).unwrap()),
        ("symlog", &mirrored, Sphere::new(4, 20, [1.0, 1.15], both).unwrap()),
    ] {
        let look = Look::new(name, &sphere, scene(96, FAR, knots, ""));
        let (max, reported) = look.check(1e-3, Precision::F32);
        assert!(reported.median < 10.0 * reported.median_error, "{name}: {reported:?}");
        assert!(max <= 1e-3 + 1e-6, "{name}: {max:e}");
    }
}

/// A tighter tolerance gives smaller errors, and the kind of error is reported.
#[test]
fn errors_follow_the_tolerance() {
    let sphere = Sphere::new(3, 8, [1.0, 1.3], multi_scale).unwrap();
    let look = Look::new("smooth", &sphere, scene(96, FAR, SMOOTH, ""));
    let [loose, tight] = [1e-2, 1e-5].map(|tolerance| look.render(tolerance, Precision::F64).report);
    assert!(tight.error.max < 0.01 * loose.error.max && tight.error.max > 0.0);
    assert!(loose.error.max <= 1e-2 && tight.error.max <= 1e-5, "{} {}", loose.error, tight.error);
    assert_eq!((tight.error.certainty, tight.quality.tolerance), (Certainty::Bound, 1e-5));
    assert_eq!(look.render(1e-2, Precision::F32).report.error.certainty, Certainty::Estimate);
    assert!(loose.error.mean < loose.error.p999 && loose.error.p999 <= loose.error.max);
}
