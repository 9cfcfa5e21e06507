//! Levels of detail: pictures of values that were drawn before are traced on coarser grids, within their errors.

use crate::common::{DENSE, FAR, INSIDE, LIT, Model, SHELL, at_centers, count_beyond, even_heights, scene};
use icoray::{Frame, Precision, Renderer, Scene};

const LAYERS: usize = 9;
const STEPS: &str = "knots = [ { value = -0.5, color = \"orange\", extinction = 30 }, { value = -0.5, color = \"blue\", extinction = 0 }, \
     { value = 0.2, color = \"blue\", extinction = 0 }, { value = 0.2, color = \"white\", extinction = 9 } ]";
/// Stripes of one extinction: only the colours of a level differ.
const STRIPES: &str = "knots = [ { value = -0.9, color = \"black\", extinction = 20 }, { value = -0.6, color = \"white\", extinction = 20 }, \
     { value = -0.3, color = \"black\", extinction = 20 }, { value = 0, color = \"white\", extinction = 20 }, \
     { value = 0.3, color = \"black\", extinction = 20 }, { value = 0.6, color = \"white\", extinction = 20 } ]";

/// A smooth field over a grid of four levels, of whose values some may be missing; `falls` stores the outermost layer
/// first.
fn model(waves: f64, misses: bool, falls: bool) -> Model {
    let mut heights = even_heights(LAYERS, 0.15);
    if falls {
        heights.reverse();
    }
    Model::new(7, &heights, |_, p, layer| {
        let height = if falls { LAYERS - 1 - layer } else { layer } as f64 / LAYERS as f64;
        let (lon, lat) = (p.y.atan2(p.x), p.z.asin());
        let value = (waves * (lon + 2.0 * height)).sin() * (waves * (1.3 * lat - 1.5 * height)).cos();
        [if misses && lat > 0.9 && lon.abs() > 2.0 { f64::NAN } else { value }]
    })
}

/// The first, second and third picture of the same renderer.
fn draw(model: &Model, scenes: [&Scene; 3]) -> [Frame; 3] {
    let field = at_centers(&model.values[0], LAYERS);
    let renderer = Renderer::new(2).unwrap().with_levels();
    scenes.map(|scene| renderer.render(scene, &model.grid, &model.layers, &field).unwrap())
}

#[test]
fn pixels_of_levels_are_within_their_errors() {
    let mut used = 0;
    for (model, camera, transfer, rest) in [
        (model(1.0, false, false), FAR, DENSE, "tolerance = 0.15"),
        (model(1.0, true, false), FAR, DENSE, "tolerance = 0.1\ncore = \"transparent\""),
        (model(3.0, false, true), FAR, SHELL, "tolerance = 0.05"),
        (model(3.0, false, false), FAR, STRIPES, "tolerance = 0.02"),
        (model(2.0, true, false), FAR, STEPS, "tolerance = 0.02"),
        (model(1.0, false, true), INSIDE, DENSE, "tolerance = 0.1"),
    ] {
        let scene = scene(camera, transfer, rest);
        let hurried = Scene { time_budget_ms: Some(1e-3), largest_step: 1, ..scene.clone() };
        let truth = Scene { precision: Precision::F64, tolerance: 1e-7, ..scene.clone() };
        let single = Scene { antialias: false, ..truth.clone() };
        let [_, level, hurried] = draw(&model, [&scene, &scene, &hurried]);
        let [truth, single, _] = draw(&model, [&truth, &single, &single]);
        used += u32::from(level.report.quality.level > 0);
        assert!(level.report.error.max <= scene.tolerance, "{rest}: {:?}", level.report.error);
        assert!(hurried.report.quality.level > 0 && hurried.report.counts.rays > 0, "{rest}");
        for (frame, truth) in [(level, truth), (hurried, single)] {
            assert_eq!(count_beyond(&frame, &truth, 0.0), 0, "{rest}: {}", frame.report.quality);
        }
    }
    assert!(used >= 2, "{used} pictures within their tolerance on levels");
}

/// Levels are made for the second picture of the same values, of renderers that have them, and for nothing else.
#[test]
fn first_pictures_and_budgets_make_no_levels() {
    let model = model(1.0, false, false);
    let scene = scene(FAR, DENSE, "tolerance = 0.2");
    let hurried = Scene { time_budget_ms: Some(1e-3), ..scene.clone() };
    let levels = |scenes| draw(&model, scenes).map(|frame| frame.report.quality.level > 0);
    assert_eq!(levels([&scene, &hurried, &hurried]), [false; 3]);
    assert_eq!(levels([&scene, &scene, &hurried]), [false, true, true]);
}

/// The shade of a level is not known to be that of the grid.
#[test]
fn lit_pictures_without_a_budget_are_of_the_grid() {
    let model = model(1.0, false, false);
    for (light, is_on_level) in [("", true), (LIT, false)] {
        let scene = scene(FAR, &format!("{DENSE}\n{light}"), "tolerance = 0.2");
        let [_, second, _] = draw(&model, [&scene; 3]);
        assert_eq!(second.report.quality.level > 0, is_on_level, "{light}");
    }
}
