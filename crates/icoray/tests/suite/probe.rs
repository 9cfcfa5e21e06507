//! Probes of rays against what is known of a field, and frames that are given up.

use icoray::{Field, Grid, IcosahedralMesh, Layers, Location, Renderer, Scene, Shape};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

const HEIGHTS_M: [f64; 9] = [0.0, 1e4, 2e4, 3e4, 4e4, 5e4, 6e4, 7e4, 8e4];
const PLANET_M: f64 = 6.371e6;

/// Heights in kilometres as values, the innermost layer first or last.
fn with_field<R>(is_falling: bool, look: impl FnOnce(&Grid, &Layers, &Field) -> R) -> R {
    let mesh = IcosahedralMesh::new(4).unwrap();
    let grid = Grid::new(mesh.tables()).unwrap();
    let mut heights = HEIGHTS_M.to_vec();
    if is_falling {
        heights.reverse();
    }
    let layers = Layers::from_heights(&heights, PLANET_M).unwrap();
    let values: Vec<f32> = (0..grid.cells()).flat_map(|_| heights.iter().map(|h| (h / 1e3) as f32)).collect();
    let shape = Shape::level_fastest(grid.cells(), heights.len());
    let field = Field::new(values.as_slice().into(), shape, Location::Center, None).unwrap();
    look(&grid, &layers, &field)
}

/// A shell around `value`, seen from over 20 E 30 N.
fn scene(value: f64, opacity: f64, rest: &str) -> Scene {
    let (below, above) = (value - 2.0, value + 2.0);
    Scene::parse(&format!(
        "field = 'height'\nexaggeration = 10\nbackground = 'transparent'\n{rest}\n\
         image = {{ width = 21, height = 15 }}\ncamera = {{ lon = 20, lat = 30, distance = 4, fov = 30 }}\n\
         [transfer]\nunit_length = 0.005\nknots = [ {{ value = {below}, color = 'white', opacity = 0 }},\n\
         {{ value = {value}, color = 'white', opacity = {opacity} }}, {{ value = {above}, color = 'white', opacity = 0 }} ]"
    ))
    .unwrap()
}

#[test]
fn a_probe_finds_where_the_light_comes_from() {
    let renderer = Renderer::new(1).unwrap();
    for is_falling in [false, true] {
        with_field(is_falling, |grid, layers, field| {
            for (value, opacity) in [(65.0, 0.9), (25.0, 0.99)] {
                let scene = scene(value, opacity, "");
                let probe = renderer.probe(&scene, grid, layers, field, [0.5, 0.5]).unwrap().unwrap();
                let [lon, lat] = probe.lon_lat_deg;
                assert!((lon - 20.0).abs() < 1e-9 && (lat - 30.0).abs() < 1e-9, "{lon} {lat}");
                assert!((probe.value.unwrap() - value).abs() < 2.6 && !probe.is_core, "{probe:?}");
                assert!((probe.height_m / 1e3 - probe.value.unwrap()).abs() < 0.1, "{probe:?}");
                let column: Vec<[f64; 2]> = HEIGHTS_M.iter().map(|h| [*h, h / 1e3]).collect();
                for (found, expected) in probe.column.iter().zip(&column) {
                    assert!((found[0] - expected[0]).abs() < 1e-3 && found[1] == expected[1], "{found:?}");
                }
                assert_eq!(probe.column.len(), column.len());
                // What the renderer integrates, and the sum of the weights.
                let frame = renderer.render(&scene, grid, layers, field).unwrap();
                let alpha = f64::from(frame.pixels[7 * 21 + 10][3]);
                let sum: f64 = probe.along.iter().map(|point| point.weight).sum();
                assert!((sum - probe.alpha).abs() < 1e-12);
                // The parts of the ray join.
                for (a, b) in probe.along.iter().zip(&probe.along[1..]) {
                    let gap = b.distance - a.distance - 0.5 * (a.length + b.length);
                    assert!(gap.abs() < 1e-9, "{a:?} {b:?}");
                }
                let solid = scene.core.is_some();
                assert!(solid && (alpha - 1.0).abs() < 1e-3);
                let clear = Scene { core: None, ..scene };
                let through = renderer.probe(&clear, grid, layers, field, [0.5, 0.5]).unwrap().unwrap();
                let frame = renderer.render(&clear, grid, layers, field).unwrap();
                let alpha = f64::from(frame.pixels[7 * 21 + 10][3]);
                assert!((through.alpha - alpha).abs() < 0.02, "{} {alpha}", through.alpha);
            }
        });
    }
}

#[test]
fn a_probe_finds_the_ground_behind_what_is_clear() {
    let renderer = Renderer::new(1).unwrap();
    with_field(false, |grid, layers, field| {
        let probe = renderer.probe(&scene(300.0, 0.5, ""), grid, layers, field, [0.5, 0.5]).unwrap().unwrap();
        assert!(probe.is_core && probe.alpha == 0.0 && probe.height_m == 0.0, "{probe:?}");
        assert!(probe.value.unwrap() < 5.0, "{probe:?}");
        assert_eq!(renderer.probe(&scene(300.0, 0.5, ""), grid, layers, field, [0.0, 0.0]).unwrap(), None);
        let hollow = renderer.probe(&scene(300.0, 0.5, "core = 'transparent'"), grid, layers, field, [0.5, 0.5]);
        let hollow = hollow.unwrap().unwrap();
        assert!(!hollow.is_core && hollow.along.len() >= 16 * 4, "{}", hollow.along.len());
    });
}

#[test]
fn a_frame_that_is_given_up_traces_nothing() {
    let stop = Arc::new(AtomicBool::new(true));
    let renderer = Renderer::new(2).unwrap().with_stop(stop.clone());
    with_field(false, |grid, layers, field| {
        let scene = scene(25.0, 0.9, "");
        let frame = renderer.render(&scene, grid, layers, field).unwrap();
        assert_eq!(frame.report.counts.rays, 0);
        stop.store(false, Relaxed);
        let frame = renderer.render(&scene, grid, layers, field).unwrap();
        let plain = Renderer::new(2).unwrap().render(&scene, grid, layers, field).unwrap();
        assert!(frame.report.counts.rays > 100 && frame.pixels == plain.pixels);
    });
}
