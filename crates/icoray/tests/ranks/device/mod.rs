//! Pictures of which a device traces some tiles: each pixel is the device's or the CPU's.

use crate::common::{FAR, LIT, Model, at_centers, columns_of, even_heights, on_nodes, on_ranks, picture};
use crate::spread::Rows;
use icoray::device::{Band, Device, DeviceCost, DeviceRequest, Devices, FallbackReason, Job, Rect, Traced};
use icoray::{Adapter, Decomposition, DeviceReport, DistributedGrid, Frame, FrameReport, Lights, Renderer, Scene};
use std::sync::{Arc, Mutex};

mod parts;

const LAYERS: usize = 3;
const SIZE: (u32, u32) = (77, 50);

/// What is given of a job's tiles.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Manner {
    All,
    /// The second half first, in two calls.
    Backwards,
    /// Every third tile, and then a reason.
    Some,
    /// The first tile, then a panic.
    Panic,
    /// A tile and a half.
    Torn,
    Twice,
}

impl Manner {
    /// Gives some of `count` tiles: `band` those from a first one to an end, `torn` a tile and a half.
    fn give(self, count: usize, band: impl Fn(usize, usize), torn: impl Fn()) -> Result<(), FallbackReason> {
        match self {
            _ if count == 0 => {}
            Manner::All => band(0, count),
            Manner::Backwards => {
                band(count / 2, count);
                band(0, count / 2);
            }
            Manner::Some => {
                (0..count).step_by(3).for_each(|i| band(i, i + 1));
                return Err(FallbackReason::new("the paint is used up"));
            }
            Manner::Panic => {
                band(0, 1);
                panic!("the brush is broken");
            }
            Manner::Torn => torn(),
            Manner::Twice => {
                band(0, count);
                band(0, count);
            }
        }
        Ok(())
    }
}

/// A device whose rays show where they are.
#[derive(Debug)]
struct Painter {
    manner: Manner,
    /// The job's number, its tiles and steps, gradients.
    asked: Mutex<Vec<(u64, usize, u32, usize)>>,
}

impl Painter {
    fn new(manner: Manner) -> Arc<Self> {
        Arc::new(Painter { manner, asked: Mutex::default() })
    }
}

/// The colour of a pixel of [`Painter`], which the field's colours are not.
fn color(x: u32, y: u32) -> [f32; 3] {
    [x as f32 / 1024.0, y as f32 / 1024.0, 0.75]
}

fn painted(job: &Job, rect: Rect) -> Vec<Traced> {
    let (step, scene) = (job.quality().pixel_step, job.scene());
    let nodes =
        (rect.top..rect.top + rect.height).flat_map(|y| (rect.left..rect.left + rect.width).map(move |x| (x, y)));
    let ray = |(x, y): (u32, u32)| {
        let (x, y) = ((x * step).min(scene.width - 1), (y * step).min(scene.height - 1));
        Traced { color: color(x, y), alpha: 1.0, error: 0.25, variance: 0.0, counts: [2, 3, 1], surfaces: [0.0; 2] }
    };
    nodes.map(ray).collect()
}

impl Device for Painter {
    fn name(&self) -> String {
        "painter".into()
    }

    fn trace(&self, job: &Job, give: &(dyn Fn(Band) + Sync)) -> Result<DeviceCost, FallbackReason> {
        let tiles: Vec<Rect> = job.tiles().collect();
        let asked = (job.number(), tiles.len(), job.quality().pixel_step, job.gradients().len());
        self.asked.lock().unwrap().push(asked);
        let rays = |tiles: &[Rect]| tiles.iter().flat_map(|tile| painted(job, *tile)).collect::<Vec<_>>();
        let band = |first: usize, end: usize| {
            let rays = rays(&tiles[first..end]);
            give(Band { first, rays: &rays, seconds: 1.0 });
        };
        let torn = || {
            let rays = rays(&tiles[..2]);
            give(Band { first: 0, rays: &rays[..rays.len() - 1], seconds: 1.0 });
        };
        self.manner.give(tiles.len(), band, torn)?;
        Ok(DeviceCost { upload_s: 0.5, device_s: Some(0.25), bytes_uploaded: 7, ..DeviceCost::default() })
    }
}

