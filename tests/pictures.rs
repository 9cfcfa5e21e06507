//! Pictures against closed forms, the exact integral over all triangles, and each other. Random and hard scenes are
//! compared with the references in `random.rs` and in icoray-reference.

use glam::DVec3;
use icoray::{CenterField, Field, Frame, Grid, Layers, Location, Method, Precision, Renderer, Scene, Shape};
use icoray_reference::comparison::Comparison;
use icoray_reference::job::Job;
use icoray_reference::oracle;
use icoray_reference::radial::Radial;
use icoray_reference::ray::Ray;
use icoray_reference::sphere::{Sphere, multi_scale};
use icoray_tests::{covered, scene};

const FAR: &str = "lon = 20\nlat = 35\ndistance = 3.5\nfov = 40";
const KNOTS: &str = r##"unit_length = 0.1
knots = [ { value = -0.6, color = "#2040ff", opacity = 0.7 }, { value = -0.2, color = "#20c0ff", opacity = 0.1 },
          { value = 0.0, color = "white", opacity = 0 }, { value = 0.15, color = "yellow", opacity = 0 },
          { value = 0.3, color = "orange", opacity = 0.6 }, { value = 0.7, color = "red", opacity = 0.9 } ]"##;

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

/// NaN, infinities and fill values make the frusta around them void, and are counted.
#[test]
fn missing_values_are_void_frusta() {
    let mut sphere = Sphere::new(2, 6, [0.9, 1.5], multi_scale).unwrap();
    let cells = sphere.mesh.cells();
    for (i, cell) in (0..cells).step_by(7).enumerate() {
        let missing = [f32::NAN, f32::INFINITY, -9e33, f32::NEG_INFINITY][i % 4];
        sphere.values[cell * 6 + i % 6] = missing;
        sphere.values[cell * 6 + (i + 1) % 6] = missing;
    }
    let grid = sphere.grid().unwrap();
    let shape = Shape::level_fastest(cells, 6);
    let fill = Some(f64::from(-9e33f32));
    let field = Field::new(sphere.values.as_slice().into(), shape, Location::Center, fill).unwrap();
    let mut scene = scene(40, FAR, KNOTS, "core = \"#203040\"");
    let job = Job { scene: &scene, grid: &grid, layers: &sphere.layers, field: &field };
    let expected = oracle::brute_force(&job, &Renderer::new(2).unwrap()).unwrap();
    for precision in [Precision::F64, Precision::F32] {
        scene.precision = precision;
        let frame = render(&scene, &grid, &sphere.layers, &field);
        let difference = Comparison::new(&frame.pixels, &expected);
        assert!(difference.max < 3e-5 && difference.rmse < 1e-6, "{precision:?}: {:e}", difference.max);
        assert!(frame.report.counts.void_frusta > 1000);
        assert_eq!(frame.report.missing_values, 2 * cells.div_ceil(7) as u64);
    }
    // All missing: an empty shell, and no error.
    let nothing = vec![f64::NAN; cells * 6];
    let field = Field::new(nothing.as_slice().into(), shape, Location::Center, None).unwrap();
    let frame = render(&scene, &grid, &sphere.layers, &field);
    assert_eq!(frame.report.value_range, None);
    assert!(frame.pixels.iter().all(|p| p[3] == 0.0 || p[3] == 1.0));
}

/// A field at corners is averaged; full levels lie midway between interfaces.
#[test]
fn corner_fields_and_full_levels_are_placed() {
    let sphere = Sphere::new(3, 8, [1.0, 1.3], |p| p.z).unwrap();
    let grid = sphere.grid().unwrap();
    let scene = scene(64, FAR, KNOTS, "");
    let corners: Vec<f64> = (0..grid.triangles())
        .flat_map(|t| (0..7).map(move |l| (t, l)))
        .map(|(t, l)| (t % 13) as f64 / 13.0 - 0.1 * f64::from(l))
        .collect();
    let corner = Field::level_fastest(&corners, 7, Location::Corner).unwrap();
    let center = CenterField::average(&grid, &corner).unwrap();
    let a = render(&scene, &grid, &sphere.layers, &corner);
    let b = render(&scene, &grid, &sphere.layers.midpoints().unwrap(), &center.field());
    assert!(a.pixels == b.pixels);
    assert_eq!(a.report.bytes_derived, grid.cells() * 7 * 8);
    assert!(covered(&a) > 0.3);
}

/// (e): bitwise equal, any number of threads.
#[test]
fn pictures_do_not_depend_on_threads() {
    let sphere = Sphere::new(4, 12, [1.0, 1.2], multi_scale).unwrap();
    let grid = sphere.grid().unwrap();
    let mut scene = scene(150, FAR, &format!("{KNOTS}\n[light]\nkind = \"headlight\""), "core = \"transparent\"");
    scene.tolerance = 1e-3;
    let field = sphere.field().unwrap();
    let first = Renderer::new(1).unwrap().render(&scene, &grid, &sphere.layers, &field).unwrap();
    assert!(covered(&first) > 0.3);
    for threads in [1, 2, 3, 7] {
        let again = Renderer::new(threads).unwrap().render(&scene, &grid, &sphere.layers, &field).unwrap();
        let same =
            again.pixels.iter().flatten().zip(first.pixels.iter().flatten()).all(|(a, b)| a.to_bits() == b.to_bits());
        assert!(same && again.error == first.error, "{threads} threads");
        assert_eq!(again.report.counts, first.report.counts);
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
