//! Pixels with the edge of a surface in them, against pictures of many more rays.

use crate::common::{LIT, Model, averaged, bits, count_beyond, distances, even_heights, scene_of};
use glam::DVec3;
use icoray::{Certainty, Precision, Scene};

const SIDE: u32 = 96;

/// A field that rises towards a place on the equator and with height.
fn rising(level: u32) -> Model {
    Model::new(level, &even_heights(5, 0.2), |_, p, layer| [p.x + 0.1 * layer as f64])
}

const CLEAR: &str = "[transfer]\nmap = \"viridis\"\nrange = [-1, 1.2]\nopacity = [[0, 0.0]]\n";
const DENSE: &str =
    "[transfer]\nmap = \"viridis\"\nrange = [-1, 1.2]\nopacity = [[-1, 0.9], [1.2, 0.9]]\nunit_length = 0.002\n";
const DOME: &str = "[[isosurfaces]]\nfield = \"f\"\nvalue = 0.8\ncolor = \"crimson\"\n";
const LAYER: &str = "[[surfaces]]\nlayer = 4\ncolor = \"gold\"\nopacity = 0.5\n";
const CUT: &str = "[[clip]]\ncut = \"inside\"\nlon = [0, 90]\nlat = [0, 90]\n";

/// A white core in front of black, `side` pixels wide.
fn scene(side: u32, antialias: bool, keys: &str, tables: &str) -> Scene {
    let keys = format!(
        "field = \"f\"\nbackend = \"cpu\"\nprecision = \"f64\"\ncore = \"white\"\nantialias = {antialias}\n{keys}\n\
         image = {{ width = {side}, height = {side} }}"
    );
    scene_of("lon = 50\nlat = 20\ndistance = 3.6\nfov = 40", &keys, tables)
}

/// What is shown, by name.
fn shown() -> Vec<(&'static str, String)> {
    vec![
        ("core", CLEAR.into()),
        ("core beside cells", format!("{CLEAR}[[lines]]\npattern = \"cells\"\nopacity = 1e-6\n")),
        ("isosurface on the ground", format!("{CLEAR}{DOME}")),
        ("lit isosurface under a layer", format!("{CLEAR}{DOME}{LAYER}{LIT}")),
        ("cut isosurface", format!("{CLEAR}{DOME}{CUT}")),
        ("cut volume", format!("{DENSE}{CUT}")),
        ("cut layer", format!("{CLEAR}{LAYER}{CUT}")),
    ]
}

#[test]
fn edges_are_a_quarter_as_far_off_at_most_and_few_pixels_have_more_rays() {
    let data = rising(5);
    for (name, tables) in shown() {
        let exact = averaged(&data.draw(&scene(8 * SIDE, true, "", &tables)), 8);
        let [rough, smooth, large] = [(SIDE, false), (SIDE, true), (2 * SIDE, true)]
            .map(|(side, antialias)| data.draw(&scene(side, antialias, "", &tables)));
        let [before, after] = [&rough, &smooth].map(|frame| distances(frame, &exact).iter().sum::<f64>());
        assert!(before > 4.0 * after, "{name}: {before} and {after} off");
        let edge_pixels = smooth.report.edge_pixels;
        let changed = bits(&rough).iter().zip(bits(&smooth)).filter(|(a, b)| **a != *b).count() as u64;
        assert!(changed > 0 && changed <= edge_pixels, "{name}: {changed} of {edge_pixels}");
        assert_eq!(rough.report.edge_pixels, 0);
        assert!(edge_pixels < 2000, "{name}: {edge_pixels}");
        assert!(large.report.edge_pixels < edge_pixels * 9 / 4, "{name}: {edge_pixels}");
        let rays = [&smooth, &rough].map(|frame| frame.report.counts.rays);
        assert!(rays[0] > rays[1] && rays[0] <= rays[1] + 8 * edge_pixels, "{name}: {rays:?}");
    }
}

#[test]
fn the_silhouette_of_the_core_covers_the_area_of_a_sphere() {
    let data = rising(6);
    let camera = scene(SIDE, true, "", CLEAR).camera;
    // The part of a pixel from which the unit sphere is met, by rays of a fine raster.
    let covered = |x: u32, y: u32| {
        let meets = |i: u32| {
            let at = [32 * x + i % 32, 32 * y + i / 32];
            let (eye, dir) = (DVec3::from(camera.eye()), camera.direction(at[0], at[1], 32 * SIDE, 32 * SIDE));
            eye.length_squared() - eye.dot(dir.into()).powi(2) < 1.0
        };
        f64::from((0..1024).filter(|i| meets(*i)).count() as u32) / 1024.0
    };
    let exact: Vec<f64> = (0..SIDE * SIDE).map(|i| covered(i % SIDE, i / SIDE)).collect();
    let mean_error = |antialias: bool| {
        let frame = data.draw(&scene(SIDE, antialias, "", CLEAR));
        let at_edge = exact.iter().zip(&frame.pixels).filter(|(exact, _)| **exact > 0.0 && **exact < 1.0);
        let off: Vec<f64> = at_edge.map(|(exact, pixel)| (f64::from(pixel[0]) - exact).abs()).collect();
        off.iter().sum::<f64>() / off.len() as f64
    };
    let [rough, smooth] = [false, true].map(mean_error);
    assert!(rough > 4.0 * smooth && smooth < 0.045, "{rough} and {smooth}");
}

