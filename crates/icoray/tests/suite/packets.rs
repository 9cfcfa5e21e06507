//! Packets of rays, in single precision, against single rays in double precision, pixel by pixel: one volume on layers
//! at heights of their own over each cell, and scenes of more than one volume.

use crate::common::{Model, bits, count_beyond, difference, even_heights, over_columns, pixel_difference, scene_of};
use crate::contents::*;
use icoray::{Heights, Layers, Precision, Renderer, Savings, Scene};
use itertools::iproduct;

const LAYERS: usize = 12;
const EXAGGERATION: f64 = 60.0;
/// Metres.
pub const TOP: f64 = 20e3;
const EARTH_M: f64 = 6.371e6;

const CAMERAS: [&str; 3] = [
    "lon = 20\nlat = 35\ndistance = 3.2\nfov = 45",
    "lon = -100\nlat = -60\ndistance = 1.5\nfov = 75",
    "eye = [1.02, 0.3, 0.1]\ntarget = [0, 1.2, 0.3]\nfov = 100",
];
const LIGHTS: [&str; 3] = [
    "[light]\nkind = \"none\"\n",
    "[light]\nkind = \"headlight\"\n",
    "[light]\nkind = \"sun\"\nlon = 80\nlat = 10\nspecular = 0.6\nshininess = 40\n",
];
const CORES: [&str; 2] = ["core = \"#405060\"", "core = \"transparent\""];

const FULL: &str = "[[volumes]]\nfield = \"f\"\ntransfer = { map = \"viridis\", range = [-1, 1], \
    opacity = [[-1, 0.9], [-0.2, 0.5], [0.25, 0.8]] }\n";
const FRONT: &str = "[[volumes]]\nfield = \"g\"\ntransfer = { unit_length = 1, knots = [ \
    { value = -0.3, color = \"yellow\", extinction = 1e9 }, { value = 0.15, color = \"blue\", extinction = 0 } ] }\n";
const HALF: &str = "[[clip]]\ncut = \"inside\"\nhalf_space = { towards = [40, 20], distance = 0.4 }\n";
const SLAB: &str = "[[clip]]\ncut = \"inside\"\nlayers = [2, 5]\nlon = [-150, 40]\nlat = [-90, 90]\n";
const CELLS: &str = "[[lines]]\npattern = \"cells\"\non = 3\ncolor = \"black\"\n";

/// What is in each scene.
const SCENES: [&[&str]; 21] = [
    &[ONE, REGION],
    &[ONE, SHELL],
    &[THIN, HALF, SHELL],
    &[ONE, SLAB],
    &[STEPS, REGION],
    &[ONE, ISO],
    &[THIN, OWN_ISO],
    &[OWN_ISO],
    &[ISO, REGION, SLAB],
    &[ONE, SURFACE, CELLS],
    &[THIN, HIGH],
    &[SURFACE],
    &[ONE, OTHER],
    &[THIN, OTHER],
    &[THIN, STEPS],
    &[ONE, DENSE],
    &[ONE, FRONT],
    &[BY_OTHER],
    &[BY_OTHER, THIN, OTHER],
    &[ONE, OTHER, REGION, ISO],
    &[THIN, OTHER, SHELL, HALF, SLAB, OWN_ISO, SURFACE, HIGH, CELLS],
];

/// The height of layer `row` of `rows` over a cell: mountains as steep as they come, with layers that get even upwards.
/// Below one cell in five the lowest layers have no thickness. Numbers of few digits, equal in both precisions.
fn height(cell: usize, row: usize, rows: usize) -> f64 {
    let (mountain, up) = (10e3 * (cell * 7919 % 13) as f64 / 12.0, row as f64 / (rows - 1) as f64);
    let up = if cell.is_multiple_of(5) { (up * 1.5 - 0.5).max(0.0) } else { up };
    f64::from((mountain * (1.0 - up) + TOP * up) as f32)
}

