//! Spheres distributed over ranks, some of which trace on the GPU: the composed picture is that of the whole sphere.

use super::common::*;
use super::scenes::{CELLS, ISOSURFACES, LINES, NATIVE, ON_CORE, heights};
use super::volumes;
use crate::common::{columns_of, picture};
use crate::culled::{Culled, Mark, Style, holes};
use crate::spread::{Spread, partitions, without_holes};
use icoray::{
    Counts, DistributedGrid, Field, Fields, Frame, FrameReport, IcosahedralMesh, Layers, Location, Scene, Scenery,
    Shape,
};
use icoray_gpu::{Gpu, MemoryLimits};
use std::sync::Arc;

const CORE: &str = "exaggeration = 60\ncore = \"gray\"\ntolerance = 1e-6";
const HOLLOW: &str = "exaggeration = 60\ncore = \"transparent\"\nbackground = \"white\"\ntolerance = 1e-6";

/// Draws a scene of a mesh distributed over ranks, with the values of [`fields`], one after the other. The ranks of
/// `has_gpu` trace on the GPU.
fn draw(
    gpu: &Arc<Gpu>,
    spread: &Spread,
    mesh: &IcosahedralMesh,
    scene: &Scene,
    (values, layers): (&[f32], &Layers),
    has_gpu: impl Fn(usize) -> bool + Sync,
) -> (Frame, Vec<FrameReport>) {
    let count = layers.count();
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
        let data = DistributedGrid { grid, decomposition: Some(&decomposition.unwrap()), layers };
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
fn whole(mesh: &IcosahedralMesh, stays: &[bool], scene: &Scene, (values, layers): (&[f32], &Layers)) -> Frame {
    let count = layers.count();
    let culled = Culled::new(mesh, stays, Style::Corners, Mark::BeforeFirst, 1);
    let shape = Shape::level_fastest(culled.cells.len(), count);
    let here = values.chunks_exact(mesh.cells() * count);
    let here: Vec<_> = here.map(|values| (shape, columns_of(values, &culled.cells, count))).collect();
    cpu(1).render(scene, &culled.grid(), layers, fields(&here)).unwrap()
}

/// Compares the picture of the ranks with that of the whole, and checks which ranks report a device.
fn check(
    name: &str,
    (frame, reports): &(Frame, Vec<FrameReport>),
    expected: &Frame,
    most: [f64; 2],
    has_gpu: impl Fn(usize) -> bool,
) {
    let (rmse, max) = apart(frame, expected);
    println!("{name}: rmse {rmse:.1e}, max {max:.1e}, {:?}", frame.report.counts);
    for (rank, report) in reports.iter().enumerate() {
        assert_eq!(report.device.left_to_cpu, None, "{name}, rank {rank}");
        assert_eq!(report.device.name.is_some(), has_gpu(rank), "{name}, rank {rank}");
    }
    assert!(rmse <= most[0] && max <= most[1], "{name}: rmse {rmse:e}, max {max:e}");
    assert_eq!(frame.report.counts.rays, expected.report.counts.rays, "{name}");
    assert_eq!(count_beyond(frame, expected, 0.0), 0, "{name}: pixels beyond their errors");
}

/// One volume; and several, surfaces, isosurfaces, cuts, lines and native heights; on whole spheres and beside holes,
/// which are holes of the parts.
#[test]
fn parts_make_the_picture_of_the_whole() {
    let Some(gpu) = gpu() else { return };
    let sphere = sphere(4, &THICK_M);
    let mesh = sphere.mesh;
    let heights: Vec<f32> = heights(&sphere).into_iter().map(|height| height as f32).collect();
    let values = [&sphere.values[0][..], &sphere.values[1], &heights].concat();
    let values = (values.as_slice(), &sphere.layers);
    let (all, holes) = (vec![true; mesh.cells()], holes(mesh));
    let lakes = &holes[2].1;
    let loose = |rest: &str| rest.replace("1e-6", "1e-4");
    let with = |camera, text: &str, rest| scene(camera, &format!("{SMOOTH}\n{text}"), rest);
    let plain = [
        ("core", scene(FAR, RAMP, CORE)),
        ("inside", scene(INSIDE, SMOOTH, HOLLOW)),
        ("sun", scene(FAR, &format!("{SMOOTH}\n{SUN}"), &loose(CORE))),
        ("hollow", scene(FAR, SMOOTH, HOLLOW)),
        ("steps", scene(RADIAL, STEPS, CORE)),
        ("dense", scene(FAR, DENSE, CORE)),
        ("headlight", scene(FAR, &format!("{RAMP}\n{LIT}"), &loose(CORE))),
        ("sun, inside", scene(INSIDE, &format!("{SMOOTH}\n{SUN}"), &loose(HOLLOW))),
    ];
    let scenes = [
        ("lines, lit", with(FAR, &format!("{LINES}{SUN}"), CORES[0]), lakes),
        ("native heights, lit", with(FAR, &format!("{}\n{LIT}", ISOSURFACES[3].1), NATIVE), &all),
        ("two volumes", scene_of(FAR, &volumes::contents("two"), CORES[0]), &all),
        ("isosurfaces, cut", with(INSIDE, ISOSURFACES[5].1, CORES[1]), lakes),
        ("cells, a lake", with(FAR, &format!("{CELLS}{ON_CORE}"), CORES[0]), lakes),
    ];
    let of_plain = plain.iter().flat_map(|(name, scene)| (0..4).map(move |k| (*name, scene, k)));
    let cases = of_plain.map(|(name, scene, k)| (name, scene, &all, k));
    let of_scenes = scenes.iter().zip([0, 1, 2, 0, 1]).map(|((name, scene, stays), k)| (*name, scene, *stays, k));
    let of_holes = holes.iter().enumerate().map(|(i, (hole, stays))| (*hole, &plain[i % 3].1, stays, i % 3));
    for (i, (name, scene, stays, k)) in cases.chain(of_scenes).chain(of_holes).enumerate() {
        let ranks = 2 + i % 3;
        let (partition, owner) = partitions(mesh, ranks).swap_remove(k);
        let spread = Spread::new(mesh, ranks, &without_holes(owner, stays));
        // Every second time, only every second rank has a GPU.
        let has_gpu = |rank: usize| i % 2 == 0 || rank % 2 == i / 2 % 2;
        let drawn = draw(&gpu, &spread, mesh, scene, values, has_gpu);
        let is_plain = scene.scenery == Scenery::default() && scene.has_one_field_of_volume();
        // As of whole grids: pieces may be halved on one of the two only.
        let most = if is_plain { [RMSE, MAX] } else { [3e-4, f64::INFINITY] };
        let expected = whole(mesh, stays, scene, values);
        check(&format!("{name}, {partition} on {ranks} ranks"), &drawn, &expected, most, has_gpu);
        let is_seen = |pixel: &&[f32; 4]| pixel[0] != pixel[2];
        let seen = drawn.0.pixels.iter().filter(is_seen).count();
        assert!(is_plain || seen > drawn.0.pixels.len() / 4, "{name}: {seen} pixels are seen");
    }
}

/// The fragments have the CPU's number, counts and errors, also for rays that end early and for clear runs.
#[test]
fn fragments_are_those_of_the_cpu() {
    let Some(gpu) = gpu() else { return };
    let (sphere, coarse) = (sphere(4, &THICK_M), sphere(2, &THICK_M));
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
        let (mesh, values) = (sphere.mesh, (sphere.values[0].as_slice(), &sphere.layers));
        for (partition, owner) in partitions(mesh, 3) {
            let name = format!("{name}, {partition}");
            let spread = Spread::new(mesh, 3, &owner);
            let (cpu, _) = draw(&gpu, &spread, mesh, &scene, values, |_| false);
            let drawn = draw(&gpu, &spread, mesh, &scene, values, |_| true);
            check(&name, &drawn, &cpu, [RMSE, MAX], |_| true);
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
    let sphere = sphere(5, &std::array::from_fn::<f64, 16, _>(|k| 1e3 * k as f64));
    let mesh = sphere.mesh;
    let values = (sphere.values[0].as_slice(), &sphere.layers);
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
        check(name, &drawn, &expected, [RMSE, MAX], |_| true);
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
