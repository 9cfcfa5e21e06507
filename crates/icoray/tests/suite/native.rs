//! One volume on native heights in packets of rays, against single rays in double precision, pixel by pixel.

use icoray::{
    Field, Fields, Frame, Grid, Heights, IcosahedralMesh, Layers, Location, Reals, Renderer, Savings, Scene, Shape,
};

use crate::common::{at_centers, bits, columns_of, count_beyond, difference, icosahedral, laid_out, over_columns};
use crate::culled::{Culled, Mark, Style, holes};

const LAYERS: usize = 12;
pub const EXAGGERATION: f64 = 50.0;
const TOP: f64 = 4e-3;

const CAMERAS: [&str; 3] = [
    "lon = 20\nlat = 35\ndistance = 3.2\nfov = 45",
    "lon = -100\nlat = -60\ndistance = 1.5\nfov = 75",
    "eye = [1.02, 0.3, 0.1]\ntarget = [0, 1.2, 0.3]\nfov = 100",
];
const LIGHTS: [&str; 3] = [
    "",
    "[light]\nkind = \"headlight\"\n",
    "[light]\nkind = \"sun\"\nlon = 80\nlat = 10\nspecular = 0.6\nshininess = 40\n",
];
const DENSE: &str = "map = \"viridis\"\nrange = [-2.2, 2.2]\nopacity = [[-2.2, 0.9], [-0.4, 0.5], [0.5, 0.8]]\n";
const SPARSE: &str = "map = \"viridis\"\nrange = [-2.2, 2.2]\n\
    opacity = [[-0.9, 0.0], [-0.7, 0.8], [-0.5, 0.0], [1.0, 0.0], [1.5, 0.9]]\n";
const STEPS: &str = "knots = [ { value = -1.3, color = \"blue\", opacity = 0.9 }, \
    { value = -0.6, color = \"blue\", opacity = 0.9 }, { value = -0.6, color = \"white\", opacity = 0 }, \
    { value = 0.4, color = \"white\", opacity = 0 }, { value = 0.4, color = \"yellow\", opacity = 0.6 }, \
    { value = 1.9, color = \"red\", opacity = 0.99 } ]\n";

fn scene(keys: &str, camera: &str, transfer: &str, light: &str) -> Scene {
    let mut scene = Scene::parse(&format!(
        "field = \"f\"\nantialias = false\nbackend = \"cpu\"\nbackground = \"transparent\"\n\
         exaggeration = {EXAGGERATION}\n{keys}\n[image]\nwidth = 56\nheight = 48\n[camera]\n{camera}\n\
         [transfer]\n{transfer}{light}"
    ))
    .unwrap();
    scene.scenery.heights = Heights::Native;
    scene
}

/// Height of a layer over a cell: mountains as steep as they come, with layers that get even upwards. Below one cell in
/// five the lowest layers have no thickness. Numbers of few digits, equal in both precisions.
fn height(cell: usize, up: f64) -> f64 {
    let mountain = 2e-3 * (cell * 7919 % 13) as f64 / 12.0;
    let up = if cell.is_multiple_of(5) { (up * 1.5 - 0.5).max(0.0) } else { up };
    f64::from((mountain * (1.0 - up) + TOP * up) as f32)
}

/// A mesh with a field, and heights of the `rows` layers on which it lies, or midway between which it lies.
pub struct Model {
    pub mesh: &'static IcosahedralMesh,
    pub grid: Grid<'static>,
    pub values: Vec<f32>,
    pub heights: Vec<f64>,
    layers: usize,
    rows: usize,
}

impl Model {
    pub fn new(level: u32, layers: usize, rows: usize) -> Self {
        let (mesh, grid) = icosahedral(level);
        let value = |cell: usize, layer: usize| {
            let (d, up) = (grid.direction(cell as u32), layer as f64 / (layers - 1) as f64);
            ((4.0 * d.x + 3.0 * up).sin() + (5.0 * d.y * d.z - up).cos()) as f32
        };
        let height = |cell: usize, row: usize| height(cell, row as f64 / (rows - 1) as f64);
        let (values, heights) = (over_columns(grid.cells(), layers, value), over_columns(grid.cells(), rows, height));
        Model { mesh, grid, values, heights, layers, rows }
    }

    fn layers(&self) -> Layers {
        let mean: Vec<f64> = (0..self.rows).map(|row| 1e-3 + 3e-3 * row as f64 / (self.rows - 1) as f64).collect();
        Layers::from_heights(&mean, 1.0).unwrap()
    }

