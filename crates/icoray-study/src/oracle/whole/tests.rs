use super::*;
use crate::job::Job;
use crate::oracle::Oracle;
use crate::sphere::{Sphere, multi_scale};

const LAYERS: usize = 6;

/// A mesh with the field `f`, and `r`, the radius.
struct Model {
    sphere: Sphere,
    fields: [(&'static str, Vec<f64>); 2],
}

impl Model {
    fn new() -> Self {
        let sphere = Sphere::new(2, LAYERS, [1.0, 1.3], multi_scale).unwrap();
        let values = sphere.values.iter().map(|value| f64::from(*value)).collect();
        let radius = sphere.layers.radius_m().iter().copied().cycle().take(sphere.values.len()).collect();
        Model { sphere, fields: [("f", values), ("r", radius)] }
    }

    /// Colours of the rays of a picture.
    fn picture(&self, text: &str, heights: &[f64]) -> Vec<[f64; 4]> {
        let scene = scene(text);
        let grid = self.sphere.grid().unwrap();
        let data = Data { grid: &grid, layers: &self.sphere.layers, heights, fields: &self.fields };
        let whole = WholeScene::new(&scene, data).unwrap();
        let dir = |i: u32| shading::pixel_direction(&scene, i);
        (0..16 * 12).map(|i| whole.pixel(scene.camera.eye().into(), dir(i)).unwrap()).collect()
    }
}

fn scene(text: &str) -> Scene {
    let mut scene = Scene::parse(&format!(
        "background = \"transparent\"\nimage = {{ width = 16, height = 12 }}\n\
         camera = {{ lon = 20, lat = 35, distance = 2.2, fov = 60 }}\n{text}"
    ))
    .unwrap();
    scene.name_first_field("f");
    scene
}

fn apart(one: &[[f64; 4]], other: &[[f64; 4]]) -> f64 {
    assert!(one.iter().any(|pixel| pixel[3] > 0.2), "nothing is seen");
    crate::compare::Comparison::new(one, other).max
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

/// The other oracle walks over columns and cuts frusta by code of its own.
#[test]
fn one_volume_is_that_of_the_oracle_of_one_volume() {
    let model = Model::new();
    for light in LIGHTS {
        let scene = scene(&format!("{}{light}", volume(1.0)));
        let (grid, field) = (model.sphere.grid().unwrap(), model.sphere.field().unwrap());
        let job = Job { scene: &scene, grid: &grid, layers: &model.sphere.layers, field: &field };
        let expected = Oracle::new(&job).unwrap().picture(&icoray::Renderer::new(1).unwrap());
        let off = apart(&model.picture(&format!("{}{light}", volume(1.0)), &[]), &expected);
        assert!(off < if light.is_empty() { 1e-12 } else { 1e-9 }, "{light} {off:e}");
    }
}

#[test]
fn parts_of_a_volume_add_up_to_it() {
    let model = Model::new();
    for light in LIGHTS {
        let parts = [0.25, 0.6, 0.15].map(volume).concat();
        let off = apart(&model.picture(&format!("{}{light}", volume(1.0)), &[]), &model.picture(&(parts + light), &[]));
        assert!(off < 1e-9, "{light} {off:e}");
    }
}

/// Columns that all have the mean heights, and a surface of constant radius, which is flat over a triangle.
#[test]
fn what_is_written_in_two_ways_is_seen_alike() {
    let model = Model::new();
    let heights: Vec<f64> = model.fields[1].1.iter().map(|radius| radius - 1.0).collect();
    for light in LIGHTS {
        // A round core has other normals than one of facets.
        let text = format!("core = \"transparent\"\n{}{light}", volume(1.0));
        let native = format!("heights = \"native\"\n{text}");
        let off = apart(&model.picture(&text, &heights), &model.picture(&native, &heights));
        assert!(off < if light.is_empty() { 1e-12 } else { 1e-9 }, "{light} {off:e}");
    }
    let paint = "color = \"orange\"\nopacity = 0.4\n";
    let iso = format!("{}[[isosurfaces]]\nfield = \"r\"\nvalue = 1.1\n{paint}", volume(1.0));
    let sheet = format!("{}[[surfaces]]\nheight_m = 0.1\n{paint}", volume(1.0));
    let off = apart(&model.picture(&iso, &[]), &model.picture(&sheet, &[]));
    assert!(off < 1e-12, "{off:e}");
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
        let [a, b] = [&one, &other].map(|cuts| model.picture(&format!("{}{cuts}", volume(3.0)), &[]));
        assert!(apart(&a, &b) < 1e-12, "{one}{other}{:e}", apart(&a, &b));
    }
}
