//! Pictures against closed forms and each other. Random and hard scenes are compared with the references in `random.rs`
//! and in icoray-reference.

use glam::DVec3;
use icoray::{Field, Frame, Grid, Layers, Location, Method, Precision, Renderer, Scene};
use icoray_reference::comparison::Comparison;
use icoray_reference::radial::Radial;
use icoray_reference::ray::Ray;
use icoray_reference::sphere::{Sphere, multi_scale};
use icoray_tests::{covered, scene};

const FAR: &str = "lon = 20\nlat = 35\ndistance = 3.5\nfov = 40";

fn render(scene: &Scene, grid: &Grid, layers: &Layers, field: &Field) -> Frame {
    Renderer::new(2).unwrap().render(scene, grid, layers, field).unwrap()
}

/// Chord of a ray inside the convex polyhedron of the mesh's facets at radius `r`, by its planes alone.
fn chord(grid: &Grid, r: f64, eye: DVec3, dir: DVec3) -> Option<[f64; 2]> {
    let (mut enter, mut leave) = (0.0f64, f64::INFINITY);
    for t in 0..grid.triangles() as u32 {
        let [a, b, c] = grid.triangle(t).map(|cell| grid.direction(cell) * r);
        let normal = (b - a).cross(c - a);
        let normal = if normal.dot(a) < 0.0 { -normal } else { normal };
        let (gap, speed) = ((a - eye).dot(normal), dir.dot(normal));
        if speed < 0.0 {
            enter = enter.max(gap / speed);
        } else {
            leave = leave.min(gap / speed);
        }
    }
    (enter < leave).then_some([enter, leave])
}

/// (b) of the requirements: a constant field has `c (1 - e^(-κ L))` with the chord's length L, to rounding.
#[test]
fn a_constant_field_is_the_closed_form() {
    let sphere = Sphere::new(3, 7, [1.0, 1.4], |_| 0.25).unwrap();
    let grid = sphere.grid().unwrap();
    let transfer = r#"unit_length = 1
knots = [ { value = 0, color = "rgb(255 0 0)", extinction = 1 }, { value = 0.5, color = "rgb(0 0 255)", extinction = 3 } ]"#;
    for (camera, core) in [
        (FAR, "core = \"rgb(0 255 0)\""),
        (FAR, "core = \"transparent\""),
        ("eye = [1.2, 0.1, 0.05]\ntarget = [0.3, 0.2, 0.9]\nfov = 100", "core = \"rgb(0 255 0)\""),
        ("eye = [0.1, 0.2, -0.3]\ntarget = [1, 0.2, 0.4]\nfov = 120", "core = \"transparent\""),
    ] {
        for (precision, bound) in [("f64", 2e-7), ("f32", 3e-6)] {
            let scene = scene(48, camera, transfer, &format!("{core}\nprecision = \"{precision}\""));
            let frame = render(&scene, &grid, &sphere.layers, &sphere.field().unwrap());
            let pixel = |i: u32| {
                let Ray { eye, dir } = Ray::of_pixel(&scene, i);
                let outer = chord(&grid, 1.4, eye, dir);
                let length = outer.map_or(0.0, |[a, b]| b - a);
                let (length, core) = match (chord(&grid, 1.0, eye, dir), scene.core) {
                    (Some([a, _]), Some(_)) => (a - outer.unwrap()[0], 1.0),
                    (Some([a, b]), None) => (length - (b - a), 0.0),
                    _ => (length, 0.0),
                };
                let transmittance = (-2.0 * length).exp();
                let emission = 0.5 * (1.0 - transmittance);
                [emission, transmittance * core, emission, 1.0 - transmittance + transmittance * core]
            };
            let max = Comparison::new(&frame.pixels, &(0..48 * 48).map(pixel).collect::<Vec<[f64; 4]>>()).max;
            assert!(max < bound, "{camera} {core} {precision}: {max:e}");
            assert!(covered(&frame) > 0.4);
        }
    }
}

/// (a): the paper's Figure 6. What is left against exact spheres is the grid's own error, which a bisection quarters.
#[test]
fn the_radial_field_converges_to_its_ground_truth() {
    for (method, is_lit) in [(Method::Exact, true), (Method::Exact, false), (Method::Paper, true)] {
        let rmse = [3, 4, 5].map(|level| {
            let radial = Radial { level, layers: 61, size: 64, steps: 1500, method, is_lit };
            let compared = radial.compare().unwrap();
            assert!(covered(&compared.frame) > 0.5);
            compared.rmse
        });
        println!("{method:?}, lit {is_lit}: {rmse:?}");
        assert!(rmse[2] < 1.6e-3, "{method:?}, lit {is_lit}: {rmse:?}");
        assert!(rmse[0] > 3.2 * rmse[1] && rmse[1] > 3.2 * rmse[2], "order lost: {method:?}, lit {is_lit}: {rmse:?}");
    }
}

/// Values far from one, and a transfer function that is a step: f32 holds to f64.
#[test]
fn scales_and_steps_hold_in_f32() {
    let base = Sphere::new(3, 10, [1.0, 1.2], multi_scale).unwrap();
    let grid = base.grid().unwrap();
    for (scale, offset) in [(1.0, 0.0), (1e30, 0.0), (1e-30, 0.0), (1.0, 1e6), (1e280, -1e281), (1e-280, 0.0)] {
        let values: Vec<f64> = base.values.iter().map(|v| f64::from(*v) * scale + offset).collect();
        let field = Field::level_fastest(&values, 10, Location::Center).unwrap();
        let v = |x: f64| format!("{:e}", x * scale + offset);
        let knots = format!(
            "knots = [ {{ value = {a}, color = \"red\", extinction = 1e6 }}, {{ value = {b}, color = \"red\", extinction = 1e6 }}, \
             {{ value = {b}, color = \"blue\", extinction = 0 }}, {{ value = {c}, color = \"white\", extinction = 0.5 }} ]",
            a = v(-0.9),
            b = v(-0.5),
            c = v(0.9)
        );
        let mut scene = scene(64, FAR, &knots, "precision = \"f64\"");
        let double = render(&scene, &grid, &base.layers, &field);
        scene.precision = Precision::F32;
        let single = render(&scene, &grid, &base.layers, &field);
        // A pixel that grazes the opaque body may see it in one precision and not in the other.
        let differences = Comparison::new(&double.pixels, &single.pixels).pixel_errors;
        let apart = differences.into_iter().filter(|difference| *difference > 1e-4).count();
        assert!(apart <= 4, "{scale:e} {offset:e}: {apart} pixels apart");
        assert!(double.pixels.iter().any(|p| p[0] > 0.9), "the opaque body is not to be seen");
    }
}
