//! Scenes of several fields over ranks: the picture of one process.

use super::*;
use crate::common::{assert_same_refusal, at_centers, level_fastest, on_ranks, picture, refusal, render_decomposed};
use crate::spread::{Spread, partitions};
use icoray::{Decomposition, DistributedGrid, Error, ErrorKind, Owned, PartCells, Rendered};
use icoray_test_support::Random;

/// The second of two frames on this rank.
pub(super) fn second(mut render: impl FnMut(usize) -> Result<Rendered, Error>) -> Rendered {
    let [_, second] = [0, 1].map(|step| render(step).unwrap());
    second
}

#[test]
fn tiles_are_bitwise_those_of_one_process() {
    let (mesh, grid) = icosahedral(3);
    let steps = [0, 1].map(|step| Model::whole(mesh, step, Location::Corner));
    for (name, scene) in scenes() {
        let expected = draw(&Renderer::new(2).unwrap(), &grid, &scene, &steps);
        for count in [1, 2, 3] {
            let drawn = on_ranks(count, |ranks| {
                let renderer = Renderer::new(1).unwrap();
                second(|step| renderer.render_over(ranks, &scene, &grid, &layers(), steps[step].fields()))
            });
            let (frame, _) = picture(drawn);
            assert!(bits(&frame) == bits(&expected), "{name} on {count} ranks");
            assert_eq!(frame.report.bytes_derived, expected.report.bytes_derived, "{name}");
        }
    }
}

#[test]
fn columns_are_bitwise_those_of_one_process() {
    let (mesh, grid) = icosahedral(3);
    let steps = [0, 1].map(|step| Model::whole(mesh, step, Location::Center));
    for (name, scene) in scenes() {
        let expected = draw(&Renderer::new(2).unwrap(), &grid, &scene, &steps);
        for count in [2, 3] {
            let drawn = on_ranks(count, |ranks| {
                let mine: Vec<usize> =
                    (0..mesh.cells()).filter(|cell| Random::at(*cell).below(count) == ranks.rank()).collect();
                let global: Vec<i64> = mine.iter().map(|cell| *cell as i64).collect();
                let owned = vec![1; mine.len()];
                let cells = PartCells { global: global.as_slice().into(), owned: Owned::Marked(&owned) };
                let decomposition = Decomposition::new(ranks, &grid, &cells).unwrap();
                assert!(matches!(decomposition, Decomposition::Columns(_)));
                let own = [0, 1].map(|step| Model::new(mesh, step, (&mine, &[]), Location::Center));
                let renderer = Renderer::new(1).unwrap();
                let data = DistributedGrid { grid: &grid, decomposition: Some(&decomposition), layers: &layers() };
                second(|step| renderer.render_decomposed(ranks, &scene, data, own[step].fields()))
            });
            assert!(bits(&picture(drawn).0) == bits(&expected), "{name} on {count} ranks");
        }
    }
}

/// None is lost at a side or a layer, nor met twice, where a field has the surface's very value on half of the globe
/// and on all layers but one.
#[test]
fn surfaces_of_a_value_that_stays_are_met_once() {
    let (mesh, grid) = icosahedral(4);
    let at = crate::culled::directions(&mesh.lon_center_rad, &mesh.lat_center_rad);
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
        let values = |cells: &[usize]| -> Vec<f64> {
            cells.iter().flat_map(|cell| (0..INTERFACES).map(|layer| value(*cell, layer))).collect()
        };
        let all: Vec<usize> = (0..mesh.cells()).collect();
        let render = |scene: &Scene| {
            let values = values(&all);
            let field = at_centers(&values, INTERFACES);
            Renderer::new(2).unwrap().render(scene, &grid, &layers(), &field).unwrap()
        };
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
            let (frame, _) = picture(Spread::new(mesh, 3, owner).each(|ranks, culled, grid, decomposition| {
                let values = values(&culled.cells);
                let field = at_centers(&values, INTERFACES);
                render_decomposed(ranks, &scene, (grid, &decomposition.unwrap()), &layers(), &field).unwrap()
            }));
            assert_eq!(differ(&frame, &sure), 0, "rises: {rises}, {partition}");
        }
    }
}

