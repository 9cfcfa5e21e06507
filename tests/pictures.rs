//! Pictures against what they must be: closed forms, the same interpolant over all triangles, themselves.

use glam::DVec3;
use icoray::{
    CenterField, Field, Frame, Grid, IcosahedralMesh, Layers, Lighting, Location, Method, Precision, Renderer, Scene,
    Shape, Source,
};
use icoray_reference::job::Job;
use icoray_reference::oracle;
use icoray_reference::radial::Radial;
use icoray_reference::sphere::{Sphere, multi_scale};
use icoray_tests::{covered, difference, scene};

const FAR: &str = "lon = 20\nlat = 35\ndistance = 3.5\nfov = 40";
const KNOTS: &str = r##"unit_length = 0.1
knots = [ { value = -0.6, color = "#2040ff", opacity = 0.7 }, { value = -0.2, color = "#20c0ff", opacity = 0.1 },
          { value = 0.0, color = "white", opacity = 0 }, { value = 0.15, color = "yellow", opacity = 0 },
          { value = 0.3, color = "orange", opacity = 0.6 }, { value = 0.7, color = "red", opacity = 0.9 } ]"##;

fn render(scene: &Scene, grid: &Grid, layers: &Layers, field: &Field) -> Frame {
    Renderer::new(2).unwrap().render(scene, grid, layers, field).unwrap()
}

/// The exact picture, found by intersection with all triangles.
fn brute_force(scene: &Scene, grid: &Grid, layers: &Layers, field: &Field) -> Vec<[f32; 4]> {
    let job = Job { scene, grid, layers, field };
    let pixels = oracle::brute_force(&job, &Renderer::new(2).unwrap()).unwrap();
    pixels.into_iter().map(|pixel| pixel.map(|c| c as f32)).collect()
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
    for (camera, core, lighted) in [
        (FAR, "core = \"rgb(0 255 0)\"", true),
        (FAR, "core = \"transparent\"", false),
        ("eye = [1.2, 0.1, 0.05]\ntarget = [0.3, 0.2, 0.9]\nfov = 100", "core = \"rgb(0 255 0)\"", false),
        ("eye = [0.1, 0.2, -0.3]\ntarget = [1, 0.2, 0.4]\nfov = 120", "core = \"transparent\"", false),
    ] {
        for precision in ["f64", "f32"] {
            let rest = format!("{core}\nprecision = \"{precision}\"");
            let mut scene = scene(48, camera, transfer, &rest);
            if lighted && precision == "f64" {
                // Light on a constant field: no gradient, ambient light alone; the core has its own normal.
                scene.lighting = None;
            }
            let frame = render(&scene, &grid, &sphere.layers, &sphere.field().unwrap());
            let mut expected = Vec::new();
            for (y, x) in (0..48).flat_map(|y| (0..48).map(move |x| (y, x))) {
                let eye = DVec3::from_array(scene.camera.eye());
                let dir = DVec3::from_array(scene.camera.direction(x, y, 48, 48));
                let outer = chord(&grid, 1.4, eye, dir);
                let inner = chord(&grid, 1.0, eye, dir);
                let length = outer.map_or(0.0, |[a, b]| b - a);
                let (length, core) = match (inner, scene.core) {
                    (Some([a, _]), Some(_)) => (a - outer.unwrap()[0], 1.0),
                    (Some([a, b]), None) => (length - (b - a), 0.0),
                    _ => (length, 0.0),
                };
                let through = (-2.0 * length).exp();
                let glow = 0.5 * (1.0 - through);
                expected.push([glow, through * core, glow, 1.0 - through + through * core].map(|c| c as f32));
            }
            let d = difference(&frame.pixels, &expected);
            let bound = if precision == "f64" { 2e-7 } else { 3e-6 };
            println!("{precision} {camera:?}: {d:?}");
            assert!(d.max < bound && d.not_finite == 0, "{camera} {rest}: {d:?}");
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
            compared.distance.rmse
        });
        println!("{method:?}, lit {is_lit}: {rmse:?}");
        assert!(rmse[2] < 1.6e-3, "{method:?}, lit {is_lit}: {rmse:?}");
        assert!(rmse[0] > 3.2 * rmse[1] && rmse[1] > 3.2 * rmse[2], "order lost: {method:?}, lit {is_lit}: {rmse:?}");
    }
}

