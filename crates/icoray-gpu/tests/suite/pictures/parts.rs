//! Spheres distributed over ranks, some of which trace on the GPU: the composed picture is that of the whole sphere.

use super::common::*;
use super::lines::{CELLS, ON_CORE};
use super::scenes::{ISOSURFACES, TwoFields};
use super::{native, volumes};
use crate::common::{columns_of, picture};
use crate::culled::{Culled, Mark, Style, holes};
use crate::spread::{Spread, partitions, without_holes};
use icoray::{
    Counts, DistributedGrid, Field, Fields, Frame, FrameReport, IcosahedralMesh, Layers, Location, Scene, Shape,
};
use icoray_gpu::{Gpu, MemoryLimits};
use std::sync::Arc;

const SUN: &str = "[light]\nkind = \"sun\"\nlon = 75\nlat = 40\nspecular = 0.5";
const CORE: &str = "exaggeration = 60\ncore = \"gray\"\ntolerance = 1e-6";
const HOLLOW: &str = "exaggeration = 60\ncore = \"transparent\"\nbackground = \"white\"\ntolerance = 1e-6";

fn layers(count: usize) -> Layers {
    let heights: Vec<f64> = (0..count).map(|k| 20e3 * k as f64 / (count - 1) as f64).collect();
    Layers::from_heights(&heights, EARTH_M).unwrap()
}

/// Draws a scene of a mesh distributed over ranks, with the values of [`fields`], one after the other. The ranks of `has_gpu` trace on
/// the GPU.
fn draw(
    gpu: &Arc<Gpu>,
    spread: &Spread,
    mesh: &IcosahedralMesh,
    scene: &Scene,
    (values, count): (&[f32], usize),
    has_gpu: impl Fn(usize) -> bool + Sync,
) -> (Frame, Vec<FrameReport>) {
    let layers = layers(count);
    picture(spread.each(|ranks, culled, grid, decomposition| {
        let cells = culled.cells.len();
        // Ranks also differ in the layout of their arrays.
        let here = values.chunks_exact(mesh.cells() * count).map(|values| {
            if ranks.rank() % 2 == 0 {
                return (Shape::level_fastest(cells, count), columns_of(values, &culled.cells, count));
            }
            let layer = |layer| culled.cells.iter().map(move |cell| values[cell * count + layer]);
            (Shape::cell_fastest(cells, count), (0..count).flat_map(layer).collect::<Vec<_>>())
        });
        let here: Vec<_> = here.collect();
        let renderer = if has_gpu(ranks.rank()) { renderer(gpu) } else { cpu(1) };
        let data = DistributedGrid { grid, decomposition: Some(&decomposition.unwrap()), layers: &layers };
        renderer.render_decomposed(ranks, scene, data, fields(&here)).unwrap()
    }))
}

/// Up to two fields and the heights of layers.
fn fields(all: &[(Shape, Vec<f32>)]) -> Fields<'_> {
    let mut all =
        all.iter().map(|(shape, values)| Field::new(values.as_slice().into(), *shape, Location::Center, None).unwrap());
    let fields = Fields::new(["f", "g"].into_iter().zip(all.by_ref()));
    all.next().into_iter().fold(fields, Fields::with_heights)
}

/// The CPU's picture of the whole mesh, culled to the cells that stay.
fn whole(mesh: &IcosahedralMesh, stays: &[bool], scene: &Scene, (values, count): (&[f32], usize)) -> Frame {
    let layers = layers(count);
    let culled = Culled::new(mesh, stays, Style::Corners, Mark::BeforeFirst, 1);
    let shape = Shape::level_fastest(culled.cells.len(), count);
    let here = values.chunks_exact(mesh.cells() * count);
    let here: Vec<_> = here.map(|values| (shape, columns_of(values, &culled.cells, count))).collect();
    cpu(1).render(scene, &culled.grid(), &layers, fields(&here)).unwrap()
}