    pub fn draw(&self, scene: &Scene, savings: Savings) -> Frame {
        let fields = Fields::new([("f", at_centers(&self.values, self.layers))]);
        let fields = fields.with_heights(at_centers(&self.heights, self.rows));
        Renderer::new(2).unwrap().with_savings(savings).render(scene, &self.grid, &self.layers(), fields).unwrap()
    }
}

/// The picture in double precision, by single rays.
fn general(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    scene.precision = icoray::Precision::F64;
    scene
}

fn compare(model: &Model, scene: &Scene, name: &str) {
    let [packets, exact] = [scene.clone(), general(scene)].map(|scene| model.draw(&scene, Savings::ALL));
    let wrong = count_beyond(&packets, &exact, f32::EPSILON);
    assert_eq!(wrong, 0, "{name}: pixels, of {}; {:e} at most", exact.pixels.len(), difference(&packets, &exact));
    // Single rays are in double precision.
    assert!(packets.pixels != exact.pixels && exact.pixels.iter().any(|p| p[3] > 0.5), "{name}: nothing is seen");
    let beyond = packets.error.iter().filter(|error| **error > 1.01 * scene.tolerance as f32).count();
    let steep = transfer_has_steps(scene) || scene.tolerance < 5e-5;
    assert!(steep || beyond == 0, "{name}: {beyond} pixels report more than the tolerance");
}

fn transfer_has_steps(scene: &Scene) -> bool {
    scene.volumes[0].transfer.knots.windows(2).any(|knots| knots[0].value == knots[1].value)
}

#[test]
fn packets_show_the_picture_of_single_rays() {
    let model = Model::new(4, LAYERS, LAYERS);
    for tolerance in ["1e-2", "1e-3", "1e-4", "1e-5"] {
        for (i, camera) in CAMERAS.into_iter().enumerate() {
            for (k, light) in LIGHTS.into_iter().enumerate() {
                let core = if (i + k) % 2 == 0 { "core = \"#405060\"" } else { "core = \"transparent\"" };
                let transfer = [DENSE, SPARSE, STEPS][(i + k) % 3];
                let keys = format!("tolerance = {tolerance}\n{core}");
                compare(&model, &scene(&keys, camera, transfer, light), &format!("{keys} {camera} {transfer} {light}"));
            }
        }
    }
}

#[test]
fn fields_lie_midway_between_layers_too() {
    let model = Model::new(3, LAYERS, LAYERS + 1);
    for camera in CAMERAS {
        compare(&model, &scene("core = \"#405060\"", camera, DENSE, LIGHTS[1]), camera);
    }
}

#[test]
fn missing_values_are_void_and_columns_without_heights_have_mean_ones() {
    let mut model = Model::new(3, LAYERS, LAYERS);
    model.values.iter_mut().step_by(31).for_each(|value| *value = f32::NAN);
    for (cell, column) in model.heights.chunks_exact_mut(LAYERS).enumerate() {
        if cell % 7 == 3 {
            column.fill(f64::NAN);
        }
    }
    for (camera, light) in CAMERAS.into_iter().zip(LIGHTS) {
        compare(&model, &scene("core = \"#405060\"", camera, DENSE, light), camera);
    }
}

/// Heights in both precisions and in all layouts: the same bits.
#[test]
fn heights_are_read_wherever_they_lie() {
    let model = Model::new(3, LAYERS, LAYERS);
    let cells = model.grid.cells();
    let draw = |shape: Shape, array: Reals, is_falling: bool| {
        let mut mean: Vec<f64> = model.layers().radius_m().iter().map(|radius| radius - 1.0).collect();
        let mut values = model.values.clone();
        if is_falling {
            mean.reverse();
            values.chunks_exact_mut(LAYERS).for_each(<[f32]>::reverse);
        }
        let layers = Layers::from_heights(&mean, 1.0).unwrap();
        let heights = Field::new(array, shape, Location::Center, None).unwrap();
        let fields = Fields::new([("f", at_centers(&values, LAYERS))]).with_heights(heights);
        let scene = scene("core = \"#405060\"", CAMERAS[0], SPARSE, "");
        bits(&Renderer::new(2).unwrap().render(&scene, &model.grid, &layers, fields).unwrap())
    };
    let given = |cell: usize, layer: usize| model.heights[cell * LAYERS + layer];
    let expected = draw(Shape::level_fastest(cells, LAYERS), model.heights.as_slice().into(), false);
    for shape in
        [Shape::level_fastest(cells, LAYERS), Shape::cell_fastest(cells, LAYERS), Shape::blocked(cells, LAYERS, 7)]
    {
        let double = laid_out(&shape, f64::NAN, given);
        let single: Vec<f32> = double.iter().map(|height| *height as f32).collect();
        assert!(draw(shape, double.as_slice().into(), false) == expected, "{shape:?} in f64");
        assert!(draw(shape, single.as_slice().into(), false) == expected, "{shape:?} in f32");
    }
    let top_first: Vec<f64> =
        model.heights.chunks_exact(LAYERS).flat_map(|column| column.iter().rev().copied()).collect();
    assert!(draw(Shape::level_fastest(cells, LAYERS), top_first.as_slice().into(), true) == expected, "top first");
}