/// (c): every method against the exact integral of the same interpolant.
#[test]
fn pictures_match_brute_force() {
    let sphere = Sphere::new(2, 6, [0.9, 1.5], multi_scale).unwrap();
    let grid = sphere.grid().unwrap();
    let field = sphere.field().unwrap();
    let cases = [
        (FAR, "core = \"#203040\""),
        (FAR, "core = \"transparent\""),
        ("eye = [1.1, 0.3, 0.2]\ntarget = [0, 1.4, 0.3]\nfov = 90", "core = \"#203040\""),
        ("eye = [0.2, -0.1, 0.4]\ntarget = [0, 1.4, 0.3]\nfov = 110", "core = \"transparent\""),
        ("eye = [1.5, 0, 0]\ntarget = [0, 0, 0.2]\nup = [0, 1, 0]\nfov = 100", "core = \"#203040\""),
    ];
    for (camera, core) in cases {
        let mut scene = scene(40, camera, KNOTS, &format!("{core}\nprecision = \"f64\""));
        let expected = brute_force(&scene, &grid, &sphere.layers, &field);
        let exact = difference(&render(&scene, &grid, &sphere.layers, &field).pixels, &expected);
        scene.precision = Precision::F32;
        let single = difference(&render(&scene, &grid, &sphere.layers, &field).pixels, &expected);
        scene.precision = Precision::F64;
        scene.method = Method::Paper;
        let paper = difference(&render(&scene, &grid, &sphere.layers, &field).pixels, &expected);
        println!("{camera:?} {core}: exact {exact:?}, f32 {single:?}, paper {paper:?}");
        assert!(exact.max < 1e-6 && exact.rmse < 1e-7 && exact.not_finite == 0, "{camera} {core}: {exact:?}");
        assert!(single.max < 3e-5 && single.not_finite == 0, "{camera} {core}: {single:?}");
        assert!(paper.max < 0.15 && paper.rmse < 0.03, "{camera} {core}: {paper:?}");
        assert!(paper.rmse > exact.rmse, "the comparison cannot tell the methods apart: {paper:?} {exact:?}");
    }
}

/// Lighting: the gradient is the mean over the incident frusta and interpolated like the value; the renderer takes it
/// once per piece, the oracle at each node.
#[test]
fn lit_pictures_match_brute_force() {
    let sphere = Sphere::new(2, 6, [0.9, 1.5], multi_scale).unwrap();
    let grid = sphere.grid().unwrap();
    let field = sphere.field().unwrap();
    for light in [
        "kind = \"headlight\"",
        "kind = \"sun\"\nlon = 80\nlat = 10",
        "kind = \"headlight\"\nambient = 0\nspecular = 0",
    ] {
        let lit = scene(40, FAR, &format!("{KNOTS}\n[light]\n{light}"), "core = \"transparent\"\nprecision = \"f64\"");
        let expected = brute_force(&lit, &grid, &sphere.layers, &field);
        let picture = render(&lit, &grid, &sphere.layers, &field);
        let d = difference(&picture.pixels, &expected);
        println!("{light:?}: {d:?}");
        assert!(d.rmse < 5e-4 && d.max < 0.01 && d.not_finite == 0, "{light}: {d:?}");
        // A wrong normal would be far off: unlit is.
        let unlit = Scene { lighting: None, ..lit.clone() };
        let flat = difference(&render(&unlit, &grid, &sphere.layers, &field).pixels, &expected);
        assert!(flat.rmse > 10.0 * d.rmse, "{light}: the comparison cannot tell light from none: {flat:?} {d:?}");
    }
}

/// NaN, infinities and fill values make the frusta around them void, and nothing else.
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
    let mut scene = scene(40, FAR, KNOTS, "core = \"#203040\"\nprecision = \"f64\"");
    let expected = brute_force(&scene, &grid, &sphere.layers, &field);
    for precision in [Precision::F64, Precision::F32] {
        scene.precision = precision;
        let frame = render(&scene, &grid, &sphere.layers, &field);
        let d = difference(&frame.pixels, &expected);
        assert!(d.max < 3e-5 && d.rmse < 1e-6 && d.not_finite == 0, "{d:?}");
        assert!(frame.report.counts.void_frusta > 1000);
        assert_eq!(frame.report.missing_values, 2 * cells.div_ceil(7) as u64);
    }
    // Under light the void frusta are left out of the vertices' mean gradients too.
    let mut lit = scene.clone();
    lit.lighting =
        Some(Lighting { source: Source::Headlight, ambient: 0.1, diffuse: 0.9, specular: 0.0, shininess: 8.0 });
    let expected = brute_force(&lit, &grid, &sphere.layers, &field);
    let d = difference(&render(&lit, &grid, &sphere.layers, &field).pixels, &expected);
    assert!(d.rmse < 1e-3 && d.not_finite == 0, "lit: {d:?}");
    // All missing: an empty shell, and no error.
    let nothing = vec![f64::NAN; cells * 6];
    let field = Field::new(nothing.as_slice().into(), shape, Location::Center, None).unwrap();
    let frame = render(&scene, &grid, &sphere.layers, &field);
    assert_eq!(frame.report.value_range, None);
    assert!(frame.pixels.iter().all(|p| p[3] == 0.0 || p[3] == 1.0));
}