/// Two fields on layers at heights of their own.
pub fn waves(level: u32, layers: usize) -> Model {
    let up = |layer: usize| layer as f64 / (layers - 1) as f64;
    let heights = even_heights(layers, TOP);
    let mut model = Model::new(level, &heights, |_, d, layer| {
        let f = (4.0 * d.x + 3.0 * up(layer)).sin() + (5.0 * d.y * d.z - up(layer)).cos();
        let g = (5.0 * d.z - 2.0 * up(layer)).cos() * (3.0 * d.y + 1.0).sin() + 0.3 * up(layer);
        [0.5 * f, 0.65 * g]
    });
    model.layers = Layers::from_heights(&heights, EARTH_M).unwrap();
    model.heights = over_columns(model.grid.cells(), layers, |cell, row| height(cell, row, layers));
    model
}

/// A scene on native heights.
pub fn scene(contents: &str, keys: &str, camera: &str, light: &str) -> Scene {
    let keys = format!(
        "antialias = false\nbackend = \"cpu\"\nbackground = \"transparent\"\nexaggeration = {EXAGGERATION}\n{keys}\n\
         image = {{ width = 56, height = 48 }}\nheights = \"native\""
    );
    scene_of(camera, &keys, &format!("{contents}{light}"))
}

/// The scene in double precision, by single rays.
fn general(scene: &Scene) -> Scene {
    Scene { precision: Precision::F64, ..scene.clone() }
}

/// Checks packets against single rays.
fn compare(model: &Model, scene: &Scene, name: &str) {
    let [packets, exact] = [scene.clone(), general(scene)].map(|scene| model.draw(&scene));
    assert!(packets.pixels.as_flattened().iter().all(|channel| channel.is_finite()), "{name}: no number");
    let is_single = scene.has_single_volume();
    // The errors of several volumes and of light are estimates.
    let (most, slack) = if is_single { (0, 1.0) } else { (exact.pixels.len() * 2 / 1000, 4.0) };
    let wrong = count_beyond(&packets, &exact, slack * f32::EPSILON);
    let of = |i: usize| (i, pixel_difference(&packets, &exact, i), packets.error[i], exact.error[i]);
    let worst = (0..packets.pixels.len()).map(of).max_by(|a, b| (a.1 - a.2 - a.3).total_cmp(&(b.1 - b.2 - b.3)));
    assert!(wrong <= most, "{name}: {wrong} pixels, {:e}; {worst:?}", difference(&packets, &exact));
    assert!(exact.pixels.iter().any(|p| p[3] > 0.2), "{name}: nothing is seen");
    // Single rays are in double precision.
    assert!(bits(&packets) != bits(&exact), "{name}: no packets");
    let has_steps = scene.volumes.iter().any(|v| v.transfer.knots.windows(2).any(|k| k[0].value == k[1].value));
    if is_single && !has_steps && scene.tolerance >= 5e-5 {
        let beyond = packets.error.iter().filter(|error| **error > 1.01 * scene.tolerance as f32).count();
        assert!(beyond == 0, "{name}: {beyond} pixels report more than the tolerance");
    }
}

/// All scenes with all lights, one of the cameras and tolerances each, on concentric and on native layers.
#[test]
fn packets_show_the_pictures_of_single_rays() {
    let model = waves(4, LAYERS);
    for (i, contents) in SCENES.into_iter().enumerate() {
        for (k, light) in LIGHTS.into_iter().enumerate() {
            for heights in [Heights::Mean, Heights::Native] {
                let tolerance = ["1e-2", "1e-3", "1e-4"][(i + k) % 3];
                let camera = CAMERAS[(i + 2 * k + usize::from(heights == Heights::Native)) % 3];
                let keys = format!("tolerance = {tolerance}\n{}", CORES[i % 2]);
                let mut scene = scene(&contents.concat(), &keys, camera, light);
                scene.scenery.heights = heights;
                compare(&model, &scene, &format!("{i} {heights:?} {keys} {camera} {light}"));
            }
        }
    }
}

#[test]
fn fields_lie_midway_between_layers_too() {
    let mut model = waves(3, LAYERS);
    model.layers = Layers::from_heights(&even_heights(LAYERS + 1, TOP), EARTH_M).unwrap();
    model.heights = over_columns(model.grid.cells(), LAYERS + 1, |cell, row| height(cell, row, LAYERS + 1));
    for camera in CAMERAS {
        compare(&model, &scene(FULL, CORES[0], camera, LIGHTS[1]), camera);
    }
}

