//! Renderers that do less than all: that only walk and interpolate, for measurements of these steps, that report their
//! progress, and that are stopped.

use crate::common::{Model, even_heights, scene};
use icoray::{Renderer, Scene};
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::{Arc, Mutex};

fn model() -> Model {
    Model::new(3, &even_heights(9, 0.16), |cell, _, layer| [((9 * cell + layer) % 7 + layer) as f64])
}

fn shown(opacity: f64) -> Scene {
    let transfer = format!("map = \"viridis\"\nrange = [0, 16]\nopacity = [[0, {opacity}], [16, {opacity}]]");
    let keys = "antialias = false\ncore = \"transparent\"\nbackground = \"transparent\"";
    scene("lon = 10\nlat = 40\ndistance = 3", &transfer, keys)
}

#[test]
fn without_integrals_rays_meet_all_frusta_and_bring_no_light() {
    let (data, dense) = (model(), shown(0.999_999_9));
    let (all, ended) = (data.draw(&shown(0.01)), data.draw(&dense));
    assert!(ended.report.counts.frusta < all.report.counts.frusta);
    let walked = data.draw_by(&Renderer::new(2).unwrap().without_integrals(), &dense);
    assert_eq!(walked.report.counts, all.report.counts);
    assert!(walked.pixels.iter().all(|pixel| *pixel == [0.0; 4]) && ended.pixels.iter().any(|p| p[3] > 0.9));
}

#[test]
fn each_tile_is_reported_once_and_the_picture_is_the_same() {
    let (data, scene) = (model(), shown(0.5));
    let reports = Arc::new(Mutex::new(Vec::new()));
    let hook = Arc::clone(&reports);
    let hook = Arc::new(move |finished, total| hook.lock().unwrap().push((finished, total)));
    let frame = data.draw_by(&Renderer::new(2).unwrap().with_progress(hook), &scene);
    let mut reports = std::mem::take(&mut *reports.lock().unwrap());
    reports.sort_unstable();
    let total = frame.report.ranks.tiles;
    assert!(total > 4);
    assert_eq!(reports, (1..=total).map(|finished| (finished, total)).collect::<Vec<_>>());
    assert!(frame.pixels == data.draw(&scene).pixels, "the hook changes nothing");
}

#[test]
fn a_frame_that_is_given_up_traces_nothing() {
    let (data, scene) = (model(), shown(0.5));
    let stop = Arc::new(AtomicBool::new(true));
    let renderer = Renderer::new(2).unwrap().with_stop(stop.clone());
    assert_eq!(data.draw_by(&renderer, &scene).report.counts.rays, 0);
    stop.store(false, Relaxed);
    let frame = data.draw_by(&renderer, &scene);
    assert!(frame.report.counts.rays > 100 && frame.pixels == data.draw(&scene).pixels);
}