fn world() -> Model {
    let heights = even_heights(LAYERS, 0.05 * (LAYERS - 1) as f64);
    Model::new(3, &heights, |cell, _, layer| [(0.37 * (cell * LAYERS + layer) as f64).sin() + layer as f64])
}

/// A scene of further keys and, behind a bar, tables.
fn scene(rest: &str) -> Scene {
    let (width, height) = SIZE;
    let keys = format!("antialias = false\nimage = {{ width = {width}, height = {height} }}\n{rest}");
    let transfer = "map = \"viridis\"\nrange = [-1, 3]\nopacity = [[-1, 0.8], [0, 0.1], [3, 0.9]]";
    crate::common::scene(FAR, transfer, &keys)
}

/// How many pixels are a painter's; the others have to be those of `alone`.
fn count_painted(frame: &Frame, alone: &Frame) -> usize {
    let mut count = 0;
    for (i, pixel) in frame.pixels.iter().enumerate() {
        let [r, g, b] = color(i as u32 % frame.width, i as u32 / frame.width);
        if *pixel == [r, g, b, 1.0] {
            assert!((0.25..0.2501).contains(&frame.error[i]), "{i}: {}", frame.error[i]);
            count += 1;
        } else {
            assert_eq!((pixel, frame.error[i]), (&alone.pixels[i], alone.error[i]), "pixel {i}");
        }
    }
    count
}

/// Checks that the reason for which the CPU draws has a word, or that there is no reason.
fn assert_left(device: &DeviceReport, word: Option<&str>, trying: &str) {
    let reason = device.left_to_cpu.as_deref();
    let is_right = reason.map_or(word.is_none(), |reason| word.is_some_and(|word| reason.contains(word)));
    assert!(is_right, "{trying}: {reason:?}, expected {word:?}");
}

#[test]
fn tiles_of_a_device_are_shown_and_the_cpu_draws_the_rest() {
    let world = world();
    let alone = world.draw(&scene(""));
    assert_eq!(count_painted(&alone, &alone), 0);
    let all = (SIZE.0 * SIZE.1) as usize;
    for (manner, painted, word) in [
        (Manner::All, all..=all, None),
        (Manner::Backwards, all..=all, None),
        (Manner::Twice, all..=all, None),
        (Manner::Some, all / 4..=all / 2, Some("used up")),
        (Manner::Panic, 1..=all / 10, Some("painter: internal error: the brush is broken")),
        (Manner::Torn, 0..=all / 10, Some("painter: internal error")),
    ] {
        let renderer = Renderer::new(2).unwrap().with_device(Painter::new(manner));
        // The next picture is tried anew.
        for _ in 0..2 {
            let frame = world.draw_by(&renderer, &scene(""));
            let count = count_painted(&frame, &alone);
            assert!(painted.contains(&count), "{manner:?}: {count} pixels");
            let FrameReport { device, counts, .. } = frame.report;
            assert_eq!(device.name.is_some(), count > 0, "{manner:?}");
            assert_left(&device, word, &format!("{manner:?}"));
            if count == all {
                let counts = [counts.rays, counts.columns, counts.frusta, counts.void_frusta];
                assert_eq!(counts, [1, 2, 3, 1].map(|n| n * all as u64));
                assert_eq!((device.upload_s, device.device_s, device.bytes_uploaded), (0.5, Some(0.25), 7));
            }
        }
    }
}

