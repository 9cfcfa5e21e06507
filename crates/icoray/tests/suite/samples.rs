//! Means of several rays per pixel, against pictures of 144 pixels for each.

use crate::common::{LIT, Model, averaged, bits, count_beyond, distances, even_heights, pixel_difference, scene_of};
use glam::DVec3;
use icoray::{Frame, SamplingReport, Scene};
use icoray_test_support::Random;

const SIDE: u32 = 36;
/// Pixels of a reference for each, in both directions.
const MANY: u32 = 12;

/// A field of chance, which is another one in each cell.
fn noise(level: u32) -> Model {
    Model::new(level, &even_heights(4, 0.15), |cell, _, _| [Random::at(cell).unit()])
}

fn smooth(level: u32) -> Model {
    let value = |p: DVec3, layer: usize| 0.5 + 0.3 * (2.0 * p.x).sin() * p.y + 0.1 * p.z + 0.02 * layer as f64;
    Model::new(level, &even_heights(4, 0.15), |_, p, layer| [value(p, layer)])
}

const DENSE: &str =
    "[transfer]\nmap = \"viridis\"\nrange = [0, 1]\nopacity = [[0, 0.1], [1, 0.95]]\nunit_length = 0.05\n";
const CLEAR: &str = "[transfer]\nmap = \"viridis\"\nrange = [0, 1]\nopacity = [[0, 0.0]]\n";
const DOME: &str = "[[isosurfaces]]\nfield = \"f\"\nvalue = 0.6\ncolor = \"crimson\"\n";

fn scene(side: u32, keys: &str, tables: &str) -> Scene {
    let keys = format!(
        "field = \"f\"\nbackend = \"cpu\"\ncore = \"white\"\n{keys}\nimage = {{ width = {side}, height = {side} }}"
    );
    scene_of("lon = 50\nlat = 20\ndistance = 3.6\nfov = 40", &keys, tables)
}

/// What is shown, by name, of a field.
fn shown<'d>(noise: &'d Model, smooth: &'d Model) -> Vec<(&'static str, &'d Model, String)> {
    vec![
        ("noise", noise, DENSE.into()),
        ("lit noise", noise, format!("{DENSE}{LIT}")),
        ("core", smooth, CLEAR.into()),
        ("lit smooth", smooth, format!("{DENSE}{LIT}")),
        ("isosurface", smooth, format!("{CLEAR}{DOME}")),
    ]
}

#[test]
fn means_are_those_of_areas_within_the_reported_errors() {
    let (noise, smooth) = (noise(6), smooth(5));
    for (name, data, tables) in shown(&noise, &smooth) {
        let exact = averaged(&data.draw(&scene(MANY * SIDE, "antialias = false", &tables)), MANY);
        let mean_off = |frame: &Frame| distances(frame, &exact).iter().sum::<f64>();
        let one = mean_off(&data.draw(&scene(SIDE, "antialias = false", &tables)));
        let mut before = one;
        for (samples, better) in [(2, 1.0), (3, 1.2), (4, 1.5), (8, 3.0), (16, 4.0), (64, 8.0)] {
            let frame = data.draw(&scene(SIDE, &format!("samples = {samples}\nantialias = false"), &tables));
            let now = mean_off(&frame);
            assert!(one > better * now && now < before, "{name}, {samples}: {one}, {before} and {now} off");
            before = now;
            // 144 rays do not give the mean over the area either.
            let errors = frame.sampling_error.iter().zip(&frame.error).map(|(sampling, error)| sampling + error + 5e-4);
            let pixels = distances(&frame, &exact).into_iter().zip(errors);
            let beyond = pixels.filter(|(off, error)| *off > f64::from(*error)).count();
            let shown = frame.error.iter().filter(|error| **error > 0.0).count();
            // Two rays miss more steps than several.
            let share = if samples < 4 { 10 } else { 20 };
            assert!(beyond * share <= shown, "{name}, {samples}: {beyond} of {shown}");
            let sampling = frame.report.sampling;
            let error = sampling.error.unwrap();
            let largest = frame.sampling_error.iter().fold(0.0f32, |largest, error| largest.max(*error));
            assert_eq!(error.max, f64::from(largest), "{name}");
            assert!(error.mean > 0.0 && error.mean < error.max, "{name}: {error:?}");
            assert!(sampling.rays_per_pixel <= f64::from(samples), "{name}: {sampling:?}");
        }
    }
}

#[test]
fn pixels_at_edges_take_no_fewer_rays_than_without_samples() {
    let data = smooth(4);
    for tables in [CLEAR.to_owned(), format!("{CLEAR}{DOME}")] {
        let exact = averaged(&data.draw(&scene(MANY * SIDE, "antialias = false", &tables)), MANY);
        let [one, two] = [1, 2].map(|n| data.draw(&scene(SIDE, &format!("samples = {n}"), &tables)));
        // Beside the shell, pixels next to an edge take no samples.
        let edge_pixels = [&one, &two].map(|frame| frame.report.edge_pixels);
        assert!(edge_pixels[1] > 100 && (0..5).contains(&(edge_pixels[0] - edge_pixels[1])), "{edge_pixels:?}");
        let [one, two] = [one, two].map(|frame| distances(&frame, &exact).iter().sum::<f64>());
        assert!(two < 1.5 * one, "{one} and {two} off");
    }
}

