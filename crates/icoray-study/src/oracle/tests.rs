use super::*;
use crate::compare::Comparison;
use crate::reference::Reference;
use crate::sphere::{Sphere, multi_scale};
use icoray::{Field, Knot, Layers, Location, Scene, Shape};

const KNOTS: &str = r##"unit_length = 0.1
knots = [ { value = -0.6, color = "#2040ff", opacity = 0.7 }, { value = -0.2, color = "#20c0ff", opacity = 0.1 },
          { value = 0.0, color = "white", opacity = 0 }, { value = 0.15, color = "yellow", opacity = 0 },
          { value = 0.3, color = "orange", opacity = 0.6 }, { value = 0.7, color = "red", opacity = 0.9 } ]"##;

/// A step to opacity, a spike 1e-6 wide, and an optical depth of 1e12 in a cell.
const HARSH: &str = r##"unit_length = 0.1
knots = [ { value = -0.3, color = "red", extinction = 0.2 }, { value = -0.3, color = "blue", extinction = 30 },
          { value = -0.2, color = "blue", extinction = 0.0 }, { value = 0.1, color = "white", extinction = 0 },
          { value = 0.1000005, color = "lime", extinction = 1e6 }, { value = 0.100001, color = "white", extinction = 0 },
          { value = 0.4, color = "white", extinction = 0 }, { value = 0.5, color = "white", extinction = 1e12 } ]"##;

fn scene(size: u32, transfer: &str, rest: &str) -> Scene {
    Scene::parse(&format!(
        "field = \"f\"\nantialias = false\n{rest}\n[image]\nwidth = {size}\nheight = {size}\n[camera]\nlon = 20\nlat = 35\ndistance = 3.5\n\
         fov = 40\n[transfer]\n{transfer}"
    ))
    .unwrap()
}

/// Largest difference of a channel.
fn apart(a: &[[f64; 4]], b: &[[f64; 4]]) -> f64 {
    Comparison::new(a, b).max
}

/// Pictures of the oracle at two panel sizes and, if there are steps, of the reference.
fn pictures(sphere: &Sphere, scene: &Scene, steps: usize) -> [Vec<[f64; 4]>; 3] {
    let renderer = Renderer::new(2).unwrap();
    let draw = |job: &Job| {
        let [coarse, fine] = [PANEL, 0.5 * PANEL].map(|p| Oracle::with_panel(job, p).unwrap().picture(&renderer));
        if steps == 0 {
            return Ok([coarse, fine, Vec::new()]);
        }
        let reference = Reference::new(job.grid, sphere.layers.radius_m(), job.field, scene);
        let prepared = PreparedJob::new(job)?;
        let brute = prepared.pixels(&renderer, |x, y, _| {
            let (eye, dir) = prepared.ray(x, y);
            over(scene.background, reference.trace(eye, dir, steps))
        });
        Ok([coarse, fine, brute])
    };
    sphere.with_job(scene, draw).unwrap()
}

/// A constant field is a slab: `c (1 - exp(-κ L))`, with the chord's length from the traversal's ends.
#[test]
fn a_constant_field_is_the_closed_form() {
    let sphere = Sphere::new(2, 5, [1.0, 1.4], |_| 0.25).unwrap();
    let transfer = r#"unit_length = 1
knots = [ { value = 0, color = "rgb(255 0 0)", extinction = 1 }, { value = 0.5, color = "rgb(0 0 255)", extinction = 3 } ]"#;
    let scene = scene(40, transfer, "core = \"rgb(0 255 0)\"\nbackground = \"transparent\"");
    let (grid, field, renderer) = (sphere.grid().unwrap(), sphere.field().unwrap(), Renderer::new(2).unwrap());
    let job = Job { scene: &scene, grid: &grid, layers: &sphere.layers, field: &field };
    let oracle = Oracle::new(&job).unwrap();
    let expected = oracle.prepared.pixels(&renderer, |x, y, hint| {
        let (eye, dir) = oracle.prepared.ray(x, y);
        let (mut range, mut core) = (None, 0.0);
        oracle.prepared.traversal.ray(eye, dir, hint, |stretch| match stretch {
            Stretch::Frustum(f) => {
                range = Some([range.map_or(f.t[0], |[a, _]: [f64; 2]| a), f.t[1]]);
                ControlFlow::Continue(())
            }
            Stretch::Core { .. } => {
                core = 1.0;
                ControlFlow::Break(())
            }
        });
        let transmittance = range.map_or(1.0, |[a, b]| (-2.0 * (b - a)).exp());
        let emission = 0.5 * (1.0 - transmittance);
        [emission, transmittance * core, emission, 1.0 - transmittance + transmittance * core]
    });
    let d = apart(&oracle.picture(&renderer), &expected);
    assert!(d < 1e-13, "{d:e}");
}

