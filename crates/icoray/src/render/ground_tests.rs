//! Whole pictures with a ground.

use crate::common::{Model, even_heights};
use crate::device::{Band, Device, DeviceCost, FallbackReason, Fragments, Job, OwnedColumns};
use crate::plan::Savings;
use crate::plan::budget::allowed;
use crate::render::Renderer;
use glam::DVec3;
use icoray_grid::grid::unit_vector;
use icoray_kernel::ground::{Ground, SurfaceHit};
use icoray_output::Frame;
use icoray_scene::{Backend, Camera, Level, Lines, Pattern, Quality, Scene};
use std::sync::Arc;

const LAND: [f64; 3] = [0.5, 0.25, 0.125];
const SEA: [f64; 3] = [0.0, 0.125, 0.5];

fn scene() -> Scene {
    Scene::parse("field = 'f'\ntransfer = { range = [0, 1], opacity = [[0, 0], [1, 0]] }").unwrap()
}

fn lines(pattern: Pattern, width_px: f64) -> Lines {
    Lines { pattern, on: Level::Ground, color: [1.0; 3], width_px, opacity: 1.0, region: None }
}

fn place([lon, lat]: [f64; 2]) -> DVec3 {
    unit_vector(lon.to_radians(), lat.to_radians())
}

/// A clear shell over land and sea, seen from above Paris.
fn earth(size: u32) -> Scene {
    let mut scene = scene();
    (scene.width, scene.height) = (size, size);
    scene.camera = Camera::above(2.35, 48.86, 3.0, 45.0).unwrap();
    (scene.scenery.ground.land, scene.scenery.ground.ocean) = (Some(LAND), Some(SEA));
    scene
}

fn draw(scene: &Scene, renderer: &Renderer) -> Frame {
    let value = |cell: usize, layer: usize| ((3 * cell + layer) as f64 * 0.37).sin().abs();
    let model = Model::new(4, &even_heights(3, 20e3 / 6.371e6), |cell, _, layer| [value(cell, layer)]);
    model.draw_by(renderer, scene)
}

fn plainly() -> Renderer {
    Renderer::new(2).unwrap()
}

/// The pixel that sees a place.
fn pixel(scene: &Scene, frame: &Frame, lon: f64, lat: f64) -> [f32; 4] {
    let eye = DVec3::from_array(scene.camera.eye());
    let towards = (place([lon, lat]) - eye).normalize();
    let toward = |i: &usize| {
        let (x, y) = (*i as u32 % scene.width, *i as u32 / scene.width);
        DVec3::from_array(scene.camera.direction(x, y, scene.width, scene.height)).dot(towards)
    };
    let nearest = (0..frame.pixels.len()).max_by(|a, b| toward(a).total_cmp(&toward(b)));
    frame.pixels[nearest.unwrap()]
}

#[test]
fn land_and_sea_are_shown_through_a_clear_shell() {
    let scene = earth(97);
    let as_pixel = |[r, g, b]: [f64; 3]| [r as f32, g as f32, b as f32, 1.0];
    let frame = draw(&scene, &plainly());
    for (color, lon, lat) in [(LAND, 2.35, 48.86), (LAND, 20.0, 25.0), (SEA, -20.0, 50.0), (SEA, 18.0, 35.0)] {
        assert_eq!(pixel(&scene, &frame, lon, lat), as_pixel(color), "{lon} {lat}");
    }
    let one_by_one = plainly().with_savings(Savings { lanes: false, ..Savings::ALL });
    assert_eq!(draw(&scene, &one_by_one).pixels, frame.pixels, "ray by ray");
}

#[test]
fn the_coast_is_smooth() {
    let scene = Scene { antialias: false, ..earth(97) };
    let frame = draw(&scene, &plainly());
    // Red is a measure of land: nothing but that lies between.
    let between = frame.pixels.iter().filter(|p| p[3] == 1.0 && p[0] > 0.01 && p[0] < 0.49);
    let (mut count, mut sum) = (0, 0.0);
    for pixel in between {
        let part = f64::from(pixel[0]) / LAND[0];
        let mixed = [1, 2].map(|k| (SEA[k] + part * (LAND[k] - SEA[k])) as f32);
        assert!((pixel[1] - mixed[0]).abs() < 1e-5 && (pixel[2] - mixed[1]).abs() < 1e-5, "{pixel:?}");
        (count, sum) = (count + 1, sum + part);
    }
    assert!(count > 150 && (sum / f64::from(count) - 0.5).abs() < 0.05, "{count}: {sum}");
}

