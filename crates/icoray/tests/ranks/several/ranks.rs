//! Scenes of several fields over ranks: the picture of one process.

use super::*;
use crate::common::{Array, assert_same_refusal, on_ranks, picture, refusal};
use crate::spread::{Spread, partitions};
use icoray::{Decomposition, DistributedGrid, ErrorKind};
use icoray_test_support::Random;

#[test]
fn tiles_are_bitwise_those_of_one_process() {
    let (mesh, grid) = icosahedral(3);
    let steps = steps(mesh, Location::Corner);
    for (name, scene) in scenes() {
        let expected = draw(&Renderer::new(2).unwrap(), &grid, &scene, &steps);
        for count in [1, 2, 3] {
            let (frame, _) = picture(on_ranks(count, |ranks| {
                let renderer = Renderer::new(1).unwrap();
                let [_, second] = steps
                    .each_ref()
                    .map(|step| renderer.render_over(ranks, &scene, &grid, &layers(), fields(step)).unwrap());
                second
            }));
            assert!(bits(&frame) == bits(&expected), "{name} on {count} ranks");
            assert_eq!(frame.report.bytes_derived, expected.report.bytes_derived, "{name}");
        }
    }
}

#[test]
fn columns_are_bitwise_those_of_one_process() {
    let (mesh, grid) = icosahedral(3);
    let steps = steps(mesh, Location::Center);
    for (name, scene) in scenes() {
        let expected = draw(&Renderer::new(2).unwrap(), &grid, &scene, &steps);
        for count in [2, 3] {
            let (frame, _) = picture(on_ranks(count, |ranks| {
                let is_mine = |cell: &usize| Random::at(*cell).below(count) == ranks.rank();
                let mine = Rows::own((0..mesh.cells()).filter(is_mine).collect());
                let decomposition = Decomposition::new(ranks, &grid, &mine.cells()).unwrap();
                assert!(matches!(decomposition, Decomposition::Columns(_)));
                let renderer = Renderer::new(1).unwrap();
                let data = DistributedGrid { grid: &grid, decomposition: Some(&decomposition), layers: &layers() };
                let [_, second] = [0, 1].map(|step| {
                    let own = arrays(mesh, step, [&mine, &Rows::default()], Location::Center);
                    renderer.render_decomposed(ranks, &scene, data, fields(&own)).unwrap()
                });
                second
            }));
            assert!(bits(&frame) == bits(&expected), "{name} on {count} ranks");
        }
    }
}

/// None is lost at a side or a layer, nor met twice, where a field has the surface's very value on half of the globe
/// and on all layers but one.
#[test]
fn surfaces_of_a_value_that_stays_are_met_once() {
    let (mesh, grid) = icosahedral(4);
    let at = directions(&mesh.lon_center_rad, &mesh.lat_center_rad);
    // No binary fraction: weights that add up to 1 bring it back but for rounding.
    let level = 0.7;
    for rises in [true, false] {
        let value = |cell: usize, layer: usize| {
            let off = if at[cell].x > 0.1 && layer > 0 { 0.0 } else { 0.31 + 0.1 * at[cell].y.abs() };
            if rises { level - off } else { level + off }
        };
        let mut scene = scene("lon = 70\nlat = 35\ndistance = 3.2\nfov = 45", "core = \"black\"", "");
        scene.volumes.truncate(1);
        scene.volumes[0].transfer = transfer(&[knot(0.0, [0.0; 3], 0.0)]);
        scene.volumes[0].coloring = None;
        scene.scenery = icoray::Scenery {
            isosurfaces: vec![Isosurface {
                field: "f".into(),
                value: level,
                paint: Paint::Plain([1.0; 3]),
                opacity: 0.5,
            }],
            ..icoray::Scenery::default()
        };
        (scene.width, scene.height) = (200, 170);
        let layout = |columns| Shape::level_fastest(columns, INTERFACES);
        let arrays =
            |cells: &Rows| vec![("f", cells.array(layout, (true, Location::Center, None), value, |_| f64::NAN))];
        let all = arrays(&Rows::all(mesh.cells()));
        let render = |scene: &Scene| Renderer::new(2).unwrap().render(scene, &grid, &layers(), fields(&all)).unwrap();
        let whole = render(&scene);
        // A little off the value that stays there is no doubt.
        let mut beside = scene.clone();
        beside.scenery.isosurfaces[0].value = if rises { level - 1e-9 } else { level - 1e-3 };
        let sure = render(&beside);
        let shown = |frame: &Frame| frame.pixels.iter().filter(|pixel| pixel[0] > 0.4).count();
        assert_eq!(shown(&sure) > 500, rises, "{}", shown(&sure));
        let differ =
            |a: &Frame, b: &Frame| a.pixels.iter().zip(&b.pixels).filter(|(a, b)| (a[0] - b[0]).abs() > 1e-3).count();
        assert_eq!(differ(&whole, &sure), 0, "rises: {rises}, of {}", shown(&sure));
        for (partition, owner) in &partitions(mesh, 3)[1..3] {
            let spread = Spread::new(mesh, 3, owner);
            let own = |rank: usize| vec![arrays(&spread.cells[rank])];
            let (frame, _) = spread.draw(&[0, 1, 2], &scene, &layers(), own);
            assert_eq!(differ(&frame, &sure), 0, "rises: {rises}, {partition}");
        }
    }
}