#[test]
fn light_comes_with_gradients_and_a_budget_is_measured_on_the_device() {
    let world = world();
    let lit = |more: &str| scene(&format!("{more}|{LIT}"));
    let painter = Painter::new(Manner::All);
    let renderer = Renderer::new(2).unwrap().with_device(Arc::clone(&painter) as _);
    let frame = world.draw_by(&renderer, &lit(""));
    assert_eq!(frame.report.quality.lights, Lights::Full);
    let frame = world.draw_by(&renderer, &lit("time_budget_ms = 60000"));
    let asked = painter.asked.lock().unwrap().clone();
    let gradients = world.grid.cells() * LAYERS;
    assert!(asked.iter().all(|(.., count)| *count == gradients), "{asked:?}");
    // A job, then one of the next number that gets ready, is measured on few pixels, and drawn.
    let first = asked[0].0;
    assert!(asked.len() >= 4 && asked[1].0 > first && asked[1..].iter().all(|job| job.0 == asked[1].0));
    assert_eq!(asked[1].1, 0);
    assert!(asked[2..asked.len() - 1].iter().all(|(_, tiles, step, _)| *tiles > 0 && *step > 1), "{asked:?}");
    assert_eq!(asked[asked.len() - 1].2, frame.report.quality.pixel_step);
    assert_eq!(frame.report.quality.pixel_step, 1);
    assert_eq!(frame.report.device.name.as_deref(), Some("painter"));
    // No time for every pixel: those between are interpolated of the painter's.
    let frame = world.draw_by(&renderer, &lit("time_budget_ms = 1"));
    assert_eq!(frame.report.device.name.as_deref(), Some("painter"));
    assert!(frame.pixels.iter().enumerate().all(|(i, pixel)| {
        let expected = color(i as u32 % SIZE.0, i as u32 / SIZE.0);
        pixel.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5)
    }));
}

/// The picture, and the reports of all ranks, of which each draws with a device of its manner.
fn over_ranks(world: &Model, scene: &Scene, manners: &[Option<Manner>], in_columns: bool) -> (Frame, Vec<FrameReport>) {
    picture(on_ranks(manners.len(), |ranks| {
        let (rank, size, grid) = (ranks.rank(), ranks.size(), &world.grid);
        let renderer = renderer_with(manners[rank].map(|manner| Painter::new(manner) as _));
        if !in_columns {
            return world.draw_over(&renderer, scene, ranks).unwrap();
        }
        let own = Rows::own((0..grid.cells()).filter(|cell| cell % size == rank).collect());
        let values = columns_of(&world.values[0], &own.rows, LAYERS);
        let decomposition = Decomposition::new(ranks, grid, &own.cells()).unwrap();
        assert!(matches!(decomposition, Decomposition::Columns(_)), "a part");
        let data = DistributedGrid { grid, decomposition: Some(&decomposition), layers: &world.layers };
        renderer.render_decomposed(ranks, scene, data, &at_centers(&values, LAYERS)).unwrap()
    }))
}

/// A renderer of one thread, with a device or without.
fn renderer_with(device: Option<Arc<dyn Device>>) -> Renderer {
    let renderer = Renderer::new(1).unwrap();
    match device {
        Some(device) => renderer.with_device(device),
        None => renderer,
    }
}

#[test]
fn ranks_draw_their_tiles_on_devices() {
    let world = world();
    let scene = scene("");
    let alone = world.draw(&scene);
    let all = (SIZE.0 * SIZE.1) as usize;
    for in_columns in [false, true] {
        let both = [Some(Manner::All), Some(Manner::Backwards)];
        let (frame, reports) = over_ranks(&world, &scene, &both, in_columns);
        assert_eq!(count_painted(&frame, &alone), all);
        assert_eq!(reports[1].device.name.as_deref(), Some("painter"));
        // One rank has no device, another's gives up.
        let mixed = [None, Some(Manner::All), Some(Manner::Some)];
        let (frame, reports) = over_ranks(&world, &scene, &mixed, in_columns);
        let count = count_painted(&frame, &alone);
        assert!((all / 4..all * 3 / 5).contains(&count), "{count} of {all}");
        assert_eq!(frame.report.device.name, None);
        assert_eq!(frame.report.device.left_to_cpu, None);
        assert!(reports[1].device.name.is_some() && reports[1].device.left_to_cpu.is_none());
        assert!(reports[2].device.left_to_cpu.as_ref().is_some_and(|reason| reason.contains("used up")));
    }
}

/// A shop that counts what is asked of it, and has painters for those who take processors.
#[derive(Debug, Default)]
struct Shop(Mutex<Vec<DeviceRequest>>);

