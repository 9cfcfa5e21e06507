//! What is left out where a scene does not need it changes no picture: leaps not in a bit, lanes by rounding at most.

use icoray::{Field, Frame, Grid, IcosahedralMesh, Layers, Location, Renderer, Savings, Scene, Shape};

const NONE: Savings = Savings { ends: true, ..Savings::NONE };
const LEAPS: Savings = Savings { leaps: true, gradients: true, tiles: true, ..NONE };

const FAR: &str = "lon = 20\nlat = 35\ndistance = 3.2\nfov = 45";
const INSIDE: &str = "eye = [1.02, 0.3, 0.1]\ntarget = [0, 1.2, 0.3]\nfov = 100";

const SHELL: &str = "knots = [ { value = 0.1, color = \"red\", extinction = 0 }, { value = 0.3, color = \"green\", extinction = 40 }, \
     { value = 0.5, color = \"blue\", extinction = 0 } ]";
const STEPS: &str = "knots = [ { value = -0.9, color = \"red\", extinction = 1e4 }, { value = -0.5, color = \"orange\", extinction = 1e4 }, \
     { value = -0.5, color = \"blue\", extinction = 0 }, { value = 0.2, color = \"blue\", extinction = 0 }, \
     { value = 0.2, color = \"white\", extinction = 9 }, { value = 0.9, color = \"white\", extinction = 0 } ]";
const DENSE: &str = "knots = [ { value = -0.8, color = \"blue\", extinction = 4 }, { value = -0.2, color = \"white\", extinction = 1 }, \
     { value = 0.3, color = \"yellow\", extinction = 1 }, { value = 0.8, color = \"red\", extinction = 9 } ]";

fn scene(camera: &str, transfer: &str, rest: &str) -> Scene {
    let (rest, light) = rest.split_once('|').unwrap_or((rest, ""));
    Scene::parse(&format!(
        "field = \"f\"\n{rest}\n[image]\nwidth = 72\nheight = 60\n[camera]\n{camera}\n[transfer]\n{transfer}\n{light}\n"
    ))
    .unwrap()
}

/// A field with waves, level-fastest or cell-fastest, some values missing.
struct Model {
    mesh: IcosahedralMesh,
    layers: Layers,
    values: Vec<f32>,
    shape: Shape,
}

impl Model {
    fn new(layers: usize, is_level_fastest: bool, misses: bool) -> Self {
        let mesh = IcosahedralMesh::new(5).unwrap();
        let cells = mesh.lon_center_rad.len();
        let shape = if is_level_fastest {
            Shape::level_fastest(cells, layers)
        } else {
            Shape::cell_fastest(cells, layers)
        };
        let mut values = vec![0.0; cells * layers];
        for cell in 0..cells {
            for layer in 0..layers {
                let (lon, lat) = (mesh.lon_center_rad[cell], mesh.lat_center_rad[cell]);
                let height = layer as f64 / layers as f64;
                let value = (5.0 * lon + 4.0 * height).sin() * (6.0 * lat - 3.0 * height).cos();
                let is_missing = misses && (cell * 31 + layer * 7) % 97 == 0;
                let at = shape.offset as isize
                    + cell as isize * shape.column_stride
                    + layer as isize * shape.layer_stride;
                values[at as usize] = if is_missing { -9e33 } else { value as f32 };
            }
        }
        let radii = (0..layers).map(|l| 1.0 + 0.15 * l as f64 / (layers - 1) as f64).collect();
        Model { mesh, layers: Layers::new(radii, 1.0).unwrap(), values, shape }
    }

    fn draw(&self, scene: &Scene, savings: Savings) -> Frame {
        let grid = Grid::new(self.mesh.tables()).unwrap();
        let fill = Some(f64::from(-9e33f32));
        let field = Field::new(self.values.as_slice().into(), self.shape, Location::Center, fill).unwrap();
        let renderer = Renderer::new(2).unwrap().with_savings(savings);
        renderer.render(scene, &grid, &self.layers, &field).unwrap()
    }
}

fn scenes() -> Vec<(String, Scene)> {
    let mut scenes = Vec::new();
    for (camera, camera_name) in [(FAR, "far"), (INSIDE, "inside")] {
        for (transfer, transfer_name) in [(SHELL, "shell"), (STEPS, "steps"), (DENSE, "dense")] {
            for rest in
                ["", "precision = \"f64\"", "core = \"transparent\"", "|[light]\nkind = \"headlight\""]
            {
                let name = format!("{camera_name}, {transfer_name}, {rest:?}");
                scenes.push((name, scene(camera, transfer, rest)));
            }
        }
    }
    scenes
}

/// Few layers and many, values missing or not, both orders of the array: every bit of pixels and errors, and fewer frusta
/// read wherever something is clear.
#[test]
fn leaps_change_no_bit() {
    for (layers, is_level_fastest, misses) in [(6, true, false), (20, false, true), (90, true, true)] {
        let model = Model::new(layers, is_level_fastest, misses);
        for (name, scene) in scenes() {
            let [plain, leaping] = [NONE, LEAPS].map(|savings| model.draw(&scene, savings));
            assert!(plain.pixels == leaping.pixels, "{layers} layers, {name}: other pixels");
            assert!(plain.error == leaping.error, "{layers} layers, {name}: other errors");
            let [all, read] = [&plain, &leaping].map(|frame| frame.report.counts.frusta);
            assert_eq!(plain.report.counts.void_frusta, leaping.report.counts.void_frusta, "{name}");
            let is_clear = !name.contains("dense") && layers > 6;
            assert!(
                read <= all && (!is_clear || read < all - all / 20),
                "{layers} layers, {name}: {read} of {all}"
            );
        }
    }
}

/// What lanes compute differs from what one piece after the other does by rounding, which the errors hold.
#[test]
fn lanes_differ_by_rounding() {
    let model = Model::new(40, true, true);
    for (name, scene) in scenes() {
        let [one, lanes] = [LEAPS, Savings::ALL].map(|savings| model.draw(&scene, savings));
        let channels = one.pixels.iter().flatten().zip(lanes.pixels.iter().flatten());
        let off = channels.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(off <= 1e-6, "{name}: {off:e}");
        let errors = one.error.iter().zip(&lanes.error).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(errors <= 2e-6, "{name}: errors differ by {errors:e}");
        assert_eq!(one.report.counts.frusta, lanes.report.counts.frusta, "{name}");
    }
}