/// Wrong further fields or heights of one rank are the same error on all.
#[test]
fn bad_data_on_one_rank_are_the_error_of_all() {
    use Location::{Center, Corner};
    /// The same over all columns, in 64 bits.
    fn set(array: &mut Array, columns: usize, layers: usize, location: Location, value: fn(usize) -> f64) {
        let shape = Shape::level_fastest(columns, layers);
        *array = Array::new(shape, true, location, None, |_, layer| value(layer));
    }
    let (of_scene, of_field, of_layers, of_mpi) =
        (ErrorKind::Scene, ErrorKind::Field, ErrorKind::Layers, ErrorKind::Mpi);
    // Of h, f, g and heights, on 162 cells and 320 corners.
    type Damage = fn(&mut Arrays);
    let cases: [(Damage, ErrorKind, &str); 10] = [
        (|of| drop(of.remove(2)), of_scene, "the scene shows field \"g\""),
        (|of| of[2].1.shape.columns = 161, of_field, "\"g\": "),
        (
            |of| of[2].1.shape.layers = LAYERS,
            of_mpi,
            "has \"g\" of 4 layers of 64 bits at centres, but \"g\" of 5 layers of 64 bits at centres on rank 0",
        ),
        (|of| of[2].1.shape.layers = 2, of_field, "\"g\": "),
        (
            |of| set(&mut of[0].1, 162, INTERFACES, Center, |_| 0.5),
            of_mpi,
            "has \"h\" of 5 layers of 64 bits at centres, but \"h\" of 5 layers of 32 bits at corners",
        ),
        (
            |of| set(&mut of[0].1, 320, INTERFACES, Corner, |_| 0.5),
            of_mpi,
            "has \"h\" of 5 layers of 64 bits at corners, but \"h\" of 5 layers of 32 bits",
        ),
        (|of| drop(of.pop()), of_scene, "the scene has heights = \"native\""),
        (|of| of[3].1.shape.layers = LAYERS, of_layers, "heights: "),
        (|of| set(&mut of[3].1, 162, INTERFACES, Center, |layer| -(layer as f64)), of_layers, "heights: cell "),
        (
            |of| set(&mut of[3].1, 162, INTERFACES, Center, |layer| 9e4 * layer as f64),
            of_mpi,
            "has heights of the lowest and highest layers",
        ),
    ];
    let (mesh, grid) = icosahedral(2);
    let mut scene = scene(FAR, "", "");
    scene.scenery.heights = Heights::Native;
    for (i, (damage, kind, words)) in cases.into_iter().enumerate() {
        println!("case {i}");
        let refusals = on_ranks(3, |ranks| {
            let [good, mut bad] = [0, 1].map(|_| steps(mesh, Corner).into_iter().next().unwrap());
            if ranks.rank() == 1 {
                damage(&mut bad);
            }
            let renderer = Renderer::new(1).unwrap();
            let refusal = refusal(renderer.render_over(ranks, &scene, &grid, &layers(), fields(&bad)));
            // The next frame is drawn.
            renderer.render_over(ranks, &scene, &grid, &layers(), fields(&good)).unwrap();
            refusal
        });
        assert_same_refusal(&refusals, kind, &format!("rank 1: {words}"));
    }
}
