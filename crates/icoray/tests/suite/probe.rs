//! Probes of rays against analytic fields.

use crate::common::{Model, over_columns};
use icoray::{Layers, Probe, Renderer, Scene, ScenePart};

const HEIGHTS_M: [f64; 9] = [0.0, 1e4, 2e4, 3e4, 4e4, 5e4, 6e4, 7e4, 8e4];
const PLANET_M: f64 = 6.371e6;

/// Heights in kilometres as values, the innermost layer first or last.
fn model(is_falling: bool) -> Model {
    let mut heights = HEIGHTS_M;
    if is_falling {
        heights.reverse();
    }
    let layers = Layers::from_heights(&heights, PLANET_M).unwrap();
    Model { layers, ..Model::new(4, &heights, |_, _, layer| [heights[layer] / 1e3]) }
}

/// A shell around `value`, seen from over 20 E 30 N.
fn scene(value: f64, opacity: f64, rest: &str) -> Scene {
    let (below, above) = (value - 2.0, value + 2.0);
    Scene::parse(&format!(
        "field = 'f'\nexaggeration = 10\nbackground = 'transparent'\n{rest}\n\
         image = {{ width = 21, height = 15 }}\ncamera = {{ lon = 20, lat = 30, distance = 4, fov = 30 }}\n\
         [transfer]\nunit_length = 0.005\nknots = [ {{ value = {below}, color = 'white', opacity = 0 }},\n\
         {{ value = {value}, color = 'white', opacity = {opacity} }}, {{ value = {above}, color = 'white', opacity = 0 }} ]"
    ))
    .unwrap()
}

fn probed(data: &Model, scene: &Scene, place: [f64; 2]) -> Option<Probe> {
    Renderer::new(1).unwrap().probe(scene, &data.grid, &data.layers, data.fields(), place).unwrap()
}

#[test]
fn a_probe_finds_where_the_light_comes_from() {
    for data in [false, true].map(model) {
        for (value, opacity) in [(65.0, 0.9), (25.0, 0.99)] {
            let scene = scene(value, opacity, "");
            let probe = probed(&data, &scene, [0.5, 0.5]).unwrap();
            let [lon, lat] = probe.lon_lat_deg;
            assert!((lon - 20.0).abs() < 1e-9 && (lat - 30.0).abs() < 1e-9, "{lon} {lat}");
            assert!(
                (probe.value.unwrap() - value).abs() < 2.6 && probe.part == Some(ScenePart::Volume(0)),
                "{probe:?}"
            );
            assert!((probe.height_m / 1e3 - probe.value.unwrap()).abs() < 0.1, "{probe:?}");
            let column: Vec<[f64; 2]> = HEIGHTS_M.iter().map(|h| [*h, h / 1e3]).collect();
            for (found, expected) in probe.column.iter().zip(&column) {
                assert!((found[0] - expected[0]).abs() < 1e-3 && found[1] == expected[1], "{found:?}");
            }
            assert_eq!(probe.column.len(), column.len());
            // What the renderer integrates, and the sum of the weights.
            let frame = data.draw(&scene);
            let alpha = f64::from(frame.pixels[7 * 21 + 10][3]);
            let sum: f64 = probe.along.iter().map(|point| point.weight).sum();
            assert!((sum - probe.alpha).abs() < 1e-12);
            // The parts of the ray join.
            for (a, b) in probe.along.iter().zip(&probe.along[1..]) {
                let gap = b.distance - a.distance - 0.5 * (a.length + b.length);
                assert!(gap.abs() < 1e-9, "{a:?} {b:?}");
            }
            assert!(scene.core.is_some() && (alpha - 1.0).abs() < 1e-3);
            let clear = Scene { core: None, ..scene };
            let through = probed(&data, &clear, [0.5, 0.5]).unwrap();
            let frame = data.draw(&clear);
            let alpha = f64::from(frame.pixels[7 * 21 + 10][3]);
            assert!((through.alpha - alpha).abs() < 1e-3, "{} {alpha}", through.alpha);
        }
    }
}

