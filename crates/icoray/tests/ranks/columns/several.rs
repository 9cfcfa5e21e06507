//! Several fields of columns that are spread over ranks, and heights.

use super::*;
use icoray::{Heights, Volume};

/// The field t beside q, on layers that lie at heights of their own.
pub(super) fn rich_scene() -> Scene {
    let mut scene = scene("");
    let transfer = scene.volumes[0].transfer.clone();
    scene.volumes.extend([Volume { field: "t".into(), transfer, coloring: None, opacity: None }]);
    scene.scenery.heights = Heights::Native;
    scene
}

#[test]
fn all_fields_and_heights_that_a_scene_needs_are_put_together() {
    let (mesh, grid) = icosahedral(3);
    let height = |cell: usize, layer: usize| 6e3 * layer as f64 + 2e3 * (0.3 * cell as f64).sin();
    let arrays = |rows: &Rows, [q, t, heights]: [Layout; 3]| {
        let array = |layout, is_wide, fill, value: &dyn Fn(usize, usize) -> f64| {
            rows.array(layout, (is_wide, Location::Center, fill), value, |_| f64::NAN)
        };
        let of_q = |c, l| value(c, l, 1);
        // In another order than the scene has them, and with one that it does not need.
        vec![
            ("t", array(t, false, Some(FILL), &|c, l| value(c, LAYERS - 1 - l, 2))),
            ("unused", array(q, true, Some(FILL), &of_q)),
            ("q", array(q, true, Some(FILL), &of_q)),
            ("heights", array(heights, true, None, &height)),
        ]
    };
    let cells = mesh.cells();
    let whole = alone(&grid, &rich_scene(), &arrays(&Rows::all(cells), [LEVEL_FASTEST; 3]));
    let expected = [(whole, cells * LAYERS * (8 + 4 + 8))];
    for (node_of, layouts) in [
        (&[0, 0][..], [LEVEL_FASTEST, CELL_FASTEST, BLOCKED]),
        (&[0, 1, 0], [CELL_FASTEST, BLOCKED, LEVEL_FASTEST]),
        (&[2, 1, 1, 0], [BLOCKED, LEVEL_FASTEST, CELL_FASTEST]),
    ] {
        let locals = locals(mesh, node_of.len(), &partitions(cells, node_of.len())[1]);
        assert_made(node_of, &expected, "several fields", |ranks| {
            let local = &locals[ranks.rank()];
            let decomposition = decomposition(ranks, &grid, local, None).unwrap();
            let arrays = arrays(local, layouts);
            // First one field only, so that the memory has to grow.
            render(ranks, &scene(""), &grid, &decomposition, &arrays[2].1.field()).unwrap();
            [render(ranks, &rich_scene(), &grid, &decomposition, fields(&arrays)).unwrap()]
        });
    }
}

/// One rank has other fields or heights than the scene needs or the other ranks have.
#[test]
fn fields_that_do_not_fit_are_refused_on_all_ranks() {
    let (mesh, grid) = icosahedral(2);
    let locals = locals(mesh, 3, &partitions(mesh.cells(), 3)[1]);
    fn array(columns: usize, layers: usize, is_wide: bool) -> Array {
        Array::new(Shape::level_fastest(columns, layers), is_wide, Location::Center, None, |_, _| 0.5)
    }
    let (of_field, of_mpi, of_scene) = (ErrorKind::Field, ErrorKind::Mpi, ErrorKind::Scene);
    let at_corners = format!("\"q\": {} columns, expected 320, one per corner", locals[1].rows.len());
    // Of q, t and heights, of so many columns.
    type Damage = fn(&mut Arrays, usize);
    let cases: [(Damage, ErrorKind, &str); 9] = [
        (|of, columns| of[0].1 = array(columns + 1, LAYERS, true), of_field, "\"q\": "),
        (
            |of, columns| of[0].1 = array(columns, LAYERS - 1, true),
            of_mpi,
            "has \"q\" of 3 layers of 64 bits, but \"q\" of 4 ",
        ),
        (|of, columns| of[0].1 = array(columns, LAYERS, false), of_mpi, "has \"q\" of 4 layers of 32 bits"),
        (|of, _| of[0].1.missing = Some(7.0), of_mpi, "has \"q\" with missing values marked by Some(7.0)"),
        (|of, _| of[0].1.location = Location::Corner, of_field, &at_corners),
        (
            |of, columns| of[1].1 = array(columns, LAYERS - 1, true),
            of_mpi,
            "has \"t\" of 3 layers of 64 bits, but \"t\" of 4 layers of 64 bits on rank 0",
        ),
        (
            |of, columns| of[2].1 = array(columns, LAYERS - 1, true),
            of_mpi,
            "has heights of 3 layers of 64 bits, but heights of 4 layers",
        ),
        (|of, _| of[1].0 = "u", of_scene, "the scene shows field \"t\", and there is [\"q\", \"u\"]"),
        (|of, _| drop(of.pop()), of_scene, "the scene has heights = \"native\""),
    ];
    for (damage, kind, words) in cases {
        let refusals = on_nodes(&[0, 1, 0], |ranks| {
            let local = &locals[ranks.rank()];
            let decomposition = decomposition(ranks, &grid, local, None).unwrap();
            let good = array(local.rows.len(), LAYERS, true);
            let mut arrays = ["q", "t", "heights"].map(|name| (name, array(local.rows.len(), LAYERS, true))).into();
            if ranks.rank() == 1 {
                damage(&mut arrays, local.rows.len());
            }
            let refusal = refusal(render(ranks, &rich_scene(), &grid, &decomposition, fields(&arrays)));
            render(ranks, &scene(""), &grid, &decomposition, &good.field()).unwrap();
            refusal
        });
        assert_same_refusal(&refusals, kind, &format!("rank 1: {words}"));
    }
}