/// One piece with a linear value and extinction: `∫ cσ e^{-τ}` with τ quadratic, by fine sums.
#[test]
fn a_linear_ramp_is_integrated_whatever_its_depth() {
    let gauss = Gauss::new();
    let parsed = scene(
        1,
        "unit_length = 1\nknots = [ { value = 0, color = \"black\", extinction = 0 }, { value = 1, color = \"white\", extinction = 1 } ]",
        "",
    );
    let spans = Spans::new(&parsed.volumes[0].transfer, 1.0);
    for length in [1e-3, 1.0, 40.0, 1e4, 1e12] {
        for f in [[0.0, 1.0], [1.0, 0.0]] {
            let interpolant = FrustumInterpolant { f, bend: 0.0, eps: 0.0 };
            let piece = Piece { interpolant, base: 0.0, span: &spans.spans[1], length };
            let mut light = Radiance { color: DVec3::ZERO, transmittance: 1.0 };
            piece.plain(&gauss, PANEL, &mut light);
            let transmittance = (-0.5 * length).exp();
            assert!((light.transmittance - transmittance).abs() < 1e-14, "{length}: {}", light.transmittance);
            // By parts: ∫ f dA with A the absorbed part is f1 A1 - ∫ A df.
            let depth = |u: f64| length * u * if f[1] > f[0] { 0.5 * u } else { 1.0 - 0.5 * u };
            let n = 400_000;
            // The integrand lives near the entry: u = x^4 crowds points there.
            let lost: f64 = (0..n)
                .map(|i| (f64::from(i) + 0.5) / f64::from(n))
                .map(|x| -(-depth(x.powi(4))).exp_m1() * 4.0 * x.powi(3) / f64::from(n))
                .sum();
            let expected = f[1] * (1.0 - transmittance) - (f[1] - f[0]) * lost;
            assert!((light.color.x - expected).abs() < 1e-9, "{length} {f:?}: {} {expected}", light.color.x);
        }
    }
}

#[test]
fn brute_force_comes_to_the_same_unlit_and_lit() {
    let sphere = Sphere::new(2, 6, [0.9, 1.5], multi_scale).unwrap();
    let lights =
        [("", 1e-5), ("[light]\nkind = \"headlight\"", 1e-4), ("[light]\nkind = \"sun\"\nlon = 80\nlat = 10", 1e-4)];
    for (light, bound) in lights {
        for core in ["core = \"#203040\"", "core = \"transparent\"\nbackground = \"#102030\""] {
            let scene = scene(20, &format!("{KNOTS}\n{light}"), core);
            let [coarse, _, brute] = pictures(&sphere, &scene, 40_000);
            let d = apart(&coarse, &brute);
            println!("{light:?} {core}: {d:.1e}");
            assert!(d < bound, "{light} {core}: {d:e}");
        }
    }
}

#[test]
fn halved_panels_change_nothing() {
    let sphere = Sphere::new(3, 12, [1.0, 1.3], multi_scale).unwrap();
    let cases = [
        (KNOTS.to_string(), 1e-12),
        (HARSH.to_string(), 1e-12),
        (format!("{KNOTS}\n[light]\nkind = \"headlight\""), 1e-9),
        (format!("{HARSH}\n[light]\nkind = \"sun\"\nlon = 80\nlat = 10"), 1e-9),
    ];
    for (transfer, bound) in cases {
        let scene = scene(48, &transfer, "core = \"transparent\"\nbackground = \"transparent\"");
        let [coarse, fine, _] = pictures(&sphere, &scene, 0);
        let d = apart(&coarse, &fine);
        println!("{:?}: {d:.1e}", transfer.lines().last());
        assert!(d < bound, "{transfer}: {d:e}");
        assert!(coarse.iter().filter(|p| p[3] > 0.1).count() > 500);
    }
}