#[test]
fn a_probe_finds_the_ground_behind_clear_volumes() {
    let (data, clear) = (model(false), scene(300.0, 0.5, ""));
    let probe = probed(&data, &clear, [0.5, 0.5]).unwrap();
    assert!(probe.part == Some(ScenePart::Core) && probe.alpha == 0.0, "{probe:?}");
    assert!(probe.height_m.abs() < 1e-3 && probe.contributions.len() == 1, "{probe:?}");
    assert!(probe.value.unwrap() < 5.0, "{probe:?}");
    assert_eq!(probed(&data, &clear, [0.0, 0.0]), None);
    let hollow = probed(&data, &scene(300.0, 0.5, "core = 'transparent'"), [0.5, 0.5]).unwrap();
    assert!(hollow.part.is_none() && hollow.along.len() >= 16 * 4, "{}", hollow.along.len());
}

/// A scene of two volumes, isosurfaces, surfaces, lines and a cut, on layers at the same or at native heights.
fn mixed_scene(heights: &str) -> Scene {
    Scene::parse(&format!(
        "heights = '{heights}'\nexaggeration = 10\nbackground = 'transparent'\ncore = 'transparent'\n\
         antialias = false\nprecision = 'f64'\ntolerance = 1e-6\n\
         image = {{ width = 32, height = 24 }}\ncamera = {{ lon = 20, lat = 30, distance = 4, fov = 30 }}\n\
         [[volumes]]\nfield = 'f'\ntransfer = {{ map = 'viridis', range = [-2, 2], unit_length = 0.05,\n\
         opacity = [[-2, 0.1], [0, 0], [0.5, 0.4], [2, 0.2]] }}\n\
         [[volumes]]\nfield = 'g'\ntransfer = {{ map = 'vik', range = [-2, 2], unit_length = 0.05,\n\
         opacity = [[-2, 0.3], [2, 0]] }}\n\
         [[isosurfaces]]\nfield = 'g'\nvalue = 0.3\ncolor = 'red'\nopacity = 0.3\n\
         [[surfaces]]\nlayer = 3\nfield = 'g'\ntransfer = {{ map = 'vik', range = [-2, 2] }}\nopacity = 0.25\n\
         [[surfaces]]\nlayer = 3\ncolor = 'white'\nopacity = 0.5\n\
         [[surfaces]]\nheight_m = 45e3\ncolor = 'blue'\nopacity = 0.1\n\
         [[lines]]\nspacing = 30\non = 6\n\
         [[clip]]\nlon = [0, 20]\n"
    ))
    .unwrap()
}

#[test]
fn the_contributions_of_a_probe_are_those_of_the_pixel() {
    let mut data = Model::new(4, &HEIGHTS_M, |_, d, layer| {
        [0.2, 1.7].map(|phase| (6.0 * d.x + phase).sin() + (5.0 * d.y + 0.4 * layer as f64).cos() * d.z)
    });
    let hill = |cell: usize| 3e3 * (9.0 * data.grid.direction(cell as u32).y).sin();
    data.heights = over_columns(data.grid.cells(), 9, |cell, layer| HEIGHTS_M[layer] + hill(cell));
    data.layers = Layers::from_heights(&HEIGHTS_M, PLANET_M).unwrap();
    let mut seen = Vec::new();
    for heights in ["mean", "native"] {
        let scene = mixed_scene(heights);
        let frame = data.draw(&scene);
        for (pixel, rgba) in frame.pixels.iter().enumerate() {
            let at = [(pixel % 32) as f64 + 0.5, (pixel / 32) as f64 + 0.5];
            let place = [at[0] / 32.0, at[1] / 24.0];
            let Some(probe) = probed(&data, &scene, place) else {
                assert_eq!(rgba[3], 0.0, "{at:?}");
                continue;
            };
            let sum: f64 = probe.contributions.iter().map(|one| one.weight).sum();
            assert!((sum - f64::from(rgba[3])).abs() < 3e-6, "{at:?}: {sum} {rgba:?}");
            assert_eq!(probe.part, probe.contributions.first().map(|one| one.part));
            for one in &probe.contributions {
                match one.part {
                    ScenePart::Isosurface(0) => assert!((one.value.unwrap() - 0.3).abs() < 1e-9, "{one:?}"),
                    ScenePart::Surface(2) => assert!((one.height_m - 45e3).abs() < 1e-3, "{one:?}"),
                    ScenePart::Surface(_) if heights == "mean" => {
                        assert!((one.height_m - HEIGHTS_M[3]).abs() < 1e-3, "{one:?}");
                    }
                    _ => (),
                }
                assert_eq!(one.value.is_some(), one.field.is_some());
                if !seen.contains(&one.part) {
                    seen.push(one.part);
                }
            }
        }
    }
    assert_eq!(seen.len(), 7, "{seen:?}");
}