/// The same values in every layout of one type give the same picture, bit for bit.
#[test]
fn layouts_do_not_change_the_picture() {
    const ROUNDED: f64 = 3e-6;
    let sphere = Sphere::new(3, 8, [1.0, 1.3], multi_scale).unwrap();
    let grid = sphere.grid().unwrap();
    let cells = grid.cells();
    let scene = scene(64, FAR, &format!("{KNOTS}\n[light]\nkind = \"headlight\""), "");
    let plain = render(&scene, &grid, &sphere.layers, &sphere.field().unwrap());
    let value = |cell: usize, layer: usize| sphere.values[cell * 8 + layer];
    let (padded, turned, columns): (Vec<f32>, Vec<f64>, Vec<f32>) = (
        (0..(cells + 1) * 11)
            .map(|i| if i % 11 < 8 && i / 11 < cells { value(i / 11, i % 11) } else { f32::NAN })
            .collect(),
        (0..cells * 8).map(|i| f64::from(value(i / 8, 7 - i % 8))).collect(),
        (0..cells * 8).map(|i| value(i % cells, i / cells)).collect(),
    );
    let fields = [
        Field::new(
            padded.as_slice().into(),
            Shape { column_stride: 11, ..Shape::level_fastest(cells, 8) },
            Location::Center,
            None,
        ),
        Field::new(columns.as_slice().into(), Shape::cell_fastest(cells, 8), Location::Center, None),
        Field::new(
            turned.as_slice().into(),
            Shape { offset: 7, layer_stride: -1, ..Shape::level_fastest(cells, 8) },
            Location::Center,
            None,
        ),
    ];
    // Values in f64 are normalised one by one, others in vectors: these differ in their last digits.
    for (field, most) in fields.into_iter().zip([0.0, 0.0, ROUNDED]) {
        let frame = render(&scene, &grid, &sphere.layers, &field.unwrap());
        assert!(difference(&frame.pixels, &plain.pixels).max <= most);
    }
    // Top first: falling radii with the first value at the top.
    let falling = Layers::new(sphere.layers.radius_m().iter().rev().copied().collect(), 1.0).unwrap();
    let top_first =
        Field::new(turned.as_slice().into(), Shape::level_fastest(cells, 8), Location::Center, None).unwrap();
    assert!(difference(&render(&scene, &grid, &falling, &top_first).pixels, &plain.pixels).max <= ROUNDED);
    assert!(covered(&plain) > 0.3);
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
    let corner =
        Field::new(corners.as_slice().into(), Shape::level_fastest(grid.triangles(), 7), Location::Corner, None)
            .unwrap();
    let center = CenterField::average(&grid, &corner).unwrap();
    let a = render(&scene, &grid, &sphere.layers, &corner);
    let b = render(&scene, &grid, &sphere.layers.midpoints().unwrap(), &center.field());
    assert_eq!(difference(&a.pixels, &b.pixels).max, 0.0);
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
        let field =
            Field::new(values.as_slice().into(), Shape::level_fastest(grid.cells(), 10), Location::Center, None)
                .unwrap();
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
        let d = difference(&double.pixels, &single.pixels);
        // A pixel that grazes the opaque body may see it in one precision and not in the other.
        let apart = double
            .pixels
            .iter()
            .zip(&single.pixels)
            .filter(|(a, b)| (0..4).any(|k| (a[k] - b[k]).abs() > 1e-4))
            .count();
        assert!(apart <= 4 && d.not_finite == 0, "{scale:e} {offset:e}: {apart} pixels apart, {d:?}");
        assert!(double.pixels.iter().any(|p| p[0] > 0.9), "the opaque body is not to be seen");
    }
}

/// A real Earth, true to scale: 100 m layers on 6371 km, looked at along the limb, in f32 as in f64.
#[test]
fn thin_layers_on_a_real_earth_hold_in_f32() {
    let mesh = IcosahedralMesh::new(5).unwrap();
    let grid = Grid::new(mesh.tables()).unwrap();
    let heights: Vec<f64> = (0..=100).map(|l| 100.0 * f64::from(l)).collect();
    let layers = Layers::from_heights(&heights, 6.371e6).unwrap();
    let wave = |cell: usize, h: f64| (3.0 * mesh.lon_center_rad[cell]).sin() * (h / 1300.0).cos();
    let values: Vec<f32> =
        (0..grid.cells()).flat_map(|c| heights.iter().map(move |h| (c, *h))).map(|(c, h)| wave(c, h) as f32).collect();
    let field =
        Field::new(values.as_slice().into(), Shape::level_fastest(grid.cells(), 101), Location::Center, None).unwrap();
    let limb = "eye = [1.02, 0, 0]\ntarget = [0.9804, 0, 0.1971]\nup = [1, 0, 0]\nfov = 1";
    for camera in [FAR, limb] {
        let mut scene = scene(96, camera, KNOTS, "precision = \"f64\"");
        scene.volumes[0].transfer.unit_length = None;
        let double = render(&scene, &grid, &layers, &field);
        scene.precision = Precision::F32;
        let single = render(&scene, &grid, &layers, &field);
        let d = difference(&double.pixels, &single.pixels);
        println!("{camera:?}: {d:?}, {} frusta", double.report.counts.frusta);
        assert!(d.max < 1e-5 && d.rmse < 1e-6 && d.not_finite == 0, "{camera}: {d:?}");
        assert!(covered(&double) > 0.2);
    }
}
