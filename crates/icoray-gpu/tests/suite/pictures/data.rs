//! Uploads of fields: in pages, in passes, without columns and layers that no ray reads, and once. Pictures do not
//! depend on them.

use super::common::*;
use icoray::{Field, Frame, Grid, Layers, Location, Renderer, Scene, Shape};
use icoray_gpu::{Gpu, MemoryLimits};
use itertools::iproduct;
use std::sync::{Arc, Mutex};

/// A renderer on a device with less memory.
fn limited(binding: Option<u64>, field: Option<u64>) -> Renderer {
    let gpu = Gpu::with_limits(None, MemoryLimits { binding, field }).unwrap();
    Renderer::new(2).unwrap().with_device(Arc::new(gpu))
}

fn assert_same(one: &Frame, other: &Frame, name: &str) {
    assert_eq!((&one.report.device.left_to_cpu, &other.report.device.left_to_cpu), (&None, &None), "{name}");
    assert!(one.report.device.name.is_some() && other.report.device.name.is_some(), "{name}");
    assert!(one.pixels == other.pixels && one.error == other.error, "{name}");
    assert_eq!(one.report.counts, other.report.counts, "{name}");
}

/// The bytes of the field that were not uploaded, and all bytes of the field.
fn unread(frame: &Frame) -> Option<(u64, u64)> {
    let line = frame.report.left_out.iter().find(|line| line.ends_with("bytes of the field on the device"))?;
    let mut words = line.split(' ');
    Some((words.next()?.parse().unwrap(), words.nth(1)?.parse().unwrap()))
}

/// The same values in both layouts and precisions.
struct Values {
    level_fastest: Vec<f32>,
    cell_fastest: Vec<f64>,
    layers: usize,
}

impl Values {
    fn new(cells: usize, layers: usize, value: impl Fn(usize, usize) -> f32) -> Self {
        let cell_fastest = over_columns(layers, cells, |layer, cell| f64::from(value(cell, layer)));
        Values { level_fastest: over_columns(cells, layers, value), cell_fastest, layers }
    }

    fn fields(&self) -> [Field<'_>; 2] {
        let shape = Shape::cell_fastest(self.level_fastest.len() / self.layers, self.layers);
        let wide = Field::new(self.cell_fastest.as_slice().into(), shape, Location::Center, None);
        [at_centers(&self.level_fastest, self.layers), wide.unwrap()]
    }
}

fn planet(level: u32, layers: usize) -> (Grid<'static>, Layers) {
    let heights: Vec<f64> = (0..layers).map(|k| 20e3 * k as f64 / layers as f64).collect();
    (icosahedral(level).1, Layers::from_heights(&heights, EARTH_M).unwrap())
}

/// Up to nine pages of 256 KiB, in which the grid's tables just fit, with pages of gradients beside them; and several
/// passes, which are reported.
#[test]
fn pages_and_passes_do_not_show() {
    let Some(gpu) = gpu() else { return };
    let (whole, paged) = (renderer(&gpu), limited(Some(256 << 10), None));
    let light = "[light]\nkind = \"headlight\"\nambient = 0.3\ndiffuse = 0.6\nspecular = 0.3";
    for (lamp, count, limit, cameras) in
        [("", 52, 500 << 10, [FAR, INSIDE, CLOSE].as_slice()), (light, 20, 2 << 20, &[FAR])]
    {
        let (grid, layers) = planet(5, count);
        let all = (4 * count * grid.cells()) as u64;
        let values = Values::new(grid.cells(), count, |c, l| wave(grid.direction(c as u32), l, count) as f32);
        let in_passes = limited(None, Some(limit));
        for (field, rest, where_) in iproduct!(&values.fields(), CORES, cameras) {
            let scene = scene(where_, &format!("{SMOOTH}\n{lamp}"), rest);
            let [one, pages, passes] =
                [&whole, &paged, &in_passes].map(|of| of.render(&scene, &grid, &layers, field).unwrap());
            let name = format!("{:?}, {lamp:?}, {rest}, {where_}", field.shape());
            assert_same(&one, &pages, &name);
            assert_same(&one, &passes, &name);
            assert_eq!(unread(&one), None);
            // The core hides columns from afar, and a close view has columns outside the picture.
            if rest == CORES[0] && *where_ == FAR || *where_ == CLOSE {
                let (unread, of) = unread(&pages).unwrap();
                assert!(of == all && unread > all / 3 && unread < all, "{name}: {unread} of {of}");
            }
            let [device, in_passes] = [one, passes].map(|frame| frame.report.device.name.unwrap());
            assert!(!device.contains("passes"), "{device}");
            let is_told = in_passes.contains("passes") && in_passes.contains("exceed its memory");
            assert!(is_told || *where_ != FAR || !lamp.is_empty(), "{name}: {in_passes}");
        }
    }
    // Less memory than a single tile needs.
    let (grid, layers) = planet(4, 20);
    let values = vec![0.5f32; 20 * grid.cells()];
    let small = limited(None, Some(200));
    let frame = small.render(&scene(FAR, SMOOTH, ""), &grid, &layers, &at_centers(&values, 20));
    let reason = frame.unwrap().report.device.left_to_cpu.unwrap();
    assert!(reason.contains("bytes of the field, expected at most"), "{reason}");
}