/// Compares the picture of the ranks with that of the whole, and checks which ranks report a device.
fn check(name: &str, (frame, reports): &(Frame, Vec<FrameReport>), expected: &Frame, has_gpu: impl Fn(usize) -> bool) {
    let (rmse, max) = apart(frame, expected);
    println!("{name}: rmse {rmse:.1e}, max {max:.1e}, {:?}", frame.report.counts);
    check_devices(name, reports, has_gpu);
    assert!(rmse <= RMSE && max <= MAX, "{name}: rmse {rmse:e}, max {max:e}");
    assert_eq!(frame.report.counts.rays, expected.report.counts.rays, "{name}");
    assert_eq!(count_beyond(frame, expected, 0.0), 0, "{name}: pixels beyond their errors");
}

fn check_devices(name: &str, reports: &[FrameReport], has_gpu: impl Fn(usize) -> bool) {
    for (rank, report) in reports.iter().enumerate() {
        assert_eq!(report.device.left_to_cpu, None, "{name}, rank {rank}");
        assert_eq!(report.device.name.is_some(), has_gpu(rank), "{name}, rank {rank}");
    }
}

#[test]
fn parts_make_the_picture_of_the_whole() {
    let Some(gpu) = gpu() else { return };
    let sphere = Sphere::new(4, &THICK_M);
    let mesh = sphere.tables;
    let values = (sphere.values.as_slice(), THICK_M.len());
    let stays = vec![true; mesh.cells()];
    let scenes = [
        ("core", scene(FAR, RAMP, CORE)),
        ("hollow", scene(FAR, SMOOTH, HOLLOW)),
        ("inside", scene(INSIDE, SMOOTH, HOLLOW)),
        ("steps", scene(RADIAL, STEPS, CORE)),
        ("dense", scene(FAR, DENSE, CORE)),
        ("headlight", scene(FAR, &format!("{RAMP}\n{LIT}"), &CORE.replace("1e-6", "1e-4"))),
        ("sun", scene(INSIDE, &format!("{SMOOTH}\n{SUN}"), &HOLLOW.replace("1e-6", "1e-4"))),
    ];
    for (i, (name, scene)) in scenes.iter().enumerate() {
        let expected = whole(mesh, &stays, scene, values);
        let ranks = 2 + i % 3;
        for (k, (partition, owner)) in partitions(mesh, ranks).iter().enumerate() {
            let spread = Spread::new(mesh, ranks, owner);
            // Every second time, only every second rank has a GPU.
            let has_gpu = |rank: usize| (i + k) % 2 == 0 || rank % 2 == k / 2;
            let drawn = draw(&gpu, &spread, mesh, scene, values, has_gpu);
            check(&format!("{name}, {partition} on {ranks} ranks"), &drawn, &expected, has_gpu);
        }
    }
}

