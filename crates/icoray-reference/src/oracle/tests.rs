use super::*;
use crate::comparison::Comparison;
use crate::sphere::{Sphere, multi_scale};
use crate::tests::scene;
use glam::DVec3;
use icoray::{Knot, Layers, Scene};
use rayon::prelude::*;

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

fn max_difference(a: &[[f64; 4]], b: &[[f64; 4]]) -> f64 {
    assert!(a.iter().any(|pixel| pixel[3] > 0.2), "nothing is seen");
    Comparison::new(a, b).max
}

struct Model {
    sphere: Sphere,
    layers: Layers,
    fields: Vec<NamedField<'static>>,
}

impl Model {
    fn new(level: u32, layers: usize, f: fn(DVec3) -> f64) -> Self {
        let sphere = Sphere::new(level, layers, [1.0, 1.3], f).unwrap();
        let values = sphere.values.iter().map(|value| f64::from(*value)).collect();
        Model { layers: sphere.layers.clone(), fields: vec![NamedField { name: "f", values }], sphere }
    }

    /// The picture by intersection with all triangles; `heights` are those of native layers.
    fn picture(&self, scene: &Scene, heights: &[f64], panel: f64) -> Vec<[f64; 4]> {
        let grid = self.sphere.grid().unwrap();
        let data = Data { grid: &grid, layers: &self.layers, heights, fields: &self.fields };
        let oracle = Oracle::new(scene, data, panel).unwrap();
        let pixels = (0..scene.width * scene.height).into_par_iter();
        pixels.map(|i| oracle.pixel(&Ray::of_pixel(scene, i)).unwrap()).collect()
    }
}