/// Rays pass void triangles, below which the core is round.
#[test]
fn meshes_with_holes_are_those_of_the_general_kernel() {
    let whole = Model::new(3, LAYERS, LAYERS);
    for (i, (name, stays)) in holes(whole.mesh).into_iter().enumerate().step_by(3) {
        let culled = Culled::new(whole.mesh, &stays, Style::Corners, Mark::MinusOne, 0);
        let grid = culled.grid();
        let values = columns_of(&whole.values, &culled.cells, LAYERS);
        let heights = columns_of(&whole.heights, &culled.cells, LAYERS);
        let light = LIGHTS[i % 3];
        let scene = scene("core = \"#405060\"", CAMERAS[i % 3], DENSE, light);
        let [packets, exact] = [scene.clone(), general(&scene)].map(|scene| {
            let fields = Fields::new([("f", at_centers(&values, LAYERS))]);
            let fields = fields.with_heights(at_centers(&heights, LAYERS));
            Renderer::new(2).unwrap().render(&scene, &grid, &whole.layers(), fields).unwrap()
        });
        assert_eq!(count_beyond(&packets, &exact, f32::EPSILON), 0, "{name}, {light}");
    }
}

#[test]
fn empty_space_skipping_changes_no_picture() {
    let model = Model::new(4, LAYERS, LAYERS);
    let reading = Savings { empty_space: false, layers: false, gradients: false, ..Savings::ALL };
    for (camera, light) in CAMERAS.into_iter().zip(LIGHTS) {
        for core in ["core = \"#405060\"", "core = \"transparent\""] {
            let scene = scene(core, camera, SPARSE, light);
            let [skipping, all] = [Savings::ALL, reading].map(|savings| model.draw(&scene, savings));
            let off = difference(&skipping, &all);
            assert!(off <= 1e-6, "{core} {camera} {light}: {off:e}");
            let [fewer, frusta] = [&skipping, &all].map(|frame| frame.report.counts.frusta);
            assert!(10 * fewer < 9 * frusta, "{core} {camera} {light}: {fewer} of {frusta}");
        }
    }
}

/// Packets report where rays meet the ground: pixels with its edge in them show several rays.
#[test]
fn edges_of_the_ground_are_smooth() {
    let model = Model::new(4, LAYERS, LAYERS);
    let thin = "map = \"viridis\"\nrange = [-2.2, 2.2]\nopacity = [[-2.2, 0.1], [2.2, 0.1]]\n";
    let mut scene = scene("core = \"#a0b0c0\"\ntolerance = 1e-4", CAMERAS[1], thin, "");
    scene.antialias = true;
    let [packets, exact] = [scene.clone(), general(&scene)].map(|scene| model.draw(&scene, Savings::ALL));
    assert!(packets.pixels != exact.pixels);
    let [edges, expected] = [&packets, &exact].map(|frame| frame.report.edge_pixels);
    assert!(expected > 20 && edges.abs_diff(expected) <= 2, "{edges} edge pixels, {expected}");
    let wrong = count_beyond(&packets, &exact, f32::EPSILON);
    assert!(wrong <= 2, "{wrong} pixels");
}

/// Without vectors single rays draw single precision too.
#[test]
fn packets_are_left_out_where_a_renderer_has_none() {
    let model = Model::new(2, LAYERS, LAYERS);
    let scene = scene("core = \"#405060\"", CAMERAS[0], DENSE, "");
    let plain = model.draw(&scene, Savings { lanes: false, ..Savings::ALL });
    assert!(plain.pixels == model.draw(&general(&scene), Savings::ALL).pixels);
}