/// Several volumes, surfaces, isosurfaces, cuts, lines and native heights, over ranks and beside holes.
#[test]
fn parts_of_scenes_make_the_picture_of_the_whole() {
    let Some(gpu) = gpu() else { return };
    let TwoFields { sphere, second } = TwoFields::new(4, &THICK_M);
    let mesh = sphere.tables;
    let heights = native::heights(&sphere).into_iter().map(|height| height as f32).collect();
    let values = [sphere.values.clone(), second, heights].concat();
    let values = (values.as_slice(), THICK_M.len());
    let (_, lakes) = holes(mesh).into_iter().find(|(hole, _)| *hole == "continents with a lake").unwrap();
    let all = vec![true; mesh.cells()];
    for (i, (what, text, stays, camera)) in [
        ("lines, lit", format!("{}{SUN}", native::LINES), &lakes, FAR),
        ("native heights, lit", format!("{}\n{LIT}", ISOSURFACES[3].1), &all, FAR),
        ("two volumes", volumes::contents("two"), &all, FAR),
        ("isosurfaces, cut", ISOSURFACES[5].1.to_owned(), &lakes, INSIDE),
        ("cells, a lake", format!("{CELLS}{ON_CORE}"), &lakes, FAR),
    ]
    .into_iter()
    .enumerate()
    {
        let rest = if what.starts_with("native") { native::NATIVE } else { CORES[i % 2] };
        let scene = match text.contains("[[volumes]]") {
            true => volumes::scene_of(camera, &[&text], rest, ""),
            false => scene(camera, &format!("{SMOOTH}\n{text}"), rest),
        };
        let expected = whole(mesh, stays, &scene, values);
        let ranks = 2 + i % 3;
        let (partition, owner) = partitions(mesh, ranks).swap_remove(i % 3);
        let spread = Spread::new(mesh, ranks, &without_holes(owner, stays));
        let has_gpu = |rank: usize| i != 1 || rank > 0;
        let drawn = draw(&gpu, &spread, mesh, &scene, values, has_gpu);
        let name = format!("{what}, {partition} on {ranks} ranks");
        let (rmse, max) = apart(&drawn.0, &expected);
        println!("{name}: rmse {rmse:.1e}, max {max:.1e}, beyond {}", count_beyond(&drawn.0, &expected, 0.0));
        // As of whole grids: pieces may be halved on one of the two only.
        assert!(rmse <= 3e-4, "{name}: rmse {rmse:e}, max {max:e}");
        check_devices(&name, &drawn.1, has_gpu);
        assert_eq!(count_beyond(&drawn.0, &expected, 0.0), 0, "{name}: pixels beyond their errors");
        let is_seen = |pixel: &&[f32; 4]| pixel[0] != pixel[2];
        let seen = drawn.0.pixels.iter().filter(is_seen).count();
        assert!(seen > drawn.0.pixels.len() / 4, "{what}: {seen} pixels are seen");
    }
}

#[test]
fn holes_of_the_whole_are_holes_of_its_parts() {
    let Some(gpu) = gpu() else { return };
    let sphere = Sphere::new(3, &THICK_M);
    let mesh = sphere.tables;
    let values = (sphere.values.as_slice(), THICK_M.len());
    let scenes = [
        scene(FAR, RAMP, CORE),
        scene(INSIDE, SMOOTH, HOLLOW),
        scene(FAR, &format!("{SMOOTH}\n{SUN}"), &CORE.replace("1e-6", "1e-4")),
    ];
    for (i, (hole, stays)) in holes(mesh).iter().enumerate() {
        let scene = &scenes[i % 3];
        let expected = whole(mesh, stays, scene, values);
        let ranks = 2 + i % 3;
        let (partition, owner) = partitions(mesh, ranks).swap_remove(i % 3);
        let spread = Spread::new(mesh, ranks, &without_holes(owner, stays));
        let has_gpu = |rank: usize| i % 2 == 0 || rank > 0;
        let drawn = draw(&gpu, &spread, mesh, scene, values, has_gpu);
        check(&format!("{hole}, {partition} on {ranks} ranks, scene {}", i % 3), &drawn, &expected, has_gpu);
    }
}