/// Clear layers at both ends are not uploaded. A single value that is not clear, even behind the core, where no ray
/// reads it, makes them be uploaded.
#[test]
fn clear_layers_are_not_uploaded() {
    let Some(gpu) = gpu() else { return };
    let renderer = renderer(&gpu);
    let (grid, layers) = planet(3, 12);
    let clear = "knots = [ { value = -0.8, color = \"blue\", extinction = 0 }, { value = -0.2, color = \"white\", extinction = 9 }, \
                 { value = 0.3, color = \"yellow\", extinction = 1 }, { value = 0.3, color = \"red\", extinction = 0 } ]";
    let scene_of_clear = scene(FAR, clear, CORES[0]);
    // Values below -0.8 and above 0.3 are clear: layers 0 to 3, and 8 to 11, of which 3 and 8 are read.
    let value = |cell: usize, layer: usize| match layer {
        0..=3 => -2.0 + 0.1 * wave(grid.direction(cell as u32), layer, 12) as f32,
        8.. => 2.0 + 0.1 * wave(grid.direction(cell as u32), layer, 12) as f32,
        _ => wave(grid.direction(cell as u32), layer, 12) as f32,
    };
    let eye = glam::DVec3::from_array(scene_of_clear.camera.eye()).normalize();
    let behind = (0..grid.cells()).min_by_key(|&c| (1e6 * grid.direction(c as u32).dot(eye)) as i64).unwrap();
    let stained = |cell: usize, layer: usize| match layer {
        0 | 11 if cell == behind => 0.0,
        _ => value(cell, layer),
    };
    let (clean, stained) = (Values::new(grid.cells(), 12, value), Values::new(grid.cells(), 12, stained));
    for (one, other) in clean.fields().iter().zip(&stained.fields()) {
        let one = renderer.render(&scene_of_clear, &grid, &layers, one).unwrap();
        let other = renderer.render(&scene_of_clear, &grid, &layers, other).unwrap();
        assert_same(&one, &other, "clear layers");
        let column = 4 * grid.cells() as u64;
        assert_eq!((unread(&one), unread(&other)), (Some((6 * column, 12 * column)), None));
        assert!(one.pixels.iter().any(|pixel| pixel[0] > 0.0));
    }
    // Gradients read one layer more.
    let lit = scene(FAR, &format!("{clear}\n[light]\nkind = \"headlight\""), CORES[0]);
    let [one, other] = [&clean, &stained].map(|of| renderer.render(&lit, &grid, &layers, &of.fields()[0]).unwrap());
    assert_same(&one, &other, "clear layers, lit");
    assert_eq!(unread(&one).map(|(unread, _)| unread), Some(4 * 4 * grid.cells() as u64));
    // The same field and range with a transfer function in which no layer is clear.
    let seen = scene(FAR, &clear.replace("extinction = 0", "extinction = 2"), CORES[0]);
    let field = &clean.fields()[0];
    renderer.render(&scene_of_clear, &grid, &layers, field).unwrap();
    let one = renderer.render(&seen, &grid, &layers, field).unwrap();
    assert_same(&one, &limited(None, None).render(&seen, &grid, &layers, field).unwrap(), "seen after clear");
    assert_eq!(unread(&one), None);
}