impl Devices for Shop {
    fn open(&self, wanted: &DeviceRequest) -> Result<Arc<dyn Device>, FallbackReason> {
        self.0.lock().unwrap().push(wanted.clone());
        match &wanted.adapter {
            Some(Adapter::Number(13)) => panic!("the shop is shut"),
            _ if wanted.or_processor => Ok(Painter::new(Manner::All)),
            _ => Err(FallbackReason::new("none is in stock")),
        }
    }
}

#[test]
fn a_device_is_opened_once_for_scenes_that_ask_alike() {
    let world = world();
    let alone = world.draw(&scene(""));
    let shop = Arc::new(Shop::default());
    let renderer = Renderer::new(1).unwrap().with_devices(Arc::clone(&shop) as _);
    let all = (SIZE.0 * SIZE.1) as usize;
    let keys = [
        ("backend = \"cpu\"\ndevice = 13", 0, None),
        ("precision = \"f64\"", 0, Some("f64")),
        ("backend = \"gpu\"\nprecision = \"f64\"", 0, Some("f64")),
        ("samples = 4", 0, Some("samples = 4")),
        ("", 1, Some("none is in stock")),
        ("backend = \"gpu\"", 2, None),
        ("backend = \"gpu\"\ndevice = \"GTX\"", 3, None),
        ("device = 13", 4, Some("the shop is shut")),
    ];
    for _ in 0..2 {
        for (keys, opened, reason) in keys {
            let frame = world.draw_by(&renderer, &scene(keys));
            assert_left(&frame.report.device, reason, keys);
            let is_drawn = keys.contains("\"gpu\"") && reason.is_none();
            assert_eq!(frame.report.device.name.is_some(), is_drawn, "{keys}");
            if reason.is_none_or(|reason| !keys.contains(reason)) {
                assert_eq!(count_painted(&frame, &alone), if is_drawn { all } else { 0 }, "{keys}");
            } else {
                assert_eq!(frame.pixels, world.draw(&scene(keys)).pixels, "{keys}");
            }
            let asked = shop.0.lock().unwrap();
            assert!(asked.len() == opened || asked.len() == 4, "{keys}: {asked:?}");
        }
    }
    let asked = shop.0.lock().unwrap().clone();
    let expected = [(None, false), (None, true), (Some("GTX"), true), (Some("13"), false)];
    assert_eq!(asked.len(), expected.len());
    for (asked, (adapter, or_processor)) in asked.iter().zip(expected) {
        let adapter = match adapter {
            Some("13") => Some(Adapter::Number(13)),
            name => name.map(|name| Adapter::Name(name.into())),
        };
        assert_eq!(*asked, DeviceRequest { adapter, or_processor, node_rank: 0 });
    }
}

#[test]
fn a_renderer_without_devices_reports_a_requested_one() {
    let world = world();
    let renderer = Renderer::new(1).unwrap();
    for (keys, word) in [("", None), ("backend = \"cpu\"", None), ("backend = \"gpu\"", Some("without the GPU"))] {
        assert_left(&world.draw_by(&renderer, &scene(keys)).report.device, word, keys);
    }
}

#[test]
fn ranks_of_a_node_ask_for_different_devices() {
    let world = world();
    let scene = scene("backend = \"gpu\"");
    let asked = on_nodes(&[0, 1, 0, 0, 1], |ranks| {
        let shop = Arc::new(Shop::default());
        let renderer = Renderer::new(1).unwrap().with_devices(Arc::clone(&shop) as _);
        for _ in 0..2 {
            world.draw_over(&renderer, &scene, ranks).unwrap();
        }
        let asked = shop.0.lock().unwrap();
        asked.iter().map(|wanted| wanted.node_rank).collect::<Vec<usize>>()
    });
    assert_eq!(asked, [[0], [0], [1], [2], [1]]);
}

/// Else some would wait for the others' numbers on their node.
#[test]
fn ranks_that_differ_in_who_draws_are_refused() {
    let world = world();
    let errors = on_ranks(2, |ranks| {
        let scene = scene(["backend = \"cpu\"", "backend = \"gpu\""][ranks.rank()]);
        world.draw_over(&Renderer::new(1).unwrap(), &scene, ranks).unwrap_err().to_string()
    });
    assert!(errors[0] == errors[1] && errors[0].contains("backend"), "{errors:?}");
}