/// Values that jump by orders from layer to layer, constant on each: a knot exactly on a layer is met exactly.
#[test]
fn a_step_on_a_layer_is_where_the_layer_is() {
    let sphere = Sphere::new(2, 4, [1.0, 1.3], |p| if p.length() < 1.05 { 0.1 } else { 7.3 }).unwrap();
    let value = f64::from(sphere.values[1]);
    let transfer = format!(
        "unit_length = 0.1\nknots = [ {{ value = 0, color = \"black\", extinction = 0 }}, {{ value = {value}, color = \"black\", extinction = 0 }},\n\
         {{ value = {value}, color = \"white\", extinction = 1e9 }} ]"
    );
    let scene = scene(32, &transfer, "core = \"transparent\"\nbackground = \"transparent\"");
    let [picture, _, _] = pictures(&sphere, &scene, 0);
    // Above the second layer the value is the knot's: opaque, down to the shell's surface.
    assert!(picture.iter().all(|p| p[3] == 0.0 || p[3] > 1.0 - 1e-9));
}

/// The oracle's picture of an f64 field with the given layers.
fn wide(sphere: &Sphere, radius: &[f64], values: &[f64], scene: &Scene) -> Vec<[f64; 4]> {
    let grid = sphere.grid().unwrap();
    let shape = Shape::level_fastest(grid.cells(), radius.len());
    let field = Field::new(values.into(), shape, Location::Center, None).unwrap();
    let layers = Layers::new(radius.to_vec(), 1.0).unwrap();
    let job = Job { scene, grid: &grid, layers: &layers, field: &field };
    Oracle::new(&job).unwrap().picture(&Renderer::new(2).unwrap())
}

/// What changes nothing in the integral changes nothing in the picture: a thousand knots on the lines between knots,
/// and layers midway between layers with the values midway.
#[test]
fn redundant_knots_and_layers_change_nothing() {
    let sphere = Sphere::new(3, 9, [1.0, 1.3], multi_scale).unwrap();
    let (radius, values) = (sphere.layers.radius_m(), sphere.values.iter().map(|v| f64::from(*v)));
    let values: Vec<f64> = values.collect();
    let midway = |row: &[f64]| -> Vec<f64> {
        let pairs = row.windows(2).flat_map(|w| [w[0], 0.5 * (w[0] + w[1])]);
        pairs.chain(row.last().copied()).collect()
    };
    let between: Vec<f64> = values.chunks_exact(radius.len()).flat_map(midway).collect();
    let hollow = "core = \"transparent\"\nbackground = \"transparent\"";
    for transfer in [KNOTS, HARSH] {
        let plain = scene(48, transfer, hollow);
        let expected = wide(&sphere, radius, &values, &plain);
        let layered = wide(&sphere, &midway(radius), &between, &plain);
        let mut knotted = plain.clone();
        let knots = &mut knotted.volumes[0].transfer.knots;
        for i in 0..1024 {
            let value = -1.0 + 2.0 * (f64::from(i) + 0.37) / 1024.0;
            let above = knots.partition_point(|k| k.value <= value);
            if above > 0 && above < knots.len() {
                let (a, b) = (knots[above - 1], knots[above]);
                let w = (value - a.value) / (b.value - a.value);
                let color = [0, 1, 2].map(|k| a.color[k] + w * (b.color[k] - a.color[k]));
                knots
                    .insert(above, Knot { value, color, extinction: a.extinction + w * (b.extinction - a.extinction) });
            }
        }
        let many = wide(&sphere, radius, &values, &knotted);
        let d = [apart(&layered, &expected), apart(&many, &expected)];
        println!("{} knots: layers {:.1e}, knots {:.1e}", knotted.volumes[0].transfer.knots.len(), d[0], d[1]);
        // Other layers round the ray's points otherwise, and where a value turns inside the spike that shows.
        let bound = if transfer == HARSH { 1e-9 } else { 1e-12 };
        assert!(d[0] < bound && d[1] < 1e-12, "{d:?}");
    }
}