/// Later frames reuse the buffers of the first one, but for the up to 8 staging buffers, which are created while the
/// device still copies from the others.
#[test]
fn later_frames_create_no_buffers() {
    let Some(gpu) = gpu() else { return };
    drop(gpu);
    let gpu = Arc::new(Gpu::with_limits(None, MemoryLimits { binding: Some(256 << 10), field: None }).unwrap());
    let renderer = renderer(&gpu);
    let (grid, layers) = planet(5, 30);
    let mut created = Vec::new();
    for step in 0..10 {
        let value = |c: usize, l: usize| wave(grid.direction(c as u32), l + step, 30) as f32;
        let values = Values::new(grid.cells(), 30, value);
        let frame = renderer.render(&scene(FAR, SMOOTH, CORES[0]), &grid, &layers, &values.fields()[step % 2]);
        let report = frame.unwrap().report;
        let device = &report.device;
        assert!(device.name.is_some() && device.bytes_uploaded > 30 * grid.cells() as u64, "{report:?}");
        created.push(gpu.buffers_created());
    }
    assert!(created[0] > 0 && created[9] < created[0] + 8, "{created:?}");
}

/// Scenes of one field share its upload. Another borrow of the same memory is another field, because the model may have
/// written to it meanwhile.
#[test]
fn a_field_is_uploaded_once_and_not_confused_with_another() {
    let Some(gpu) = gpu() else { return };
    drop(gpu);
    let renderer = limited(None, None);
    let (grid, layers) = planet(4, 20);
    let all = 4 * 20 * grid.cells() as u64;
    let draw = |scene: &Scene, field: &Field| renderer.render(scene, &grid, &layers, field).unwrap();
    let mut values: Vec<f32> =
        Values::new(grid.cells(), 20, |c, l| wave(grid.direction(c as u32), l, 20) as f32).level_fastest;
    let far = scene(FAR, SMOOTH, CORES[0]);
    let before = {
        let field = at_centers(&values, 20);
        let first = draw(&far, &field);
        assert!(first.report.device.bytes_uploaded > all);
        for other in [scene(POLE, SMOOTH, CORES[1]), far.clone()] {
            assert!(draw(&other, &field.clone()).report.device.bytes_uploaded < all);
        }
        // Normalised to another range.
        assert!(draw(&scene(FAR, RAMP, CORES[0]), &field).report.device.bytes_uploaded > all);
        first
    };
    values.iter_mut().for_each(|value| *value = -*value);
    let field = at_centers(&values, 20);
    let after = draw(&far, &field);
    assert!(after.report.device.bytes_uploaded > all && after.pixels != before.pixels);
    let fresh = limited(None, None).render(&far, &grid, &layers, &field).unwrap();
    assert_same(&after, &fresh, "written anew");
}

/// Threads that draw different fields concurrently on one device, in pages, draw the pictures of a single thread.
#[test]
fn threads_share_a_device() {
    let Some(_) = gpu() else { return };
    let (grid, layers) = planet(4, 20);
    let (one_by_one, at_once) = (Mutex::new(limited(None, None)), limited(Some(64 << 10), None));
    // Each thread has its own camera; every other scene is lit.
    let scene = |thread: usize, step: usize| {
        let camera = format!("lon = {}\nlat = 25\ndistance = 3.2\nfov = 45", 80 * thread + 30 * step);
        let light = format!("{SMOOTH}\n[light]\nkind = \"sun\"\nlon = {}\nlat = 10", 70 * thread);
        scene(&camera, if step.is_multiple_of(2) { &light } else { SMOOTH }, CORES[0])
    };
    let draw = |renderer: &Renderer, thread: usize, step: usize| {
        let value = |c: usize, l: usize| wave(grid.direction(c as u32), l + 5 * thread + step, 20) as f32;
        let values = Values::new(grid.cells(), 20, value);
        renderer.render(&scene(thread, step), &grid, &layers, &values.fields()[step / 2 % 2]).unwrap()
    };
    std::thread::scope(|scope| {
        for thread in 0..4 {
            let (draw, at_once, one_by_one) = (&draw, &at_once, &one_by_one);
            scope.spawn(move || {
                let frames: Vec<Frame> = (0..4).map(|step| draw(at_once, thread, step)).collect();
                for (step, frame) in frames.iter().enumerate() {
                    let alone = draw(&one_by_one.lock().unwrap(), thread, step);
                    assert_same(frame, &alone, &format!("thread {thread}, step {step}"));
                }
            });
        }
    });
}