#[test]
fn pictures_are_the_same_on_any_threads_and_ranks() {
    let data = rising(3);
    for (name, tables) in shown() {
        let scene = scene(SIDE, true, "", &tables);
        let frame = data.draw_anywhere(&scene, name);
        assert!(frame.report.edge_pixels > 100, "{name}");
    }
}

#[test]
fn fragments_have_the_same_edges() {
    let data = rising(3);
    for (name, tables) in shown() {
        let tables = &tables;
        let [whole, pieces] = ["tiles", "fragments"]
            .map(|ranks| scene(SIDE, true, &format!("tolerance = 1e-6\nranks = \"{ranks}\""), tables));
        let expected = data.draw(&whole);
        for ranks in [2, 3] {
            let (frame, reports) = data.draw_on(&pieces, ranks);
            assert!(reports.iter().all(|report| report.edge_pixels == frame.report.edge_pixels));
            let [mine, others] = [&frame, &expected].map(|frame| frame.report.edge_pixels);
            let off = count_beyond(&frame, &expected, 0.0);
            // Of surfaces that are all but hidden ranks do not know what is in front, on other ranks.
            let few = if name == "cut volume" { 5 } else { 0 };
            let are_few = mine.abs_diff(others) <= few && off as u64 <= few;
            assert!(are_few, "{name} on {ranks}: {mine}, {others}, {off}");
        }
    }
}

#[test]
fn errors_of_edges_are_bounds_too() {
    let data = rising(3);
    let haze = CLEAR.replace("[[0, 0.0]]", "[[-1, 0.2], [0.3, 0.1], [1.2, 0.4]]");
    let [exact, loose] =
        ["1e-7", "1e-3"].map(|tolerance| data.draw(&scene(SIDE, true, &format!("tolerance = {tolerance}"), &haze)));
    assert_eq!(exact.report.edge_pixels, loose.report.edge_pixels);
    assert_eq!(loose.report.error.certainty, Certainty::Bound);
    assert!(loose.report.error.max <= 1.01e-3);
    assert_eq!(count_beyond(&loose, &exact, 0.0), 0);
}

#[test]
fn edges_are_the_same_at_every_tolerance() {
    let data = rising(3);
    // Matter through which surfaces are seen by a share of the light from all to nothing.
    let haze = CLEAR.replace("[[0, 0.0]]", "[[-1, 0.0], [0.2, 0.6], [1.2, 0.9]]\nunit_length = 0.02");
    for (surface, precision) in [(DOME, Precision::F64), (DOME, Precision::F32), (LAYER, Precision::F64)] {
        let clear = surface.replace("opacity = 0.5\n", "") + "opacity = 1e-9\n";
        for tables in [format!("{haze}{clear}{LIT}"), format!("{haze}{surface}{CUT}")] {
            let drawn = |tolerance: &str| {
                let scene = scene(SIDE, true, &format!("tolerance = {tolerance}"), &tables);
                data.draw(&Scene { precision, ..scene })
            };
            let exact = drawn("1e-6");
            assert!(exact.report.edge_pixels > 100, "{tables}: {}", exact.report.edge_pixels);
            for tolerance in ["1e-4", "1e-3", "1e-2"] {
                let frame = drawn(tolerance);
                // Pixels at the limits of what counts may be an edge in one picture.
                let beyond = count_beyond(&frame, &exact, 0.0);
                assert!(beyond <= 2, "{precision:?}, {tolerance}: {beyond} of {tables}");
            }
        }
    }
}

#[test]
fn scenes_without_edges_have_one_ray_per_pixel() {
    let data = rising(3);
    let haze = CLEAR.replace("[[0, 0.0]]", "[[-1, 0.01], [1.2, 0.01]]");
    // Lines are smooth by themselves.
    for lines in ["", "[[lines]]\npattern = \"cells\"\non = 2\n"] {
        let tables = format!("{haze}{lines}");
        let mut scene = scene(SIDE, true, "", &tables);
        scene.core = None;
        assert_eq!(data.draw(&scene).report.edge_pixels, 0);
    }
    let hurried = data.draw(&scene(SIDE, true, "time_budget_ms = 1", CLEAR));
    assert_eq!(hurried.report.edge_pixels, 0);
    let patient = scene(SIDE, true, "time_budget_ms = 1e9", CLEAR);
    assert!(data.draw(&patient).report.edge_pixels > 0);
}
