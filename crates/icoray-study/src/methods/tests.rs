use super::*;
use crate::oracle::Oracle;
use crate::sphere::{Sphere, multi_scale};
use glam::DVec3;

const KNOTS: &str = r##"unit_length = 0.1
knots = [ { value = -1.1, color = "#2040ff", opacity = 0.4 }, { value = 1.1, color = "orange", opacity = 0.1 } ]"##;

fn scene(rest: &str) -> Scene {
    Scene::parse(&format!(
        "field = \"f\"\nantialias = false\nbackground = \"transparent\"\ncore = \"transparent\"\n[image]\nwidth = 32\nheight = 32\n\
         [camera]\nlon = 20\nlat = 35\ndistance = 3.5\nfov = 40\n[transfer]\n{KNOTS}\n{rest}"
    ))
    .unwrap()
}

/// Root-mean-square and largest difference from the oracle.
fn off(picture: &Picture, truth: &[[f64; 4]]) -> [f64; 2] {
    let pairs = picture.pixels.iter().flatten().zip(truth.iter().flatten());
    let (sum, max) =
        pairs.map(|(a, b)| (f64::from(*a) - b).abs()).fold((0.0, 0.0f64), |(s, m), d| (s + d * d, m.max(d)));
    assert!(picture.pixels.iter().flatten().all(|c| c.is_finite()));
    [(sum / (4 * truth.len()) as f64).sqrt(), max]
}

fn all(step: f64) -> [Method; 6] {
    let pre = |attenuated| Method::PreIntegrated { step, table: 256, attenuated };
    [
        Method::Uniform { step },
        Method::Tetrahedra { step },
        Method::MeanValue { step },
        Method::Constant { step },
        pre(true),
        pre(false),
    ]
}

/// A constant field has one value for every interpolant, so all agree but the one that leaves attenuation out.
#[test]
fn all_agree_on_a_constant_field() {
    let sphere = Sphere::new(2, 5, [1.0, 1.3], |_| 0.3).unwrap();
    let (grid, field, renderer) =
        (sphere.grid().unwrap(), sphere.field().unwrap(), Renderer::new(2).unwrap());
    let (scene, layers) = (scene(""), &sphere.layers);
    let job = Job { scene: &scene, grid: &grid, layers, field: &field };
    let truth = Oracle::new(&job).unwrap().picture(&renderer);
    let mut methods = all(0.013).to_vec();
    methods.truncate(5);
    methods.extend([Method::Exact { tolerance: 1e-3 }, Method::Paper]);
    for method in methods {
        let [_, max] = off(&method.render(&job, &renderer).unwrap(), &truth);
        assert!(max < 5e-6, "{}: {max:e}", method.name());
    }
}

/// All three interpolants reproduce a field linear in space, so they come to one picture; on another they differ.
#[test]
fn wedge_tetrahedra_and_mean_values_reproduce_linear_fields() {
    let linear = |p: DVec3| 0.4 * p.x - 0.3 * p.y + 0.2 * p.z;
    let bent = |p: DVec3| p.x * p.y * p.z;
    let apart = |field: &(dyn Fn(DVec3) -> f64 + Sync)| {
        let sphere = Sphere::new(1, 3, [1.0, 1.3], field).unwrap();
        let (grid, field, renderer) =
            (sphere.grid().unwrap(), sphere.field().unwrap(), Renderer::new(2).unwrap());
        let scene = scene("");
        let job = Job { scene: &scene, grid: &grid, layers: &sphere.layers, field: &field };
        let step = 0.01;
        let wedge = Method::Uniform { step }.render(&job, &renderer).unwrap();
        let wedge: Vec<_> = wedge.pixels.iter().map(|p| p.map(f64::from)).collect();
        [Method::Tetrahedra { step }, Method::MeanValue { step }]
            .map(|m| off(&m.render(&job, &renderer).unwrap(), &wedge)[1])
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
    let (grid, field, renderer) =
        (sphere.grid().unwrap(), sphere.field().unwrap(), Renderer::new(2).unwrap());
    for light in ["", "[light]\nkind = \"sun\"\nlon = 70\nlat = 20"] {
        let scene = scene(light);
        let job = Job { scene: &scene, grid: &grid, layers: &sphere.layers, field: &field };
        let truth = Oracle::new(&job).unwrap().picture(&renderer);
        let bounds = [1e-5, 4e-3, 4e-3, 2e-2, 1e-5, 4e-3];
        for (method, bound) in all(1e-3).into_iter().zip(bounds) {
            if !light.is_empty() && !matches!(method, Method::Uniform { .. }) {
                continue;
            }
            let picture = method.render(&job, &renderer).unwrap();
            let [rmse, max] = off(&picture, &truth);
            println!("{}: RMSE {rmse:.1e}, max {max:.1e}, {} samples", method.name(), picture.samples);
            let bound = if light.is_empty() { bound } else { 1e-3 };
            assert!(rmse < bound, "{}: {rmse:e}", method.name());
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
    let (grid, field, renderer) =
        (sphere.grid().unwrap(), sphere.field().unwrap(), Renderer::new(2).unwrap());
    let scene = scene("");
    let job = Job { scene: &scene, grid: &grid, layers: &sphere.layers, field: &field };
    let truth = Oracle::new(&job).unwrap().picture(&renderer);
    for method in all(2e-3) {
        let [rmse, _] = off(&method.render(&job, &renderer).unwrap(), &truth);
        println!("{}: {rmse:.1e}", method.name());
        assert!(rmse < 0.04, "{}: {rmse:e}", method.name());
    }
}
