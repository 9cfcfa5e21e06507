//! Orders of convergence, in the sense of Etiene et al. 2014 (doi:10.1109/TVCG.2013.90): the power of two by which the
//! error falls when a step is halved or the mesh bisected. An error in a formula or in its code shows as a lost order.

use super::*;
use icoray::{Camera, Precision};

/// Transfer functions over the field's range, with the order in the step of methods of second order.
const TRANSFERS: [(&str, f64, &str); 3] = [
    (
        "smooth",
        2.0,
        r##"{ value = -1.5, color = "#2040ff", extinction = 0.5 },
{ value = 1.5, color = "orange", extinction = 0.1 }"##,
    ),
    (
        "kinks",
        2.0,
        r##"{ value = -0.5, color = "#2040ff", extinction = 0.6 }, { value = -0.1, color = "white", extinction = 0 },
{ value = 0.2, color = "yellow", extinction = 0 }, { value = 0.5, color = "red", extinction = 0.8 }"##,
    ),
    (
        "steps",
        1.0,
        r##"{ value = -0.2, color = "#2040ff", extinction = 0.4 }, { value = -0.2, color = "white", extinction = 0 },
{ value = 0.3, color = "yellow", extinction = 0 }, { value = 0.3, color = "red", extinction = 0.6 }"##,
    ),
];

/// The first step, planet radii, and how often it is halved.
const STEP: f64 = 0.04;
const HALVINGS: i32 = 3;

fn smooth_field(p: DVec3) -> f64 {
    (3.0 * p.x + 2.0 * p.z).sin() * (2.5 * p.y - 4.0 * (p.length() - 1.0)).cos()
}

fn scene(knots: &str) -> Scene {
    let camera = Camera::above(25.0, 20.0, 3.6, 42.0).unwrap();
    let scene = crate::tests::scene(24, &format!("unit_length = 0.15\nknots = [ {knots} ]"));
    Scene { precision: Precision::F64, camera, ..scene }
}

/// Least, greatest and last order from each error to that of half the size.
fn orders(name: &str, errors: &[f64]) -> [f64; 3] {
    let orders: Vec<f64> = errors.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect();
    println!("{name}: errors {errors:.6?}, orders {orders:.2?}");
    let (low, high) = orders.iter().fold((f64::INFINITY, 0.0f64), |(l, h), o| (l.min(*o), h.max(*o)));
    [low, high, orders[orders.len() - 1]]
}

/// Errors against each method's own limit: other interpolants than the wedge's have other ones than the oracle.
#[test]
fn no_order_in_the_step_is_lost() {
    let renderer = Renderer::new(0).unwrap();
    let sphere = Sphere::new(2, 5, [1.0, 1.3], smooth_field).unwrap();
    for (kind, second, knots) in TRANSFERS {
        let check = |job: &Job| {
            let truth = oracle::picture(job, &renderer)?;
            for sampling in Sampling::all(512) {
                let picture = |halvings| sampling.at(STEP * 0.5f64.powi(halvings)).render(job, &renderer);
                let is_wedge = matches!(sampling, Sampling::Uniform | Sampling::PreIntegrated { .. });
                let own = if is_wedge { None } else { Some(picture(HALVINGS + 3)?.pixels) };
                let error = |halvings| {
                    let pixels = picture(halvings)?.pixels;
                    Ok(own.as_ref().map_or_else(
                        || Comparison::new(&pixels, &truth).rmse,
                        |own| Comparison::new(&pixels, own).rmse,
                    ))
                };
                let errors = (0..=HALVINGS).map(error).collect::<Result<Vec<_>>>()?;
                let [low, high, _] = orders(&format!("{kind}, {}", sampling.name()), &errors);
                let is_first = ["constant", "pre-integrated, no attenuation"].contains(&sampling.name());
                let expected = if is_first { 1.0 } else { second };
                let slack = if expected > 1.5 { 0.25 } else { 0.35 };
                assert!(low > expected - slack && high < expected + 2.0 * slack, "{kind}, {sampling:?}");
            }
            Ok(())
        };
        sphere.with_job(&scene(knots), check).unwrap();
    }
}

/// Errors of small steps against the oracle on the same mesh, whose layers are bisected too.
#[test]
fn no_order_in_the_mesh_is_lost() {
    let renderer = Renderer::new(0).unwrap();
    let step = STEP * 0.5f64.powi(HALVINGS + 1);
    let sampled = [Sampling::Tetrahedra, Sampling::MeanValue, Sampling::Constant].map(|sampling| sampling.at(step));
    let methods = [&[Method::Paper], &sampled[..]].concat();
    let mut errors = vec![Vec::new(); methods.len()];
    for level in 1..=4 {
        let sphere = Sphere::new(level, 1 + (1 << level), [1.0, 1.3], smooth_field).unwrap();
        let add = |job: &Job| {
            let truth = oracle::picture(job, &renderer)?;
            for (method, errors) in methods.iter().zip(&mut errors) {
                errors.push(Comparison::new(&method.render(job, &renderer)?.pixels, &truth).rmse);
            }
            Ok(())
        };
        sphere.with_job(&scene(TRANSFERS[0].2), add).unwrap();
    }
    for (method, errors) in methods.iter().zip(&errors) {
        let [.., last] = orders(&format!("{method:?}"), errors);
        let expected = if *method == Sampling::Constant.at(step) { 1.0 } else { 2.0 };
        assert!(last > expected - 0.2 && last < expected + 0.7, "{method:?}");
    }
}