/// One piece with a linear value and extinction: `∫ cσ e^{-τ}` with τ quadratic, by fine sums.
#[test]
fn a_linear_ramp_of_any_depth_is_integrated() {
    let gauss = Gauss::new();
    let parsed = scene(
        1,
        "unit_length = 1\nknots = [ { value = 0, color = \"black\", extinction = 0 }, { value = 1, color = \"white\", extinction = 1 } ]",
    );
    let spans = Spans::new(&parsed.volumes[0].transfer, 1.0);
    for length in [1e-3, 1.0, 40.0, 1e4, 1e12] {
        for f in [[0.0, 1.0], [1.0, 0.0]] {
            let field = FieldInSpan { field: FrustumInterpolant::linear(f), span: &spans.spans[1] };
            let parts = vec![VolumePiece { color: field, extinction: field, normal: None }];
            let mut light = Radiance::NONE;
            let blend = Blend { gauss: &gauss, parts, length, lighting: None, limit: PANEL };
            blend.add(&mut light);
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
fn halved_panels_change_nothing() {
    let model = Model::new(3, 12, multi_scale);
    let cases = [
        (KNOTS.to_string(), 1e-12),
        (HARSH.to_string(), 1e-12),
        (format!("{KNOTS}\n[light]\nkind = \"headlight\""), 1e-9),
        (format!("{HARSH}\n[light]\nkind = \"sun\"\nlon = 80\nlat = 10"), 1e-9),
    ];
    for (transfer, bound) in cases {
        let scene = scene(48, &transfer);
        let [coarse, fine] = [PANEL, 0.5 * PANEL].map(|panel| model.picture(&scene, &[], panel));
        let d = max_difference(&coarse, &fine);
        println!("{:?}: {d:.1e}", transfer.lines().last());
        assert!(d < bound, "{transfer}: {d:e}");
        assert!(coarse.iter().filter(|p| p[3] > 0.1).count() > 500);
    }
}

/// Values that jump by orders from layer to layer, constant on each: a knot exactly on a layer is met exactly.
#[test]
fn a_step_on_a_layer_is_where_the_layer_is() {
    let model = Model::new(2, 4, |p| if p.length() < 1.05 { 0.1 } else { 7.3 });
    let value = model.fields[0].values[1];
    let transfer = format!(
        "unit_length = 0.1\nknots = [ {{ value = 0, color = \"black\", extinction = 0 }}, {{ value = {value}, color = \"black\", extinction = 0 }},\n\
         {{ value = {value}, color = \"white\", extinction = 1e9 }} ]"
    );
    let scene = scene(32, &transfer);
    let picture = model.picture(&scene, &[], PANEL);
    // Above the second layer the value is the knot's: opaque, down to the shell's surface.
    assert!(picture.iter().all(|p| p[3] == 0.0 || p[3] > 1.0 - 1e-9));
}

/// What changes nothing in the integral changes nothing in the picture: a thousand knots on the lines between knots,
/// and layers midway between layers with the values midway.
#[test]
fn redundant_knots_and_layers_change_nothing() {
    let model = Model::new(3, 9, multi_scale);
    let radius = model.layers.radius_m();
    let midway = |row: &[f64]| -> Vec<f64> {
        let pairs = row.windows(2).flat_map(|w| [w[0], 0.5 * (w[0] + w[1])]);
        pairs.chain(row.last().copied()).collect()
    };
    let values = model.fields[0].values.chunks_exact(radius.len()).flat_map(midway).collect();
    let layers = Layers::new(midway(radius), 1.0).unwrap();
    let finer = Model { layers, fields: vec![NamedField { name: "f", values }], ..Model::new(3, 9, multi_scale) };
    for transfer in [KNOTS, HARSH] {
        let plain = scene(48, transfer);
        let expected = model.picture(&plain, &[], PANEL);
        let layered = finer.picture(&plain, &[], PANEL);
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
        let many = model.picture(&knotted, &[], PANEL);
        let d = [max_difference(&layered, &expected), max_difference(&many, &expected)];
        println!("{} knots: layers {:.1e}, knots {:.1e}", knotted.volumes[0].transfer.knots.len(), d[0], d[1]);
        // Other layers round the ray's points otherwise, and where a value turns inside the spike that shows.
        let bound = if transfer == HARSH { 1e-9 } else { 1e-12 };
        assert!(d[0] < bound && d[1] < 1e-12, "{d:?}");
    }
}

/// A mesh with the field `f`, and `r`, the radius.
fn with_radius() -> Model {
    let mut model = Model::new(2, 6, multi_scale);
    let values = model.layers.radius_m().iter().copied().cycle().take(model.sphere.values.len()).collect();
    model.fields.push(NamedField { name: "r", values });
    model
}

fn small(text: &str) -> Scene {
    let mut scene = Scene::parse(&format!(
        "background = \"transparent\"\nimage = {{ width = 16, height = 12 }}\n\
         camera = {{ lon = 20, lat = 35, distance = 2.2, fov = 60 }}\n{text}"
    ))
    .unwrap();
    scene.name_first_field("f");
    scene
}

/// A volume of `f` whose extinctions are multiplied by `times`.
fn volume(times: f64) -> String {
    let [a, b] = [0.9, 9.0].map(|extinction| times * extinction);
    format!(
        "[[volumes]]\nfield = \"f\"\ntransfer = {{ unit_length = 1, knots = [\n\
         {{ value = -0.5, color = \"red\", extinction = {a} }}, {{ value = 0, color = \"blue\", extinction = 0 }},\n\
         {{ value = 0.1, color = \"lime\", extinction = 0 }}, {{ value = 0.1, color = \"white\", extinction = {b} }}] }}\n"
    )
}

const LIGHTS: [&str; 3] = ["", "[light]\n", "[light]\nkind = \"sun\"\nlon = 80\nlat = 10\nshininess = 90\n"];

/// The renderer's traversal, and intersection with all triangles.
#[test]
fn the_traversal_finds_the_frusta_of_brute_force() {
    let model = with_radius();
    for core in ["", "core = \"transparent\"\n"] {
        for light in LIGHTS {
            let scene = small(&format!("{core}{}{light}", volume(1.0)));
            let renderer = Renderer::new(1).unwrap();
            let both = |job: &Job| Ok(max_difference(&picture(job, &renderer)?, &brute_force(job, &renderer)?));
            let difference = model.sphere.with_job(&scene, both).unwrap();
            assert!(difference < if light.is_empty() { 1e-12 } else { 1e-9 }, "{light} {difference:e}");
        }
    }
}

#[test]
fn parts_of_a_volume_add_up_to_it() {
    let model = with_radius();
    for light in LIGHTS {
        let parts = [0.25, 0.6, 0.15].map(volume).concat();
        let difference = max_difference(
            &model.picture(&small(&format!("{}{light}", volume(1.0))), &[], PANEL),
            &model.picture(&small(&(parts + light)), &[], PANEL),
        );
        assert!(difference < 1e-9, "{light} {difference:e}");
    }
}

/// Columns that all have the mean heights, and a surface of constant radius, which is flat over a triangle.
#[test]
fn two_spellings_of_a_scene_give_one_picture() {
    let model = with_radius();
    let heights: Vec<f64> = model.fields[1].values.iter().map(|radius| radius - 1.0).collect();
    for light in LIGHTS {
        // A round core has other normals than one of facets.
        let text = format!("core = \"transparent\"\n{}{light}", volume(1.0));
        let native = format!("heights = \"native\"\n{text}");
        let difference = max_difference(
            &model.picture(&small(&text), &heights, PANEL),
            &model.picture(&small(&native), &heights, PANEL),
        );
        assert!(difference < if light.is_empty() { 1e-12 } else { 1e-9 }, "{light} {difference:e}");
    }
    let paint = "color = \"orange\"\nopacity = 0.4\n";
    let iso = format!("{}[[isosurfaces]]\nfield = \"r\"\nvalue = 1.1\n{paint}", volume(1.0));
    let sheet = format!("{}[[surfaces]]\nheight_m = 0.1\n{paint}", volume(1.0));
    let difference =
        max_difference(&model.picture(&small(&iso), &[], PANEL), &model.picture(&small(&sheet), &[], PANEL));
    assert!(difference < 1e-12, "{difference:e}");
    // All that is outside of one cut is inside one of two others.
    let cut = |cut: &str, ends: &str| format!("[[clip]]\ncut = \"{cut}\"\n{ends}\n");
    let half = |lon: f64, lat: f64| format!("half_space = {{ towards = [{lon}, {lat}] }}");
    let pairs = [
        (cut("outside", "lat = [-20, 50]"), cut("inside", "lat = [50, 90]") + &cut("inside", "lat = [-90, -20]")),
        (cut("inside", &half(30.0, 20.0)), cut("outside", &half(210.0, -20.0))),
        (cut("inside", "lat = [0, 90]"), cut("inside", &half(0.0, 90.0))),
        (cut("inside", "layers = [1, 3]"), cut("inside", "layers = [1, 2]") + &cut("inside", "layers = [2, 3]")),
        (cut("inside", "lon = [20, 200]"), cut("inside", &half(110.0, 0.0))),
    ];
    for (one, other) in pairs {
        let [a, b] = [&one, &other].map(|cuts| model.picture(&small(&format!("{}{cuts}", volume(3.0))), &[], PANEL));
        assert!(max_difference(&a, &b) < 1e-12, "{one}{other}{:e}", max_difference(&a, &b));
    }
}