#[test]
fn missing_values_are_void_and_columns_without_heights_have_mean_ones() {
    let mut model = waves(3, LAYERS);
    let [f, g] = &mut model.values[..] else { panic!("two fields") };
    f.iter_mut().step_by(31).for_each(|value| *value = f32::NAN);
    g.iter_mut().skip(5).step_by(47).for_each(|value| *value = f32::NAN);
    model.heights.chunks_exact_mut(LAYERS).skip(3).step_by(7).for_each(|column| column.fill(f64::NAN));
    for (camera, light) in CAMERAS.into_iter().zip(LIGHTS) {
        compare(&model, &scene(FULL, CORES[0], camera, light), camera);
    }
    for (i, contents) in SCENES.into_iter().enumerate() {
        let mut scene = scene(&contents.concat(), CORES[0], CAMERAS[i % 3], LIGHTS[i % 2]);
        scene.scenery.heights = Heights::Mean;
        compare(&model, &scene, &format!("{i}"));
    }
}

#[test]
fn threads_change_no_bit() {
    let model = waves(3, LAYERS);
    for (i, contents) in SCENES.into_iter().enumerate() {
        let mut scene = scene(&contents.concat(), CORES[0], CAMERAS[i % 2], LIGHTS[i % 3]);
        scene.scenery.heights = Heights::Mean;
        let [one, three] = [1, 3].map(|threads| bits(&model.draw_by(&Renderer::new(threads).unwrap(), &scene)));
        assert!(one == three, "{i}");
    }
}

#[test]
fn empty_space_skipping_changes_no_picture() {
    let model = waves(4, LAYERS);
    let reading = Savings { empty_space: false, layers: false, gradients: false, ..Savings::ALL };
    let reading = Renderer::new(2).unwrap().with_savings(reading);
    // Of several fields each is visible where the others are not.
    for ((camera, light), core, contents) in
        iproduct!(CAMERAS.into_iter().zip(LIGHTS), CORES, [[THIN, ""], [THIN, OTHER], [OTHER, THIN], [OTHER, OWN_ISO]])
    {
        let scene = scene(&contents.concat(), core, camera, light);
        let (skipping, all) = (model.draw(&scene), model.draw_by(&reading, &scene));
        let off = difference(&skipping, &all);
        assert!(off <= 1e-6, "{contents:?} {core} {camera} {light}: {off:e}");
        let [fewer, frusta] = [&skipping, &all].map(|frame| frame.report.counts.frusta);
        let most = if contents[1].is_empty() { 9 } else { 10 };
        assert!(10 * fewer < most * frusta, "{contents:?} {core} {camera} {light}: {fewer} of {frusta}");
    }
}

/// Packets report where rays meet the ground: pixels with its edge in them show several rays.
#[test]
fn edges_of_the_ground_are_smooth() {
    let model = waves(4, LAYERS);
    let haze = FULL.replace("[-1, 0.9], [-0.2, 0.5], [0.25, 0.8]", "[-1, 0.1], [1, 0.1]");
    let mut scene = scene(&haze, "core = \"#a0b0c0\"\ntolerance = 1e-4", CAMERAS[1], "");
    scene.antialias = true;
    let [packets, exact] = [scene.clone(), general(&scene)].map(|scene| model.draw(&scene));
    assert!(packets.pixels != exact.pixels);
    let [edges, expected] = [&packets, &exact].map(|frame| frame.report.edge_pixels);
    assert!(expected > 20 && edges.abs_diff(expected) <= 2, "{edges} edge pixels, {expected}");
    let wrong = count_beyond(&packets, &exact, f32::EPSILON);
    assert!(wrong <= 2, "{wrong} pixels");
}

/// Without vectors single rays draw single precision too.
#[test]
fn packets_are_left_out_where_a_renderer_has_none() {
    let model = waves(2, LAYERS);
    let scene = scene(FULL, CORES[0], CAMERAS[0], "");
    let plain = Renderer::new(2).unwrap().with_savings(Savings { lanes: false, ..Savings::ALL });
    assert!(model.draw_by(&plain, &scene).pixels == model.draw(&general(&scene)).pixels);
}