/// The fragments have the CPU's number, counts and errors, also for rays that end early and for clear runs.
#[test]
fn fragments_are_those_of_the_cpu() {
    let Some(gpu) = gpu() else { return };
    let (sphere, coarse) = (Sphere::new(4, &THICK_M), Sphere::new(2, &THICK_M));
    let loose = |rest: &str| rest.replace("1e-6", "1e-2");
    for (name, sphere, scene) in [
        ("dense, core", &sphere, scene(FAR, DENSE, &loose(CORE))),
        ("ramp, hollow", &sphere, scene(INSIDE, RAMP, &loose(HOLLOW))),
        ("ramp, core", &sphere, scene(FAR, RAMP, &loose(CORE))),
        // Facets that lie deep below the core's sphere, almost clear above it.
        ("spike, core", &coarse, scene(FAR, SPIKE, CORE)),
        ("steps, paper", &sphere, scene(FAR, STEPS, &format!("{}\nmethod = \"paper\"", loose(HOLLOW)))),
        ("lit", &sphere, scene(FAR, &format!("{RAMP}\n{SUN}"), &CORE.replace("1e-6", "1e-3"))),
    ] {
        let (mesh, values) = (sphere.tables, (sphere.values.as_slice(), THICK_M.len()));
        for (partition, owner) in partitions(mesh, 3) {
            let name = format!("{name}, {partition}");
            let spread = Spread::new(mesh, 3, &owner);
            let (cpu, _) = draw(&gpu, &spread, mesh, &scene, values, |_| false);
            let drawn = draw(&gpu, &spread, mesh, &scene, values, |_| true);
            check(&name, &drawn, &cpu, |_| true);
            let [ours, theirs] = [&drawn.0.report, &cpu.report];
            let numbers = |counts: Counts| [counts.columns, counts.frusta, counts.fragments];
            for (ours, theirs) in numbers(ours.counts).into_iter().zip(numbers(theirs.counts)) {
                let allowed = 5.0 + 0.001 * theirs as f64;
                assert!(ours.abs_diff(theirs) as f64 <= allowed, "{name}: {ours}, expected about {theirs}");
            }
            assert_reported_error(&name, ours.error.mean, (theirs.error.mean, theirs.error.mean), 0.02);
        }
    }
}

/// A part's field in pages, of a close view with the columns that its rays read, and of lit scenes, whose gradients are
/// uploaded.
#[test]
fn parts_in_pages_do_not_show() {
    let Some(_) = gpu() else { return };
    let count = 16;
    let sphere = Sphere::new(5, &std::array::from_fn::<f64, 16, _>(|k| 1e3 * k as f64));
    let mesh = sphere.tables;
    let values = (sphere.values.as_slice(), count);
    let limited = |binding, field| Arc::new(Gpu::with_limits(None, MemoryLimits { binding, field }).unwrap());
    let (_, owner) = partitions(mesh, 2).swap_remove(1);
    let spread = Spread::new(mesh, 2, &owner);
    let stays = vec![true; mesh.cells()];
    let loose = CORE.replace("1e-6", "1e-4");
    let paged = limited(Some(256 << 10), None);
    for (name, scene) in [
        ("far", scene(FAR, &format!("{RAMP}\n{SUN}"), &loose)),
        ("close", scene(CLOSE, &format!("{SMOOTH}\n{LIT}"), &loose)),
        ("in time", scene(FAR, SMOOTH, &format!("{CORE}\ntime_budget_ms = 3600000"))),
    ] {
        let expected = whole(mesh, &stays, &scene, values);
        let drawn = draw(&paged, &spread, mesh, &scene, values, |_| true);
        check(name, &drawn, &expected, |_| true);
        let is_unread = |line: &String| line.ends_with("bytes of the field on the device");
        assert!(drawn.1.iter().flat_map(|report| &report.left_out).any(is_unread), "{name}: {:?}", drawn.1);
        // No room for the whole field: the CPU traces the rank's part.
        let small = limited(None, Some(1000));
        let (frame, reports) = draw(&small, &spread, mesh, &scene, values, |_| true);
        let (rmse, max) = apart(&frame, &expected);
        assert!(rmse <= RMSE && max <= MAX, "{name}: rmse {rmse:e}, max {max:e}");
        let is_left = |report: &FrameReport| {
            let reason = report.device.left_to_cpu.as_ref();
            let is_left = reason.is_some_and(|reason| reason.contains("expected at most"));
            assert_eq!(is_left, report.device.name.is_none(), "{name}: {report:?}");
            is_left
        };
        // The cells of the close view belong to one rank.
        let expected = if name == "close" { 1 } else { 2 };
        assert_eq!(reports.iter().filter(|report| is_left(report)).count(), expected);
    }
}
