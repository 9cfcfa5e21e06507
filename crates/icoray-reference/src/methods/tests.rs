mod orders;

use super::*;
use crate::comparison::Comparison;
use crate::oracle;
use crate::sphere::{Sphere, multi_scale};
use glam::DVec3;

const KNOTS: &str = r##"unit_length = 0.1
knots = [ { value = -1.1, color = "#2040ff", opacity = 0.4 }, { value = 1.1, color = "orange", opacity = 0.1 } ]"##;

fn scene(rest: &str) -> Scene {
    crate::tests::scene(32, &format!("{KNOTS}\n{rest}"))
}

fn compared<T: Copy + Into<f64>>(picture: &Picture, truth: &[[T; 4]]) -> Comparison {
    assert!(picture.pixels.iter().flatten().all(|c| c.is_finite()));
    Comparison::new(&picture.pixels, truth)
}

fn all(step: f64) -> Vec<Method> {
    Sampling::all(256).map(|sampling| sampling.at(step)).to_vec()
}

/// The pictures of the methods, and the oracle's.
fn pictures(sphere: &Sphere, scene: &Scene, methods: &[Method]) -> (Vec<Picture>, Vec<[f64; 4]>) {
    let renderer = Renderer::new(2).unwrap();
    let draw = |job: &Job| {
        let pictures = methods.iter().map(|method| method.render(job, &renderer)).collect::<Result<_>>()?;
        Ok((pictures, oracle::picture(job, &renderer)?))
    };
    sphere.with_job(scene, draw).unwrap()
}

/// A constant field has one value for every interpolant, so all agree but the one that leaves attenuation out.
#[test]
fn all_agree_on_a_constant_field() {
    let sphere = Sphere::new(2, 5, [1.0, 1.3], |_| 0.3).unwrap();
    let mut methods = all(0.013);
    let unattenuated = methods.remove(2);
    assert_eq!(unattenuated, Sampling::PreIntegrated { table: 256, attenuated: false }.at(0.013));
    methods.extend([Method::Exact { tolerance: 1e-3 }, Method::Paper]);
    let (pictures, truth) = pictures(&sphere, &scene(""), &methods);
    for (method, picture) in methods.into_iter().zip(pictures) {
        let max = compared(&picture, &truth).max;
        assert!(max < 5e-6, "{method:?}: {max:e}");
    }
}

/// All three interpolants reproduce a field linear in space, so their pictures are equal; those of another field
/// differ.
#[test]
fn wedge_tetrahedra_and_mean_values_reproduce_linear_fields() {
    let linear = |p: DVec3| 0.4 * p.x - 0.3 * p.y + 0.2 * p.z;
    let bent = |p: DVec3| p.x * p.y * p.z;
    let step = 0.01;
    let methods = [Sampling::Uniform, Sampling::Tetrahedra, Sampling::MeanValue].map(|sampling| sampling.at(step));
    let apart = |field: &(dyn Fn(DVec3) -> f64 + Sync)| {
        let sphere = Sphere::new(1, 3, [1.0, 1.3], field).unwrap();
        let (pictures, _) = pictures(&sphere, &scene(""), &methods);
        [1, 2].map(|i: usize| compared(&pictures[i], &pictures[0].pixels).max)
    };
    let (same, other) = (apart(&linear), apart(&bent));
    println!("linear {same:?}, bent {other:?}");
    assert!(same.iter().all(|d| *d < 2e-6), "{same:?}");
    assert!(other.iter().all(|d| *d > 1e-4), "{other:?}");
}

/// On a varied field every method comes near the oracle with small steps, as near as its interpolant is to the wedge's.
#[test]
fn small_steps_come_to_the_oracle() {
    let sphere = Sphere::new(3, 8, [1.0, 1.3], multi_scale).unwrap();
    let uniform = Sampling::Uniform.at(1e-3);
    let unlit = all(1e-3).into_iter().zip([1e-5, 1e-5, 4e-3, 2e-2, 4e-3, 4e-3]).collect();
    for (light, bounds) in [("", unlit), ("[light]\nkind = \"sun\"\nlon = 70\nlat = 20", vec![(uniform, 1e-3)])] {
        let methods: Vec<Method> = bounds.iter().map(|(method, _)| *method).collect();
        let (pictures, truth) = pictures(&sphere, &scene(light), &methods);
        for ((method, bound), picture) in bounds.into_iter().zip(pictures) {
            let Comparison { rmse, max, .. } = compared(&picture, &truth);
            println!("{method:?}: RMSE {rmse:.1e}, max {max:.1e}, {} samples", picture.samples);
            assert!(rmse < bound, "{method:?}: {rmse:e}");
        }
    }
}

/// Missing values make a frustum void for all methods: with the same voids, they stay near the oracle.
#[test]
fn voids_are_left_out() {
    let mut sphere = Sphere::new(2, 5, [1.0, 1.3], multi_scale).unwrap();
    for i in (0..sphere.values.len()).step_by(37) {
        sphere.values[i] = f32::NAN;
    }
    let methods = all(2e-3);
    let (pictures, truth) = pictures(&sphere, &scene(""), &methods);
    for (method, picture) in methods.into_iter().zip(pictures) {
        let rmse = compared(&picture, &truth).rmse;
        println!("{method:?}: {rmse:.1e}");
        assert!(rmse < 0.04, "{method:?}: {rmse:e}");
    }
}