#[test]
fn smooth_pictures_take_no_more_than_the_first_round() {
    // Cells of 4 and of 18 pixels across: slopes change where they meet.
    for level in [6, 4] {
        let data = smooth(level);
        let near = |keys: &str| {
            let mut scene = scene(64, keys, DENSE);
            scene.camera = icoray::Camera::above(50.0, 20.0, 2.5, 12.0).unwrap();
            data.draw(&scene)
        };
        let frame = near("samples = 64\ntolerance = 5e-5");
        let sampling = frame.report.sampling;
        assert!((4.0..4.4).contains(&sampling.rays_per_pixel), "{level}: {sampling:?}");
        assert!(sampling.error.unwrap().mean < 5e-5, "{level}: {sampling:?}");
        // Where all of it is to be exact, all take all.
        assert!(near("samples = 16\ntolerance = 1e-7").report.sampling.rays_per_pixel > 15.9);
    }
}

#[test]
fn one_sample_is_the_ray_through_the_middle() {
    let data = noise(4);
    for tables in [DENSE.to_owned(), format!("{DENSE}{LIT}"), format!("{CLEAR}{DOME}")] {
        let [plain, one, several] =
            ["", "samples = 1", "samples = 8"].map(|keys| data.draw(&scene(SIDE, keys, &tables)));
        assert_eq!(bits(&plain), bits(&one));
        assert_eq!(plain.report.counts, one.report.counts);
        let sampling = one.report.sampling;
        assert_eq!((sampling.samples, sampling.rays_per_pixel, sampling.error), (1, 1.0, None));
        assert!(one.sampling_error.is_empty() && several.sampling_error.len() == several.pixels.len());
        // Beside the shell pixels stay as they are.
        let corner = [&one, &several].map(|frame| frame.pixels[0]);
        assert_eq!((corner[0], several.error[0], several.sampling_error[0]), (corner[1], 0.0, 0.0));
        assert!(several.report.counts.rays > one.report.counts.rays);
    }
}

#[test]
fn samples_are_the_same_on_any_threads_and_ranks() {
    let (noise, smooth) = (noise(4), smooth(4));
    for (name, data, tables) in shown(&noise, &smooth) {
        data.draw_anywhere(&scene(SIDE, "samples = 12", &tables), name);
    }
}

#[test]
fn fragments_have_samples_too() {
    let (noise, smooth) = (noise(3), smooth(3));
    for (name, data, tables) in shown(&noise, &smooth) {
        let [whole, pieces] = ["tiles", "fragments"].map(|ranks| {
            let keys = format!("samples = 8\ntolerance = 1e-6\nprecision = \"f64\"\nranks = \"{ranks}\"");
            scene(SIDE, &keys, &tables)
        });
        let (expected, (frame, reports)) = (data.draw(&whole), data.draw_on(&pieces, 3));
        assert_eq!(count_beyond(&frame, &expected, 0.0), 0, "{name}");
        let rays = [&frame, &expected].map(|frame| frame.report.sampling.rays_per_pixel);
        assert!((rays[0] - rays[1]).abs() < 0.01 && rays[0] > 4.0, "{name}: {rays:?}");
        assert!(reports.iter().all(|report| report.sampling == frame.report.sampling), "{name}");
    }
}

#[test]
fn samples_are_taken_where_a_budget_leaves_time() {
    let data = noise(3);
    let hurried = data.draw(&scene(SIDE, "samples = 16\ntime_budget_ms = 1", DENSE)).report;
    assert!(hurried.sampling.rays_per_pixel <= 1.0, "{hurried:?}");
    let patient = data.draw(&scene(SIDE, "samples = 16\ntime_budget_ms = 1e9", DENSE)).report;
    assert!(patient.sampling.rays_per_pixel > 10.0 && patient.sampling.error.is_some(), "{patient:?}");
}

#[test]
fn pixels_that_are_not_traced_have_the_largest_error() {
    let (noise, smooth) = (noise(4), smooth(4));
    for (name, data, tables) in shown(&noise, &smooth).into_iter().filter(|(name, ..)| !name.starts_with("lit")) {
        let whole = data.draw(&scene(100, "tolerance = 1e-6\nantialias = false", &tables));
        let mut hurried = scene(100, "samples = 16", &tables);
        hurried.time_budget_ms = Some(1e-3);
        let frame = data.draw(&hurried);
        assert_eq!(frame.report.quality.pixel_step, 32, "{name}");
        assert_eq!(count_beyond(&frame, &whole, 0.0), 0, "{name}");
        // Beside the shell all is known.
        let [beside, between, traced] = [1, 50 * 100 + 50, 64 * 100 + 64];
        assert_eq!([frame.error[beside], frame.error[between]], [0.0, 1.0], "{name}");
        assert!((1e-9..0.1).contains(&frame.error[traced]), "{name}: {}", frame.error[traced]);
        // The estimate is apart.
        let estimate = &frame.sampling_error;
        assert!(estimate[between] > 0.0 && [estimate[beside], estimate[traced]] == [0.0; 2], "{name}");
        let unknown: Vec<usize> = (0..frame.error.len()).filter(|i| frame.error[*i] == 1.0).collect();
        let beyond = unknown.iter().filter(|i| pixel_difference(&frame, &whole, **i) > estimate[**i]).count();
        // A field of chance has details that 3 x 3 traced pixels know nothing of.
        assert!(beyond * 5 <= unknown.len(), "{name}: {beyond} of {}", unknown.len());
        let SamplingReport { rays_per_pixel, error, .. } = frame.report.sampling;
        let largest = estimate.iter().fold(0.0f32, |largest, error| largest.max(*error));
        assert_eq!((rays_per_pixel, error.unwrap().max), (25e-4, f64::from(largest)), "{name}");
    }
}
