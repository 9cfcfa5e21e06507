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

/// The form of a rank's field: by how many its columns are too many, layers, bits, place, and the mark of what is missing.
#[derive(Clone, Copy)]
struct Form {
    more: usize,
    layers: usize,
    is_wide: bool,
    location: Location,
    fill: Option<f64>,
}

const GOOD: Form = Form { more: 0, layers: LAYERS, is_wide: true, location: Location::Center, fill: None };
const FEWER_LAYERS: Form = Form { layers: LAYERS - 1, ..GOOD };

/// One rank has other fields or heights than the scene needs or the other ranks have.
#[test]
fn fields_that_do_not_fit_are_refused_on_all_ranks() {
    let (mesh, grid) = icosahedral(2);
    let locals = locals(mesh, 3, &partitions(mesh.cells(), 3)[1]);
    let (of_field, of_mpi, of_scene) = (ErrorKind::Field, ErrorKind::Mpi, ErrorKind::Scene);
    let at_corners = format!("\"q\": {} columns, expected 320, one per corner", locals[1].rows.len());
    let (t, heights) = (("t", GOOD), Some(GOOD));
    let cases = [
        (Form { more: 1, ..GOOD }, t, heights, of_field, "\"q\": "),
        (FEWER_LAYERS, t, heights, of_mpi, "has \"q\" of 3 layers of 64 bits, but \"q\" of 4 "),
        (Form { is_wide: false, ..GOOD }, t, heights, of_mpi, "has \"q\" of 4 layers of 32 bits"),
        (Form { fill: Some(7.0), ..GOOD }, t, heights, of_mpi, "has \"q\" with missing values marked by Some(7.0)"),
        (Form { location: Location::Corner, ..GOOD }, t, heights, of_field, at_corners.as_str()),
        (
            GOOD,
            ("t", FEWER_LAYERS),
            heights,
            of_mpi,
            "has \"t\" of 3 layers of 64 bits, but \"t\" of 4 layers of 64 bits on rank 0",
        ),
        (GOOD, t, Some(FEWER_LAYERS), of_mpi, "has heights of 3 layers of 64 bits, but heights of 4 layers"),
        (GOOD, ("u", GOOD), heights, of_scene, "the scene shows field \"t\", and there is [\"q\", \"u\"]"),
        (GOOD, t, None, of_scene, "the scene has heights = \"native\""),
    ];
    for (q, other, of_heights, kind, words) in cases {
        let refusals = on_nodes(&[0, 1, 0], |ranks| {
            let local = &locals[ranks.rank()];
            let decomposition = decomposition(ranks, &grid, local, None).unwrap();
            let array = |Form { more, layers, is_wide, location, fill }: Form| {
                let shape = Shape::level_fastest(local.rows.len() + more, layers);
                Array::new(shape, is_wide, location, fill, |_, _| 0.5)
            };
            let (q, (name, other), of_heights) =
                if ranks.rank() == 1 { (q, other, of_heights) } else { (GOOD, t, heights) };
            let mut arrays = vec![("q", array(q)), (name, array(other))];
            arrays.extend(of_heights.map(|heights| ("heights", array(heights))));
            let refusal = refusal(render(ranks, &rich_scene(), &grid, &decomposition, fields(&arrays)));
            render(ranks, &scene(""), &grid, &decomposition, &array(GOOD).field()).unwrap();
            refusal
        });
        assert_same_refusal(&refusals, kind, &format!("rank 1: {words}"));
    }
}