#[test]
fn lines_on_the_ground_are_lit_as_the_ground_is() {
    let mut scene = earth(129);
    scene.scenery.lines = vec![lines(Pattern::Graticule { spacing_deg: 30.0 }, 3.0)];
    let unlit = draw(&scene, &plainly());
    assert_eq!(pixel(&scene, &unlit, 0.0, 45.0), [1.0; 4]);
    let headlight = "light = { kind = \"headlight\", ambient = 0.2, diffuse = 0.7 }";
    scene.lighting = Scene::parse(headlight).unwrap().lighting;
    let lit = draw(&scene, &plainly());
    let bare = draw(&Scene { scenery: earth(129).scenery, ..scene.clone() }, &plainly());
    let ground = draw(&earth(129), &plainly());
    for [lon, lat] in [[0.0, 45.0], [-30.0, 40.0], [30.0, 30.0]] {
        let on_line = pixel(&scene, &lit, lon, lat)[2];
        let plain = pixel(&scene, &bare, lon, lat)[2];
        let ground = pixel(&scene, &ground, lon, lat)[2];
        assert!(on_line < 0.95 && (on_line - plain / ground).abs() < 1e-3, "{on_line}: {plain} of {ground}");
    }
}

#[test]
fn a_scene_of_one_color_has_no_ground() {
    assert!(Ground::new(&scene()).is_none());
    let mut hollow = earth(9);
    hollow.core = None;
    assert!(Ground::new(&hollow).is_none());
    let mut above = scene();
    above.scenery.lines = vec![Lines { on: Level::Top, ..lines(Pattern::Coast, 1.0) }];
    assert!(Ground::new(&above).is_none());
    let mut land_only = scene();
    land_only.scenery.ground.land = Some(LAND);
    let ground = Ground::new(&land_only).unwrap();
    let at = |lon: f64, lat: f64| ground.color(&SurfaceHit::round(place([lon, lat])), None);
    assert_eq!([at(20.0, 10.0), at(-20.0, 0.0)], [LAND, land_only.core.unwrap()]);
}

#[test]
fn the_brightest_background_includes_ground_and_lines() {
    let brightest = |scene: &Scene| allowed(scene, &Quality::default()).brightest;
    let mut scene = earth(9);
    scene.background = Some([0.0; 3]);
    assert!(brightest(&scene) < 2.0);
    scene.scenery.ground.ocean = Some([0.0, 4.0, 0.0]);
    assert_eq!(brightest(&scene), 4.0);
    scene.scenery.lines = vec![Lines { color: [5.0, 0.0, 0.0], ..lines(Pattern::Coast, 1.0) }];
    assert_eq!(brightest(&scene), 5.0);
}

/// A device that traces nothing.
#[derive(Debug)]
struct Idle;

impl Device for Idle {
    fn name(&self) -> String {
        "a device".into()
    }

    fn trace(&self, _: &Job, _: &(dyn Fn(Band) + Sync)) -> Result<DeviceCost, FallbackReason> {
        Err(FallbackReason::new("pixels"))
    }

    fn fragments(
        &self,
        _: &Job,
        own: &OwnedColumns,
        _: &(dyn Fn(Fragments) + Sync),
    ) -> Result<DeviceCost, FallbackReason> {
        Err(FallbackReason::new(format!(
            "fragments over {} triangles",
            (0..5130).filter(|triangle| own.triangles.has(*triangle)).count()
        )))
    }
}

#[test]
fn devices_trace_fragments_over_grounds() {
    let mut scene = earth(33);
    scene.backend = Backend::Gpu;
    let renderer = plainly().with_device(Arc::new(Idle));
    let frame = draw(&scene, &renderer);
    let reason = frame.report.device.left_to_cpu.unwrap();
    assert_eq!(reason, "fragments over 5120 triangles");
    scene.scenery = icoray_scene::Scenery::default();
    assert_eq!(draw(&scene, &renderer).report.device.left_to_cpu.unwrap(), "pixels");
}