/// Wrong further fields or heights of one rank are the same error on all.
#[test]
fn bad_data_on_one_rank_are_the_error_of_all() {
    let mesh = IcosahedralMesh::new(2).unwrap();
    type Damage = for<'m> fn(Fields<'m>, &'m Model) -> Fields<'m>;
    fn with<'m>(of: Fields<'m>, name: &str, field: Option<Field<'m>>) -> Fields<'m> {
        let named = of.iter().filter(|(known, _)| *known != name).map(|(known, field)| (known, *field));
        let fields: Vec<(&str, Field)> = named.chain(field.map(|field| (name, field))).collect();
        let heights = *of.heights().unwrap();
        Fields::new(fields).with_heights(heights)
    }
    /// Values of `g`, read as so many columns and layers.
    fn g(m: &Model, columns: usize, layers: usize) -> Option<Field<'_>> {
        Some(at_centers(&m.g[..columns * layers], layers))
    }
    let cases: [(&str, Damage, ErrorKind, &str); 10] = [
        ("none", |of, _| with(of, "g", None), ErrorKind::Scene, "the scene shows field \"g\""),
        ("columns", |of, m| with(of, "g", g(m, m.cells - 1, INTERFACES)), ErrorKind::Field, "\"g\": "),
        (
            "layers",
            |of, m| with(of, "g", g(m, m.cells, LAYERS)),
            ErrorKind::Mpi,
            "has \"g\" of 4 layers of 64 bits at centres, but \"g\" of 5 layers of 64 bits at centres on rank 0",
        ),
        ("too few layers", |of, m| with(of, "g", g(m, m.cells, 2)), ErrorKind::Field, "\"g\": "),
        (
            "place",
            |of, m| with(of, "h", g(m, m.cells, INTERFACES)),
            ErrorKind::Mpi,
            "has \"h\" of 5 layers of 64 bits at centres, but \"h\" of 5 layers of 32 bits at corners",
        ),
        (
            "bits",
            |of, m| {
                let wide: &'static [f64] = vec![0.5; m.h.len()].leak();
                with(of, "h", Some(level_fastest(wide, INTERFACES, Location::Corner)))
            },
            ErrorKind::Mpi,
            "has \"h\" of 5 layers of 64 bits at corners, but \"h\" of 5 layers of 32 bits",
        ),
        (
            "no heights",
            |of, _| Fields::new(of.iter().map(|(name, field)| (name, *field))),
            ErrorKind::Scene,
            "the scene has heights = \"native\"",
        ),
        (
            "heights of another shape",
            |of, m| of.with_heights(at_centers(&m.heights[..m.cells * LAYERS], LAYERS)),
            ErrorKind::Layers,
            "heights: ",
        ),
        (
            "heights that fall",
            |of, m| of.with_heights(at_centers(&m.g, INTERFACES)),
            ErrorKind::Layers,
            "heights: cell ",
        ),
        (
            "higher heights",
            |of, m| {
                let mut heights = m.heights.clone();
                heights[LAYERS] = 9e4;
                of.with_heights(at_centers(heights.leak(), INTERFACES))
            },
            ErrorKind::Mpi,
            "has heights of the lowest and highest layers",
        ),
    ];
    let mut scene = scene(FAR, "", "");
    scene.scenery.heights = Heights::Native;
    for (name, damage, kind, words) in cases {
        println!("{name}");
        let refusals = on_ranks(3, |ranks| {
            let (model, grid) = (Model::whole(&mesh, 0, Location::Corner), Grid::new(mesh.tables()).unwrap());
            let fields = model.fields();
            let fields = if ranks.rank() == 1 { damage(fields, &model) } else { fields };
            let renderer = Renderer::new(1).unwrap();
            let refusal = refusal(renderer.render_over(ranks, &scene, &grid, &layers(), fields));
            // The next frame is drawn.
            renderer.render_over(ranks, &scene, &grid, &layers(), model.fields()).unwrap();
            refusal
        });
        assert_same_refusal(&refusals, kind, &format!("rank 1: {words}"));
    }
}
